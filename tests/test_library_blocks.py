"""The IL text of every standard function block does what the standard's diagrams show."""

from __future__ import annotations

import operator
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc.library import blocks, functions
from ldc.types import BOOL, ELEMENTARY, TIME, default
from models import MODELS, RANGES, make

MS = 1_000_000
_WORKS = {"ADD": operator.add, "SUB": operator.sub, "GT": operator.gt, "GE": operator.ge,
          "LT": operator.lt, "LE": operator.le, "OR": operator.or_, "AND": operator.and_,
          "ANDN": lambda a, b: a and not b, "ORN": lambda a, b: a or not b}
_DECLARATION = re.compile(r"^    (\w+) : (\w+);", re.MULTILINE)


class Text:
    """Executes the text of a block, one line after the other."""

    def __init__(self, name: str) -> None:
        declared, body = blocks.source(name).rsplit("END_VAR\n", 1)
        self.types = {n: ELEMENTARY[t] for n, t in _DECLARATION.findall(declared)} | {"%NOW": TIME}
        self.values = {n: default(t) for n, t in self.types.items()}
        body = re.sub(r"\(\*.*?\*\)", "", body).replace("END_FUNCTION_BLOCK", "")
        self.code = [line.split(maxsplit=1) for line in body.splitlines() if line.strip()]
        self.outputs = [p.name for p in blocks.signature(name).outputs]

    def read(self, operand: str, type_):
        operand = operand.strip()
        if operand == "T#0s":
            return 0, TIME
        if re.fullmatch(r"-?\d+", operand):
            return int(operand), type_
        return self.values[operand], self.types[operand]

    def step(self, now: int, **inputs) -> dict:
        self.values |= inputs | {"%NOW": now}
        acc, type_ = None, None
        for op, *rest in self.code:
            if op == "LD":
                acc, type_ = self.read(rest[0], None)
            elif op == "ST":
                target = self.types[rest[0].strip()]
                assert type_ == target
                low, high = target.range
                assert low <= acc <= high
                self.values[rest[0].strip()] = acc
            elif op in _WORKS:
                value, other = self.read(rest[0], type_)
                assert other == type_
                acc = _WORKS[op](acc, value)
                type_ = BOOL if op in ("GT", "GE", "LT", "LE") else type_
            else:
                args = [self.read(a, None) for a in (rest[0].split(",") if rest else ())]
                found = functions.resolve(op, (type_, *(t for _, t in args)))
                values = [v for v, _ in args]
                acc = functions.meaning(found.name, found.parameters, found.result)(acc, *values)
                type_ = found.result
        return {n: self.values[n] for n in self.outputs}


def trace(name: str, *steps: tuple, **constant) -> list[tuple]:
    """Outputs after each step of (time in ms, inputs in the order of the pins); text and model agree."""
    text, model = Text(name), make(name)
    pins = [p for p in blocks.signature(name).inputs if p.name not in constant]
    seen = []
    for at, *values in steps:
        inputs = {p.name: bool(v) if p.type == BOOL else v for p, v in zip(pins, values, strict=True)}
        inputs |= constant
        found = text.step(at * MS, **inputs)
        assert model.step(at * MS, **inputs) == found
        seen.append(tuple(v // MS if k == "ET" else v for k, v in found.items()))
    return seen


def test_every_block_has_a_model_and_pins_of_the_same_names():
    assert set(blocks.names()) == set(MODELS)
    for name in blocks.names():
        signature, model = blocks.signature(name.lower()), make(name)
        assert signature.name == name
        assert signature.standard
        assert [p.name for p in signature.inputs] == list(model.inputs)
        assert [p.name for p in signature.outputs] == list(model.outputs)
        assert model.step(0).keys() == model.outputs.keys()


def test_no_block_of_that_name():
    assert blocks.signature("TIMER") is None


def test_on_delay():
    assert trace("TON", (0, 0), (10, 1), (20, 1), (30, 1), (40, 1), (50, 0), (60, 1), PT=20 * MS) == [
        (False, 0), (False, 0), (False, 10), (True, 20), (True, 20), (False, 0), (False, 0)]


def test_on_delay_is_not_early_in_the_first_scan():
    assert trace("TON", (0, 1), (10, 1), PT=10 * MS) == [(False, 0), (True, 10)]


@pytest.mark.parametrize("preset", [0, -5 * MS])
def test_no_delay_at_all(preset):
    assert trace("TON", (10, 1), (20, 0), PT=preset) == [(True, 0), (False, 0)]
    assert trace("TOF", (10, 1), (20, 0), (30, 1), PT=preset) == [(True, 0), (False, 0), (True, 0)]
    assert trace("TP", (10, 1), (20, 1), (30, 0), PT=preset) == [(False, 0), (False, 0), (False, 0)]


def test_on_delay_follows_a_changed_preset():
    seen = trace("TON", (0, 1, 20 * MS), (20, 1, 20 * MS), (25, 1, 40 * MS), (40, 1, 40 * MS),
                 (50, 1, 5 * MS))
    assert seen == [(False, 0), (True, 20), (False, 25), (True, 40), (True, 5)]


def test_off_delay():
    seen = trace("TOF", (0, 0), (10, 1), (20, 1), (30, 0), (40, 0), (50, 0), (60, 0), (70, 1), PT=20 * MS)
    assert seen == [(False, 0), (True, 0), (True, 0), (True, 0), (True, 10), (False, 20), (False, 20),
                    (True, 0)]


def test_off_delay_interrupted():
    assert trace("TOF", (0, 1), (10, 0), (20, 1), (30, 0), (45, 0), (50, 0), PT=20 * MS) == [
        (True, 0), (True, 0), (True, 0), (True, 0), (True, 15), (False, 20)]


def test_what_fell_does_not_rise_by_a_longer_preset():
    seen = trace("TOF", (0, 1, 10 * MS), (10, 0, 10 * MS), (20, 0, 10 * MS), (25, 0, 90 * MS))
    assert [q for q, _ in seen] == [True, True, False, False]
    seen = trace("TP", (0, 1, 10 * MS), (10, 1, 10 * MS), (15, 1, 90 * MS))
    assert [q for q, _ in seen] == [True, False, False]


def test_pulse():
    seen = trace("TP", (0, 1), (10, 0), (15, 1), (20, 1), (30, 1), (40, 0), (50, 1), PT=20 * MS)
    assert seen == [(True, 0), (True, 10), (True, 15), (False, 20), (False, 20), (False, 0), (True, 0)]


def test_pulse_is_ready_when_released_at_its_end():
    assert trace("TP", (0, 1), (20, 0), (25, 1), PT=20 * MS) == [(True, 0), (False, 0), (True, 0)]


def test_pulse_released_only_before_its_end_is_not_ready():
    assert trace("TP", (0, 1), (10, 0), (20, 1), (30, 1), PT=20 * MS)[2:] == [(False, 20), (False, 20)]


def test_count_up():
    assert trace("CTU", (0, 1, 0), (1, 1, 0), (2, 0, 0), (3, 1, 0), (4, 0, 0), (5, 1, 1), (6, 1, 0),
                 PV=2) == [(False, 1), (False, 1), (False, 1), (True, 2), (True, 2), (False, 0), (False, 0)]


def test_count_down():
    assert trace("CTD", (0, 0, 1), (1, 1, 0), (2, 0, 0), (3, 1, 0), (4, 0, 0), (5, 1, 0), (6, 0, 1),
                 PV=2) == [(False, 2), (False, 1), (False, 1), (True, 0), (True, 0), (True, -1), (False, 2)]


def test_count_both_ways():
    seen = trace("CTUD", (0, 1, 0, 0, 0), (1, 0, 0, 0, 0), (2, 1, 1, 0, 0), (3, 0, 0, 0, 1), (4, 0, 1, 0, 0),
                 (5, 0, 0, 1, 1), PV=3)
    assert seen == [(False, False, 1), (False, False, 1), (False, False, 1), (True, False, 3),
                    (False, False, 2), (False, True, 0)]


@pytest.mark.parametrize("suffix", RANGES)
def test_counters_stop_at_the_ends_of_their_type(suffix):
    least, greatest = RANGES[suffix]
    for name, pins, start in (("CTUD", {"CU": True}, greatest), ("CTUD", {"CD": True}, least),
                              ("CTD", {"CD": True}, least)):
        text = Text(name + suffix)
        text.step(0, LD=True, PV=start)
        assert text.step(1, LD=False, **pins)["CV"] == start
    text = Text("CTU" + suffix)
    text.values["CV"] = greatest - 1
    assert [text.step(n, CU=n % 2 == 0, PV=greatest) for n in range(3)] == [{"Q": True, "CV": greatest}] * 3


def test_edges():
    assert trace("R_TRIG", (0, 1), (1, 1), (2, 0), (3, 1)) == [(True,), (False,), (False,), (True,)]
    assert trace("F_TRIG", (0, 0), (1, 1), (2, 0), (3, 0)) == [(False,), (False,), (True,), (False,)]


def test_the_dominant_side_wins():
    assert trace("SR", (0, 1, 1), (1, 0, 0), (2, 0, 1)) == [(True,), (True,), (False,)]
    assert trace("RS", (0, 1, 0), (1, 0, 0), (2, 1, 1)) == [(True,), (True,), (False,)]


def _inputs(name: str) -> st.SearchStrategy:
    """Random executions: time that passes, then the inputs."""
    values = {}
    for pin in blocks.signature(name).inputs:
        if pin.type == BOOL:
            values[pin.name] = st.booleans()
        elif pin.type == TIME:
            values[pin.name] = st.sampled_from([-MS, 0, 5 * MS, 20 * MS, 20 * MS, 20 * MS])
        else:
            low, high = pin.type.range
            values[pin.name] = st.sampled_from([low, 0, 1, 2, 3, high - 1, high])
    return st.lists(st.tuples(st.integers(0, 10 * MS), st.fixed_dictionaries(values)), max_size=40)


@pytest.mark.parametrize("name", blocks.names())
def test_the_text_is_the_model(name):
    @settings(max_examples=60, deadline=None)
    @given(_inputs(name))
    def run(executions):
        text, model, now = Text(name), make(name), 0
        for passed, inputs in executions:
            assert text.step(now, **inputs) == model.step(now, **inputs)
            now += passed

    run()
