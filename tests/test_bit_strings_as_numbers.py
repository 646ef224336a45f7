"""Bit strings that are taken for numbers, as other editors do."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, trace

HEAD = """PROGRAM main VAR b : BYTE := 250; w : WORD := 65535; d : DWORD := 5; i : INT := 7; di : DINT := -2;
    u : USINT := 9; n : UINT; x, y, z : BOOL; part : INT (0..300); c : (red, green); r : REAL; END_VAR
"""


def test_arithmetic_and_conversions_on_every_engine(tmp_path: Path) -> None:
    text = HEAD + """    b := b + 1; w := w + b - 2; d := 2 * d; x := b > 5; y := w + 1 < d; z := d MOD 4 = 2;
    di := di + w; i := b; n := b; w := u; IF w / 2 >= 4 THEN part := b; END_IF;
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{}, {"w": 10}, {"b": 255}],
                 ("b", "w", "d", "x", "y", "z", "di", "i", "n", "part"))
    assert rows[0] == (251, 9, 10, True, False, True, 246, 251, 251, 251)
    assert rows[1] == (252, 9, 20, True, False, False, 506, 252, 252, 252)
    assert rows[2] == (0, 9, 40, False, True, False, 513, 0, 0, 0)
    assert {d.code for d in checked(text, "main.st").diagnostics} == {"LD0204", "LD0240"}


def test_ladders_too(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR
    b     : BYTE := 3;
    x     : BOOL;
    i, j  : INT;
END_VAR

RUNG
    [b + 1 > 4] <MOVE(IN := i + (b + 2), OUT => i)> <ADD(IN1 := i, IN2 := i + b, OUT => j)> (x)
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.ld", [{}, {"b": 9}], ("i", "j", "x"))
    assert rows == [(0, 0, False), (11, 31, True)]


@pytest.mark.parametrize("statement", [
    "b := w;", "b := w + 1;", "b := i;", "b := b + 300;", "i := w;", "i := i + w;", "b := b + r;",
    "r := b;", "b := b ** 2;",
    "b := -b;", "x := b;", "x := b > x;", "w := b + 'a';",
])
def test_what_may_not_fit_or_is_no_number_is_an_error(statement: str) -> None:
    found = checked(f"{HEAD}{statement} END_PROGRAM", "main.st").diagnostics
    assert found.has_errors
    assert not [d for d in found if d.code == "LD0901"]
