"""Bit operators on integers, as other editors have them: their bits, on every engine and through every text."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, compiled, trace
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.vm.machine import Machine

HEAD = """PROGRAM main VAR i, j : INT; u : UINT := 40000; d : DINT := -2; si : SINT := -1; b : BYTE := 16#F0;
    w : WORD := 16#00FF; x : BOOL; n : USINT := 3; l : REAL; c : (red, green); p : INT (0..300); END_VAR
"""


def test_on_every_engine(tmp_path: Path) -> None:
    text = HEAD + """    i := 16#1234 AND NOT 16#34; j := i OR 1; d := d XOR j; u := SHR(u, 4) + ROL(u, 1);
    w := w AND i OR n; si := NOT si; x := (i AND 16#1000) <> 0; p := SHL(21, 2); b := b OR n;
    i := j AND (6 OR 1);
END_PROGRAM
"""
    (row,) = trace(tmp_path, text, "main.st", [{}], ["i", "j", "d", "u", "w", "si", "x", "p", "b"])
    assert row == (1, 0x1201, -2 ^ 0x1201, 2500 + 14465, 3, 0, True, 84, 0xF3)
    told = checked(text, "main.st").diagnostics
    assert {d.code for d in told if d.severity == "warning"} <= {"LD0204", "LD0240"}
    assert not told.has_errors


def test_in_a_ladder(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR
    status : INT := 5;
    x, y   : BOOL;
END_VAR

RUNG
    [(status AND 4) = 4] (x)
RUNG
    [x] <MOVE(IN := status XOR 1, OUT => status)> (y)
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.ld", [{}, {}], ["status", "x", "y"]) == [(4, True, True), (5, True, True)]


@pytest.mark.parametrize("statement", [
    "i := SHR(i, 1);", "i := i AND x;", "i := i AND 16#FFFFF;", "l := l AND 3;", "i := i AND 1.5;", "i := c AND 1;",
    "b := i AND 3;", "i := w AND i;",
])
def test_what_has_no_bits_or_does_not_fit_is_an_error(statement: str) -> None:
    assert checked(f"{HEAD}{statement} END_PROGRAM", "main.st").diagnostics.has_errors


_RANGES = {"SINT": 8, "INT": 16, "DINT": 32, "LINT": 64, "USINT": 8, "UINT": 16, "UDINT": 32, "ULINT": 64}


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(sorted(_RANGES)), st.sampled_from(sorted(_RANGES)), st.data())
def test_as_numbers_of_the_largest_size(left: str, right: str, data: st.DataObject) -> None:
    """The bits of two numbers of one size; of two sizes the smaller is widened, with its sign."""
    def drawn(type_: str) -> int:
        signed, bits = not type_.startswith("U"), _RANGES[type_]
        least, greatest = (-(1 << bits - 1), (1 << bits - 1) - 1) if signed else (0, (1 << bits) - 1)
        return data.draw(st.integers(least, greatest))

    a, b = drawn(left), drawn(right)
    result = max((left, right), key=_RANGES.get)
    bits = _RANGES[result]
    text = (f"PROGRAM main VAR a : {left}; b : {right}; r, s, t : {result}; END_VAR "
            "r := a AND b; s := a OR b; t := a XOR NOT b; END_PROGRAM")
    machine = Machine(compiled(text, "main.st").program)
    machine.set("main.a", a)
    machine.set("main.b", b)
    machine.scan()

    def whole(value: int) -> int:
        value &= (1 << bits) - 1
        return value - (1 << bits) if not result.startswith("U") and value >> bits - 1 else value

    turned = ~b if not right.startswith("U") else ~b & (1 << _RANGES[right]) - 1
    expected = [whole(a & b), whole(a | b), whole(a ^ turned)]
    assert [machine.get(f"main.{name}") for name in "rst"] == expected
