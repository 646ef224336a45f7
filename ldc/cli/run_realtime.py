"""`ldc run --realtime`: scans at their time, each slave and the plant in a process of its own
(docs/realtime.md)."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Sequence
from typing import BinaryIO

from ldc import pipeline
from ldc.cli import lateness, system
from ldc.cli.attached import attached
from ldc.cli.compiling import locator
from ldc.cli.console import answered, report, say
from ldc.cli.realtime import Processes
from ldc.cli.starting import displayed, run_length, stimuli_of, watched
from ldc.cli.run_options import live
from ldc.il.external import Binding
from ldc.manifest import Sources
from ldc.render import plural
from runtime.machine import Machine
from runtime.realtime import processes
from runtime.values import milliseconds


def run(options: argparse.Namespace, sources: Sources, result: pipeline.Compiled, machine: Machine,
        beat: Callable[[], None], file: BinaryIO | None, bindings: tuple[Binding, ...],
        events: BinaryIO | None) -> int:
    """As ``ldc.cli.run``, in real time; each slave tells its own faults. Status 1 also when the plant or a
    slave has ended before its time."""
    if options.plot:
        lateness.check(options.plot)
    stimuli = stimuli_of(options.inputs, sources.manifest, machine)
    names = watched(options.watch, sources.manifest, machine.symbols)
    scans = run_length(options, stimuli, machine)
    affinity = os.sched_getaffinity(0)
    with attached(options, sources, result, machine, names,
                  beside=lambda: processes.ordinary(affinity)) as beside, \
            system.recorded(options.events, events) as record, processes.interrupted() as came:
        whole = Processes(result, machine, bindings, beat, record.append if record else None, beside.join)
        whole.loop.until(came)
        try:
            table = None
            if live(options):
                from ldc.cli.live_table import LiveTable  # loads rich

                table = LiveTable(machine, names, scans, None, whole.loop.scan)
            with displayed(options, machine, names, table, file, whole.loop.scan) as (scan, sample):
                whole.begin()
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
    return told(options, result, whole, machine, beat)


def told(options: argparse.Namespace, result: pipeline.Compiled, whole: Processes, machine: Machine,
         beat: Callable[[], None]) -> int:
    """The status of a run that is over, after all that people are told of it."""
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
