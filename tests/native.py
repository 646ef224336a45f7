"""Native machines for tests: compiled by gcc without optimisation, kept in the user's cache of objects."""

from __future__ import annotations

import pytest

from ldc.backends.c import emit, gcc
from ldc.components import toolchain
from ldc.diagnostics import Diagnostics
from ldc.il import block
from ldc.il.external import Binding
from ldc.il.layout import lay_out
from ldc.il.program import Program
from runtime.cost import Cost, Costs
from runtime.native import paced
from runtime.native.library import Code
from runtime.native.machine import Machine

QUICK = tuple("-O0" if flag == "-O1" else flag for flag in gcc.FLAGS)

needs_gcc = pytest.mark.skipif(toolchain.find(toolchain.GCC) is None, reason="gcc is not installed")


def built(program: Program, flags: tuple[str, ...] = QUICK, bindings: tuple[Binding, ...] = (),
          cost: Cost | None = None) -> Code:
    """The native code of the first resource; with ``cost`` for execution piece by piece."""
    one = None if cost is None else Costs(program, cost).one
    plan = emit.plan(block.make(program, lay_out(program)), flags, bindings, one)
    made = gcc.build(plan, gcc.find_compiler(Diagnostics()))
    return Code(made.path, plan.block, plan.map, plan.bindings)


def machine(program: Program, period_ns: int | None = None, flags: tuple[str, ...] = QUICK,
            bindings: tuple[Binding, ...] = ()) -> Machine:
    return Machine(program, 0, period_ns, native=built(program, flags, bindings))


def paced_machine(program: Program, cost: Cost, period_ns: int | None = None,
                  bindings: tuple[Binding, ...] = ()) -> paced.Machine:
    """A machine that executes piece by piece."""
    return paced.Machine(program, 0, period_ns, native=built(program, QUICK, bindings, cost), cost=cost)
