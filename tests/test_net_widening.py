"""Values of nets in the type of the pin that they go to: widened on all engines, and proved."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import pytest
from everywhere import checked, trace

TYPES = ("INT", "UINT", "DINT", "REAL", "WORD", "TIME")
HEAD = """FUNCTION_BLOCK F
VAR_INPUT x : BOOL; p : DINT; s : REAL; END_VAR
VAR_OUTPUT q : BOOL; o : INT; sum : REAL; END_VAR
RUNG [x] (q)
RUNG <ADD(IN1 := p, IN2 := 1, OUT => @n) in=_ out=_>; <DINT_TO_REAL(IN := @n, OUT => @r) in=_>;
    <ADD(IN1 := @r, IN2 := s, OUT => sum) in=_>
RUNG <MOVE(IN := 7, OUT => o)>
END_FUNCTION_BLOCK
FUNCTION g : DINT VAR_INPUT p : DINT; END_VAR
RUNG <ADD(IN1 := p, IN2 := 100000, OUT => g)>
END_FUNCTION
PROGRAM main
VAR
    go, q, big : BOOL; i : INT := 3; d : DINT := 5; re : REAL := 0.5; w : WORD := 16#8001; dw : DWORD; f : F;
END_VAR
"""


def test_nets_of_operators_functions_and_blocks(tmp_path: Path) -> None:
    text = HEAD + """RUNG <ADD(IN1 := i, IN2 := i, OUT => @n) in=_ out=_>; [go] <f: F(p := @n, s := @n)> (q)
RUNG <SUB(IN1 := i, IN2 := 10, OUT => @n) in=_ out=_>; <ADD(IN1 := @n, IN2 := d, OUT => d) in=_>;
    <GT(IN1 := @n, IN2 := re) in=_ out=OUT> (big)
RUNG <f: F(o => @n) in=_ out=_>; <g(p := @n, OUT => @m) in=_>; [go] <MOVE(IN := @m, OUT => d)>;
    <ADD(IN1 := @n, IN2 := re, OUT => re) in=_>
RUNG <OR(IN1 := w, IN2 := 1, OUT => @n) in=_ out=_>; <OR(IN1 := @n, IN2 := dw, OUT => dw) in=_>
END_PROGRAM
"""
    names = ("q", "big", "d", "re", "dw", "f.sum")
    rows = trace(tmp_path, text, "main.ld", [{}, {"go": 1}, {"i": 30}], names)
    assert rows == [(False, False, -2, 7.5, 0x8001, 13.0), (True, False, 100007, 14.5, 0x8001, 13.0),
                    (True, True, 100007, 21.5, 0x8001, 121.0)]


@pytest.mark.parametrize(("given", "taken"), list(product(TYPES, repeat=2)))
def test_a_net_goes_where_a_variable_goes(given: str, taken: str) -> None:
    text = (f"FUNCTION_BLOCK F VAR_INPUT x : BOOL; p : {taken}; END_VAR VAR_OUTPUT q : BOOL; END_VAR "
            f"RUNG [x] (q)\nEND_FUNCTION_BLOCK PROGRAM main VAR v : {given}; f : F; END_VAR RUNG ")
    net = checked(f"{text}<MOVE(IN := v, OUT => @n) in=_ out=_>; <f: F(p := @n) in=_ out=_>\nEND_PROGRAM", "a.ld")
    variable = checked(f"{text}<f: F(p := v) in=_ out=_>\nEND_PROGRAM", "a.ld")
    # A variable that is a bit string counts as a number with a warning, what a net carries does not.
    refused = ["LD0313"] if any(d.code in ("LD0403", "LD0240") for d in variable.diagnostics) else []
    assert [d.code for d in net.diagnostics if d.severity.value == "error"] == refused
