"""From a program to a shared object: memory, plan, compiler."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from ldc.backends import findings
from ldc.backends.c import emit, gcc
from ldc.backends.c.emit import BuildPlan
from ldc.backends.c.gcc import Artifact
from ldc.diagnostics import Diagnostics
from ldc.il import block
from ldc.il.external import Binding
from ldc.il.layout import Layout
from ldc.il.program import Instr, Program


def planned(program: Program, layout: Layout, resource: int, bindings: Iterable[Binding] = (),
            areas: Mapping[str, int] | None = None, sanitize: bool = False,
            cost: Callable[[Instr], int] | None = None) -> BuildPlan:
    """The files for one resource of a program with the layout of its image. ``bindings``: its components in C
    and C++; ``areas``: the sizes of I, Q and M of the build before; ``cost``: as of ``emit.plan``."""
    memory = block.make(program, layout, resource, areas)
    return emit.plan(memory, gcc.FLAGS + (gcc.SANITIZE if sanitize else ()), bindings, cost)


def built(plan: BuildPlan, diagnostics: Diagnostics, folder: Path | None = None) -> Artifact | None:
    """The shared object of a plan, in ``folder`` or the user's cache. None, with findings, when there is no
    compiler or it fails. Raises OSError when a folder cannot be written."""
    try:
        compiler = gcc.find_compiler(diagnostics)
        return None if compiler is None else gcc.build(plan, compiler, folder)
    except gcc.CompilerFailed as error:
        findings.compiler_failed(diagnostics, error)
    return None
