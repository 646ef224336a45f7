"""Typed functions, ADD_INT and so on (2nd edition, 2.5.1.4): the overloaded ones in one type."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, trace
from tests.il_text import code

HEAD = """VAR
    few     : INT := 3;
    many    : DINT := -7;
    ratio   : REAL := 2.25;
    mask    : WORD := 5;
    ready   : BOOL := TRUE;
    max_int : INT;
    sum     : DINT;
    bits    : WORD;
    root    : REAL;
    same    : BOOL;
    late    : TIME;
END_VAR
"""


def test_they_are_called_like_the_others(tmp_path: Path) -> None:
    text = f"""PROGRAM main
{HEAD}
    sum := ADD_DINT(few, many, 5) + SEL_DINT(ready, 1, few) + MUX_DINT(1, many, few)
        + LIMIT_DINT(0, many, 10);
    bits := OR_WORD(AND_WORD(mask, 16#4), SHL_WORD(mask, 2));
    root := SQRT_REAL(ratio) + MUL_REAL(2.0, 3);
    same := EQ_INT(few, 3) AND NOT GT_DINT(few, 3);
    max_int := MAX_INT(few, 12);
    late := MAX_TIME(T#1s, T#2s);
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{}], ("sum", "bits", "root", "same", "max_int", "late"))
    assert rows == [(7, 20, 7.5, True, 12, 2_000_000_000)]
    assert not len(checked(text, "main.st").diagnostics)


def test_in_ladders_and_instruction_lists(tmp_path: Path) -> None:
    rung = "RUNG [ready] <ADD_DINT(IN1 := few, IN2 := 4, OUT => sum)> (same)"
    ladder = f"PROGRAM main\n{HEAD}\n{rung}\nEND_PROGRAM\n"
    assert trace(tmp_path, ladder, "main.ld", [{}], ("sum", "same")) == [(7, True)]
    assert code("LD i\nADD_DINT 4, d\nST d") == [
        "LD INT i", "FN DINT INT_TO_DINT", "FN DINT ADD 4, d", "ST DINT d"]


def test_a_function_of_the_project_comes_first(tmp_path: Path) -> None:
    text = f"""FUNCTION MAX_INT : INT
VAR_INPUT
    a, b : INT;
END_VAR
    MAX_INT := a * 10 + b;
END_FUNCTION
PROGRAM main
{HEAD}
    sum := MAX_INT(few, 2);
END_PROGRAM
"""
    assert trace(tmp_path, text.replace("    max_int : INT;\n", ""), "main.st", [{}], ("sum",)) == [(32,)]


@pytest.mark.parametrize(("call", "code"), [
    ("sum := ADD_INT(few, many);", "LD0410"), ("root := ADD_INT(few, ratio);", "LD0410"),
    ("max_int := SQRT_INT(few);", "LD0410"), ("sum := ADD_DINT(few);", "LD0507"),
    ("max_int := ADD_DINT(few, 1);", "LD0403"), ("max_int := ADD_FEW(few, 1);", "LD0501"),
    ("max_int := TRUNC_INT(ratio);", "LD0501"),
])
def test_other_types_are_told(call: str, code: str) -> None:
    found = checked(f"PROGRAM main {HEAD} {call} END_PROGRAM", "main.st").diagnostics
    assert [d.code for d in found] == [code]
