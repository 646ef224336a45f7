"""The virtual machine runs the standard function blocks as the standard's diagrams show them."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc.expr import Place
from ldc.il import program as il
from ldc.il import standard
from ldc.library import blocks
from ldc.symbols import Variable
from ldc.types import BOOL, TIME, Instance
from models import make
from runtime.vm.machine import Machine

PERIOD = 5_000_000


def machine_of(name: str) -> Machine:
    """A program that calls one instance ``block`` of a standard function block in every scan."""
    type_ = Instance(name)
    code = (il.Instr("CAL", Place("block", type_), type_),)
    unit = il.Unit("PROGRAM", "main", (Variable("block", type_),), (il.RungCode("body", code),))
    resource = il.Resource("plc", "master", (il.Task("main"),), (il.Run("main", "main", "main"),))
    return Machine(il.Program((standard.unit(name), unit), (), (), (resource,)), period_ns=PERIOD)


def inputs_of(name: str) -> st.SearchStrategy:
    values = {}
    for pin in blocks.signature(name).inputs:
        if pin.type == BOOL:
            values[pin.name] = st.booleans()
        elif pin.type == TIME:
            values[pin.name] = st.sampled_from([0, PERIOD, 4 * PERIOD, 4 * PERIOD, 4 * PERIOD + 1])
        else:
            low, high = pin.type.range
            values[pin.name] = st.sampled_from([low, 0, 1, 2, 3, high - 1, high])
    return st.lists(st.fixed_dictionaries(values), min_size=1, max_size=30)


@pytest.mark.parametrize("name", [n for n in blocks.names() if not n.endswith("_INT")])
def test_the_machine_runs_the_block(name):
    @settings(max_examples=25, deadline=None)
    @given(inputs_of(name))
    def run(scans):
        machine, model = machine_of(name), make(name)
        for number, inputs in enumerate(scans):
            for pin, value in inputs.items():
                machine.set(f"block.{pin}", value)
            machine.scan()
            expected = model.step(number * PERIOD, **inputs)
            assert {pin: machine.get(f"block.{pin}") for pin in expected} == expected

    run()
