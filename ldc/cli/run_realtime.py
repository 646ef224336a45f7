"""`ldc run --realtime`: scans at their time, each slave and the plant in a process of its own
(docs/realtime.md)."""

from __future__ import annotations

import argparse
import os
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import BinaryIO

from ldc import pipeline
from ldc.cli import lateness, system
from ldc.cli.attached import attached
from ldc.cli.compiling import locator
from ldc.cli.console import OK, answered, report, say
from ldc.cli.plant import Plant
from ldc.cli.run import displayed, is_system, run_length, stimuli_of, watched
from ldc.cli.run_options import live
from ldc.cli.watching import LiveTable
from ldc.diagnostics import Invalid
from ldc.il.external import Binding
from ldc.il.placement import points
from ldc.manifest import Sources
from ldc.render import plural
from runtime.field import Field, field_size
from runtime.machine import Machine
from runtime.master.part import MasterPart
from runtime.master.wiring import Wiring
from runtime.protocol.memory import allocate
from runtime.realtime import processes
from runtime.realtime.board import Board
from runtime.realtime.lateness import Figures
from runtime.realtime.master import MasterLoop, Watched
from runtime.realtime.pace import Pace
from runtime.realtime.slave import run_plant, run_slave, slave_period
from runtime.slave.algorithm import makers
from runtime.slave.part import SlavePart
from runtime.units import UnitEvent
from runtime.values import milliseconds

_ACK_MS, _ACK_MS_ORDINARY = 50, 100
"""T_ack with SCHED_FIFO, and for ordinary processes, which may have to wait for others as long."""

_LEAD_NS = 20_000_000
"""Between making the processes and the first period of all."""


def run(options: argparse.Namespace, sources: Sources, result: pipeline.Compiled, machine: Machine,
        beat: Callable[[], None], file: BinaryIO | None, bindings: tuple[Binding, ...],
        events: BinaryIO | None) -> int:
    """As ``ldc.cli.run``, in real time; each slave tells its own faults. Status 1 also when the plant or a
    slave has ended before its time."""
    if options.plot:
        lateness.check(options.plot)
    stimuli = stimuli_of(options.inputs, sources.manifest, machine)
    names = watched(options.watch, sources.manifest, machine)
    scans = run_length(options, stimuli, machine)
    with attached(options, sources, result, machine, names, beside=True) as beside, \
            system.recorded(options.events, events) as record, _interrupted() as came:
        whole = _Run(result, machine, bindings, beat, record.append if record else None)
        whole.loop.until(came)
        try:
            table = LiveTable(machine, names, scans, None, whole.loop.scan) if live(options) else None
            with displayed(options, machine, names, table, file, whole.loop.scan) as (scan, sample):
                for _ in range(scans):
                    stimuli.apply(machine)
                    before = machine.scans
                    scan()
                    if machine.scans == before:  # the run was ended while it waited
                        break
                    sample()
                    beside.scanned()
                    beat()
                    if whole.loop.over:
                        break
        finally:
            whole.finish()
    processors = whole.processors()
    drawn = not options.plot or _drawn(options.plot, processors, beat)
    say(f"{plural(machine.scans, 'scan')}, {milliseconds(whole.passed_ns)} ms of real time")
    for line in lateness.told(processors):
        say(line)
    findings = (*machine.faults, *whole.loop.findings)
    status = report((found.diagnostic() for found in findings), locator(result))
    return max(status, int(whole.broken or not drawn))


def _drawn(target: str, processors: Sequence[lateness.Processor], beat: Callable[[], None]) -> bool:
    """Whether the picture was written, by a process of its own: to load what draws may take longer than a
    scan ever does."""
    def work() -> int:
        return answered("run", lambda: lateness.draw(target, processors) or 0)

    child = processes.start("plot", work)
    while child.look() is None:
        beat()
        time.sleep(0.02)
    return child.status == 0


@contextmanager
def _interrupted() -> Iterator[Callable[[], bool]]:
    """Whether SIGINT or SIGTERM came, which end the run after the scan that is executed."""
    came: list[int] = []
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda number, frame: came.append(number)) for number in numbers]
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)


class _Run:
    """The processes of a run, made and started. ``loop``: of the master, which is this process."""

    def __init__(self, result: pipeline.Compiled, machine: Machine, bindings: tuple[Binding, ...],
                 beat: Callable[[], None], note: Callable[[UnitEvent], None] | None) -> None:
        said, algorithms, self._locate = system.together(result), system.placement(result), locator(result)
        places = points(result.program, algorithms)
        slaves = sorted({p.slave for p in algorithms})
        self._names = ["master", *(f"slave{n}" for n in slaves), *(["plant"] if said.plant else [])]
        self._board = board = Board(field_size(places), len(self._names))
        field = Field(board.field, places)
        plant = Plant(said.plant, field) if said.plant is not None else None
        wired = sorted(field.asked - {pin.path.upper() for p in algorithms for pin in p.local})
        self._affinity = os.sched_getaffinity(0)
        seats = processes.cpus(1 + len(slaves))
        refused = processes.claim(seats[0])
        for text in refused:
            say(f"note: {text}")
        ack_ms = _ACK_MS_ORDINARY if any("FIFO" in text for text in refused) else _ACK_MS
        start = time.monotonic_ns() + _LEAD_NS
        self._periods = [machine.period_ns]
        made, others = makers(result.program, bindings), []
        try:
            for number, slave in enumerate(slaves, 1):
                period_ns = slave_period(algorithms, slave)
                pace = Pace(start, period_ns, board.lateness(number))
                memory = allocate(f"slave{slave}", board.shared)
                part = SlavePart(slave, memory, algorithms, made, field, None,
                                 lambda pace=pace: pace.now_ns, scan_ns=machine.period_ns, ack_periods=ack_ms)
                self._periods.append(period_ns)
                others.append(self._slave(part, number, seats[number], pace))
            if plant is not None:
                self._periods.append(said.plant.step_ns)
                others.append(self._plant(plant, len(others) + 1, start))
        except BaseException:
            self._others = others
            self.finish()
            raise
        self._others = others
        self._pace = Pace(start, machine.period_ns, board.lateness(0))
        part = None
        if note is not None or is_system(result):
            part = MasterPart(machine, allocate("master", board.shared), algorithms, said, note,
                              lambda: self._pace.now_ns, on_emergency=board.emergency,
                              wiring=Wiring(field, wired), t_ack_ns=ack_ms * 1_000_000)
        self.loop = MasterLoop(machine, part, board, self._pace, others,
                               lambda text: say(f"note: {text}"), beat)

    def _slave(self, part: SlavePart, number: int, cpu: int | None, pace: Pace) -> Watched:
        def work() -> int:
            processes.claim(cpu)
            run_slave(part, self._board, number, pace)
            return report((error.fault.diagnostic() for error in part.faults), self._locate)

        return Watched(processes.start(self._names[number], work), number, part.number)

    def _plant(self, plant: Plant, number: int, start: int) -> Watched:
        pace = Pace(start, self._periods[number], self._board.lateness(number))

        def work() -> int:
            processes.give_back(self._affinity)
            try:
                run_plant(plant.step, self._board, number, pace)
            except Invalid as error:
                return report(error.diagnostics)
            return OK

        return Watched(processes.start(self._names[number], work), number, None)

    def finish(self) -> None:
        """Ends the processes; this one is an ordinary one again."""
        early = [each for each in self._others if each.child.look() is not None]
        self._board.stop()
        processes.finish([each.child for each in self._others])
        processes.give_back(self._affinity)
        self.broken = bool(early) or any(each.child.status for each in self._others)

    @property
    def passed_ns(self) -> int:
        """The real time that the scans took."""
        return self._pace.now_ns + self._pace.period_ns

    def processors(self) -> list[lateness.Processor]:
        """What each process has noted of its periods."""
        figures: list[Figures] = [self._board.lateness(n).figures() for n in range(len(self._names))]
        return [lateness.Processor(*row) for row in zip(self._names, self._periods, figures, strict=True)]
