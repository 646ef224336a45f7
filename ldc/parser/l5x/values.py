"""Typed operands and what Logix does when it mixes their types.

Integers are computed in 32 bits (64 when one of them has them), reals in a REAL; a REAL that goes to an
integer is rounded half to even, an integer that goes to a narrower one keeps its low bits (1756-RM003, data
conversions).
"""

from __future__ import annotations

from math import isfinite

from ldc.parser import ast
from ldc.parser.l5x.types import (
    BOOL, DINT, LINT, LREAL, REAL, WIDTHS, Atom, Text, Type, is_integer, is_real,
)
from ldc.records import record
from ldc.source import Span

_BITS = {8: "BYTE", 16: "WORD", 32: "DWORD", 64: "LWORD"}


@record
class Value:
    """``expr`` reads it. ``type`` None: not known (nobody declared it; the model tells).

    ``number``: of a literal. ``bit``: it is that bit (an expression) of the integer ``whole``, whose bits the
    ladder language does not name. ``way``: the variable and the constant steps to the place, None when it is
    none or an index is computed. ``place``: whether it can be written. ``array``, ``at``: it is that element
    of an array of one dimension; ``whole_array``: it is an element of that array. ``text``: it is the length
    of that string.
    """

    expr: ast.Expr
    type: Type | None
    span: Span
    number: int | float | None = None
    whole: Value | None = None
    bit: ast.Expr | None = None
    way: tuple | None = None
    place: bool = False
    array: Value | None = None
    at: ast.Expr | None = None
    whole_array: Value | None = None
    text: Value | None = None


def literal(number: int | float, span: Span) -> Value:
    """A number as an operand; an integer is a DINT, or a LINT when it needs to be."""
    if isinstance(number, float):
        return Value(ast.Literal(number, None, real_text(number), span), REAL, span, number)
    type_ = DINT if -(1 << 31) <= number < 1 << 32 else LINT
    return Value(ast.Literal(number, None, str(number), span), type_, span, number)


def real_text(number: float) -> str:
    """A finite real as a literal, ``1.0e+16``."""
    text = repr(number)
    mantissa, e, exponent = text.partition("e")
    return f"{mantissa}{'' if '.' in mantissa else '.0'}{e}{exponent}"


def boolean(value: bool, span: Span) -> ast.Literal:
    return ast.Literal(value, "BOOL", "TRUE" if value else "FALSE", span)


def call(name: str, span: Span, *arguments: ast.Expr) -> ast.Call:
    return ast.Call(name, tuple(ast.Argument(None, a, False, a.span) for a in arguments), span)


def negated(expr: ast.Expr) -> ast.Expr:
    if isinstance(expr, ast.Unary) and expr.op == "NOT":
        return expr.operand
    return ast.Unary("NOT", expr, expr.span)


def joined(op: str, first: ast.Expr, *more: ast.Expr) -> ast.Expr:
    for other in more:
        first = ast.Binary(op, first, other, first.span.to(other.span))
    return first


# ---- conversion -------------------------------------------------------------------------------


def common(*types: Type | None) -> Type | None:
    """The type that an instruction computes in; None when one is not known."""
    if None in types:
        return None
    if LREAL in types:
        return LREAL
    if REAL in types:
        return REAL
    return LINT if any(is_integer(t) and WIDTHS[t.name] == 64 for t in types) else DINT


def convert(value: Value, target: Type | None) -> ast.Expr:
    """The value in another type, as Logix converts it; what cannot be is left for the model to tell."""
    source = value.type
    if value.number is not None and target is not None and not isinstance(target, Text):
        return _literal_as(value, target)
    if source is None or target is None or source == target:
        return value.expr
    if not (isinstance(source, Atom) and isinstance(target, Atom)):
        return value.expr
    if target == BOOL or source == BOOL and is_real(target):
        return value.expr
    if source == BOOL:
        return call(f"BOOL_TO_{target.name}", value.span, value.expr)
    if is_real(source) and is_integer(target):
        wide = LINT if WIDTHS[target.name] == 64 else DINT
        rounded = Value(call(f"{source.name}_TO_{wide.name}", value.span, value.expr), wide, value.span)
        return convert(rounded, target)
    return call(f"{source.name}_TO_{target.name}", value.span, value.expr)


def _literal_as(value: Value, target: Type) -> ast.Expr:
    number = value.number
    if is_real(target):
        return literal(float(number), value.span).expr
    if isinstance(number, float) and isfinite(number):
        number = round(number)
    if is_integer(target):
        number = wrapped(number, WIDTHS[target.name], target.name.startswith("U"))
    if target == BOOL and number in (0, 1):
        return boolean(bool(number), value.span)
    return ast.Literal(number, None, str(number), value.span)


def wrapped(number: int, width: int, unsigned: bool) -> int:
    """The low bits of a number."""
    number %= 1 << width
    return number - (1 << width) if not unsigned and number >> width - 1 else number


def as_bits(value: Value, width: int) -> ast.Expr:
    """An integer as a bit string of ``width`` bits; a narrower one is filled with zeros, as logic does."""
    target = _BITS[width]
    if value.number is not None and isinstance(value.number, int):
        number = value.number % (1 << width)
        return ast.Literal(number, target, f"{target}#16#{number:X}", value.span)
    if not is_integer(value.type):
        return value.expr
    own = min(WIDTHS[value.type.name], width)
    narrow = call(f"{value.type.name}_TO_{_BITS[own]}", value.span, value.expr)
    return narrow if own == width else call(f"{_BITS[own]}_TO_{target}", value.span, narrow)


def from_bits(expr: ast.Expr, width: int) -> Value:
    """A bit string of 32 or 64 bits as DINT or LINT."""
    type_ = LINT if width == 64 else DINT
    return Value(call(f"{_BITS[width]}_TO_{type_.name}", expr.span, expr), type_, expr.span)


def bits_of(*values: Value) -> int:
    """The width in which logic is done."""
    return 64 if any(is_integer(v.type) and WIDTHS[v.type.name] == 64 for v in values) else 32
