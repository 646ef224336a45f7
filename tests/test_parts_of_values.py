"""Bits and parts of numbers by path (`n.3`, `n.%B1`, `n.%W1.15`): read, set, forced, safe, the same on both engines."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import native
from online_programs import loaded
from ldc.cli.main import main
from ldc.types import ELEMENTARY
from runtime.symbols import UnknownSymbol

TYPES = ("SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT", "BYTE", "WORD", "DWORD", "LWORD")
SIZES = {"X": 1, "B": 8, "W": 16, "D": 32, "L": 64}
ENGINES = ("vm", pytest.param("native", marks=native.needs_gcc))
TEXT = "PROGRAM p\nVAR\n" + "".join(
    f"  n{name} : {name};\n  a{name} : ARRAY[1..2] OF {name};\n" for name in TYPES
) + "  small : INT (0..9);\n  flag AT %IX0.0 : BOOL;\n  q AT %QW2 : INT;\n  i AT %IW2 : INT;\n  copy : INT;\n" \
    "  x : REAL;\nEND_VAR\nRUNG r\n  <MOVE(IN := i, OUT => copy)>\nEND_PROGRAM\n"


@cache
def machine(engine: str):
    return loaded(TEXT, engine).machine


@st.composite
def parts(draw) -> tuple[str, int, str, int, int]:
    """A type, a value, the path of a part, its first bit and its size."""
    name = draw(st.sampled_from(TYPES))
    low, high = ELEMENTARY[name].range
    size, first, text = ELEMENTARY[name].bits, 0, ""
    for letter in draw(st.lists(st.sampled_from("BWDL"), max_size=2)):
        if SIZES[letter] <= size:
            number = draw(st.integers(0, size // SIZES[letter] - 1))
            size, first, text = SIZES[letter], first + number * SIZES[letter], f"{text}.%{letter}{number}"
    if not text or draw(st.booleans()):
        number = draw(st.integers(0, size - 1))
        size, first, text = 1, first + number, text + draw(st.sampled_from((f".{number}", f".%x{number}")))
    return name, draw(st.integers(low, high)), text, first, size


@pytest.mark.parametrize("engine", ENGINES)
@settings(max_examples=150, deadline=None)
@given(part=parts(), new=st.integers(0, 2**64 - 1), place=st.sampled_from(("n{}", "a{}[2]")))
def test_a_part_is_these_bits_of_the_number(engine: str, part, new: int, place: str) -> None:
    name, value, text, first, size = part
    ones, whole = (1 << size) - 1, ELEMENTARY[name]
    path, new = place.format(name), new & ones
    run = machine(engine)
    run.set(path, value)
    assert run.get(path + text) == value >> first & ones
    symbol = run.symbols.find(path + text)
    assert run.reader([symbol])() == (run.get(path + text),)
    run.assign(symbol, bool(new) if size == 1 else new)
    bits = (value & (1 << whole.bits) - 1) & ~(ones << first) | new << first
    assert run.get(path) == (bits - (1 << whole.bits) if bits > whole.range[1] else bits)
    assert run.symbols.find(run.symbols.full(symbol)).place == symbol.place


@pytest.mark.parametrize("path", ["nINT.16", "nINT.%B2", "nINT.%D0", "nINT.%W0.16", "flag.0", "x.0", "nINT.3.0",
                                  "aINT.3", "nINT.%Q0", "nINT.%B", "nINT.-1"])
def test_parts_that_a_value_does_not_have(path: str) -> None:
    with pytest.raises(UnknownSymbol):
        machine("vm").symbols.find(path)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_bit_of_an_input_is_forced_and_the_others_come_in(engine: str) -> None:
    run = loaded(TEXT, engine).machine
    run.forces.add("i.15", "1")
    run.forces.add("i.%B0", "3")
    run.set("i", 0x1FF)
    run.scan()
    assert run.get("copy") == 0x103 - 0x8000
    assert len(run.forces.rows) == 2, "bit 0 and byte 0 are not the same"
    run.forces.remove("i.%X15")
    run.scan()
    assert run.get("copy") == 0x103
    run.forces.remove("i.%B0")
    run.scan()
    assert run.get("copy") == 0x1FF


@pytest.mark.parametrize("engine", ENGINES)
def test_watch_force_and_safe_name_bits_of_integers(engine: str, tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.st").write_text("PROGRAM p\nVAR q AT %QW2 : INT; n, z : INT; END_VAR\n"
                               "q := 100; n := n + 1; IF n > 2 THEN n := n / z; END_IF;\nEND_PROGRAM\n")
    Path("ldc.toml").write_text('[project]\nname = "p"\n[safe]\n"%QW2" = 5\n"p.q.3" = true\n"q.15" = true\n'
                                '[run]\nwatch = ["q", "n.%X1", "q.%B0"]\n')
    assert main(["run", ".", "--scans", "3", "--trace", "-", "--engine", engine, "--force", "n.4=1"]) == 1
    out = capsys.readouterr().out
    # The force makes it 16 before the first scan, which counts: the division faults at once.
    assert out.splitlines() == ["scan,t_ms,q,n.%X1,q.%B0"] + [f"{n},{10 * n},-32755,0,13" for n in range(3)]
