"""Bits of integers and parts of bit strings, read and written, against arithmetic on plain numbers."""

from __future__ import annotations

from pathlib import Path

import native
import pytest
from everywhere import PERIOD, checked, compiled, trace
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc.components import toolchain
from runtime.vm.machine import Machine
from runtime.vm.stepping import Stepper

BITS = {"SINT": 8, "USINT": 8, "BYTE": 8, "INT": 16, "UINT": 16, "WORD": 16, "DINT": 32, "UDINT": 32, "DWORD": 32,
        "LINT": 64, "ULINT": 64, "LWORD": 64}
PARTS = {"B": ("BYTE", 8), "W": ("WORD", 16), "D": ("DWORD", 32), "L": ("LWORD", 64)}
LOCATED = {"INT": " AT %MW100", "WORD": " AT %QW4", "DINT": " AT %MD70", "LINT": " AT %ML20", "SINT": " AT %MB9"}
HEAD = f"""VAR_GLOBAL CONSTANT top : INT := 7; END_VAR
PROGRAM main
VAR
    x, y : BOOL; k : INT := 1; field : ARRAY [0..2] OF INT; words : ARRAY [0..2] OF DWORD;
    p_BYTE : BYTE; p_WORD : WORD; p_DWORD : DWORD; p_LWORD : LWORD;
{"".join(f"    v_{name}{LOCATED.get(name, '')} : {name};" + chr(10) for name in BITS)}END_VAR
"""


@st.composite
def moves(draw) -> tuple[str, str, int, int, bool]:
    """A variable and what of it is moved: the type, the text of the part, its first bit and width, the direction."""
    name = draw(st.sampled_from(sorted(BITS)))
    writes = draw(st.booleans())
    size = draw(st.sampled_from(["X", "X", *(s for s, (_, bits) in PARTS.items() if bits <= BITS[name])]))
    if size == "X":
        at = draw(st.integers(0, BITS[name] - 1) | st.just(BITS[name] - 1))
        return name, draw(st.sampled_from([f".{at}", f".%X{at}"])), at, 1, writes
    at = draw(st.integers(0, BITS[name] // PARTS[size][1] - 1))
    return name, f".%{size}{at}", at * PARTS[size][1], PARTS[size][1], writes


def wrapped(value: int, name: str) -> int:
    value &= (1 << BITS[name]) - 1
    return value - (1 << BITS[name]) if name.endswith("INT") and name[0] != "U" and value >> BITS[name] - 1 else value


@settings(max_examples=25, deadline=None)
@given(st.lists(moves(), min_size=1, max_size=12), st.integers(0, 2**64 - 1), st.integers(0, 2**64 - 1))
def test_every_bit_and_part_on_vm_stepping_and_native(chosen, seed: int, other: int) -> None:
    values = {f"v_{name}": wrapped(seed, name) for name in BITS}
    values |= {f"p_{name}": wrapped(other, name) for name, _ in PARTS.values()} | {"x": other % 3 == 0}
    lines = []
    expected = dict(values)
    for name, text, first, width, writes in chosen:
        side = "x" if width == 1 else next(f"p_{part}" for part, bits in PARTS.values() if bits == width)
        lines.append(f"v_{name}{text} := {side};" if writes else f"{side} := v_{name}{text};")
        mask, whole = (1 << width) - 1, expected[f"v_{name}"]
        if writes:
            expected[f"v_{name}"] = wrapped(whole & ~(mask << first) | int(expected[side]) << first, name)
        else:
            expected[side] = type(expected[side])(whole >> first & mask)
    program = compiled(f"{HEAD}{chr(10).join(lines)}\nEND_PROGRAM\n", "main.st").program
    machines = [Machine(program, period_ns=PERIOD), Machine(program, period_ns=PERIOD)]
    scans = [machines[0].scan, Stepper(machines[1]).scan]
    if toolchain.find(toolchain.GCC) is not None:
        machines.append(native.machine(program, PERIOD))
        scans.append(machines[2].scan)
    for machine, scan in zip(machines, scans, strict=True):
        for name, value in values.items():
            machine.set(f"main.{name}", value)
        scan()
        assert {name: machine.get(f"main.{name}") for name in values} == expected


def test_in_all_texts(tmp_path: Path) -> None:
    text = HEAD + """
    v_INT.15 := x; v_INT.top := NOT x; y := v_INT.15; field[k].0 := y; v_DINT.31 := field[k].%X0;
    v_DWORD.%W1 := v_WORD; v_WORD.%B1 := v_BYTE + 1; p_WORD := v_DWORD.%W1; words[k].%B3 := 16#80;
    v_LWORD.%D1.%W0 := p_WORD; v_LWORD.%D1.%W1.15 := TRUE; p_BYTE := v_LWORD.%D1.%B3; v_UINT.%B1 := 3;
    IF v_DINT.31 AND v_LWORD.%W3.%X15 AND v_LWORD.%B7.7 THEN k := 2; END_IF;
END_PROGRAM
"""
    names = ("v_INT", "y", "field[1]", "v_DINT", "v_DWORD", "v_WORD", "words[1]", "words[2]", "v_LWORD", "p_BYTE", "v_UINT",
             "k")
    rows = trace(tmp_path, text, "main.st", [{"x": True, "v_WORD": 0x1234, "v_BYTE": 7}, {"x": False}], names)
    assert rows[0] == (-32768, True, 1, -(1 << 31), 0x12340000, 0x834, 0x80000000, 0, 0x80001234 << 32, 0x80, 768, 2)
    assert rows[1][0] == 128
    assert {d.code for d in checked(text, "main.st").diagnostics} == {"LD0240"}


def test_in_ladders(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR
    i, n  : INT;
    w     : WORD := 16#0180;
    q     : BOOL;
    t     : TON;
END_VAR

RUNG
    [i.3] { (n.15) | (S n.0) } <MOVE(IN := w.%B1, OUT => w)> (R i.3)

RUNG
    [P n.15] (q)
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.ld", [{}, {"i": 9}, {}, {"i": -1}], ("i", "n", "w", "q"))
    assert rows == [(0, 0, 384, False), (1, -32767, 1, True), (1, 1, 1, False), (-9, -32767, 0, True)]


@pytest.mark.parametrize("statement", [
    "x := v_INT.16;", "v_SINT.8 := x;", "x := k.k;", "x := v_INT.none;", "x := v_WORD.%X16;", "p_BYTE := v_WORD.%B2;",
    "p_LWORD := v_DWORD.%L0;", "p_BYTE := v_WORD.%B1.%B0.8;", "x := v_DWORD.%W1.16;", "p_BYTE := v_DWORD.%W2.%B0;",
    "p_BYTE := v_DWORD.%W0.%B2;", "v_WORD.%B1 := p_WORD;", "p_BYTE := x.%B0;", "x := x.0;", "v_WORD.%W1 := 3;",
    "x := v_WORD.%Z1;", "x := v_WORD.%B;", "x := v_WORD.%B1.%X;", "p_BYTE := v_WORD.%B99999;", "field.%B0 := 1;",
    "FOR v_WORD.%B1 := 0 TO 3 DO ; END_FOR;", "x := v_DWORD.%X1.3;",
])
def test_what_is_no_part_is_told(statement: str) -> None:
    found = checked(f"{HEAD}{statement}\nEND_PROGRAM", "main.st").diagnostics
    assert found.has_errors
    assert not [d for d in found if d.code == "LD0901"]
