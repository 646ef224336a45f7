"""Bringing a computed number back into its type: wrapping, rounding, saturating (docs/semantics.md)."""

from __future__ import annotations

import math
from collections.abc import Callable
from struct import Struct

from ldc.types import Type, storage

DAY, SECOND, MILLISECOND = 86_400_000_000_000, 1_000_000_000, 1_000_000
_SINGLE = Struct("<f")


def to_real(value: float) -> float:
    """The nearest 32-bit REAL (ties to even) as a Python float; infinity past the greatest one."""
    try:
        return _SINGLE.unpack(_SINGLE.pack(value))[0]
    except OverflowError:
        return math.copysign(math.inf, value)


def normaliser(type_: Type) -> Callable:
    """What makes a value of ``type_`` of an exact integer or a double.

    Integers, bit strings, TIME, DATE and DATE_AND_TIME wrap to their width (two's complement),
    TIME_OF_DAY wraps at 24 h, REAL is rounded once, LREAL stays.
    """
    type_ = storage(type_)
    if type_.kind == "real":
        return to_real if type_.bits == 32 else float
    if type_.kind == "bool":
        return bool
    if type_.kind == "tod":
        return lambda v: v % DAY
    mask = (1 << type_.bits) - 1
    if type_.kind in ("int", "time"):
        half = 1 << type_.bits - 1
        return lambda v: ((v + half) & mask) - half
    return lambda v: v & mask


def saturate(value: float, low: int, high: int, to_integer: Callable[[float], int] = round) -> int:
    """A double as an integer: half to even (``round``) or cut (``int``); bounded; 0 for NaN."""
    if value != value:
        return 0
    if value <= low:
        return low
    return high if value >= high else to_integer(value)


def fold(step: Callable, count: int) -> Callable:
    """``step`` of two values as a function of ``count`` values, from left to right."""
    if count == 2:
        return step

    def chain(first, *others):
        for other in others:
            first = step(first, other)
        return first

    return chain
