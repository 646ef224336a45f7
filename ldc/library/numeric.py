"""Numeric functions and arithmetic (IEC 61131-3, 2nd edition, tables 23 and 24)."""

from __future__ import annotations

import math
from collections.abc import Callable

from ldc.library.faults import DivisionByZero
from ldc.library.generic import kind
from ldc.library.table import Function, Shape
from ldc.library.values import DAY, fold, normaliser, saturate, to_real
from ldc.types import DINT, TIME, Type

ONE, ARITHMETIC = "23 numeric", "24 arithmetic"


def _add(types: tuple[Type, ...], result: Type) -> Callable:
    fit = normaliser(result)
    return fold(lambda a, b: fit(a + b), len(types))


def _sub(types: tuple[Type, ...], result: Type) -> Callable:
    fit = normaliser(result)
    if kind(types[0]) == "date":
        return lambda a, b: fit((a - b) * DAY)
    return lambda a, b: fit(a - b)


def _mul(types: tuple[Type, ...], result: Type) -> Callable:
    fit = normaliser(result)
    if result == TIME and kind(types[1]) == "real":
        low, high = TIME.range
        return lambda a, b: saturate(float(a) * b, low, high)
    return fold(lambda a, b: fit(a * b), len(types))


def _div(types: tuple[Type, ...], result: Type) -> Callable:
    fit = normaliser(result)
    real = kind(types[1]) == "real"
    if real and result == TIME:
        low, high = TIME.range

        def divide(a, b):
            return saturate(float(a) / b, low, high)
    elif real:
        def divide(a, b):
            return fit(a / b)
    else:
        def divide(a, b):
            return fit(a // b if (a >= 0) == (b > 0) else -(-a // b))

    def checked(a, b):
        if b == 0:
            raise DivisionByZero
        return divide(a, b)

    return checked


def _mod(types: tuple[Type, ...], result: Type) -> Callable:
    def modulo(a, b):
        if b == 0:
            raise DivisionByZero
        rest = abs(a) % abs(b)
        return -rest if a < 0 else rest

    return modulo


def _neg(types: tuple[Type, ...], result: Type) -> Callable:
    fit = normaliser(result)
    return lambda a: fit(-a)


def _abs(types: tuple[Type, ...], result: Type) -> Callable:
    fit = normaliser(result)
    return lambda a: fit(abs(a))


def _power(base: float, exponent: float) -> float:
    """pow() of C: NaN for a negative base and a fraction, infinity for overflow and for 0 ** negative."""
    try:
        return math.pow(base, exponent)
    except OverflowError:
        odd = math.fmod(exponent, 2.0) != 0.0
        return -math.inf if base < 0.0 and odd else math.inf
    except ValueError:
        if base != 0.0:
            return math.nan
        odd = math.fmod(abs(exponent), 2.0) == 1.0
        return math.copysign(math.inf, base) if odd else math.inf


def _expt(types: tuple[Type, ...], result: Type) -> Callable:
    fit = normaliser(result)
    return lambda a, b: fit(_power(a, float(b)))


def _trunc(types: tuple[Type, ...], result: Type) -> Callable:
    low, high = result.range
    return lambda a: saturate(a, low, high, int)


def _guarded(function: Callable[[float], float], at_zero: float = math.nan) -> Callable:
    """A function of C's math library: NaN outside its domain, infinity for overflow."""
    def compute(value: float) -> float:
        try:
            return function(value)
        except OverflowError:
            return math.inf
        except ValueError:
            return at_zero if value == 0.0 else math.nan

    def meaning(types: tuple[Type, ...], result: Type) -> Callable:
        return (lambda a: to_real(compute(a))) if result.bits == 32 else compute

    return meaning


def _real_function(name: str, function: Callable, note: str, at_zero: float = math.nan) -> Function:
    return Function(name, ("IN",), (Shape(("ANY_REAL",), "same"),), _guarded(function, at_zero), ONE, note)


_IN1_IN2 = ("IN1", "IN2")
_NUMBERS = Shape(("ANY_NUM", "ANY_NUM"), "same", extends=True)

FUNCTIONS = (
    Function("ABS", ("IN",), (Shape(("ANY_NUM",), "same"),), _abs, ONE,
             "absolute value; of the least integer that integer itself (it wraps)"),
    _real_function("SQRT", math.sqrt, "square root; NaN below 0"),
    _real_function("LN", math.log, "natural logarithm; negative infinity at 0, NaN below", -math.inf),
    _real_function("LOG", math.log10, "logarithm to the base 10; as LN at 0 and below", -math.inf),
    _real_function("EXP", math.exp, "e to the power of IN"),
    _real_function("SIN", math.sin, "sine of an angle in radians"),
    _real_function("COS", math.cos, "cosine of an angle in radians"),
    _real_function("TAN", math.tan, "tangent of an angle in radians"),
    _real_function("ASIN", math.asin, "arc sine in radians; NaN outside -1..1"),
    _real_function("ACOS", math.acos, "arc cosine in radians; NaN outside -1..1"),
    _real_function("ATAN", math.atan, "arc tangent in radians"),
    Function("TRUNC", ("IN",), (Shape(("ANY_REAL",), DINT.name),), _trunc, ONE,
             "fraction cut off; saturates at the ends of DINT, NaN gives 0; REAL_TRUNC_INT and so on "
             "give other types"),
    Function("ADD", _IN1_IN2, (
        _NUMBERS, Shape(("TIME", "TIME"), "TIME", extends=True),
        Shape(("TOD", "TIME"), "TOD"), Shape(("DT", "TIME"), "DT")), _add, ARITHMETIC,
        "sum; integers wrap; times as ADD_TIME, ADD_TOD_TIME, ADD_DT_TIME", "ADD"),
    Function("MUL", _IN1_IN2, (_NUMBERS, Shape(("TIME", "own ANY_NUM"), "TIME")), _mul, ARITHMETIC,
             "product; integers wrap; TIME times a number as MULTIME", "MUL"),
    Function("SUB", _IN1_IN2, (
        Shape(("ANY_NUM", "ANY_NUM"), "same"), Shape(("TIME", "TIME"), "TIME"),
        Shape(("DATE", "DATE"), "TIME"), Shape(("TOD", "TIME"), "TOD"), Shape(("TOD", "TOD"), "TIME"),
        Shape(("DT", "TIME"), "DT"), Shape(("DT", "DT"), "TIME")), _sub, ARITHMETIC,
        "difference; integers wrap; times as the SUB_ functions of table 30", "SUB"),
    Function("DIV", _IN1_IN2, (
        Shape(("ANY_NUM", "ANY_NUM"), "same"), Shape(("TIME", "own ANY_NUM"), "TIME")), _div, ARITHMETIC,
        "quotient; integers are cut toward zero; a fault when IN2 is 0, also of REAL", "DIV"),
    Function("MOD", _IN1_IN2, (Shape(("ANY_INT", "ANY_INT"), "same"),), _mod, ARITHMETIC,
             "remainder of DIV, with the sign of IN1; a fault when IN2 is 0", "MOD"),
    Function("EXPT", _IN1_IN2, (Shape(("ANY_REAL", "own ANY_NUM"), "same"),), _expt, ARITHMETIC,
             "IN1 to the power of IN2 (`**` of ST)"),
    Function("MOVE", ("IN",), (Shape(("ANY",), "same"),), lambda types, result: lambda a: a, ARITHMETIC,
             "the same value"),
    Function("NEG", ("IN",), (Shape(("ANY_MAGNITUDE",), "same"),), _neg, ARITHMETIC,
             "unary minus of ST; the least integer stays itself (it wraps)", internal=True),
)

# The named time functions of table 30 share these.
ADD, SUB, MUL, DIV, TRUNCATE = _add, _sub, _mul, _div, _trunc
