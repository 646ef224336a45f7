"""Small functions that generated code and the stepping interpreter call."""

from __future__ import annotations

from array import array
from collections.abc import Callable

from ldc.types import String
from runtime.faults import IndexOutOfRange


def make_f32() -> Callable[[float], float]:
    """A rounder to the nearest REAL (ties to even, overflow to infinity). One per machine: it has a cell."""
    cell = array("f", [0.0])

    def f32(value: float) -> float:
        cell[0] = value
        return cell[0]

    return f32


def divide(a: int, b: int) -> int:
    """Quotient truncated toward zero (IEC 61131-3 2.5.1.5.2); ZeroDivisionError when b is 0."""
    quotient = abs(a) // abs(b)
    return quotient if (a < 0) == (b < 0) else -quotient


def modulo(a: int, b: int) -> int:
    """Remainder with the sign of the dividend; ZeroDivisionError when b is 0."""
    remainder = abs(a) % abs(b)
    return -remainder if a < 0 else remainder


def bad_index(offset: int, low: int, high: int) -> int:
    """Raises for an offset from ``low`` that is outside the bounds; never returns."""
    raise IndexOutOfRange(offset + low, low, high)


def cut(value: bytes | str, type_: String) -> bytes | str:
    """A string cut to the length of the variable that takes it."""
    return value[: type_.length]
