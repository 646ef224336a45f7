"""`ldc run`: a program in virtual time, its inputs from a file, what it does as a trace or on the screen."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from ldc import pipeline
from ldc.cli import run_options, sanitized
from ldc.cli.apart import apart
from ldc.cli.attached import Attached, attached
from ldc.cli.compiling import compiled, locator, native_code
from ldc.cli.console import UsageError, report, say
from ldc.cli.inputs import read
from ldc.cli.output import replacing
from ldc.cli.starting import Action, displayed, is_system, run_length, start, stimuli_of, watched
from ldc.il.external import Binding
from ldc.manifest import Sources
from ldc.render import plural
from runtime.machine import Machine
from runtime.values import milliseconds

if TYPE_CHECKING:
    from runtime.cost import Cost


def run(options: argparse.Namespace) -> int:
    """Status 1 when a task was stopped by a fault; the scans after it are still run and traced."""
    run_options.check(options)
    if options.target:
        from ldc.cli import run_firmware  # loads what only firmware needs

        return run_firmware.run(options)
    sources = read(options.sources)
    # The power of rungs is seen by stepping, which native code does not.
    result = compiled(sources, keep=_stepped(options, sources))
    if not result.natives and not options.online:
        return _run(options, sources, result, lambda: None)
    if result.natives and options.sanitize and not sanitized.inside():
        return sanitized.run(options.arguments, result)
    bindings = native_code(result)
    # A crash ends the process that writes: files are given their names, or taken away, by this one.
    with _opened(options.trace) as file, _opened(options.events) as events:
        return apart(result, bindings,
                     lambda beat: _run(options, sources, result, beat, file, bindings, events),
                     options.arguments, orderly=options.realtime or options.online)


def _opened(target: str | None) -> AbstractContextManager[BinaryIO | None]:
    return nullcontext() if target in (None, "-") else replacing(Path(target))


def _stepped(options: argparse.Namespace, sources: Sources) -> bool:
    """Whether scans with a picture go step by step: not those that take virtual time."""
    return run_options.live(options) and options.engine == "vm" and not _takes_time(options, sources)


def _takes_time(options: argparse.Namespace, sources: Sources) -> bool:
    """Whether executions take virtual time."""
    return sources.manifest is not None and sources.manifest.cost is not None and not options.realtime


def _run(options: argparse.Namespace, sources: Sources, result: pipeline.Compiled, beat: Action,
         file: BinaryIO | None = None, bindings: tuple[Binding, ...] = (),
         events: BinaryIO | None = None) -> int:
    """All scans, and what is said at the end; ``beat`` is called before the first and after each scan.
    ``file``, ``events``: for the trace and for what units did, when they are open already; ``bindings``: the
    components in C and C++."""
    if options.online:
        from ldc.cli import run_online  # loads what only a socket needs

        return run_online.run(options, sources, result, beat, file, bindings, events)
    cost = None
    if _takes_time(options, sources):
        from ldc.cli import timing as times  # loads what a run without [cost] does not need

        cost = times.cost_of(sources.manifest, result.program)
    elif options.timing:
        raise UsageError("--timing needs a table [cost] in ldc.toml: without one nothing takes time")
    machine = start(result, options.period, sources.manifest, options.engine, bindings, cost)
    if options.realtime:
        from ldc.cli import run_realtime  # loads what a run in virtual time does not need

        return run_realtime.run(options, sources, result, machine, beat, file, bindings, events)
    stimuli = stimuli_of(options.inputs, sources.manifest, machine)
    names = watched(options.watch, sources.manifest, machine.symbols)
    scans = run_length(options, stimuli, machine)
    runner = _system if is_system(result) or options.events else _alone
    with attached(options, sources, result, machine, names) as beside, \
            runner(options, sources, result, machine, bindings, events, cost, beside) as \
            (execute, rows, findings):
        table = None
        if run_options.live(options):
            from ldc.cli.live_table import LiveTable, Powers  # loads rich

            stepped = runner is _alone and _stepped(options, sources)
            powers = Powers(machine, result.units) if stepped else None
            table = LiveTable(machine, names, scans, powers, execute)
        with displayed(options, machine, names, table, file, execute) as (scan, sample):
            beat()
            for _ in range(scans):
                stimuli.apply(machine)
                scan()
                sample()
                beside.scanned()
                beat()
    say(f"{plural(scans, 'scan')}, {milliseconds(scans * machine.period_ns)} ms of virtual time")
    if cost:
        times.tell(rows(), options.timing)
    return report((found.diagnostic() for found in findings()), locator(result))


Runner = tuple[Action, Callable[[], Iterable], Callable[[], Iterable]]
"""What executes a scan; how long tasks took, when executions take time; what is to be told at the end."""


@contextmanager
def _alone(options: argparse.Namespace, sources: Sources, result: pipeline.Compiled, machine: Machine,
           bindings: tuple[Binding, ...], events: BinaryIO | None, cost: Cost | None, beside: Attached
           ) -> Iterator[Runner]:
    """A machine without others."""
    if cost is None:
        yield machine.scan, list, lambda: machine.faults
        return
    from ldc.cli import timing as times

    timing = times.tasks(machine, sources.manifest)
    yield timing.scan, timing.rows, lambda: machine.faults


@contextmanager
def _system(options: argparse.Namespace, sources: Sources, result: pipeline.Compiled, machine: Machine,
            bindings: tuple[Binding, ...], events: BinaryIO | None, cost: Cost | None, beside: Attached
            ) -> Iterator[Runner]:
    """Master, slaves and plant."""
    from ldc.cli import system as systems  # loads what a machine alone does not need
    from ldc.cli import timing as times

    with systems.recorded(options.events, events) as record:
        watchdogs = times.watchdogs_of(machine, sources.manifest) if cost else None
        whole = systems.system(result, machine, bindings, record, cost=cost, watchdogs=watchdogs)
        beside.join(whole)
        yield whole.scan, whole.rows, lambda: whole.findings
