"""Selection and comparison (IEC 61131-3, 2nd edition, tables 27 and 28)."""

from __future__ import annotations

import operator
from collections.abc import Callable
from itertools import pairwise

from ldc.library.table import Function, Shape

SELECTION, COMPARISON = "27 selection", "28 comparison"


def _select(gate, in0, in1):
    return in1 if gate else in0


def _limit(low, value, high):
    return min(max(value, low), high)


def _multiplex(index, *values):
    return values[min(max(index, 0), len(values) - 1)]


def _fixed(function: Callable) -> Callable:
    return lambda types, result: function


def _compare(step: Callable) -> Callable:
    def chain(*values) -> bool:
        return all(step(a, b) for a, b in pairwise(values))

    return lambda types, result: step if len(types) == 2 else chain


def _comparison(name: str, step: Callable, note: str, generic: str = "ANY_ELEMENTARY") -> Function:
    shape = Shape((generic, generic), "BOOL", extends=name != "NE")
    return Function(name, ("IN1", "IN2"), (shape,), _compare(step), COMPARISON, note, name)


_NAN = "; a NaN is never greater or less, so the earlier value stays"
_PAIR = Shape(("ANY_ELEMENTARY", "ANY_ELEMENTARY"), "same", extends=True)

FUNCTIONS = (
    Function("SEL", ("G", "IN0", "IN1"), (Shape(("BOOL", "ANY_SCALAR", "ANY_SCALAR"), "same"),),
             _fixed(_select), SELECTION, "IN0 when G is FALSE, IN1 when it is TRUE"),
    Function("MAX", ("IN1", "IN2"), (_PAIR,), _fixed(max), SELECTION, "the greatest" + _NAN),
    Function("MIN", ("IN1", "IN2"), (_PAIR,), _fixed(min), SELECTION, "the least" + _NAN),
    Function("LIMIT", ("MN", "IN", "MX"), (Shape(("ANY_ELEMENTARY",) * 3, "same"),), _fixed(_limit),
             SELECTION, "MIN(MAX(IN, MN), MX): MX wins when MN is above it"),
    Function("MUX", ("K", "IN0", "IN1"), (Shape(("own ANY_INT", "ANY_SCALAR", "ANY_SCALAR"), "same",
             extends=True),), _fixed(_multiplex), SELECTION,
             "input number K; the first below 0, the last past the end"),
    _comparison("GT", operator.gt, "IN1 > IN2, and so on along a chain"),
    _comparison("GE", operator.ge, "IN1 >= IN2, and so on along a chain"),
    _comparison("EQ", operator.eq, "all equal", "ANY_SCALAR"),
    _comparison("LE", operator.le, "IN1 <= IN2, and so on along a chain"),
    _comparison("LT", operator.lt, "IN1 < IN2, and so on along a chain"),
    _comparison("NE", operator.ne, "not equal; not extensible", "ANY_SCALAR"),
)
