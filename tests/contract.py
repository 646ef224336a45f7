"""What a user sees of a program, whichever way it is executed: text in, findings, IL or a trace out.

A program is run on the virtual machine, stepped instruction by instruction, at every nesting limit, from its
own printed IL and from its image; all must give one trace before a test sees it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from io import StringIO

from ldc import pipeline
from ldc.diagnostics import Diagnostics
from ldc.il import image, text
from ldc.il.program import Program
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile
from runtime.stimuli import read
from runtime.trace import Trace
from runtime.vm.machine import Machine
from runtime.vm.stepping import Stepper

MS = 1_000_000


def compiled(source: str, path: str = "main.ld", **options) -> pipeline.Compiled:
    sources = Sources((SourceFile(path, source),), Settings(), None)
    return pipeline.compile_project(sources, pipeline.Options(**options))


def good(source: str, path: str = "main.ld", **options) -> pipeline.Compiled:
    """A compile that must have no errors."""
    made = compiled(source, path, **options)
    assert not made.diagnostics.has_errors, "\n".join(
        f"{d.code} {d.message} [{d.primary.span.text if d.primary else ''}]" for d in made.diagnostics)
    return made


def codes(source: str, path: str = "main.ld") -> list[str]:
    """The codes of all errors and warnings, in order."""
    return [d.code for d in compiled(source, path).diagnostics if d.severity in ("error", "warning")]


def program(body: str, variables: str = "", before: str = "", after: str = "") -> str:
    """A PROGRAM ``main`` around some rungs."""
    declared = f"VAR {variables} END_VAR\n" if variables else ""
    return f"{before}\nPROGRAM main\n{declared}{body}\nEND_PROGRAM\n{after}"


def il(body: str, variables: str = "", before: str = "", **options) -> list[str]:
    """The instructions of a program, one a line, as printed: no declarations, comments or blank lines."""
    made = good(program(body, variables, before), **options)
    printed = text.print_program(made.program)
    code = printed[printed.index("PROGRAM main"):printed.index("END_PROGRAM")].rpartition("END_VAR")[2]
    lines = (line.partition("(* ")[0].rstrip() for line in code.splitlines())
    return [" ".join(line.split()) for line in lines if line.strip()]


def versions(source: str) -> Iterator[tuple[str, Program, bool]]:
    """All ways to execute a program: a name, the program, whether to step it."""
    made = good(source)
    yield "vm", made.program, False
    yield "stepped", made.program, True
    yield "image", image.load(made.image.data).program, False
    printed = text.print_program(made.program)
    again = good(printed, "main.il")
    assert text.print_program(again.program) == printed, "print, read, print is not stable"
    yield "il", again.program, False
    for depth in (0, 1, 2):
        shallow = good(source, max_paren_depth=depth).program
        yield f"depth {depth}", shallow, False
        yield f"il of depth {depth}", good(text.print_program(shallow), "main.il").program, False


def machine(source: str, period: int | None = 10) -> Machine:
    """The program on the virtual machine; ``period`` in milliseconds."""
    return Machine(good(source).program, 0, period * MS if period else None)


def trace(
    source: str, watch: str, inputs: str = "scan", scans: int = 0, period: int | None = 10,
) -> list[str]:
    """The rows of the trace, without ``scan`` and ``t_ms``, as ``1 0 -7``; one way to execute or another.

    ``inputs``: an input file, lines divided by blanks. A fault adds the row ``fault CODE`` where it happens.
    """
    found: dict[str, list[str]] = {}
    names: list[str] = []
    for name, made, stepping in versions(source):
        # Printed IL gives program instances names that no POU has.
        runs = [run.name for run in made.resources[0].runs]
        names = names or runs
        here = {f"{old}.": f"{new}." for old, new in zip(names, runs, strict=True)}
        paths = re.compile(r"\b(" + "|".join(map(re.escape, here)) + ")")
        asked, given = (paths.sub(lambda match, here=here: here[match[1]], t) for t in (watch, inputs))
        machine = Machine(impatient(made), 0, period * MS if period else None)
        found[name] = _rows(machine, stepping, asked, given, scans)
    first = found["vm"]
    for name, rows in found.items():
        assert rows == first, f"{name} gives {rows}, the virtual machine {first}"
    return first


def impatient(made: Program) -> Program:
    """The program with a short watchdog: a million jumps take long when they are stepped."""
    resources = (replace(r, tasks=tuple(replace(t, watchdog=2_000) for t in r.tasks)) for r in made.resources)
    return replace(made, resources=tuple(resources))


def _rows(machine: Machine, stepping: bool, watch: str, inputs: str, scans: int) -> list[str]:
    diagnostics = Diagnostics()
    stimuli = read(SourceFile("in.csv", "\n".join(inputs.split())), machine.symbols, diagnostics)
    assert stimuli is not None, [d.message for d in diagnostics]
    scan = Stepper(machine).scan if stepping else machine.scan
    rows: list[str] = []
    faults = 0
    out = StringIO()
    written = Trace(machine, watch.split(), out)
    for _ in range(scans or stimuli.last + 1):
        stimuli.apply(machine)
        scan()
        rows += [f"fault {fault.code}" for fault in machine.faults[faults:]]
        faults = len(machine.faults)
        out.seek(0)
        out.truncate()
        written.sample()
        rows.append(" ".join(out.getvalue().rstrip("\n").split(",")[2:]))
    return rows
