"""Actions of POUs that are no charts: what their calls do on all engines, in text, drawings and other formats."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, compiled, trace
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from plcopen_xml import block, coil, contact, pou, project, rail
from statements import BOOLS, HEAD, TYPES, blocks
from test_plcopen import run

from ldc.diagnostics import Diagnostics
from ldc.il import performed
from ldc.il.st_text import print_st
from ldc.il.text import print_program
from ldc.parser import parse_file
from ldc.parser.format import format_file
from ldc.source import SourceFile
from runtime.vm.machine import Machine

PUMP = """FUNCTION_BLOCK pump
VAR_INPUT run : BOOL; END_VAR
VAR_OUTPUT hours : INT; ok : BOOL; END_VAR
RUNG [run] <Count()> (ok)
ACTION Count:
    hours := hours + 1;
    IF hours > 4 THEN RETURN; END_IF;
    hours := hours + 1;
END_ACTION
ACTION Reset:
    RUNG [hours = 0] >>RETURN
    RUNG <MOVE(IN := 0, OUT => hours)>
END_ACTION
END_FUNCTION_BLOCK
"""
LADDER = PUMP + """PROGRAM main
VAR
    go, stop, high, q, done, old, e : BOOL; n, k : INT;
    x : pump; xs : ARRAY [0..1] OF pump;
END_VAR
RUNG [go] <x: pump()> (q)
RUNG [stop] <x: Reset()> (done)
RUNG { [go] <Tick()> | [stop] } (e)
RUNG [n > 3] <Tick()> [n > 5] (old)
RUNG <Twice()>
ACTION Tick:
    FOR k := 1 TO 2 DO
        n := n + 1;
        Twice(EN := n > 7, ENO => high);
    END_FOR;
    xs[k - 2](run := TRUE);
    xs[1].Reset();
    IF n > 100 THEN RETURN; END_IF;
    n := n + 1;
END_ACTION
ACTION Twice:
    RUNG [P go] (S stop)
    RUNG [/go] >>small
    RUNG <ADD(IN1 := n, IN2 := 10, OUT => n)>
    RUNG small <ADD(IN1 := n, IN2 := 1, OUT => n)>
END_ACTION
END_PROGRAM
"""
NAMES = ("q", "done", "e", "old", "high", "stop", "n", "k", "x.hours", "xs[0].hours", "xs[1].hours")


def test_a_ladder_and_the_instances_in_it(tmp_path: Path) -> None:
    scans = [{}, {"go": 1}, {}, {"go": 0, "stop": 0}, {"go": 1}, {}]
    rows = trace(tmp_path, LADDER, "main.ld", scans, NAMES)
    assert rows[1:4] == [(True, False, True, True, False, True, 18, 3, 2, 0, 0),
                         (True, True, True, True, True, True, 79, 3, 0, 0, 0),
                         (False, False, False, True, True, False, 85, 3, 0, 0, 0)]


def test_statements(tmp_path: Path) -> None:
    text = """FUNCTION_BLOCK Axis
VAR_INPUT go : BOOL; END_VAR
VAR_OUTPUT pos : INT; END_VAR
VAR t : TON; END_VAR
    IF go THEN Further(); END_IF;
    Limit();
ACTION Further: pos := pos + 3; END_ACTION
ACTION Limit: IF pos <= 10 THEN RETURN; END_IF; pos := 10; END_ACTION
ACTION Home:
    t(IN := TRUE, PT := T#10ms);
    IF t.Q THEN pos := 0; END_IF;
END_ACTION
END_FUNCTION_BLOCK
PROGRAM main
VAR x, y : Axis; a, ok : BOOL; i : INT; END_VAR
    main.Move();
    FOR i := 1 TO 5 DO IF i = 3 THEN CONTINUE; END_IF; IF a THEN Move(); EXIT; END_IF; END_FOR;
    y.Home(EN := a, ENO => ok);
END_PROGRAM
ACTION Move:
    x(go := TRUE);
    y(go := x.pos > 5);
END_ACTION
"""
    rows = trace(tmp_path, text, "main.st", [{}, {}, {"a": 1}, {}, {}], ("x.pos", "y.pos", "i", "ok"))
    assert rows == [(3, 0, 6, False), (6, 3, 6, False), (10, 9, 1, True), (10, 0, 1, True), (10, 0, 1, True)]


def test_a_loop_ends_though_an_action_writes_its_variable(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR i, n : INT; END_VAR
    n := 0;
    FOR i := 1 TO 32766 DO n := n + 1; Jump(); END_FOR;
ACTION Jump: IF i > 3 THEN i := 32766; END_IF; END_ACTION
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}], ("n", "i")) == [(4, 32767)]


def test_lists_of_instructions(tmp_path: Path) -> None:
    text = """FUNCTION_BLOCK counter
VAR_OUTPUT n : INT; END_VAR
LD n
ADD 1
ST n
ACTION Back:
LD n
EQ 0
RETC
LD 0
ST n
END_ACTION
END_FUNCTION_BLOCK
PROGRAM main
VAR c : counter; a : BOOL; END_VAR
CAL c
LD a
CALC c.Back
CAL Again
ACTION Again:
CAL c
END_ACTION
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.il", [{}, {"a": 1}, {}], ("c.n",)) == [(2,), (1,), (1,)]


def test_a_program_that_is_nothing_but_actions_is_no_chart() -> None:
    assert compiled("PROGRAM main VAR n : INT; END_VAR ACTION one: n := 1; END_ACTION END_PROGRAM", "a.ld")


def test_the_canonical_form_has_actions_last() -> None:
    text = """PROGRAM main VAR n : INT; END_VAR
n := 1; // behind
(* above the end *)
END_PROGRAM
// above the action
ACTION one: (* here *) n := 2; two(); END_ACTION
ACTION two: END_ACTION
"""
    once = format_file(parse_file(SourceFile("a.st", text), Diagnostics()))
    assert once.split("ACTION one:")[1].endswith("ACTION two:\nEND_ACTION\nEND_PROGRAM\n")
    assert format_file(parse_file(SourceFile("a.st", once), Diagnostics())) == once
    assert all(once.count(said) == 1 for said in ("behind", "above the end", "above the action", "here"))
    assert compiled(once, "a.st").image.digest == compiled(text, "a.st").image.digest


@pytest.mark.parametrize(("body", "wanted"), [
    ("one(); ACTION one: two(); END_ACTION ACTION two: one(); END_ACTION", ["LD0518"]),
    ("one(); ACTION one: one(); END_ACTION", ["LD0518"]),
    ("ACTION one: END_ACTION ACTION One: END_ACTION", ["LD0201"]),
    ("ACTION n: END_ACTION", ["LD0201"]),
    ("one(3); ACTION one: END_ACTION", ["LD0509"]),
    ("one(x := 3); ACTION one: END_ACTION", ["LD0505"]),
    ("n := one(); ACTION one: END_ACTION", ["LD0502"]),
    ("n := one; ACTION one: END_ACTION", ["LD0405"]),
    ("ACTION one: END_ACTION n := 1;", ["LD0101"]),
    ("ACTION one: n := 1;", ["LD0119"]),
    ("ACTION one n := 1; END_ACTION", ["LD0101"]),
    ("ACTION one: n := o; END_ACTION", ["LD0404"]),
])
def test_what_is_wrong_is_told(body: str, wanted: list[str]) -> None:
    text = f"PROGRAM main VAR n : INT; END_VAR {body} END_PROGRAM"
    assert [d.code for d in checked(text, "main.st").diagnostics] == wanted


def test_actions_that_grow_without_end_are_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(performed, "MOST", 10_000)
    actions = "".join(f"ACTION a{n}: a{n + 1}(); a{n + 1}(); END_ACTION " for n in range(40))
    text = f"PROGRAM main VAR n : INT; END_VAR a0(); {actions} ACTION a40: n := n + 1; END_ACTION END_PROGRAM"
    assert [d.code for d in checked(text, "main.st").diagnostics] == ["LD0519"]


# ---- PLCopen XML


def ld(*elements: str) -> str:
    return f"<LD>{rail()}{''.join(elements)}</LD>"


@pytest.mark.parametrize(("type_", "instance"), [
    ("Count", ""), ("main.Count", ""), ("x.Add", ""), ("Add", "x"), ("adder.Add", "x")])
def test_a_block_that_calls_an_action(type_: str, instance: str) -> None:
    body = ld(contact(2, "a"), block(3, type_, {"EN": 2}, ("ENO",), instance), coil(4, "q", "3.ENO"))
    adder = pou("<ST>;</ST>", "", "adder", "functionBlock", "<outputVars><variable name='n'><type><INT/></type>"
                "</variable></outputVars>").replace(
        "<body>", "<actions><action name='Add'><body><ST>n := n + 1;</ST></body></action></actions><body>", 1)
    count = ld(contact(2, "a"), coil(3, "z", 2))
    main = pou(body, "a q z : BOOL; x : adder").replace(
        "<body>", "<actions><action name='Count'><body><ST>x.Add();</ST></body></action>"
        f"<action name='Other'><body>{count}</body></action></actions><body>", 1)
    xml = project(adder, main)
    assert run(xml, [{}, {"a": 1}, {}, {"a": 0}], "x.n") == ["0", "1", "2", "2"]
    assert run(xml, [{}, {"a": 1}, {}, {"a": 0}], "q") == ["0", "1", "1", "0"]


# ---- any statements


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=10)
@given(blocks(2), blocks(2), st.integers(-5, 5))
def test_an_action_does_what_its_statements_do_in_its_place(first: str, second: str, start: int) -> None:
    assume("RETURN" not in first + second)
    around = "FOR n := 1 TO 2 DO {one} IF b0 OR i0 > 0 THEN\n{two} END_IF; END_FOR;\n{one}END_PROGRAM\n"
    direct = HEAD + around.format(one=first, two=second)
    called = HEAD + around.format(one="One();", two="Two();").replace("END_PROGRAM", (
        f"ACTION One:\n{first}Nothing();\nEND_ACTION\nACTION Two:\n{second}END_ACTION\n"
        "ACTION Nothing: RETURN; i0 := 7; END_ACTION\nEND_PROGRAM"))
    program = compiled(called, "main.st").program
    programs = [compiled(direct, "main.st").program, program,
                compiled(print_program(program), "main.il").program, compiled(print_st(program), "again.st").program]
    machines = [Machine(one, period_ns=10_000_000) for one in programs]
    for machine in machines:
        machine.set("i0", start)
    for _ in range(2):
        found = []
        for machine in machines:
            machine.scan()
            found.append("fault" if machine.faults else [machine.get(name) for name in (*TYPES, *BOOLS, "field[1]")])
        assert found == [found[0]] * len(found), called
        if found[0] == "fault":
            return
