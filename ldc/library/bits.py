"""Bit shift and bitwise functions (IEC 61131-3, 2nd edition, tables 25 and 26)."""

from __future__ import annotations

import operator
from collections.abc import Callable

from ldc.library.table import Function, Shape
from ldc.library.values import fold
from ldc.types import Type

SHIFT, BITWISE = "25 bit shift", "26 bitwise"


def _shift(types: tuple[Type, ...], left: bool) -> Callable:
    width = types[0].bits
    mask, plain = (1 << width) - 1, _type_of(types[0])

    def shifted(value, count):
        if count <= 0:
            return value
        if count >= width:
            return plain(0)
        return plain((value << count) & mask if left else value >> count)

    return shifted


def _rotate(types: tuple[Type, ...], left: bool) -> Callable:
    width = types[0].bits
    mask, plain = (1 << width) - 1, _type_of(types[0])

    def rotated(value, count):
        if count <= 0:
            return value
        count %= width
        if not left:
            count = width - count
        return plain(((value << count) | (value >> width - count)) & mask)

    return rotated


def _type_of(type_: Type) -> type:
    """The Python type that a BOOL or bit string is kept as."""
    return bool if type_.kind == "bool" else int


def _bitwise(step: Callable) -> Callable:
    return lambda types, result: fold(step, len(types))


def _not(types: tuple[Type, ...], result: Type) -> Callable:
    if result.kind == "bool":
        return operator.not_
    mask = (1 << result.bits) - 1
    return lambda a: a ^ mask


_SHIFTS = (Shape(("ANY_BIT", "own ANY_INT"), "same"),)
_CHAIN = (Shape(("ANY_BIT", "ANY_BIT"), "same", extends=True),)
_ABOUT = "; all bits are gone when N is the width or more; N below 1 changes nothing"
_ROUND = "; N counts modulo the width; N below 1 changes nothing"

FUNCTIONS = (
    Function("SHL", ("IN", "N"), _SHIFTS, lambda types, _: _shift(types, True), SHIFT,
             "IN shifted left by N bits, filled with 0" + _ABOUT),
    Function("SHR", ("IN", "N"), _SHIFTS, lambda types, _: _shift(types, False), SHIFT,
             "IN shifted right by N bits, filled with 0" + _ABOUT),
    Function("ROR", ("IN", "N"), _SHIFTS, lambda types, _: _rotate(types, False), SHIFT,
             "IN rotated right by N bits" + _ROUND),
    Function("ROL", ("IN", "N"), _SHIFTS, lambda types, _: _rotate(types, True), SHIFT,
             "IN rotated left by N bits" + _ROUND),
    Function("AND", ("IN1", "IN2"), _CHAIN, _bitwise(operator.and_), BITWISE,
             "bit by bit: all of them", "AND"),
    Function("OR", ("IN1", "IN2"), _CHAIN, _bitwise(operator.or_), BITWISE,
             "bit by bit: at least one", "OR"),
    Function("XOR", ("IN1", "IN2"), _CHAIN, _bitwise(operator.xor), BITWISE,
             "bit by bit: an odd number of them", "XOR"),
    Function("NOT", ("IN",), (Shape(("ANY_BIT",), "same"),), _not, BITWISE, "each bit turned", "NOT"),
)
