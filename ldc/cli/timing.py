"""`ldc run` with `[cost]`: the tasks take virtual time; what they took, on the screen and as a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple

from ldc.cli.console import say
from ldc.cli.output import write_result
from ldc.diagnostics import Diagnostics, Invalid
from ldc.il.program import Program
from ldc.manifest import Manifest
from runtime.cost import Cost
from runtime.machine import Machine
from runtime.scheduler.report import COLUMNS, Row
from runtime.timing import Timing

_TITLES = ("", "runs", "worst us", "mean us", "jitter us", "overruns", "missed", "watchdog", "lost",
           "preempted",
           "load %")


def cost_of(manifest: Manifest, program: Program) -> Cost:
    """What `[cost]` says. Raises Invalid for the cost of an algorithm that is none."""
    given = dict(manifest.cost or {})
    known = {unit.name.upper(): unit.name for unit in program.algorithms}
    algorithms, diagnostics = given.pop("algorithms", {}), Diagnostics()
    for name in algorithms:
        if name.upper() not in known:
            diagnostics.error("LD0869", f"no algorithm of a slave is called `{name}`",
                              manifest.value_span("cost", "algorithms", name), "it costs nothing",
                              help=f"algorithms of this project: {', '.join(known.values()) or 'none'}; what "
                                   "the master executes costs by its instructions")
    if diagnostics.has_errors:
        raise Invalid(diagnostics)
    return Cost(**given, algorithms=tuple((name.upper(), cost) for name, cost in algorithms.items()))


def watchdogs_of(machine: Machine, manifest: Manifest) -> dict[str, int]:
    """What executions of its tasks may take in ns, by name in capitals. Raises Invalid for a watchdog of a
    task that is none."""
    known = {schedule.task.name.upper(): schedule.task.name for schedule in machine.schedules}
    here = machine.program.resources[machine.resource].processor
    watchdogs, diagnostics = {}, Diagnostics()
    for task in manifest.tasks:
        if task.watchdog is None or task.processor != here:
            continue
        if task.name.upper() not in known:
            diagnostics.error("LD0833", f"the watchdog of task `{task.name}` watches nothing",
                              manifest.value_span("tasks", task.name, "watchdog"), "no such task runs",
                              help=f"tasks that run: {', '.join(known.values())}")
        watchdogs[task.name.upper()] = task.watchdog
    if diagnostics.has_errors:
        raise Invalid(diagnostics)
    return watchdogs


def tasks(machine: Machine, manifest: Manifest) -> Timing:
    """The tasks of a machine as threads. Raises Invalid."""
    return Timing(machine, watchdogs_of(machine, manifest))


def tell(found: Sequence[Row], target: str | None) -> None:
    """A table to standard error, and the same as CSV to a file (`-`: standard output) when asked for."""
    several = len({row.processor for row in found}) > 1
    lines = [_TITLES]
    for row in found:
        processor, name, *figures = astuple(row)
        lines.append((f"{processor}.{name}" if several else name, *(f"{figure:g}" for figure in figures)))
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for first, *others in lines:
        cells = [text.rjust(width) for text, width in zip(others, widths[1:], strict=True)]
        say("  ".join([first.ljust(widths[0]), *cells]))
    if target is not None:
        rows = [COLUMNS, *(astuple(row) for row in found)]
        write_result("".join(",".join(map(str, row)) + "\n" for row in rows), target)
