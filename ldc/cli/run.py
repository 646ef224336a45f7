"""`ldc run`: a program in virtual time, its inputs from a file, what it does as a trace or on the screen."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from ldc import pipeline
from ldc.cli import run_options, sanitized
from ldc.cli.apart import apart
from ldc.cli.attached import Attached, attached, listed
from ldc.cli.compiling import compiled, locator, native_code
from ldc.cli.console import Failure, UsageError, report, say
from ldc.cli.inputs import read
from ldc.cli.output import replacing
from ldc.cli.watching import ChangeLines
from ldc.diagnostics import Diagnostics, Invalid
from ldc.il.external import Binding
from ldc.manifest import Manifest, Sources
from ldc.reading import read_source
from ldc.render import plural
from runtime.machine import Machine
from runtime.stimuli import Stimuli
from runtime.stimuli import read as read_stimuli
from runtime.symbols import UnknownSymbol
from runtime.trace import Trace
from runtime.values import milliseconds
from runtime.vm import machine as vm

if TYPE_CHECKING:
    from ldc.cli.live_table import LiveTable
    from runtime.cost import Cost

SCANS = 100
"""How long a run is when nothing says it."""

Action = Callable[[], None]


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
    names = watched(options.watch, sources.manifest, machine)
    scans = run_length(options, stimuli, machine)
    runner = _system if is_system(result) or options.events else _alone
    with attached(options, sources, result, machine, names) as beside, \
            runner(options, sources, result, machine, bindings, events, cost, beside) as \
            (execute, rows, findings):
        table = None
        if run_options.live(options):
            from ldc.cli.live_table import LiveTable, Powers  # loads rich

            stepped = runner is _alone and _stepped(options, sources)
            table = LiveTable(machine, names, scans, Powers(machine, result.units) if stepped else None, execute)
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


def is_system(result: pipeline.Compiled) -> bool:
    """Whether a project needs more than a machine to run; otherwise it is executed as it always was."""
    manifest = result.sources.manifest
    return bool(result.program.algorithms) or manifest is not None and bool(manifest.coordination)


def start(
    result: pipeline.Compiled, period: int | None, manifest: Manifest | None, engine: str = "vm",
    bindings: tuple[Binding, ...] | None = None, cost: Cost | None = None,
) -> Machine:
    """The machine for a compiled project; `period` of the command line wins over that of the project.
    `bindings`: its components in C and C++, when they are built already. `cost`: what execution costs; the
    machine then executes by the rung, and tells it."""
    number = resource_to_run(result)
    period = period or (manifest.period if manifest else None)
    if engine == "native":
        from ldc.cli import native  # loads cffi and jinja2

        return native.machine(result, number, period, bindings, cost)
    bindings = native_code(result) if bindings is None else bindings
    if cost is not None:
        from runtime.vm import paced  # loads what only a run with [cost] needs

        return paced.Machine(result.program, number, period, bindings, cost=cost)
    return vm.Machine(result.program, number, period, bindings)


def resource_to_run(result: pipeline.Compiled) -> int:
    """The number of the processor that is run: the first one that has a program. Raises Failure."""
    resources = result.program.resources
    if not any(resource.runs for resource in resources):
        raise Failure("there is no PROGRAM to run")
    number = next(i for i, resource in enumerate(resources) if resource.runs)
    if sum(bool(resource.runs) for resource in resources) > 1:
        say(f"note: only processor `{resources[number].processor}` is run")
    return number


def stimuli_of(inputs: str | None, manifest: Manifest | None, machine: Machine) -> Stimuli:
    """The inputs that are asked for, those of the project, or none. Raises Invalid."""
    path = Path(inputs) if inputs else None
    if path is None and manifest and manifest.inputs:
        path = manifest.folder / manifest.inputs
    if path is None:
        return Stimuli({})
    diagnostics = Diagnostics()
    source = read_source(path, path.as_posix(), diagnostics)
    stimuli = read_stimuli(source, machine.symbols, diagnostics) if source else None
    if stimuli is None:
        raise Invalid(diagnostics)
    return stimuli


def watched(asked: str | None, manifest: Manifest | None, machine: Machine) -> tuple[str, ...]:
    """The paths to show: those asked for, those of the project, or all located inputs and outputs."""
    if asked is not None:
        names = listed(asked)
        for name in names:
            try:
                machine.find([name])
            except UnknownSymbol as error:
                raise UsageError(str(error)) from error
        return names
    if manifest and manifest.watch:
        diagnostics = Diagnostics()
        for name in manifest.watch:
            try:
                machine.find([name])
            except UnknownSymbol as error:
                span = manifest.value_span("run", "watch")
                diagnostics.error(
                    "LD0620",
                    f"cannot watch `{name}`: {error}",
                    span,
                    help="name a variable as in " "`motor`, `warm.Q`, `conveyor.warm.Q` or `%QX0.0`",
                )
        if diagnostics.has_errors:
            raise Invalid(diagnostics)
        return manifest.watch
    located = {area: [s.path for s in machine.symbols.located(area)] for area in "IQ"}
    return _short((*located["I"], *located["Q"]), machine)


def _short(paths: tuple[str, ...], machine: Machine) -> tuple[str, ...]:
    """Paths without the name of the program when there is only one."""
    runs = machine.program.resources[machine.resource].runs
    if len(runs) != 1:
        return paths
    prefix = f"{runs[0].name.upper()}."
    return tuple(path[len(prefix) :] if path.upper().startswith(prefix) else path for path in paths)


def run_length(options: argparse.Namespace, stimuli: Stimuli, machine: Machine) -> int:
    """How many scans: as asked for, as many as the inputs are, or ``SCANS``."""
    if options.scans:
        return options.scans
    if options.duration:
        return -(-options.duration // machine.period_ns)
    return stimuli.last + 1 if stimuli.last >= 0 else SCANS


@contextmanager
def displayed(
    options: argparse.Namespace, machine: Machine, names: tuple[str, ...], table: LiveTable | None,
    opened: BinaryIO | None = None, execute: Action | None = None,
) -> Iterator[tuple[Action, Action]]:
    """How a scan is run, and what is done after each. `execute`: a scan, when not that of the machine."""
    execute = execute or machine.scan
    if table is not None:
        with table:
            yield table.scan, table.sample
    elif options.trace == "-":
        yield execute, Trace(machine, names, sys.stdout).sample
    elif options.trace:
        with replacing(Path(options.trace)) if opened is None else nullcontext(opened) as file:
            text = io.TextIOWrapper(file, encoding="utf-8", newline="")
            yield execute, Trace(machine, names, text).sample
            text.flush()
            text.detach()
    else:
        yield execute, ChangeLines(machine, names if run_options.shows(options) else (), sys.stdout).sample
