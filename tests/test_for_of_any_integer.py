"""FOR with variables and ends of every integer type and bit string, against a loop in Python."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import PERIOD, checked, trace
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.vm.machine import Machine

BITS = {"SINT": 8, "USINT": 8, "BYTE": 8, "INT": 16, "UINT": 16, "WORD": 16, "DINT": 32, "UDINT": 32, "DWORD": 32,
        "LINT": 64, "ULINT": 64, "LWORD": 64}
SIGNED = ("SINT", "INT", "DINT", "LINT")


def ends(name: str) -> tuple[int, int]:
    return (-1 << BITS[name] - 1, (1 << BITS[name] - 1) - 1) if name in SIGNED else (0, (1 << BITS[name]) - 1)


def counted(name: str, start: int, stop: int, step: int) -> tuple[int, int]:
    """Rounds, and the variable after the loop."""
    low, high = ends(name)
    now, rounds = start, 0
    while now <= stop if step > 0 else now >= stop:
        rounds += 1
        if not low <= now + step <= high:
            break
        now += step
    return rounds, now


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(sorted(BITS)), st.sampled_from(sorted(BITS)), st.data())
def test_rounds_and_last_value(name: str, other: str, data) -> None:
    step = data.draw(st.sampled_from([1, 1, 2, 7, -1, -3]))
    near = st.sampled_from([*ends(name), *ends(other), 0, 100])
    low, high = ends(other)
    stop = min(max(data.draw(near) + data.draw(st.integers(-20, 20)), low), high)
    low, high = ends(name)
    start = min(max(stop - step * data.draw(st.integers(-3, 40)), low), high)
    if abs(stop - start) > 600:
        stop = start if ends(other)[0] <= start <= ends(other)[1] else stop
    if (stop - start) * step > 5000:
        return
    text = (f"PROGRAM main VAR k : {name}; stop : {other}; n : DINT; END_VAR\n"
            f"FOR k := {start} TO stop BY {step} DO n := n + 1; END_FOR;\nEND_PROGRAM\n")
    result = checked(text, "main.st")
    if result.diagnostics.has_errors:  # no type holds both
        assert {d.code for d in result.diagnostics if d.severity == "error"} == {"LD0403"}
        assert 64 in (BITS[name], BITS[other]) and (name in SIGNED) != (other in SIGNED)
        return
    machine = Machine(result.program, period_ns=PERIOD)
    machine.set("stop", stop)
    machine.scan()
    assert not machine.faults
    assert (machine.get("n"), machine.get("k")) == counted(name, start, stop, step)


def test_on_every_engine(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR b : BYTE; w : WORD := 300; u : USINT; i, n, m, all : INT; field : ARRAY [0..7] OF INT; bits : DWORD; top : INT := 254;
    part : UINT (0..9); END_VAR
    FOR b := 0 TO 7 DO field[b] := field[b] + b; END_FOR;
    FOR b := 250 TO 255 DO n := n + 1; END_FOR;
    FOR i := 0 TO w DO all := all + 1; IF i = 200 THEN EXIT; END_IF; END_FOR;
    FOR u := 250 TO top DO m := m + 1; END_FOR;
    FOR w := 16#10 TO 0 BY -1 DO all := all + 1; IF w = 3 THEN CONTINUE; END_IF; m := m + 1; END_FOR;
    FOR bits := 1 TO n BY 2 DO all := all + 1; END_FOR;
    FOR part := 0 TO b - 250 DO all := all + 1; END_FOR;
END_PROGRAM
"""
    names = ("field[7]", "b", "n", "all", "i", "u", "m", "w", "bits", "part")
    rows = trace(tmp_path, text, "main.st", [{}, {"top": 300, "w": 5}], names)
    assert rows[0] == (7, 255, 6, 201 + 17 + 3 + 6, 200, 255, 5 + 16, 0, 7, 6)
    assert rows[1][5:7] == (255, 21 + 6 + 16)


@pytest.mark.parametrize("loop", [
    "r := 0 TO 3", "i := 0 TO l", "u := 0 TO x", "b := i TO 3", "u := 0 TO 300", "b := 0 TO 3 BY i", "x := 0 TO 3",
    "i := 0 TO r", "u := 0 TO 3 BY 0",
])
def test_what_does_not_count_is_an_error(loop: str) -> None:
    text = ("PROGRAM main VAR r : REAL; i : INT; l : ULINT; u : USINT; b : BYTE; x : BOOL; END_VAR\n"
            f"FOR {loop} DO ; END_FOR; END_PROGRAM\n")
    assert checked(text, "main.st").diagnostics.has_errors
