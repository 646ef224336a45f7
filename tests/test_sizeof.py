"""SIZEOF: a constant that has the type its context asks for."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, trace

HEAD = """TYPE
    Colour : (red, green); Large : (few, many := 70000); Small : (off, lit) USINT;
    Point : STRUCT a : BOOL; b : LREAL; c : INT; END_STRUCT;
    Line : STRUCT p, q : Point; name : STRING[5]; END_STRUCT;
END_TYPE
VAR_GLOBAL CONSTANT room : INT := SIZEOF(Point) / 2; END_VAR
PROGRAM main
VAR
    a : ARRAY [0..3] OF INT; b : ARRAY [-1..1, 0..1] OF Point; p : Point; l : Line; t : TON; text : STRING; wide : WSTRING[9];
    c : Colour; c2 : Large; c3 : Small; part : DINT (1..5); tm : TIME; d : DATE; day : DT; x : BOOL; w : LWORD;
    i, n : INT; u : UDINT; re : REAL; sizes : ARRAY [1..20] OF UDINT; field : ARRAY [1..room] OF BYTE;
END_VAR
"""


def test_values_on_every_engine(tmp_path: Path) -> None:
    of = {"a": 8, "a[i]": 2, "b": 6 * 24, "p": 24, "p.b": 8, "l": 56, "l.name": 6, "text": 81, "wide": 20, "c": 2, "c2": 4, "c3": 1,
          "part": 4, "tm": 4, "day": 4, "x": 1, "w": 8, "INT": 2, "Line": 56, "field": 12}
    lines = "".join(f"sizes[{n}] := SIZEOF({name});\n" for n, name in enumerate(of, 1))
    text = f"""{HEAD}{lines}    FOR i := 0 TO SIZEOF(a) / SIZEOF(a[0]) - 1 DO n := n + 1; END_FOR;
    u := u + SIZEOF(text); re := SIZEOF(p); i := LEN(text) + SIZEOF(a);
END_PROGRAM
"""
    names = tuple(f"sizes[{n}]" for n in range(1, 21))
    rows = trace(tmp_path, text, "main.st", [{}], (*names, "n", "u", "re"))
    assert rows == [(*of.values(), 4, 81, 24.0)]


@pytest.mark.parametrize("value", ["SIZEOF(t)", "SIZEOF()", "SIZEOF(a, b)", "SIZEOF(nothing)", "SIZEOF(3)", "SIZEOF(TON)",
                                   "SIZEOF(x := a)", "SIZEOF(main)", "SIZEOF(a[9])"])
def test_what_has_no_size_is_told(value: str) -> None:
    found = checked(f"{HEAD}u := {value}; END_PROGRAM", "main.st").diagnostics
    assert found.has_errors
    assert not [d for d in found if d.code == "LD0901"]
