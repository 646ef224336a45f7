"""Values of enumerations that are taken for numbers, as other editors do."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, trace

HEAD = """TYPE
    State : (idle := 0, run := 10, stop := 20);
    Mode  : (slow, fast := 40000) UINT;
    Piece : (one_less, other_one := 5, much := 7000);
    Level : (low := -1, high := 70000);
END_TYPE
FUNCTION next_of : State
VAR_INPUT one : State; add : INT; END_VAR
    next_of := one + add;
END_FUNCTION
VAR_GLOBAL CONSTANT last : INT := stop; END_VAR
PROGRAM main
VAR
    state : State; mode : Mode := 1; level : Level; own : (la, lb, lc); i : INT := run; u : UINT; b : BYTE; d : DINT;
    w : WORD; r : REAL; q, x, y, z : BOOL; field : ARRAY [idle..stop] OF INT; steps : INT; l : LINT; part : INT (0..9);
END_VAR
"""


def test_on_every_engine(tmp_path: Path) -> None:
    text = HEAD + """
    CASE state OF
        0: steps := steps + 1; state := run;
        State.run: state := state + 10;
        21..30, 99: state := idle;
    ELSE
        state := state + 1;
    END_CASE;
    CASE i OF
        idle: i := 1;
        run, 11: i := stop;
        State.stop: i := 5;
    ELSE
        i := i - 1;
    END_CASE;
    d := state; u := mode + 1; b := state; w := mode; l := level; field[state] := state; own := own + 1;
    q := state = 10; x := state > idle; y := i = run; z := state >= i;
    part := other_one; level := d; mode := w; state := next_of(one := state + 0, add := state / 20); own := lb;
END_PROGRAM
"""
    names = ("state", "i", "d", "u", "b", "w", "l", "field[10]", "own", "q", "x", "y", "z", "level", "mode", "steps")
    rows = trace(tmp_path, text, "main.st", [{}, {}, {}, {"state": 99, "mode": 40000}], names)
    assert rows[0] == (10, 20, 10, 2, 10, 1, -1, 10, 1, True, True, False, False, 10, 1, 1)
    assert rows[1][:3] == (21, 5, 20)
    assert rows[2][:3] == (0, 4, 0)
    assert rows[3] == (0, 3, 0, 40001, 0, 40000, 0, 10, 1, False, False, False, False, 0, 40000, 1)
    assert {d.code for d in checked(text, "main.st").diagnostics} >= {"LD0241"}


def test_in_ladders(tmp_path: Path) -> None:
    text = """TYPE
    State : (idle, run, stop);
END_TYPE

PROGRAM main
VAR
    now : State;
    i   : INT := 1;
    q   : BOOL;
END_VAR

RUNG
    [now + 1 > i] (q)

RUNG
    [now < 2] <MOVE(IN := now + 1, OUT => i)>
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.ld", [{}, {"now": 1}, {"now": 2}], ("i", "q"))
    assert rows == [(1, False), (2, True), (2, True)]


@pytest.mark.parametrize("statement", [
    "b := mode;", "i := mode;", "b := level;", "u := level;", "state := l;", "state := r;", "r := state;",
    "state := mode;", "q := state = mode;", "i := state + mode;", "i := i + mode;", "q := state;", "state := q;",
    "i := -state;", "i := state + 'a';", "i := state AND 1;", "state := 5000000000;", "state := 1.5;",
    "i := state ** 2;", "state := T#1s;", "part := stop;", "part := state;", "b := many;",
])
def test_what_may_not_fit_or_is_no_number_is_an_error(statement: str) -> None:
    found = checked(f"{HEAD}{statement} END_PROGRAM", "main.st").diagnostics
    assert found.has_errors
    assert not [d for d in found if d.code == "LD0901"]


def test_a_value_of_its_own_type_gives_no_warning() -> None:
    body = "state := run; q := state = idle; CASE state OF run: i := 1; END_CASE;"
    codes = [[d.code for d in checked(f"{HEAD}{text} END_PROGRAM", "main.st").diagnostics] for text in ("", body)]
    assert codes[0] == codes[1]
