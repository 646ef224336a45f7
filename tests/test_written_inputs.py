"""Inputs that their POU writes, as other editors let it: the caller's variables stay as they are."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, trace

TEXT = """TYPE
    Row  : ARRAY [0..3] OF INT;
    Pair : STRUCT a : INT; t : STRING[10]; END_STRUCT;
END_TYPE

FUNCTION size : INT
VAR_INPUT
    n    : INT;
    row  : Row;
    pair : Pair;
END_VAR
    IF n < 0 THEN n := -n; END_IF;
    row[0] := row[0] + n;
    pair.a := pair.a + 1;
    pair.t := 'x';
    size := row[0] + pair.a;
END_FUNCTION

FUNCTION_BLOCK answer
VAR_INPUT
    start : BOOL;
    row   : Row;
    pair  : Pair;
END_VAR
VAR_OUTPUT
    calls, sum : INT;
END_VAR
    IF start THEN calls := calls + 1; start := FALSE; END_IF;
    row[3] := row[3] + 1;
    pair.a := pair.a * 2 + 1;
    sum := row[3] + pair.a;
END_FUNCTION_BLOCK

PROGRAM main
VAR
    go, same : BOOL;
    one, two : answer;
    own      : Row := [5, 6, 7, 8];
    mine     : Pair := (a := 4, t := 'abc');
    round, found, n1, s1, n2, s2 : INT;
END_VAR
    round := round + 1;
    found := size(-round, own, mine);
    one(start := go, row := own, pair := mine, calls => n1, sum => s1);
    IF round = 2 THEN two.start := TRUE; END_IF;
    two(calls => n2, sum => s2);
    same := own[0] = 5 AND own[3] = 8 AND mine.a = 4 AND mine.t = 'abc';
END_PROGRAM
"""


def test_a_written_input_lasts_until_a_call_gives_it_again(tmp_path: Path) -> None:
    """Of ``one`` every call gives all, of ``two`` none does; what is given to a FUNCTION is a copy."""
    rows = trace(tmp_path, TEXT, "main.st", [{"go": True}, {}, {"go": False}],
                 ("found", "n1", "s1", "n2", "s2", "same"))
    assert rows == [(11, 1, 18, 0, 2, True), (12, 2, 18, 1, 5, True), (13, 2, 18, 1, 10, True)]


@pytest.mark.parametrize("rung", [
    "[start] (R start)", "<MOVE(IN := num, OUT => num)>", "[start] <one: swap(v := num)> (lamp)"])
def test_each_way_of_writing_is_told(rung: str) -> None:
    text = f"""FUNCTION_BLOCK swap
VAR_INPUT
    go : BOOL;
END_VAR
VAR_IN_OUT
    v : INT;
END_VAR
VAR_OUTPUT
    done : BOOL;
END_VAR
RUNG [go] <MOVE(IN := 2, OUT => v)> (done)
END_FUNCTION_BLOCK
FUNCTION_BLOCK writer
VAR_INPUT
    start : BOOL;
    num   : INT;
END_VAR
VAR
    one  : swap;
    lamp : BOOL;
END_VAR
RUNG {rung}
END_FUNCTION_BLOCK
"""
    assert [d.code for d in checked(text, "main.ld").diagnostics] == ["LD0161"]
