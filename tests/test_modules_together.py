"""Modules that a sequence and messages start, over the whole master: the example of the page, and program 2
of the paper on the injection machine in both of its variants (SPEC 11.3)."""

from __future__ import annotations

from pathlib import Path

import pytest
from documents import blocks

from ldc import pipeline
from ldc.cli.coordinate import coordination
from runtime.field import Field
from runtime.system import System
from runtime.units import C_BCAST, C_END, C_MSG, C_START, UnitEvent
from runtime.vm.machine import Machine

MS = 1_000_000
PAGE = Path(__file__).resolve().parent.parent / "docs" / "messages.md"

TOML = """\
[project]
modules = ["clamp", "inject", "eject"]

[sequence]
repeat = false
steps = ["clamp"]

[messages.clamped]
from = "{source}"
data = "clamp.force"
to = [{{ module = "inject", data = "force" }}, {{ module = "eject", flag = "heard" }}]
"""

PRESS = """\
VAR_GLOBAL
    obstacle : BOOL;
    guarded  : BOOL;
END_VAR

PROGRAM clamp
VAR_INPUT
    start : BOOL;
END_VAR
VAR_OUTPUT
    done  : BOOL;
    high  : BOOL;
    force : REAL;
END_VAR
VAR_EXTERNAL
    obstacle : BOOL;
    guarded  : BOOL;
END_VAR
VAR
    approach : TON;
    protect  : TON;
    press    : TON;
END_VAR

RUNG
    [start] <approach: TON(PT := T#100ms)> [/obstacle] <protect: TON(PT := T#50ms)> (guarded)
    <press: TON(PT := T#100ms)> (done)

RUNG
    [guarded] [/done] (high) <MOVE(IN := 1250.5, OUT => force)>
END_PROGRAM

PROGRAM inject
VAR_INPUT
    start : BOOL;
    force : REAL;
END_VAR
VAR_OUTPUT
    done      : BOOL;
    injecting : BOOL;
END_VAR
VAR_EXTERNAL
    guarded : BOOL;
END_VAR
VAR
    fill : TON;
END_VAR

RUNG
    [start] {guard} (injecting) <fill: TON(PT := T#200ms)> (done)
END_PROGRAM

PROGRAM eject
VAR_INPUT
    start : BOOL;
    heard : BOOL;
END_VAR
VAR_OUTPUT
    done  : BOOL;
    times : INT;
END_VAR

RUNG
    [heard] <ADD(IN1 := times, IN2 := 1, OUT => times)>
END_PROGRAM
"""


def system(folder: Path, files: dict[str, str]) -> tuple[System, list[UnitEvent]]:
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    result = pipeline.compile_paths([str(folder)])
    assert result.program is not None, list(result.diagnostics)
    events: list[UnitEvent] = []
    machine = Machine(result.program, 0, 10 * MS, ())
    return System(machine, (), {}, coordination(result), Field(bytearray(4), {}), events=events), events


def seen(events: list[UnitEvent], *units: str) -> list[tuple[int, str, int]]:
    return [(e.time_ns // MS, e.unit, e.index) for e in events if e.unit in units]


def read(system: System, path: str) -> object:
    return system.machine.value(system.machine.symbols.find(path))


def write(system: System, path: str, value: object) -> None:
    system.machine.assign(system.machine.symbols.find(path), value)


def test_the_example_of_the_page_runs_as_its_table_says(tmp_path: Path) -> None:
    files = {Path(b.file).name: b.text for b in blocks(PAGE.read_text(encoding="utf-8")) if b.file}
    press, events = system(tmp_path, files)
    write(press, "auto", True)
    on_clamped = []
    for _ in range(70):
        press.scan()
        if read(press, "lamps.on_clamped"):
            on_clamped.append(press.machine.now_ns // MS)
    assert seen(events, C_START, C_END, C_BCAST, C_MSG) == [
        (10, C_START, 0), (310, C_END, 0), (310, C_BCAST, 64), (310, C_MSG, 64), (310, C_MSG, 64),
        (320, C_START, 1), (620, C_END, 1), (630, C_START, 2), (680, C_END, 2), (690, C_START, 0)]
    assert read(press, "lamps.clamped.CV") == 1 and read(press, "clamp.closing") == 200 * MS
    assert len(on_clamped) == 1


@pytest.mark.parametrize(("source", "guard", "overlap"), [
    ("guarded", "[guarded]", 9),  # before high pressure, as the heading has it, with the interlock
    ("clamp.done", "", 0),  # when clamping has ended, as the body has it
], ids=["before high pressure", "at the end"])
def test_program_2_of_the_paper(tmp_path: Path, source: str, guard: str, overlap: int) -> None:
    press, events = system(tmp_path, {"ldc.toml": TOML.format(source=source),
                                      "main.ld": PRESS.replace("{guard}", guard)})
    both = 0
    for _ in range(60):
        press.scan()
        both += bool(read(press, "clamp.high") and read(press, "inject.injecting"))
    assert both == overlap
    ((sent, _, number),) = seen(events, C_BCAST)
    assert number == 64
    starts = seen(events, C_START)
    assert [module for _, _, module in starts] == [0, 1] and starts[1][0] - sent == 10
    assert read(press, "eject.times") == 1 and read(press, "inject.force") == 1250.5


def test_the_interlock_stops_the_injection_in_the_same_scan(tmp_path: Path) -> None:
    press, _ = system(tmp_path, {"ldc.toml": TOML.format(source="guarded"),
                                 "main.ld": PRESS.replace("{guard}", "[guarded]")})
    while not read(press, "inject.injecting"):
        press.scan()
    write(press, "obstacle", True)
    press.scan()
    assert not read(press, "inject.injecting") and not read(press, "clamp.high")
