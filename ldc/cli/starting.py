"""What a run consists of, whatever executes it: its machine, inputs, length, and what is shown."""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from ldc import pipeline
from ldc.cli import run_options
from ldc.cli.attached import listed
from ldc.cli.compiling import native_code
from ldc.cli.console import Failure, UsageError, say
from ldc.cli.output import replacing
from ldc.cli.watching import ChangeLines
from ldc.diagnostics import Diagnostics, Invalid
from ldc.il.external import Binding
from ldc.manifest import Manifest
from ldc.reading import read_source
from runtime.machine import Machine
from runtime.stimuli import Stimuli
from runtime.stimuli import read as read_stimuli
from runtime.symbols import Symbols, UnknownSymbol
from runtime.trace import Trace
from runtime.vm import machine as vm

if TYPE_CHECKING:
    from ldc.cli.live_table import LiveTable
    from runtime.cost import Cost

SCANS = 100
"""How long a run is when nothing says it."""

Action = Callable[[], None]


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


def watched(asked: str | None, manifest: Manifest | None, symbols: Symbols) -> tuple[str, ...]:
    """The paths to show: those asked for, those of the project, or all located inputs and outputs."""
    if asked is not None:
        names = listed(asked)
        for name in names:
            try:
                symbols.find(name)
            except UnknownSymbol as error:
                raise UsageError(str(error)) from error
        return names
    if manifest and manifest.watch:
        diagnostics = Diagnostics()
        for name in manifest.watch:
            try:
                symbols.find(name)
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
    located = {area: [s.path for s in symbols.located(area)] for area in "IQ"}
    return _short((*located["I"], *located["Q"]), symbols)


def _short(paths: tuple[str, ...], symbols: Symbols) -> tuple[str, ...]:
    """Paths without the name of the program when there is only one."""
    if len(symbols.programs) != 1:
        return paths
    prefix = f"{symbols.programs[0].upper()}."
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
