"""Every standard function gives on the virtual machine, inlined or not, what the library says."""

from __future__ import annotations

import math
import random
import struct

import pytest

from ldc.expr import Place
from ldc.il import program as il
from ldc.library import functions
from ldc.library.faults import DivisionByZero
from ldc.library.generic import GENERIC
from ldc.library.table import Resolved
from ldc.symbols import Variable
from ldc.types import ELEMENTARY, Enum, Type
from runtime.vm.machine import Machine

COLOUR = Enum("COLOUR", (("red", 0), ("green", 300)))
TYPES = (*dict.fromkeys(ELEMENTARY.values()), COLOUR)
TEXTS = ("", "a", "abc", "12", "-7", "1.5", "TRUE", "T#5s", "16#FF", "D#2000-01-01", "b1b1")
REALS = (0.0, -0.0, 0.5, 1.5, 2.5, -1.0, -3.5, 1e30, -1e30, math.inf, -math.inf, math.nan, 1e-3, 12345.678)


def calls(row: functions.Function) -> list[Resolved]:
    """A call of the function per shape and type that its generic pins may share."""
    found = []
    for shape in row.shapes:
        generic = next((w for w in shape.inputs if w in GENERIC), None)
        for shared in TYPES:
            if generic is not None and functions.kind(shared) not in GENERIC[generic]:
                continue
            types = []
            for number, want in enumerate(shape.inputs):
                own = [t for t in TYPES if functions.kind(t) in GENERIC.get(want.removeprefix("own "), ())]
                types.append(ELEMENTARY.get(want) or (shared if want in GENERIC else own[number % len(own)]))
            found.append(functions.resolve(row.name, types))
    return list(dict.fromkeys(found))


def value_of(type_: Type, dice: random.Random):
    kind = functions.kind(type_)
    if kind == "bool":
        return dice.random() < 0.5
    if kind == "real":
        value = dice.choice((*REALS, dice.uniform(-9.0, 9.0), dice.uniform(-1e6, 1e6)))
        return struct.unpack("f", struct.pack("f", value))[0] if type_.bits == 32 else value
    if kind == "string":
        text = dice.choice(TEXTS)
        return text.encode() if type_.name == "STRING" else text
    if kind == "tod":
        return dice.randrange(86_400 * 10**9)
    if kind == "enum":
        return dice.choice(type_.values)[1]
    low, high = type_.range
    near = dice.randint(max(low, -20), min(high, 20))
    return dice.choice((low, high, near, near, dice.randint(low, high)))


def machine_of(call: Resolved) -> Machine:
    """A program ``q := name(a0, a1, ...)``."""
    variables = tuple(Variable(f"a{n}", t) for n, t in enumerate(call.parameters))
    first, *others = (Place(v.name, v.type) for v in variables)
    code = (il.Instr("LD", first, first.type), il.Instr("FN", None, call.result, call.name, tuple(others)),
            il.Instr("ST", Place("q", call.result), call.result))
    unit = il.Unit("PROGRAM", "main", (*variables, Variable("q", call.result)), (il.RungCode("body", code),))
    resource = il.Resource("plc", "master", (il.Task("main"),), (il.Run("main", "main", "main"),))
    return Machine(il.Program((unit,), (), (), (resource,)), period_ns=1)


GROUPS = {
    "BCD": [n for n in functions.TABLE if "_BCD" in n],
    "conversions": [n for n, f in functions.TABLE.items() if f.group.startswith("22") and "_BCD" not in n],
} | {number: [n for n, f in functions.TABLE.items() if f.group.startswith(number)]
     for number in ("23", "24", "25", "26", "27", "28", "29", "30")}


@pytest.mark.parametrize("group", GROUPS)
def test_the_machine_computes_what_the_library_means(group):
    dice = random.Random(group)
    for call in [call for name in GROUPS[group] for call in calls(functions.TABLE[name])]:
        means = functions.meaning(call.name, call.parameters, call.result)
        machine = machine_of(call)
        for _ in range(8):
            values = [value_of(t, dice) for t in call.parameters]
            for number, value in enumerate(values):
                machine.set(f"a{number}", value)
            machine.scan()
            told = (call.name, *map(str, call.parameters), *values)
            try:
                expected = means(*values)
            except DivisionByZero:
                assert machine.faults, told
                machine = machine_of(call)
                continue
            assert not machine.faults, told
            seen = machine.get("q")
            expected = expected.decode("latin-1") if isinstance(expected, bytes) else expected
            assert repr(seen) == repr(expected), told
