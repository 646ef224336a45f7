"""The paper's program 3: the ejector comes into the injection machine while it cycles (SPEC 11.3)."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from test_system_online import ENGINES, Online, loaded

from ldc import pipeline
from ldc.cli import system as systems
from ldc.cli.compiling import native_code
from ldc.diagnostics import Invalid
from runtime.online.controller import Controller
from runtime.units import C_START, UnitEvent

SAMPLE = Path(__file__).resolve().parents[1] / "samples" / "injection_machine"
MODULES = ("clamp", "inject", "charge", "cooling", "suck_back")


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    """The machine without its ejector, and with it."""
    without, whole = tmp_path / "without", tmp_path / "whole"
    for folder in (without, whole):
        shutil.copytree(SAMPLE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    (without / "ejector.ld").unlink()
    project = (without / "ldc.toml").read_text()
    project = project.replace('"ejector", ', "").replace('    { module = "ejector" },\n', "")
    (without / "ldc.toml").write_text(re.sub(r"\[messages\.part\].*?\n\n", "", project, flags=re.S))
    return without, whole


class Starts(list):
    """Events, those alone that start a module: a cycle has thousands of others."""

    def append(self, event: UnitEvent) -> None:
        if event.unit == C_START:
            super().append(event)


class Machine(Online):
    """The machine, switched to automatic; ``late``: scans that did not follow the one before by a period."""

    def __init__(self, folder: Path, engine: str) -> None:
        self.engine, first = engine, loaded(folder, engine)
        self.controller, self.events = Controller(first), Starts()
        result = pipeline.compile_paths([str(folder)])
        self.system = systems.system(result, self.controller, native_code(result), self.events)
        self.late = self.count = 0
        for name in ("guard", "motor_ok", "auto_switch"):
            self.system.machine.set(name, True)

    def scans(self, count: int) -> None:
        for _ in range(count):
            before = self.system.machine.now_ns
            self.system.scan()
            self.count += 1
            self.late += self.system.machine.now_ns - before != self.system.machine.period_ns

    def until(self, path: str, value: object = True) -> None:
        for _ in range(1500):
            if self.system.machine.get(path) == value:
                return
            self.scans(1)
        raise AssertionError(f"{path} never became {value}")

    def started(self) -> list[str]:
        """The modules in the order in which they were started, by the names of the program that runs now."""
        names = [m.name for m in self.system.master.coordination.modules]
        return [names[e.index] for e in self.events]


@ENGINES
def test_the_ejector_is_inserted_while_the_machine_cycles(folders: tuple[Path, Path], engine: str) -> None:
    without, whole = folders
    m = Machine(without, engine)
    while len(m.events) < 7:
        m.scans(1)
    assert m.started() == [*MODULES, "clamp", "clamp"]
    m.until("charge.start")
    m.scans(20)
    kept = {path: m.system.machine.get(path) for path in
            ("control.blink.ET", "mould_locked", "charge.axis.position", "inject.full", "charge.start")}
    m.events.clear()
    m.test(whole)
    assert {path: m.system.machine.get(path) for path in kept} == kept
    m.until("ejector.part")
    m.until("control.parts.CV", 1)
    m.scans(900)
    assert m.started()[:5] == ["cooling", "suck_back", "clamp", "ejector", "clamp"]
    assert m.started()[5:9] == list(MODULES[1:])
    assert not m.late and m.system.machine.scans == m.count
    assert not m.system.machine.faults
    m.end("commit")
    m.until("control.parts.CV", 2)


@pytest.mark.parametrize("file, old, new, code", [
    ("ejector.ld", "goal      : REAL", "goal      : BOOL", "LD0"),
    ("control.ld", "CTU", "CTU_DINT", "LD0820"),
])
def test_an_invalid_program_is_refused_and_the_machine_runs_on(
        folders: tuple[Path, Path], file: str, old: str, new: str, code: str) -> None:
    """It does not compile; or it compiles, and what is kept has another type."""
    without, whole = folders
    text = (whole / file).read_text()
    assert old in text
    (whole / file).write_text(text.replace(old, new))
    m = Machine(without, "vm")
    m.until("inject.start")
    with pytest.raises((Invalid, AssertionError)) as refused:
        m.test(whole)
    assert code in str(refused.value)
    m.until("cooling.start")
    assert m.controller.state == "running"
    assert not m.late and not m.system.machine.faults


@ENGINES
def test_without_the_ejector_again_the_cycle_goes_on(folders: tuple[Path, Path], engine: str) -> None:
    without, whole = folders
    m = Machine(without, engine)
    m.until("charge.start")
    m.test(whole)
    m.until("ejector.done")
    m.end("untest")
    m.events.clear()
    m.until("charge.start", False)
    m.until("charge.start")
    assert "ejector" not in m.started()
    assert not m.late and not m.system.machine.faults
