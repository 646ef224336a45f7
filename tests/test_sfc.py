"""Sequential function charts: what each word means scan by scan, what is told about wrong ones."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ldc import pipeline
from ldc.cli.powers import Powers
from ldc.diagnostics import Diagnostics
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser import parse_file
from ldc.parser.format import format_file
from ldc.parser.sfc import SfcBody
from ldc.source import SourceFile
from runtime.vm.machine import Machine

PERIOD = 10_000_000
DECLARED = "VAR go, back, x, y, q : BOOL; n, k, divisor : INT; t : TIME; END_VAR\n"
THREE = "INITIAL_STEP A: END_STEP STEP B: END_STEP STEP C: END_STEP "
TWO = "TRANSITION FROM A TO B := go; END_TRANSITION TRANSITION FROM B TO A := back; END_TRANSITION\n"


def program(body: str, before: str = "") -> str:
    return f"{before}PROGRAM main\n{DECLARED}{body}\nEND_PROGRAM\n"


def two(a: str = "", b: str = "", rest: str = "") -> str:
    """Two steps: A, which is left by ``go``, and B, which is left by ``back``."""
    return program(f"INITIAL_STEP A: {a} END_STEP STEP B: {b} END_STEP {TWO}{rest}")


def compiled(text: str, path: str = "main.ld") -> pipeline.Compiled:
    return pipeline.compile_project(Sources((SourceFile(path, text),), Settings(), None), pipeline.Options())


def codes(text: str, path: str = "main.ld") -> list[str]:
    return [d.code for d in compiled(text, path).diagnostics]


def machine(text: str) -> Machine:
    result = compiled(text)
    assert not result.diagnostics.has_errors, [f"{d.code} {d.message}" for d in result.diagnostics]
    return Machine(result.program, period_ns=PERIOD)


def trace(text: str, names: str, inputs: dict[str, str], scans: int | None = None) -> list[str]:
    """A line of 0 and 1 (or numbers between spaces) for each name; inputs likewise, a digit for each scan."""
    found, rows = machine(text), {name: [] for name in names.split()}
    for scan in range(scans or len(next(iter(inputs.values())))):
        for name, values in inputs.items():
            found.set(name, values[scan] == "1")
        found.scan()
        assert not found.faults
        for name, row in rows.items():
            row.append(found.get(name))
    plain = all(isinstance(value, bool) for row in rows.values() for value in row)
    return ["".join(str(int(v)) for v in row) if plain else " ".join(str(int(v)) for v in row)
            for row in rows.values()]


# ---- steps and transitions


def test_the_initial_step_is_active_in_the_first_scan_whatever_the_inputs_are() -> None:
    assert trace(two(), "A.X B.X", {"go": "1111", "back": "0001"}) == ["1001", "0110"]


def test_one_transition_step_in_one_execution() -> None:
    chain = program(THREE + "TRANSITION FROM A TO B := TRUE; END_TRANSITION "
                    "TRANSITION FROM B TO C := TRUE; END_TRANSITION")
    assert trace(chain, "A.X B.X C.X", {"go": "1111"}) == ["1000", "0100", "0011"]


def test_time_of_a_step_runs_while_it_is_active_and_then_stays() -> None:
    found = machine(two())
    seen = []
    for go, back in ((0, 0), (0, 0), (1, 0), (0, 0), (0, 1), (0, 0)):
        found.set("go", bool(go))
        found.set("back", bool(back))
        found.scan()
        seen.append((found.get("A.T") // 1_000_000, found.get("B.T") // 1_000_000))
    assert seen == [(0, 0), (10, 0), (20, 0), (20, 10), (0, 20), (10, 20)]


@pytest.mark.parametrize(("first", "second", "taken"), [
    ("", "", "B"), (" (PRIORITY := 2)", " (PRIORITY := 1)", "C"), ("", " (PRIORITY := 9)", "C"),
    (" (PRIORITY := 1)", " (PRIORITY := 1)", "B"),
])
def test_the_first_transition_by_priority_then_by_place_goes(first: str, second: str, taken: str) -> None:
    text = program(f"{THREE}TRANSITION{first} FROM A TO B := go; END_TRANSITION "
                   f"TRANSITION{second} FROM A TO C := go; END_TRANSITION")
    found = machine(text)
    found.set("go", True)
    found.scan()
    found.scan()
    assert [step for step in "ABC" if found.get(f"{step}.X")] == [taken]


FORK = """INITIAL_STEP A: END_STEP STEP B: END_STEP STEP C: END_STEP STEP D: END_STEP STEP E: END_STEP
TRANSITION FROM A TO (B, C) := go; END_TRANSITION
TRANSITION FROM B TO D := x; END_TRANSITION
TRANSITION FROM C TO E := y; END_TRANSITION
TRANSITION FROM (D, E) TO A := TRUE; END_TRANSITION
"""


def test_a_simultaneous_convergence_waits_for_all() -> None:
    got = trace(program(FORK), "A.X B.X C.X D.X E.X",
                {"go": "01000000", "x": "00010000", "y": "00000100"})
    assert got == ["10000011", "01100000", "01111000", "00011100", "00000100"]
    assert not len(compiled(program(FORK)).diagnostics)


def test_a_step_that_leads_to_itself_begins_anew() -> None:
    text = program("INITIAL_STEP A: pulse(P1); ends(P0); END_STEP "
                   "TRANSITION FROM A TO A := go; END_TRANSITION ACTION pulse: n := n + 1; END_ACTION "
                   "ACTION ends: k := k + 1; END_ACTION")
    assert trace(text, "n k", {"go": "00110"}) == ["1 1 2 3 3", "0 0 1 2 2"]
    found = machine(text)
    for _ in range(3):
        found.scan()
    found.set("go", True)
    found.scan()
    assert found.get("A.T") == 0


def test_a_condition_is_computed_only_while_its_steps_are_active() -> None:
    text = program("INITIAL_STEP A: END_STEP STEP B: END_STEP TRANSITION FROM A TO B := go; END_TRANSITION "
                   "TRANSITION FROM B TO A := 100 / divisor > 3; END_TRANSITION")
    found = machine(text)
    found.scan()
    found.scan()
    assert not found.faults
    found.set("go", True)
    found.scan()
    assert not found.faults
    found.scan()
    assert [fault.code for fault in found.faults] == ["LD0801"]


def test_charts_beside_each_other_run_on_their_own() -> None:
    text = program("INITIAL_STEP A: END_STEP STEP B: END_STEP " + TWO
                   + "INITIAL_STEP C: END_STEP STEP D: END_STEP TRANSITION FROM C TO D := x; END_TRANSITION "
                   "TRANSITION FROM D TO C := TRUE; END_TRANSITION")
    assert trace(text, "A.X C.X", {"go": "0100", "x": "0010"}) == ["1000", "1101"]
    assert codes(text) == []


def test_a_rung_as_condition() -> None:
    text = program("INITIAL_STEP A: END_STEP STEP B: END_STEP\n"
                   "TRANSITION start FROM A TO B: RUNG [x] [/y] (start) END_TRANSITION\n"
                   "TRANSITION ends FROM B TO A: ends := back AND x; END_TRANSITION\n")
    assert trace(text, "A.X start", {"x": "011101", "y": "010001", "back": "000101"}) == ["110111", "001000"]
    result = compiled(text)
    assert [b.verdict.kind for builds in result.units.values() for b in builds] == ["proof"]


# ---- actions

QUALIFIERS = [
    # B is active in the scans 2 to 5; A before and after.
    ("N", "001111000"), ("P", "001000000"), ("P1", "001000000"), ("P0", "000000100"),
    ("S", "001111111"), ("R", "000000000"), ("L, T#20ms", "001100000"), ("L, T#1h", "001111000"),
    ("D, T#20ms", "000011000"), ("D, T#0s", "001111000"), ("D, T#1h", "000000000"),
    ("SD, T#50ms", "000000011"), ("DS, T#30ms", "000001111"), ("DS, T#40ms", "000000000"),
    ("SL, T#60ms", "001111110"), ("SL, T#15ms", "001100000"),
]


@pytest.mark.parametrize(("qualifier", "wanted"), QUALIFIERS)
def test_a_variable_follows_its_qualifier(qualifier: str, wanted: str) -> None:
    inputs = {"go": "001000000", "back": "000000100"}
    assert trace(two(b=f"q({qualifier});"), "q", inputs) == [wanted]


@pytest.mark.parametrize(("qualifier", "on"), QUALIFIERS)
def test_a_body_is_executed_while_it_is_on_and_once_more(qualifier: str, on: str) -> None:
    """Pulses apart: their body is executed once. In the final execution Q is FALSE."""
    inputs = {"go": "001000000", "back": "000000100"}
    body = "ACTION act: n := n + 1; IF NOT act.Q THEN k := k + 1; END_IF; END_ACTION"
    text = two(b=f"act({qualifier});", rest=body)
    executions, last = trace(text, "n k", inputs)
    again = "10" in on and not qualifier.startswith("P")
    assert int(executions.split()[-1]) == on.count("1") + again
    assert int(last.split()[-1]) == again


def test_set_and_reset_of_an_action() -> None:
    text = program("INITIAL_STEP A: END_STEP STEP B: q(S); act(S); END_STEP STEP C: q(R); act(R); END_STEP "
                   "TRANSITION FROM A TO B := go; END_TRANSITION TRANSITION FROM B TO A := x; END_TRANSITION "
                   "TRANSITION FROM A TO C := back; END_TRANSITION ACTION act: n := n + 1; END_ACTION")
    inputs = {"go": "0100000", "x": "0010000", "back": "0000100"}
    assert trace(text, "q A.X C.X", inputs) == ["0111000", "1011000", "0000111"]
    assert trace(text, "n", inputs) == ["0 1 2 3 4 4 4"]


def test_reset_wins_over_every_other_qualifier() -> None:
    text = program("INITIAL_STEP A: q(R); END_STEP STEP B: END_STEP STEP C: q(N); q(S); q(P1); END_STEP "
                   "STEP Z: q(R); END_STEP TRANSITION FROM A TO (C, Z) := go; END_TRANSITION "
                   "TRANSITION FROM Z TO B := x; END_TRANSITION")
    assert trace(text, "q", {"go": "0100000", "x": "0001000"}) == ["0001111"]


def test_two_steps_after_each_other_with_one_action() -> None:
    """Each association has its own pulse and time; there is no final execution between the steps."""
    text = two(a="act(N); count(P1);", b="act(N); count(P1); q(L, T#20ms);",
               rest="ACTION act: n := n + 1; END_ACTION ACTION count: k := k + 1; END_ACTION")
    assert trace(text, "n k", {"go": "01000", "back": "00010"}) == ["1 2 3 4 5", "1 2 2 3 3"]


def test_a_time_may_be_a_variable() -> None:
    found = machine(two(b="q(D, t);"))
    found.set("t", "T#20ms")
    found.set("go", True)
    seen = []
    for _ in range(5):
        found.scan()
        seen.append(found.get("q"))
    assert seen == [False, False, False, True, True]


def test_return_leaves_the_action_only() -> None:
    text = two(a="one(N); other(N);", rest="ACTION one: RUNG [x] >>RETURN RUNG [/q] (q) END_ACTION "
               "ACTION other: IF y THEN RETURN; END_IF; FOR k := 1 TO 9 DO n := n + 1; IF y OR k = 3 THEN "
               "RETURN; END_IF; END_FOR; n := 100; END_ACTION")
    assert trace(text, "q n", {"x": "0110", "y": "0001"}) == ["1 1 1 0", "3 6 9 9"]


def test_rungs_of_actions_keep_their_proof_and_their_edges() -> None:
    text = two(a="act(N);", rest="ACTION act: RUNG [P x] (S q) RUNG [y] (R q) END_ACTION")
    result = compiled(text)
    assert [b.verdict.kind for builds in result.units.values() for b in builds] == ["proof", "proof"]
    assert trace(text, "q", {"x": "01110", "y": "00100"}) == ["01000"]


def test_a_chart_in_a_function_block_has_its_own_steps() -> None:
    before = ("FUNCTION_BLOCK cell\nVAR_INPUT go : BOOL; END_VAR\nVAR_OUTPUT lit : BOOL; END_VAR\n"
              "INITIAL_STEP A: END_STEP STEP B: lit(N); END_STEP TRANSITION FROM A TO B := go; END_TRANSITION"
              " TRANSITION FROM B TO A := NOT go; END_TRANSITION END_FUNCTION_BLOCK\n")
    text = (before + "PROGRAM main VAR a, b : cell; x, y : BOOL; END_VAR RUNG [x] <a: cell()> (y) "
            "RUNG [y] <b: cell()> END_PROGRAM")
    assert trace(text, "a.B.X b.B.X a.lit b.lit", {"x": "011010"}) == ["011010"] * 4


def test_the_chart_may_read_its_flags_and_nothing_else_may_write_them() -> None:
    body = "ACTION act: A.X := TRUE; B.T := T#1s; act.Q := FALSE; END_ACTION"
    assert codes(two(a="act(N);", rest=body)) == ["LD0503"] * 3
    assert codes(two(b="q(N);", rest="")) == []
    assert codes(two(a="A.X(N);")) == ["LD0503"]


def test_the_power_of_rungs_between_the_control_of_a_chart() -> None:
    """What the live table shows; a rung of an action that is off was not executed."""
    result = compiled(two(a="act(N);", b="other(N);", rest="ACTION act: RUNG one [x] (q) END_ACTION "
                          "ACTION other: RUNG two [y] (q) END_ACTION"))
    found = Machine(result.program, period_ns=PERIOD)
    powers = Powers(found, result.units)
    assert [row.name for row in powers.rows] == ["one", "two"]
    found.set("x", True)
    powers.scan()
    assert [powers.at(row) for row in powers.rows] == [True, None]
    found.set("go", True)
    for _ in range(2):
        powers.scan()
    assert [powers.at(row) for row in powers.rows] == [None, False]


# ---- what is wrong

WRONG = [
    (two(a="nothing(N);"), ["LD0229"]), (two(a="n(N);"), ["LD0229"]), (two(a="q(D, 5);"), ["LD0403"]),
    (two(a="q(L);"), ["LD0138"]), (two(a="q(N, T#1s);"), ["LD0138"]), (two(a="q(Q);"), ["LD0137"]),
    (two(a="q(D, time := T#1s);"), ["LD0137"]), (two(a="q(N)"), ["LD0101"]), (two(a="(N);"), ["LD0101"]),
    (two(rest="ACTION unused: n := 1; END_ACTION"), ["LD0235"]),
    (two(rest="STEP A: END_STEP"), ["LD0201"]), (two(rest="STEP n: END_STEP"), ["LD0201", "LD0230"]),
    (two(rest="STEP main: END_STEP"), ["LD0201", "LD0230"]),
    (two(a="act(N);", rest="ACTION act: n := 1; END_ACTION ACTION act: n := 2; END_ACTION"), ["LD0201"]),
    (two(rest="TRANSITION FROM A TO C := go; END_TRANSITION"), ["LD0228"]),
    (two(rest="TRANSITION FROM A TO B := n; END_TRANSITION"), ["LD0401"]),
    (two(rest="TRANSITION FROM A TO B : RUNG [x] (y) END_TRANSITION"), ["LD0139"]),
    (two(rest="TRANSITION (ORDER := 1) FROM A TO B := go; END_TRANSITION"), ["LD0139"]),
    (two(rest="TRANSITION FROM A TO B := go; x := y; END_TRANSITION"), ["LD0101"]),
    (two(rest="x := y;"), ["LD0139"]), (two(rest="STEPP C: END_STEP"), ["LD0139"]),
    (two(rest="VAR z : BOOL; END_VAR"), ["LD0121"]),
    (two(rest="STEP C: END_STPE"), ["LD0120"]), (two(rest="STEP C: x(N);"), ["LD0119"]),
    (two(rest="ACTION act: n := 1; END_ACTOIN"), ["LD0120"]),
    (two(rest="ACTION act: n := 1; END_STEP"), ["LD0120"]),
    (two(rest="ACTION act: n := 1;"), ["LD0119"]), (two(rest="STEP C END_STEP"), ["LD0101"]),
    (two(a="act(N);", rest="ACTION act: RUNG [x] END_ACTION"), ["LD0304"]),
    (two(a="act(N);", rest="ACTION act: RUNG [x] >>there END_ACTION "
         "ACTION other: RUNG there [x] (q) END_ACTION"), ["LD0235", "LD0515"]),
    (program("STEP A: END_STEP"), ["LD0226"]),
    ("FUNCTION f : INT INITIAL_STEP A: END_STEP END_FUNCTION", ["LD0233"]),
]


@pytest.mark.parametrize(("text", "wanted"), WRONG, ids=range(len(WRONG)))
def test_what_is_wrong_is_told_once(text: str, wanted: list[str]) -> None:
    assert sorted(codes(text)) == wanted


def test_charts_that_cannot_end_well() -> None:
    unsafe = FORK.replace("FROM (D, E) TO A", "FROM D TO A")
    assert "LD0231" in codes(program(unsafe))
    waits = FORK.replace("FROM A TO (B, C) := go;", "FROM A TO B := go;")
    assert codes(program(waits + "TRANSITION FROM A TO C := x; END_TRANSITION")) == ["LD0232"]
    assert codes(program(FORK + "STEP F: END_STEP TRANSITION FROM F TO A := x; END_TRANSITION")) == ["LD0230"]


def test_large_charts_take_linear_time() -> None:
    count = 1500
    steps = "".join(f"{'INITIAL_' * (n == 0)}STEP s{n}: q(N); act(P1); END_STEP\n" for n in range(count))
    ways = "".join(f"TRANSITION FROM s{n} TO s{(n + 1) % count} := go; END_TRANSITION\n"
                   for n in range(count))
    text = program(steps + ways + "ACTION act: n := n + 1; END_ACTION")
    assert trace(text, "n", {"go": "11111"}) == ["1 2 3 4 5"]


def test_parallel_branches_without_number_are_not_explored_for_ever() -> None:
    count = 40
    steps = "".join(f"STEP a{n}: END_STEP STEP b{n}: END_STEP\n" for n in range(count))
    ways = "".join(f"TRANSITION FROM a{n} TO b{n} := go; END_TRANSITION\n" for n in range(count))
    first, last = (", ".join(f"{letter}{n}" for n in range(count)) for letter in "ab")
    text = program(f"INITIAL_STEP A: END_STEP\n{steps}TRANSITION FROM A TO ({first}) := go; END_TRANSITION\n"
                   f"{ways}TRANSITION FROM ({last}) TO A := go; END_TRANSITION")
    assert codes(text) == []


# ---- broken text, formatter

WHOLE = two(a="q(N); act(D, T#10ms, x);", rest="ACTION act: RUNG one [x] (S q) RUNG [y] >>one END_ACTION "
            "TRANSITION named (PRIORITY := 3) FROM A TO B: IF x THEN named := y; END_IF; END_TRANSITION")


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=150)
@given(st.integers(0, len(WHOLE)), st.integers(0, len(WHOLE)), st.sampled_from(
    ("", "END_STEP", "STEP", "TRANSITION FROM", "ACTION", ":", ";", "(", "(*", "RUNG", "END_PROGRAM", "'",
     "IF x THEN")))
def test_broken_charts_give_findings_only(start: int, end: int, put: str) -> None:
    text = WHOLE[:min(start, end)] + put + WHOLE[max(start, end):]
    for path in ("main.ld", "main.st"):
        result = compiled(text, path)
        assert result.program is not None or result.diagnostics.has_errors


@pytest.mark.parametrize("path", ["main.ld", "main.st"])
def test_the_formatter_keeps_the_chart_and_its_comments(path: str) -> None:
    text = WHOLE.replace("END_STEP", "(* in *) END_STEP // behind\n").replace(":= go", "(* why *) := go")
    once = format_file(parse_file(SourceFile(path, text), Diagnostics()))
    assert format_file(parse_file(SourceFile(path, once), Diagnostics())) == once
    assert once.count("(* in *)") == 2 and once.count("// behind") == 2 and "(* why *)" in once
    assert codes(once, path) == codes(text, path) == []
    assert isinstance(parse_file(SourceFile(path, once), Diagnostics()).pous[0].body, SfcBody)
