"""Contract: IL text is printed, read back and executed the same, whatever the program holds (DESIGN 4)."""

from __future__ import annotations

import pytest
from contract import codes, program, trace

TYPES = """TYPE
    Colour : (red, green, blue) := green;
    Point : STRUCT
        x : INT := 3; y : ARRAY [0..1] OF INT := [1, 2]; name : STRING[3] := 'ab'; c : Colour;
    END_STRUCT;
    Rows : ARRAY [1..2, 0..1] OF Point;
END_TYPE
"""


def test_whole_structures_and_arrays_are_copied() -> None:
    source = program(
        "RUNG [a] <MOVE(IN := p, OUT => o)> <MOVE(IN := rows[1, 1], OUT => rows[2, 0])>\n"
        "RUNG <MOVE(IN := few, OUT => more)>\n"
        "RUNG [a] <MOVE(IN := 7, OUT => p.x)>",
        "a : BOOL; p : Point; o : Point := (x := 9, y := [2(8)]);"
        " few, more : ARRAY [0..2] OF INT := [1, 2, 3]; rows : Rows := [3((x := 5)), (x := 6)];", TYPES)
    assert trace(source, "o.x o.y[1] o.name o.c more[2] rows[2,0].x", "scan,a,few[2] 0,0,3 1,1,4 2,1,5") == [
        "9 8 ab green 3 5", "3 2 ab green 4 5", "7 2 ab green 5 5"]


def test_whole_values_pass_through_pins_and_results() -> None:
    pous = TYPES + """FUNCTION_BLOCK Shift
VAR_INPUT e : BOOL; END_VAR
VAR_IN_OUT p : Point; END_VAR
VAR_OUTPUT o : BOOL; was : Point; END_VAR
RUNG <MOVE(IN := p, OUT => was)>
RUNG [e] <ADD(IN1 := p.x, IN2 := p.y[1], OUT => p.x)> (o)
END_FUNCTION_BLOCK

FUNCTION Sum : Point
VAR_INPUT p : Point; k : ARRAY [0..1] OF Point; END_VAR
RUNG <MOVE(IN := p, OUT => Sum)>
RUNG <ADD(IN1 := k[0].x, IN2 := k[1].x, OUT => Sum.x)>
END_FUNCTION
"""
    source = program(
        "RUNG [a] <f: Shift(p := two[i], was => before)>\nRUNG <Sum(p := before, k := two, OUT => all)>",
        "a : BOOL; f : Shift; two : ARRAY [0..1] OF Point := [(x := 10), (x := 20)];"
        " before, all : Point; i : INT;", pous)
    assert trace(source, "two[0].x two[1].x before.x all.x all.y[0]", "scan,a,i 0,0,1 1,1,1 2,1,0") == [
        "10 20 20 30 1", "10 22 20 32 1", "12 22 10 34 1"]


def test_an_array_of_blocks_cannot_be_copied() -> None:
    declared = "VAR a, b : ARRAY [0..1] OF TON; END_VAR"
    assert codes(f"PROGRAM main\n{declared}\nLD a\nST b\nEND_PROGRAM\n", "main.il") == ["LD0708"]


@pytest.mark.parametrize("behind", ["\n", "   ", "\n\n(* the end *)\n"])
def test_the_result_of_a_function_is_no_call_of_it(behind: str) -> None:
    """A comment begins with the bracket that a call has, too."""
    text = ("FUNCTION Twice : INT\nVAR_INPUT x : INT; END_VAR\nLD x\nADD x\n"
            f"ST Twice{behind}(* done *)\nRET\nEND_FUNCTION\n")
    assert codes(text, "main.il") == []
    assert codes(text.replace("ST Twice", "Twice(x := 1)"), "main.il") == ["LD0216"]


def test_a_function_that_returns_early_is_read_back() -> None:
    early = """FUNCTION Early : INT
VAR_INPUT x : INT; END_VAR
RUNG <MOVE(IN := x, OUT => Early)>
RUNG [x > 3] >>RETURN
RUNG <MOVE(IN := -1, OUT => Early)>
END_FUNCTION
"""
    source = program("RUNG <Early(x := a, OUT => k)>", "a, k : INT;", early)
    assert trace(source, "k", "scan,a 0,1 1,5") == ["-1", "5"]
