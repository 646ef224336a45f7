"""Instances of function blocks as VAR_IN_OUT, called by who gets them, and as VAR_INPUT, read; on all engines."""

from __future__ import annotations

from pathlib import Path

import native
import pytest
from everywhere import checked, compiled, trace
from online_programs import loaded

from ldc import pipeline
from ldc.il import text as il_text
from ldc.il.st_text import print_st
from runtime.online.checks import Limits
from runtime.online.controller import Controller, prepare

MS = 1_000_000
DELAY = """
FUNCTION_BLOCK delay
VAR_INPUT x : BOOL; END_VAR
VAR_IN_OUT t : TON; END_VAR
VAR_OUTPUT done : BOOL; END_VAR
    t(IN := x, PT := T#20ms);
    done := t.Q;
END_FUNCTION_BLOCK
"""


def codes(text: str, path: str = "main.st") -> list[str]:
    return [d.code for d in checked(text, path).diagnostics]


def test_one_timer_for_two_callers(tmp_path: Path) -> None:
    """The timer goes on where the last call left it, whoever calls, and who declares it sees it."""
    text = DELAY + """PROGRAM main
VAR a, b : delay; first : BOOL; timer : TON; over, late : BOOL; elapsed : TIME; END_VAR
    first := NOT first;
    IF first THEN a(x := TRUE, t := timer, done => over); ELSE b(x := TRUE, t := timer, done => late); END_IF;
    elapsed := timer.ET;
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}] * 4, ("elapsed", "timer.Q", "over", "late")) == [
        (0, False, False, False), (10 * MS, False, False, False), (20 * MS, True, True, False),
        (20 * MS, True, True, True)]


def test_places_of_all_kinds_are_handed_over(tmp_path: Path) -> None:
    """Elements, members, globals, on to further blocks; and inputs that are only read."""
    text = """TYPE Station : STRUCT warm : TON; n : INT; END_STRUCT; END_TYPE
VAR_GLOBAL shared : TON; END_VAR
""" + DELAY + """
FUNCTION_BLOCK counting
VAR_INPUT x : BOOL; seen : TON; END_VAR
VAR_IN_OUT c : CTU; t : TON; END_VAR
VAR_OUTPUT late : TIME; END_VAR
VAR inner : delay; END_VAR
    inner(x := x, t := t);
    c(CU := inner.done, PV := 100);
    late := seen.ET;
END_FUNCTION_BLOCK
PROGRAM main
VAR
    a : BOOL; d1, d2, d3, d4 : delay; m : TON; ms : ARRAY [0..2] OF TON; one : Station; k : counting; c : CTU;
    i, n : INT; e : TIME;
END_VAR
    d1(x := TRUE, t := m);
    i := (i + 1) MOD 3;
    d2(x := m.Q, t := ms[i], done => a);
    d3(x := TRUE, t := one.warm);
    d4(x := NOT a, t := shared);
    k(x := NOT a, c := c, t := ms[2], seen := m, late => e);
    n := c.CV;
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{}] * 6, (
        "n", "e", "ms[1].ET", "ms[2].ET", "one.warm.Q", "a"))
    assert rows == [
        (0, 0, 0, 0, False, False), (0, 10 * MS, 0, 0, False, False), (0, 20 * MS, 0, 10 * MS, True, False),
        (1, 20 * MS, 0, 20 * MS, True, False), (1, 20 * MS, 0, 0, True, True), (1, 20 * MS, 0, 0, True, True),
    ]


def test_ladders_give_and_take_instances(tmp_path: Path) -> None:
    text = """FUNCTION_BLOCK delay
VAR_INPUT x : BOOL; END_VAR
VAR_IN_OUT t : TON; all : ARRAY [0..1] OF CTU; END_VAR
VAR_OUTPUT done : BOOL; END_VAR
RUNG [x] <t: TON(PT := T#20ms)> (done)
RUNG [x] <all[1]: CTU(PV := 3)>
END_FUNCTION_BLOCK
FUNCTION_BLOCK outer
VAR_INPUT x : BOOL; look : delay; END_VAR
VAR_IN_OUT d : delay; t : TON; END_VAR
VAR_OUTPUT q, seen : BOOL; END_VAR
VAR counts : ARRAY [0..1] OF CTU; END_VAR
RUNG [x] <d: delay(t := t, all := counts)> (q)
RUNG [look.done] (seen)
END_FUNCTION_BLOCK
PROGRAM main
VAR a, b : BOOL; d, d2 : delay; ts : ARRAY [1..3] OF TON; cs : ARRAY [0..1] OF CTU; o : outer; n : INT; END_VAR
RUNG [/a] <d: delay(t := ts[2], all := cs)> (a)
RUNG <o: outer(d := d2, t := ts[3], look := d2, seen => b)>
RUNG <MOVE(cs[1].CV, OUT => n)>
END_PROGRAM
"""
    built = compiled(text, "main.ld")
    assert {b.code.proof for builds in built.units.values() for b in builds} == {"proof"}
    assert trace(tmp_path, text, "main.ld", [{}] * 5, ("a", "b", "n", "ts[2].ET", "ts[3].ET", "o.q")) == [
        (False, False, 1, 0, 0, False), (False, False, 1, 10 * MS, 10 * MS, False), (True, False, 1, 20 * MS, 20 * MS, True),
        (False, True, 1, 0, 20 * MS, True), (False, True, 2, 0, 20 * MS, True)]


FUNCTIONS = """FUNCTION_BLOCK pair
VAR_INPUT u : BOOL; END_VAR
VAR_OUTPUT n : INT; END_VAR
VAR up : CTU; END_VAR
    up(CU := u, PV := 10); n := up.CV;
END_FUNCTION_BLOCK
FUNCTION run_it : BOOL
VAR_IN_OUT t : TON; p : pair; END_VAR
VAR_INPUT x : BOOL; seen : TON; END_VAR
    t(IN := x, PT := T#20ms);
    IF NOT seen.Q THEN p(u := TRUE); END_IF;
    p(u := FALSE);
    run_it := t.Q;
END_FUNCTION
FUNCTION elapsed : TIME
VAR_INPUT t : TON; END_VAR
    elapsed := t.ET;
END_FUNCTION
"""


def test_functions_take_instances(tmp_path: Path) -> None:
    text = FUNCTIONS + """PROGRAM main
VAR a, b : BOOL; m : TON; ms : ARRAY [0..1] OF TON; p, p2 : pair; e : TIME; i : INT; END_VAR
    a := run_it(t := m, p := p, x := TRUE, seen := m);
    i := 1 - i;
    IF NOT a OR run_it(t := ms[i], p := p2, x := TRUE, seen := m) THEN b := NOT b; END_IF;
    e := elapsed(m) + elapsed(t := ms[1]);
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{}] * 4, ("a", "b", "e", "p.n", "p2.n"))
    assert rows == [(False, True, 0, 1, 1), (False, False, 10 * MS, 2, 2), (True, True, 40 * MS, 3, 2),
                    (True, False, 40 * MS, 3, 2)]


def test_a_call_without_power_takes_nothing(tmp_path: Path) -> None:
    text = FUNCTIONS + DELAY + """PROGRAM main
VAR go, q : BOOL; m : TON; p : pair; d : delay; more : TON; END_VAR
    go := NOT go;
    q := run_it(EN := go, t := m, p := p, x := TRUE, seen := m);
    d(EN := NOT go, x := TRUE, t := more);
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{}] * 4, ("p.n", "m.ET", "more.ET"))
    assert rows == [(1, 0, 0), (1, 0, 0), (2, 20 * MS, 0), (2, 20 * MS, 20 * MS)]


def test_an_external_instance_is_called_and_handed_on(tmp_path: Path) -> None:
    text = "VAR_GLOBAL shared : TON; END_VAR\n" + DELAY + """
FUNCTION_BLOCK holder
VAR_EXTERNAL shared : TON; END_VAR
VAR d : delay; END_VAR
VAR_OUTPUT q : BOOL; END_VAR
    d(x := TRUE, t := shared);
    shared(IN := TRUE, PT := T#20ms, Q => q);
END_FUNCTION_BLOCK
PROGRAM main
VAR h : holder; q : BOOL; END_VAR
    h(q => q);
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}] * 3, ("q", "h.d.done")) == [
        (False, False), (False, False), (True, True)]


IL = """FUNCTION_BLOCK delay
VAR_INPUT x : BOOL; END_VAR
VAR_IN_OUT t : TON; END_VAR
    LD x
    ST t.IN
    LD T#20ms
    ST t.PT
    CAL t
END_FUNCTION_BLOCK
PROGRAM main
VAR d : delay; timer, other : TON; END_VAR
    {}
END_PROGRAM
"""


def test_instruction_lists_name_it_in_the_call(tmp_path: Path) -> None:
    text = IL.format("CAL d(x := TRUE, t := timer)")
    assert trace(tmp_path, text, "main.il", [{}] * 3, ("timer.ET",)) == [(0,), (10 * MS,), (20 * MS,)]


@pytest.mark.parametrize("body, told", [
    ("LD timer\nST other", "LD0708"), ("LD timer\nLD TRUE", "LD0708"), ("CAL d(x := TRUE, t := d)", "LD0511"),
    ("CAL d.t", "LD0244"), ("CAL d(x := TRUE, t := d.t)", "LD0244"),
])
def test_instruction_lists_copy_no_instances(body: str, told: str) -> None:
    assert told in codes(IL.format(body), "main.il")


@pytest.mark.parametrize("statement, code", [
    ("d(x := TRUE, t := c);", "LD0511"), ("d(x := TRUE, t := 5);", "LD0511"), ("d(x := TRUE);", "LD0507"),
    ("d.t(IN := TRUE);", "LD0244"), ("d.t.IN := TRUE;", "LD0244"), ("d(x := TRUE, t := d.t);", "LD0503"),
    ("e(t := c);", "LD0511"), ("e(t := a + 1);", "LD0511"), ("m := m2;", "LD0405"), ("m := d.t;", "LD0405"),
])
def test_what_is_no_hand_over_is_told(statement: str, code: str) -> None:
    text = DELAY + f"""FUNCTION_BLOCK reading VAR_INPUT t : TON; END_VAR END_FUNCTION_BLOCK
PROGRAM main
VAR d : delay; e : reading; m, m2 : TON; c : CTU; a : INT; END_VAR
    {statement}
END_PROGRAM
"""
    assert codes(text) == [code]


@pytest.mark.parametrize("statement", ["t(IN := TRUE);", "t.IN := TRUE;", "d(t := t);", "ts[1](IN := TRUE);"])
def test_an_instance_at_an_input_is_only_read(statement: str) -> None:
    text = DELAY + f"""FUNCTION_BLOCK reading
VAR_INPUT t : TON; ts : ARRAY [0..1] OF TON; END_VAR
VAR d : delay; END_VAR
    {statement}
END_FUNCTION_BLOCK
"""
    assert codes(text) == ["LD0244"]


def test_a_block_that_is_lent_its_like_is_told() -> None:
    assert codes("FUNCTION_BLOCK a VAR_IN_OUT other : a; END_VAR END_FUNCTION_BLOCK") == ["LD0216"]


def test_what_a_slave_executes_stays_where_it_is(tmp_path: Path) -> None:
    (tmp_path / "ldc.toml").write_text('[project]\nname = "p"\n[processors]\nmaster = "master"\nslave1 = "slave"\n')
    (tmp_path / "axis.ldc.toml").write_text(
        '[component]\nname = "AXIS"\nid = "test.axis"\n[requires]\ninputs = []\n[provides]\n'
        'outputs = [{ name = "position", type = "REAL" }]\n[function]\nlanguage = "st"\nsources = ["axis.st"]\n'
        'processor = "slave1"\nperiod_us = 1000\n')
    (tmp_path / "axis.st").write_text("FUNCTION_BLOCK AXIS\n    position := position + 1.0;\nEND_FUNCTION_BLOCK\n")
    (tmp_path / "main.st").write_text("""FUNCTION_BLOCK mover VAR_IN_OUT axis : AXIS; END_VAR
    axis();
END_FUNCTION_BLOCK
PROGRAM main VAR m : mover; one : AXIS; END_VAR
    m(axis := one);
END_PROGRAM
""")
    assert [d.code for d in pipeline.compile_paths([str(tmp_path)]).diagnostics] == ["LD0245"]


@pytest.mark.parametrize("engine", ["vm", pytest.param("native", marks=native.needs_gcc)])
def test_an_online_change_keeps_what_is_lent(engine: str) -> None:
    def text(variable: str, rung: str) -> str:
        return f"""FUNCTION_BLOCK delay
VAR_INPUT x : BOOL; END_VAR
VAR_IN_OUT t : TON; END_VAR
RUNG [x] <t: TON(PT := T#1s)>
END_FUNCTION_BLOCK
PROGRAM main
VAR timer : TON; d : delay; {variable} END_VAR
{rung}
RUNG [TRUE] <d: delay(t := timer) out=_>
END_PROGRAM
"""
    controller = Controller(loaded(text("", ""), engine))
    for _ in range(4):
        controller.scan()
    old = controller.running
    change = prepare(old, loaded(text("over : BOOL;", "RUNG [timer.Q] (over)"), engine, old), old.digest, "me", Limits())
    controller.stage(change)
    controller.test("me")
    before = old.machine.get("timer.ET")
    controller.scan()
    assert controller.running.machine.get("timer.ET") == before + controller.running.machine.period_ns


def test_printed_text_hands_over_in_the_call() -> None:
    text = DELAY + "PROGRAM main\nVAR d : delay; timer : TON; END_VAR\n    d(x := TRUE, t := timer);\nEND_PROGRAM\n"
    program = compiled(text, "main.st").program
    assert "d(x := TRUE, t := timer);" in print_st(program)
    assert "ST      d.t\n    CAL     d\n    LD      d.t\n    ST      timer" in il_text.print_program(program)


def test_what_is_no_instance_is_not_stored_to_one_in_il() -> None:
    text = ("TYPE\n  pair : STRUCT a : INT; END_STRUCT;\nEND_TYPE\nPROGRAM main\nVAR\n  one : pair; t : TON;\n"
            "  n : ARRAY [0..2] OF INT;\nEND_VAR\n  LD one.a\n  ST t\n  LD n[1]\n  ST t\nEND_PROGRAM\n")
    assert [d.code for d in checked(text, "main.il").diagnostics] == ["LD0708", "LD0708"]
