"""Parameters `ARRAY [*]`: arrays of all sizes in one FUNCTION, on all engines, and told where they are not possible."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, compiled, trace

from ldc.diagnostics import Diagnostics
from ldc.il.st_text import print_st
from ldc.parser import parse_file
from ldc.parser.format import format_file
from ldc.pipeline.memory import Memory
from ldc.source import SourceFile

TOTAL = """FUNCTION total : DINT
VAR_INPUT
    a  : ARRAY [*] OF INT;
END_VAR
VAR
    i  : DINT;
END_VAR

    total := 0;
    FOR i := LOWER_BOUND(a, 1) TO UPPER_BOUND(a, 1) DO
        total := total + a[i];
    END_FOR;
END_FUNCTION
"""
FILL = """
FUNCTION fill : BOOL
VAR_INPUT
    with  : INT;
END_VAR
VAR_IN_OUT
    a  : ARRAY [*] OF INT;
END_VAR
VAR_OUTPUT
    copy  : ARRAY [*] OF INT;
END_VAR
VAR
    i  : DINT;
END_VAR

    FOR i := LOWER_BOUND(a, 1) TO UPPER_BOUND(a, 1) DO
        a[i] := with;
    END_FOR;
    copy := a;
    fill := total(a) > 12;
END_FUNCTION
""".replace("with", "value")
KEEPER = """
FUNCTION_BLOCK keeper
VAR_INPUT
    on_  : BOOL;
END_VAR
VAR_IN_OUT
    grid  : ARRAY [*, *] OF INT;
END_VAR
VAR_OUTPUT
    n  : DINT;
END_VAR

    IF on_ THEN
        n := n + 10 * UPPER_BOUND(grid, 2) + grid[LOWER_BOUND(grid, 1), 1];
    END_IF;
END_FUNCTION_BLOCK
"""


def test_functions_take_arrays_of_all_sizes(tmp_path: Path) -> None:
    text = TOTAL + FILL + """PROGRAM main
VAR x, x2 : ARRAY [0..3] OF INT; y, y2 : ARRAY [-1..1] OF INT; both : DINT; p, q : BOOL; on_ : BOOL; END_VAR
    IF on_ THEN
        q := fill(3, x, copy => x2);
        p := fill(a := y, value := 5, copy => y2);
    END_IF;
    both := total(x2) + 100 * total(a := y2) + 10_000 * total(x);
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{}, {"on_": True}], ("both", "p", "q", "x[3]", "y2[-1]"))
    assert rows == [(0, False, False, 0, 0), (121512, True, False, 3, 5)]


def test_instances_keep_arrays_of_one_size_each(tmp_path: Path) -> None:
    text = KEEPER + """VAR_GLOBAL shared : keeper; wide : ARRAY [0..0, 1..9] OF INT; END_VAR
PROGRAM main
VAR_EXTERNAL shared : keeper; END_VAR
VAR z : ARRAY [1..2, 0..3] OF INT := [8(1)]; w : ARRAY [5..6, 1..1] OF INT := [2(7)];
    k : keeper; two : ARRAY [0..1] OF keeper; a, b, c : DINT; i : INT; END_VAR
    k(on_ := TRUE, grid := z);
    k(grid := z);
    FOR i := 0 TO 1 DO two[i](on_ := i = 1, grid := w); END_FOR;
    shared(TRUE, wide);
    a := k.n; b := two[1].n + 1000 * two[0].n; c := shared.n;
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}, {}], ("a", "b", "c")) == [(62, 17, 90), (124, 34, 180)]


DRAWN = """FUNCTION last : INT
VAR_INPUT a : ARRAY [*] OF INT; END_VAR
RUNG only
    <MOVE(IN := a[UPPER_BOUND(a, 1)], OUT => last)>
END_FUNCTION
FUNCTION_BLOCK keeper
VAR_INPUT on_ : BOOL; END_VAR
VAR_IN_OUT grid : ARRAY [*, *] OF INT; END_VAR
VAR_OUTPUT n : DINT; END_VAR
RUNG only
    [on_] <ADD(IN1 := n, IN2 := UPPER_BOUND(grid, 2), OUT => n)>
END_FUNCTION_BLOCK
PROGRAM main
VAR go, q, p : BOOL; x : ARRAY [0..3] OF INT := [4(2)]; y : ARRAY [1..2] OF INT := [2(9)];
    z : ARRAY [1..2, 0..3] OF INT := [8(1)]; v : ARRAY [1..2, 0..5] OF INT; k, l : keeper; m, n : DINT; i : INT; END_VAR
RUNG first
    [go] <last(a := x, OUT => i)> (q)
RUNG second
    [go] [last(y) > last(x)] (p)
RUNG third
    [go] <k: keeper(grid := z, n => m) in=on_ out=_>
RUNG fourth
    <l: keeper(go, v, n => n) in=_ out=_>
END_PROGRAM
"""


def test_ladders_draw_functions_with_arrays_of_all_sizes(tmp_path: Path) -> None:
    text = DRAWN.replace("keeper(go, v,", "keeper(go, grid := v,")
    rows = trace(tmp_path, text, "main.ld", [{}, {"go": True}], ("q", "p", "i", "m", "n"))
    assert rows == [(False, False, 0, 0, 0), (True, True, 2, 3, 5)]


def test_a_ladder_that_was_compiled_before_gives_the_same(tmp_path: Path) -> None:
    text = DRAWN.replace("keeper(go, v,", "keeper(go, grid := v,")
    for _ in range(2):
        memory = Memory(tmp_path / "memory.rungs")
        assert compiled(text, "main.ld", memory=memory, keep=False).image.digest == compiled(text, "main.ld").image.digest


def test_what_nobody_calls_is_checked(tmp_path: Path) -> None:
    assert compiled(TOTAL + "PROGRAM main VAR q : BOOL; END_VAR q := TRUE; END_PROGRAM", "main.st")
    wrong = TOTAL.replace("total + a[i]", "total + b[i]")
    found = checked(wrong + "PROGRAM main VAR q : BOOL; END_VAR q := TRUE; END_PROGRAM", "main.st").diagnostics
    assert [d.code for d in found] == ["LD0404"]


def test_the_printed_program_is_the_same_program() -> None:
    text = TOTAL + """PROGRAM main
VAR x : ARRAY [0..3] OF INT; y : ARRAY [1..2] OF INT; n : DINT; END_VAR
    n := total(x) + total(y);
END_PROGRAM
"""
    program = compiled(text, "main.st").program
    assert print_st(compiled(print_st(program), "printed.st").program) == print_st(program)


def test_the_formatter_keeps_what_is_open() -> None:
    file = parse_file(SourceFile("main.st", TOTAL), Diagnostics())
    assert format_file(file) == TOTAL


@pytest.mark.parametrize("text, codes", [
    ("PROGRAM main VAR a : ARRAY [*] OF INT; END_VAR a[0] := 1; END_PROGRAM", ["LD0242"]),
    ("PROGRAM main VAR_INPUT a : ARRAY [*] OF INT; END_VAR END_PROGRAM", ["LD0242"]),
    ("TYPE t : ARRAY [*] OF INT; END_TYPE PROGRAM main VAR a : t; END_VAR END_PROGRAM", ["LD0242"]),
    ("FUNCTION_BLOCK f VAR_OUTPUT a : ARRAY [*] OF INT; END_VAR END_FUNCTION_BLOCK", ["LD0242"]),
    ("FUNCTION f : INT VAR_INPUT a : ARRAY [0..1] OF ARRAY [*] OF INT; END_VAR f := 1; END_FUNCTION", ["LD0242"]),
    ("FUNCTION f : INT VAR_INPUT a : ARRAY [**] OF INT; END_VAR f := 1; END_FUNCTION", ["LD0101"]),
    (TOTAL + "PROGRAM main VAR n : DINT; END_VAR n := total(n); END_PROGRAM", ["LD0403"]),
    (TOTAL + "PROGRAM main VAR n : DINT; a : ARRAY [0..1] OF REAL; END_VAR n := total(a); END_PROGRAM", ["LD0403"]),
    (TOTAL + "PROGRAM main VAR n : DINT; a : ARRAY [0..1, 0..1] OF INT; END_VAR n := total(a); END_PROGRAM",
     ["LD0403"]),
    (TOTAL + "PROGRAM main VAR n : DINT; END_VAR n := total(missing); END_PROGRAM", ["LD0404"]),
    (KEEPER + "PROGRAM main VAR k : keeper; a : ARRAY [0..1, 0..1] OF INT; b : ARRAY [0..1, 0..2] OF INT; END_VAR "
     "k(grid := a); k(grid := b); END_PROGRAM", ["LD0243"]),
])
def test_what_cannot_be_is_told(text: str, codes: list[str]) -> None:
    assert [d.code for d in checked(text, "main.st").diagnostics if d.severity == "error"] == codes


def test_an_array_is_handed_over_within_brackets(tmp_path: Path) -> None:
    """The IL `MUL( y / total / )` loads an array that a FUNCTION takes."""
    text = TOTAL.replace("[*]", "[0..1]") + """PROGRAM main
VAR y : ARRAY [0..1] OF INT := [3, 4]; n : DINT := 5; END_VAR
    n := n * total(y);
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}], ("n",)) == [(35,)]
