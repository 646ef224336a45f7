"""Several variables read and written by one function, as whoever asks again and again does it: on both
engines the same as one by one."""

from __future__ import annotations

import random
import shutil
from pathlib import Path

import pytest

from ldc import pipeline
from ldc.cli.compiling import native_code
from ldc.cli.starting import start

FX = """\
TYPE PAIR : STRUCT
    n : INT;
    lit : BOOL;
END_STRUCT; END_TYPE

PROGRAM main
VAR
    go AT %IX0.3 : BOOL;
    wide AT %QW2 : WORD;
    half AT %QB2 : BYTE;
    pair : PAIR;
    name : STRING[8];
    many : ARRAY [0..3] OF LINT;
    speed : REAL;
    place : LREAL;
    late : TON;
    first, second : BOOL;
END_VAR

RUNG late
    [go] <late: TON(PT := T#20ms)> (first)
END_PROGRAM
"""


@pytest.mark.parametrize("engine", ["vm", pytest.param("native", marks=pytest.mark.skipif(
    shutil.which("gcc") is None, reason="native code needs gcc"))])
def test_all_at_once_is_as_one_by_one(tmp_path: Path, engine: str) -> None:
    source = tmp_path / "main.ld"
    source.write_text(FX)
    result = pipeline.compile_paths([str(source)])
    assert not result.diagnostics.has_errors, [d.message for d in result.diagnostics]
    machine = start(result, 10_000_000, result.sources.manifest, engine, native_code(result))
    draws, symbols = random.Random(1), list(machine.symbols.all(hidden=True))
    for path, value in {"main.pair.n": -7, "main.many[2]": 1 << 40, "main.name": "ab", "main.speed": 0.1,
                        "main.place": 1e300, "main.wide": 513, "main.second": True}.items():
        machine.set(path, value)
    for count in (0, 1, 1, 2, *draws.choices(range(2, 12), k=60)):
        wanted = draws.choices(symbols, k=count)
        read, machine_has = machine.reader(wanted), [machine.value(symbol) for symbol in wanted]
        assert read() == read() == tuple(machine_has)
        assert list(map(type, read())) == list(map(type, machine_has))
    paths = "MAIN.PAIR.N", "MAIN.LATE.Q", "MAIN.FIRST", "MAIN.PLACE"
    some = [s for s in symbols if s.path.upper() in paths]
    for wanted in (some, [s for s in some if s.keys]):
        before = machine.reader(wanted)
        before()
        values = [{"bool": True, "int": 41, "real": 2.5}[s.type.kind] for s in wanted]
        machine.writer(wanted)(values)
        assert list(before()) == values == [machine.value(s) for s in wanted]
