"""Every standard function gives in native code what the library says, on values at the edges."""

from __future__ import annotations

import random

import native
import pytest
from test_library_machine import GROUPS, calls, value_of

from ldc.expr import Place
from ldc.il import program as il
from ldc.library import functions
from ldc.library.faults import DivisionByZero
from ldc.symbols import Variable

pytestmark = native.needs_gcc


def program_of(group: str) -> tuple[list, il.Program]:
    """The calls of a group, and a program that makes each: ``q<n>`` of the variables ``a<n>_<m>``."""
    found = [call for name in GROUPS[group] for call in calls(functions.TABLE[name])]
    variables, rungs = [], []
    for at, call in enumerate(found):
        given = [Variable(f"a{at}_{n}", t) for n, t in enumerate(call.parameters)]
        first, *others = (Place(v.name, v.type) for v in given)
        code = (il.Instr("LD", first, first.type), il.Instr("FN", None, call.result, call.name, tuple(others)),
                il.Instr("ST", Place(f"q{at}", call.result), call.result))
        variables += [*given, Variable(f"q{at}", call.result)]
        rungs.append(il.RungCode(f"r{at}", code))
    unit = il.Unit("PROGRAM", "main", tuple(variables), tuple(rungs))
    resource = il.Resource("plc", "master", (il.Task("main"),), (il.Run("main", "main", "main"),))
    return found, il.Program((unit,), (), (), (resource,))


@pytest.mark.parametrize("group", GROUPS)
def test_native_code_computes_what_the_library_means(group: str) -> None:
    dice = random.Random(group)
    found, program = program_of(group)
    machine = native.machine(program, 1)
    meanings = [functions.meaning(call.name, call.parameters, call.result) for call in found]
    for _ in range(12):
        expected = []
        for at, (call, means) in enumerate(zip(found, meanings, strict=True)):
            values, result = wanted(call, means, dice)
            for number, value in enumerate(values):
                machine.set(f"a{at}_{number}", value)
            expected.append((values, result))
        machine.scan()
        assert not machine.faults
        for at, (call, (values, result)) in enumerate(zip(found, expected, strict=True)):
            result = result.decode("latin-1") if isinstance(result, bytes) else result
            assert repr(machine.get(f"q{at}")) == repr(result), (call.name, *map(str, call.parameters), *values)


def wanted(call, means, dice: random.Random) -> tuple[list, object]:
    """Values that the function has a result for, and the result."""
    while True:
        values = [value_of(t, dice) for t in call.parameters]
        try:
            return values, means(*values)
        except DivisionByZero:
            continue
