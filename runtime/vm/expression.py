"""Python expressions under construction: what the accumulator holds while IL is translated.

An expression knows how tightly it binds, which variables it reads (so that a later store can force
its evaluation first), how deep it is nested, and whether it still has to be wrapped to its width.
"""

from __future__ import annotations

from dataclasses import dataclass

from ldc.types import BOOL, Elementary, Type, storage

OR, AND, NOT, COMPARE, BIT_OR, BIT_XOR, BIT_AND, SHIFT, SUM, PRODUCT, UNARY, ATOM = range(1, 13)
NOTHING: frozenset[str] = frozenset()


@dataclass(slots=True)
class Expression:
    """``text`` binds as ``level``; ``reads`` are the names of variables that it depends on.

    ``unwrapped``: a sum or product of integers that may exceed ``type``; ADD, SUB and MUL go on with
    it, everything else wraps it first.
    """

    text: str
    type: Type
    level: int = ATOM
    reads: frozenset[str] = NOTHING
    depth: int = 0
    unwrapped: bool = False

    @property
    def is_atom(self) -> bool:
        return self.level == ATOM and self.depth == 0


def constant(value: object, type_: Type) -> Expression:
    """A literal. Infinities and NaN are names of the namespace."""
    text = repr(value)
    if isinstance(value, float) and (value != value or value in (float("inf"), float("-inf"))):
        text = text.replace("inf", "_inf").replace("nan", "_nan")
    return Expression(text, type_, UNARY if text[0] == "-" else ATOM)


def within(expression: Expression, level: int) -> tuple[str, int]:
    """Text and depth of an operand of an operator that needs operands binding at least as ``level``."""
    if expression.level >= level:
        return expression.text, expression.depth
    return f"({expression.text})", expression.depth + 1


def binary(left: Expression, sign: str, right: Expression, level: int, type_: Type,
           left_level: int | None = None, right_level: int | None = None) -> Expression:
    """``left sign right``; operands in parentheses where their binding needs it."""
    a, depth_a = within(left, level if left_level is None else left_level)
    b, depth_b = within(right, level + 1 if right_level is None else right_level)
    return Expression(f"{a} {sign} {b}", type_, level, left.reads | right.reads, max(depth_a, depth_b))


def invert(operand: Expression) -> Expression:
    """NOT of a BOOL or a bit string."""
    type_ = storage(operand.type)
    if type_ == BOOL:
        if operand.text in ("True", "False"):
            return constant(operand.text == "False", BOOL)
        text, depth = within(operand, NOT)
        return Expression(f"not {text}", BOOL, NOT, operand.reads, depth)
    return binary(operand, "^", constant(type_.range[1], type_), BIT_XOR, type_)


def logic(op: str, left: Expression, right: Expression) -> Expression:
    """AND, OR, XOR of two BOOLs (short circuit: both sides are free of effects) or bit strings."""
    type_ = storage(left.type)
    if type_ != BOOL:
        sign, level = {"AND": ("&", BIT_AND), "OR": ("|", BIT_OR), "XOR": ("^", BIT_XOR)}[op]
        return binary(left, sign, right, level, type_)
    if op == "XOR":
        return binary(left, "!=", right, COMPARE, BOOL, COMPARE + 1)
    neutral, absorbing = ("True", "False") if op == "AND" else ("False", "True")
    for one, other in ((left, right), (right, left)):
        if one.text == neutral:
            return other
        if one.text == absorbing:
            return one
    level = AND if op == "AND" else OR
    return binary(left, op.lower(), right, level, BOOL, right_level=level)


def compare(op: str, left: Expression, right: Expression) -> Expression:
    """A comparison of two values of one type."""
    sign = {"GT": ">", "GE": ">=", "EQ": "==", "NE": "!=", "LE": "<=", "LT": "<"}[op]
    return binary(left, sign, right, COMPARE, BOOL, COMPARE + 1)


def arithmetic(sign: str, left: Expression, right: Expression, type_: Type) -> Expression:
    """``+ - *`` of numbers: the caller rounds REAL; integers stay unwrapped."""
    made = binary(left, sign, right, PRODUCT if sign == "*" else SUM, type_)
    made.unwrapped = storage(type_).kind != "real"
    return made


def wrapped(operand: Expression, temporary: str) -> Expression:
    """The operand cut to the width of its type. ``temporary`` is a fresh local name, used for 64 bit."""
    if not operand.unwrapped:
        return operand
    type_: Elementary = storage(operand.type)
    low, high = type_.range
    if not low:
        text, depth = within(operand, BIT_AND)
        return Expression(f"{text} & {high}", operand.type, BIT_AND, operand.reads, depth)
    if type_.bits < 64:
        text, depth = within(operand, SUM)
        text = f"({text} + {-low} & {high - low}) - {-low}"
        return Expression(text, operand.type, SUM, operand.reads, depth + 1)
    over = f"({temporary} + {-low} & {high - low}) - {-low}"
    text = f"({temporary} if {low} <= ({temporary} := {operand.text}) <= {high} else {over})"
    return Expression(text, operand.type, ATOM, operand.reads, operand.depth + 2)
