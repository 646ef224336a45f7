"""What operators and functions do to operands of mixed types (1756-RM003: compute and math instructions)."""

from __future__ import annotations

from ldc.parser import ast
from ldc.parser.l5x.support import Support
from ldc.parser.l5x.types import BOOL, DINT, REAL, Text, is_real
from ldc.parser.l5x.values import (
    Value, as_bits, bits_of, call, common, convert, from_bits, joined, literal, negated,
)
from ldc.source import Span

_LOGIC, _COMPARISONS = ("AND", "&", "XOR", "OR"), ("=", "<>", "<", ">", "<=", ">=")
_REAL_FUNCTIONS = {
    "SIN": "SIN", "COS": "COS", "TAN": "TAN", "ASN": "ASIN", "ASIN": "ASIN", "ACS": "ACOS", "ACOS": "ACOS",
    "ATN": "ATAN", "ATAN": "ATAN", "LN": "LN", "LOG": "LOG",
}
_DEGREES, _RADIANS = 57.29578, 0.017453292
FUNCTIONS = (*_REAL_FUNCTIONS, "ABS", "SQR", "SQRT", "DEG", "RAD", "TRN", "TRUNC", "TOD", "FRD",
             "TO_BCD", "BCD_TO")


def binary(op: str, left: Value, right: Value, real: bool, support: Support) -> Value:
    """``left op right``. ``real``: integers are computed as REAL, since the result goes to one."""
    span = left.span.to(right.span)
    if op in _LOGIC:
        return logic("AND" if op == "&" else op, left, right, span)
    if op in _COMPARISONS:
        return compare(op, left, right, span)
    type_ = common(left.type, right.type)
    if type_ is not None and real and not is_real(type_) or op == "**" and type_ is not None:
        type_ = type_ if is_real(type_) else REAL
    a, b = convert(left, type_), convert(right, type_)
    if op in ("/", "MOD") and type_ is not None and not right.number:
        kind = "div" if op == "/" else "mod"
        form = "real" if is_real(type_) else "whole"
        name = support.use(f"logix_{kind}_{form}", T=type_.name)
        return Value(call(name, span, a, b), type_, span)
    if op == "MOD" and is_real(type_):
        return Value(call(support.use("logix_mod_real", T=type_.name), span, a, b), type_, span)
    return Value(ast.Binary(op, a, b, span), type_, span)


def compare(op: str, left: Value, right: Value, span: Span) -> Value:
    """A comparison: of numbers in their common type, of strings byte by byte."""
    if isinstance(left.type, Text) or isinstance(right.type, Text) or BOOL in (left.type, right.type):
        return Value(ast.Binary(op, left.expr, right.expr, span), BOOL, span)
    type_ = common(left.type, right.type)
    # The spelling stays as it is where both sides are of one type already.
    if left.type == right.type and left.number is None and right.number is None:
        type_ = left.type
    elif right.number is not None and not (is_real(type_) and not is_real(left.type)):
        type_ = left.type if left.number is None and _holds(left.type, right.number) else type_
    elif left.number is not None and not (is_real(type_) and not is_real(right.type)):
        type_ = right.type if _holds(right.type, left.number) else type_
    return Value(ast.Binary(op, convert(left, type_), convert(right, type_), span), BOOL, span)


def _holds(type_: object, number: int | float) -> bool:
    return is_real(type_) or type_ == DINT and isinstance(number, int) or (
        isinstance(number, int) and -128 <= number <= 127)


def logic(op: str, left: Value, right: Value, span: Span) -> Value:
    """Logic of BOOLs, or bit by bit in 32 or 64 bits."""
    if left.type == BOOL and right.type == BOOL:
        return Value(ast.Binary(op, left.expr, right.expr, span), BOOL, span)
    if None in (left.type, right.type):
        return Value(ast.Binary(op, left.expr, right.expr, span), None, span)
    width = bits_of(left, right)
    return from_bits(joined(op, as_bits(_whole(left), width), as_bits(_whole(right), width)), width)


def unary(op: str, operand: Value, span: Span) -> Value:
    if op == "+":
        return operand
    if op == "-":
        if operand.number is not None:
            return literal(-operand.number, span)
        type_ = common(operand.type)
        return Value(ast.Unary("-", convert(operand, type_), span), type_, span)
    if operand.type == BOOL:
        return Value(negated(operand.expr), BOOL, span)
    if operand.type is None:
        return Value(ast.Unary("NOT", operand.expr, span), None, span)
    width = bits_of(operand)
    return from_bits(ast.Unary("NOT", as_bits(_whole(operand), width), span), width)


def _whole(value: Value) -> Value:
    """A number for logic: a real is rounded, a BOOL is 0 or 1."""
    if is_real(value.type) or value.type == BOOL:
        number = round(value.number) if value.number is not None else None
        return Value(convert(value, DINT), DINT, value.span, number)
    return value


def function(name: str, x: Value, span: Span, support: Support) -> Value | None:
    """A function of an expression, by name in capitals; None when there is none."""
    type_ = common(x.type)
    real = None if type_ is None else type_ if is_real(type_) else REAL
    if name in _REAL_FUNCTIONS:
        return Value(call(_REAL_FUNCTIONS[name], span, convert(x, real)), real, span)
    if name == "ABS":
        return Value(call("ABS", span, convert(x, type_)), type_, span)
    if name in ("SQR", "SQRT"):
        if type_ is None or is_real(type_):
            return Value(call("SQRT", span, call("ABS", span, convert(x, real))), real, span)
        return Value(call(support.use("logix_root", T=type_.name), span, convert(x, type_)), type_, span)
    if name in ("DEG", "RAD"):
        factor = literal(_DEGREES if name == "DEG" else _RADIANS, span)
        return Value(joined("*", convert(x, real), convert(factor, real)), real, span)
    if name in ("TRN", "TRUNC"):
        if is_real(type_):
            return Value(call(f"{type_.name}_TRUNC_DINT", span, convert(x, type_)), DINT, span)
        return Value(convert(x, type_), type_, span)
    if name in ("TOD", "FRD", "TO_BCD", "BCD_TO"):
        return Value(_bcd(name, convert(x, DINT), span), DINT, span)
    return None


def _bcd(name: str, x: ast.Expr, span: Span) -> ast.Expr:
    if name in ("TOD", "TO_BCD"):
        return call("DWORD_TO_DINT", span, call("UDINT_TO_BCD_DWORD", span, call("DINT_TO_UDINT", span, x)))
    return call("UDINT_TO_DINT", span, call("DWORD_BCD_TO_UDINT", span, call("DINT_TO_DWORD", span, x)))
