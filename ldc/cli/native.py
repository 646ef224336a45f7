"""Native code for a command: built now or taken from the cache."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ldc import pipeline
from ldc.backends.c import build
from ldc.backends.c.gcc import Artifact
from ldc.cli.compiling import native_code
from ldc.cli.console import Failure, reason, report
from ldc.diagnostics import Diagnostics, Invalid
from ldc.il.external import Binding
from runtime.cost import Cost, Costs
from runtime.native import paced
from runtime.native.library import Code
from runtime.native.machine import Machine


def artifact(result: pipeline.Compiled, resource: int, folder: Path | None = None,
             areas: Mapping[str, int] | None = None, sanitize: bool = False,
             bindings: tuple[Binding, ...] | None = None, cost: Cost | None = None) -> Artifact:
    """The shared object for one resource of a compiled project; ``bindings``: its components, when they are
    built already; ``cost``: what execution costs, for code that is executed piece by piece. Raises Invalid
    and Failure."""
    diagnostics = Diagnostics()
    bindings = native_code(result) if bindings is None else bindings
    one = None if cost is None else Costs(result.program, cost).one
    plan = build.planned(result.program, result.image.layout, resource, bindings, areas, sanitize, one)
    try:
        made = build.built(plan, diagnostics, folder)
    except OSError as error:
        raise Failure(f"cannot write native code: {reason(error)}") from error
    if made is None:
        raise Invalid(diagnostics)
    report(diagnostics)
    return made


def loadable(made: Artifact) -> Code:
    """What the runtime takes of an artifact."""
    return Code(made.path, made.plan.block, made.plan.map, made.plan.bindings)


def machine(result: pipeline.Compiled, resource: int, period: int | None,
            bindings: tuple[Binding, ...] | None = None, cost: Cost | None = None) -> Machine:
    """A machine that runs native code; with ``cost`` by the rung."""
    native = loadable(artifact(result, resource, bindings=bindings, cost=cost))
    if cost is None:
        return Machine(result.program, resource, period, native=native)
    return paced.Machine(result.program, resource, period, native=native, cost=cost)
