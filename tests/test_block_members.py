"""Function blocks as members of structures and in arrays of structures (IEC 61131-3, 2.4.3.1)."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import PERIOD, checked, compiled, trace

from ldc.il import text as il_text
from runtime.retain import leaves
from runtime.vm.machine import Machine

TYPES = """TYPE
    Station : STRUCT
        warm : TON := (PT := T#30ms);
        late : ARRAY [0..2] OF TON;
        n    : INT;
        k    : counter;
    END_STRUCT;
    Hall : STRUCT
        stations : ARRAY [1..2] OF Station;
        name     : STRING[10] := 'a';
    END_STRUCT;
END_TYPE

FUNCTION_BLOCK counter
VAR_INPUT
    up  : BOOL R_EDGE;
    inc : INT := 1;
END_VAR
VAR_OUTPUT
    n : INT;
END_VAR
VAR RETAIN
    all : INT;
END_VAR
"""
DECLARED = """PROGRAM main
VAR
    a, q, later : BOOL;
    i : INT := 1;
    n, m : INT;
    h : Hall := (stations := [(n := 3), (k := (inc := 5))]);
    f : ARRAY [0..2] OF Station := [(n := 7, late := [(PT := T#5s)])];
END_VAR
"""
PROGRAMS = {
    "main.st": f"""{TYPES}
    IF up THEN n := n + inc; all := all + 1; END_IF;
END_FUNCTION_BLOCK
{DECLARED}
    h.stations[i].warm(IN := a, Q => q);
    h.stations[i].k(up := a, n => n);
    h.stations[2].k(up := TRUE);
    h.stations[2].late[1](IN := a, PT := T#20ms);
    later := h.stations[2].late[i].Q;
    m := h.stations[2].k.n + f[0].n;
    f[i].n := f[i].n + 1;
END_PROGRAM
""",
    "main.ld": f"""{TYPES}
RUNG
    [up] <ADD(IN1 := n, IN2 := inc, OUT => n)> <ADD(IN1 := all, IN2 := 1, OUT => all)>
END_FUNCTION_BLOCK
{DECLARED}
RUNG
    [a] <h.stations[i].warm: TON() > (q);
    [a] <h.stations[i].k: counter(n => n) out=_>
RUNG
    <h.stations[2].k: counter(up := TRUE) in=_ out=_>
RUNG
    [a] <h.stations[2].late[1]: TON(PT := T#20ms)>;
    [h.stations[2].late[i].Q] (later)
RUNG
    <ADD(IN1 := h.stations[2].k.n, IN2 := f[0].n, OUT => m)>
RUNG
    <ADD(IN1 := f[i].n, IN2 := 1, OUT => f[i].n)>
END_PROGRAM
""",
}


@pytest.mark.parametrize("path", sorted(PROGRAMS))
def test_members_are_called_and_read_where_they_lie(path: str, tmp_path: Path) -> None:
    scans = [{"a": True}, {}, {}, {}, {"a": False}, {}, {"a": True, "i": 2}]
    rows = trace(tmp_path, PROGRAMS[path], path, scans, ("q", "later", "n", "m", "f[1].n", "h.stations[1].k.all"))
    assert [row[:2] for row in rows] == [(False, False)] * 2 + [(False, True), (True, True)] + [(False, False)] * 3
    assert [row[2:] for row in rows] == [(1, 12, n, 1) for n in range(1, 7)] + [(5, 12, 6, 1)]


def test_a_global_structure_is_seen_while_its_block_runs(tmp_path: Path) -> None:
    text = """TYPE S : STRUCT b : ARRAY [1..2] OF blk; END_STRUCT; END_TYPE
FUNCTION_BLOCK blk
VAR_INPUT x : INT; END_VAR
VAR_OUTPUT y, before : INT; END_VAR
VAR_EXTERNAL g : S; END_VAR
    y := x;
    before := g.b[1].y;
    y := x + 1;
END_FUNCTION_BLOCK
VAR_GLOBAL g : S; END_VAR
PROGRAM main
VAR_EXTERNAL g : S; END_VAR
VAR i, x : INT := 1; END_VAR
VAR before : INT; END_VAR
    g.b[i](x := x, before => before);
    x := x + 1;
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}] * 3, ("before",)) == [(1,), (2,), (3,)]


def test_what_a_member_retains_is_retained() -> None:
    machine = Machine(compiled(PROGRAMS["main.st"], "main.st").program, period_ns=PERIOD)
    assert [leaf.path for leaf in leaves(machine.layout)][:2] == [
        "MAIN.H.STATIONS[1].K.ALL", "MAIN.H.STATIONS[2].K.ALL"]


def test_il_calls_a_member_with_its_pins() -> None:
    text = """TYPE S : STRUCT t : TON; END_STRUCT; END_TYPE
PROGRAM main
VAR s1 : S; q : BOOL; END_VAR
    CAL s1.t(IN := TRUE, PT := T#10ms, Q => q)
END_PROGRAM
"""
    machine = Machine(compiled(text, "main.il").program, period_ns=PERIOD)
    machine.scan()
    machine.scan()
    assert machine.get("q") is True


@pytest.mark.parametrize(("statement", "code"), [
    ("x := y;", "LD0405"), ("v[1] := v[2];", "LD0405"), ("x.t.Q := TRUE;", "LD0503"), ("x();", "LD0405"),
    ("x.t(IN := TRUE, M := 1);", "LD0505"),
])
def test_an_instance_stays_where_it_is_declared(statement: str, code: str) -> None:
    text = f"""TYPE T : STRUCT t : TON; n : INT; END_STRUCT; END_TYPE
PROGRAM main
VAR x, y : T; v : ARRAY [1..2] OF T; END_VAR
    {statement}
END_PROGRAM
"""
    assert [d.code for d in checked(text, "main.st").diagnostics] == [code]


@pytest.mark.parametrize("section", ["VAR_OUTPUT", "VAR_TEMP", "VAR CONSTANT"])
def test_only_a_variable_with_state_holds_one(section: str) -> None:
    text = f"""TYPE T : STRUCT t : TON; END_STRUCT; END_TYPE
FUNCTION_BLOCK b
{section} x : ARRAY [0..1] OF T; END_VAR
END_FUNCTION_BLOCK
"""
    assert "LD0217" in [d.code for d in checked(text, "main.st").diagnostics]


def test_a_block_that_holds_itself_through_a_structure_is_told() -> None:
    text = """TYPE T : STRUCT inner : b; END_STRUCT; END_TYPE
FUNCTION_BLOCK b
VAR x : T; END_VAR
END_FUNCTION_BLOCK
"""
    assert [d.code for d in checked(text, "main.st").diagnostics] == ["LD0216"]


def test_initial_values_of_instances_in_arrays_are_printed_as_far_as_there_are_some() -> None:
    text = """PROGRAM main
VAR t : ARRAY [0..3] OF TON := [(PT := T#5s)]; END_VAR
END_PROGRAM
"""
    printed = il_text.print_program(compiled(text, "main.st").program)
    assert "t : ARRAY [0..3] OF TON := [(PT := T#5s)];" in printed
