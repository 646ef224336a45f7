"""Firmware for a command: what a machine knows of tasks and places goes into a plan, an image, and into
QEMU."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from ldc import pipeline
from ldc.backends.firmware import board, components, findings, plan, qemu, remote, tools
from ldc.backends.firmware.board import Board
from ldc.backends.firmware.plan import FirmwarePlan, TaskPlan
from ldc.backends.firmware.tools import Firmware
from ldc.cli.console import Failure, UsageError, reason, report
from ldc.components import pace
from ldc.components.project import Native
from ldc.diagnostics import Diagnostics, Invalid
from ldc.il import block
from ldc.manifest import Manifest
from runtime.firmware.machine import Machine
from runtime.stimuli import Stimuli

Numbered = tuple[int, Native]

TIMEOUT = 120.0
"""Seconds that QEMU may take; LDC_QEMU_TIMEOUT says another number."""


def chosen(target: str, wanted: str | None) -> tuple[Board, Path | None]:
    """The board of a target and the folder of its file. Raises Invalid."""
    diagnostics = Diagnostics()
    found = board.find(target, wanted, diagnostics)
    if found is None:
        raise Invalid(diagnostics)
    return found


def machine(result: pipeline.Compiled, resource: int, period: int | None, manifest: Manifest | None,
            areas: Mapping[str, int] | None = None) -> Machine:
    """The machine that goes through what the firmware did, before it is built. ``areas``: the sizes of I, Q
    and M of the build before."""
    memory = block.make(result.program, result.image.layout, resource, areas)
    period = period or (manifest.period if manifest else None)
    return Machine(result.program, resource, period, block=memory, parts=())


def planned(made: Machine, result: pipeline.Compiled, on: Board, room: Path | None) -> FirmwarePlan:
    """All files of the firmware for a machine, which then knows the map of the code. ``room``: the folder of
    a board file. Raises Invalid and Failure."""
    tasks = [TaskPlan(s.task.name, s.task.interval or 0, s.task.watchdog, s.runs, made.single_spot(s),
                      made.safe_values(s)) for s in made.schedules]
    if len(tasks) > plan.TASKS_MOST:
        raise Failure(f"firmware runs at most {plan.TASKS_MOST} tasks, this project has {len(tasks)}")
    diagnostics = Diagnostics()
    here, there = divided(result.natives, on, diagnostics)
    memory = components.memory_of(made.block, result.model.globals.values())
    try:
        parts = components.build(here, memory, on.cpu, diagnostics)
        others = components.build(there, components.memory_of_slave("slave1"), on.cpu, diagnostics)
        further = [(name, source_text(room / name)) for name in on.sources] if room else []
    except (OSError, UnicodeDecodeError) as error:
        raise Failure(f"cannot make firmware: {error}") from error
    if diagnostics.has_errors:
        raise Invalid(diagnostics)
    report(diagnostics)
    manifest = result.sources.manifest
    slaves = pace.slaves(manifest.processors) if manifest else frozenset()
    steps = {number: native.component.period_us for number, native in there
             if pace.slave_of(native.component, slaves) is not None}
    found = plan.plan(made.block, on, made.period_ns, tasks, result.natives, parts, there, others, further,
                      steps)
    made.parts = found.code.map
    return found


def source_text(path: Path) -> str:
    """A C file of a board, so that the compiler names it in what it says. Raises OSError,
    UnicodeDecodeError."""
    name = path.as_posix().replace("\\", "\\\\").replace('"', '\\"')
    return f'#line 1 "{name}"\n' + path.read_text(encoding="utf-8")


def divided(natives: Sequence[Native], on: Board,
            diagnostics: Diagnostics) -> tuple[list[Numbered], list[Numbered]]:
    """The components of the master and those of slave1, each with its number. A board with one processor runs
    all."""
    numbered = list(enumerate(natives))
    if on.second is None:
        return numbered, []
    there = [pair for pair in numbered if pair[1].component.processor != "master"]
    for _, native in there:
        if native.component.processor not in ("slave", "slave1"):
            findings.no_processor(diagnostics, native, on.name)
        elif (size := remote.slot([(0, native)])) > remote.room():
            findings.call_too_large(diagnostics, native, size, remote.room())
    return [pair for pair in numbered if pair not in there], there


def built(found: FirmwarePlan, folder: Path, name: str) -> Firmware:
    """The image. Raises Invalid and Failure."""
    diagnostics = Diagnostics()
    try:
        firmware = tools.build(found, folder, name, diagnostics)
    except OSError as error:
        raise Failure(f"cannot write firmware: {reason(error)}") from error
    if firmware is None:
        raise Invalid(diagnostics)
    report(diagnostics)
    return firmware


def run(made: Machine, firmware: Firmware, names: Sequence[str], scans: int, stimuli: Stimuli) -> None:
    """Executes all scans in QEMU; the machine goes through them afterwards. Raises Invalid and Failure."""
    on = firmware.plan.board
    if on.qemu is None:
        raise UsageError(f"QEMU has no machine for board `{on.name}`")
    diagnostics = Diagnostics()
    job = made.job(scans, made.find(names), stimuli)
    try:
        trace = qemu.run(on, [image.elf for image in firmware.images], job, timeout(), diagnostics)
    except OSError as error:
        raise Failure(f"cannot run QEMU: {reason(error)}") from error
    if trace is None:
        raise Invalid(diagnostics)
    made.replay(trace)


def timeout() -> float:
    """How long QEMU may take, in seconds. Raises UsageError."""
    text = os.environ.get("LDC_QEMU_TIMEOUT", str(TIMEOUT))
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 0 < seconds < 1e6:
        raise UsageError(f"LDC_QEMU_TIMEOUT is a number of seconds, not `{text}`")
    return seconds
