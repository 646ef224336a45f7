"""AND_THEN and OR_ELSE in Structured Text: the right side is computed when the left one does not decide."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, compiled, trace
from plcopen_xml import coil, contact, ladder, rail
from test_plcopen import run

HEAD = """FUNCTION noted : BOOL
VAR_INPUT give : BOOL; END_VAR
VAR_IN_OUT calls : INT; END_VAR
    calls := calls + 1;
    noted := give;
END_FUNCTION
PROGRAM main
VAR a, b, q, z : BOOL; n, m : INT; f : ARRAY [0..3] OF BOOL := [4(TRUE)]; END_VAR
"""


def test_the_right_side_is_protected(tmp_path: Path) -> None:
    text = HEAD + """
    IF n <> 0 AND_THEN 10 / n > 2 THEN m := m + 1; END_IF;
    q := n = 0 OR_ELSE 10 MOD n = 0 and_then n > 1;
    z := n < 4 AND_THEN f[n] AND NOT (n > 3 OR_ELSE f[n] = FALSE);
    WHILE n < 4 AND_THEN f[n] AND_THEN m < 3 DO m := m + 1; END_WHILE;
    n := n + 1;
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{}] * 6, ("m", "q", "z"))
    assert rows == [(3, True, True), (4, False, True), (5, True, True), (6, False, True), (6, False, False),
                    (6, True, False)]


def test_what_stands_on_the_right_has_its_effects_only_then(tmp_path: Path) -> None:
    text = HEAD + """
    q := a AND_THEN noted(give := b, calls := n) OR_ELSE noted(give := a, calls := m);
END_PROGRAM
"""
    scans = [{"a": a, "b": b} for a in (False, True) for b in (False, True)]
    assert trace(tmp_path, text, "main.st", scans, ("q", "n", "m")) == [
        (False, 0, 1), (False, 0, 2), (True, 1, 3), (True, 2, 3)]


def test_a_condition_of_a_chart(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR n : INT; END_VAR
INITIAL_STEP one: END_STEP
STEP two: count(N); END_STEP
TRANSITION FROM one TO two := n = 0 OR_ELSE 10 / n > 3; END_TRANSITION
TRANSITION FROM two TO one := n <> 0 AND_THEN 10 / n < 4; END_TRANSITION
ACTION count: n := n + 1; END_ACTION
END_PROGRAM
"""
    assert [n for n, in trace(tmp_path, text, "main.st", [{}] * 5, ("n",))] == [0, 1, 2, 3, 4]


def test_a_long_chain() -> None:
    compiled(HEAD + f"q := {' AND_THEN '.join(['a'] * 900)};\nEND_PROGRAM\n", "main.st")


@pytest.mark.parametrize(("statement", "code"), [
    ("q := n AND_THEN a;", "LD0410"), ("n := n AND_THEN n;", "LD0410"), ("n := a OR_ELSE b;", "LD0403")])
def test_wrong_uses_are_told(statement: str, code: str) -> None:
    assert code in [d.code for d in checked(f"{HEAD}{statement}\nEND_PROGRAM\n", "main.st").diagnostics]


def test_a_variable_of_that_name_in_a_drawing_is_renamed() -> None:
    xml = ladder("or_else q : BOOL", rail(), contact(2, "or_else"), coil(3, "q", 2))
    assert run(xml, [{"or_else_": 1}], "q") == ["1"]


def test_what_a_function_reads_and_writes_is_copied_in_and_out_in_printed_text(tmp_path: Path) -> None:
    text = HEAD + "IF a THEN q := noted(give := NOT q, calls := n); END_IF;\na := NOT a;\nEND_PROGRAM\n"
    assert trace(tmp_path, text, "main.st", [{"n": 4}, {}, {}, {}], ("n", "q")) == [
        (4, False), (5, True), (5, True), (6, False)]
