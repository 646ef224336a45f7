"""Arithmetic, logic and moves: under power a value goes to the destination."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser.l5x import arithmetic
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.types import (
    BOOL, DINT, LINT, LREAL, REAL, WIDTHS, Structure, Text, is_integer, is_real,
)
from ldc.parser.l5x.values import Value, as_bits, bits_of, call, convert, from_bits, joined, literal

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer

_OPERATORS = {"ADD": "+", "SUB": "-", "MUL": "*", "DIV": "/", "MOD": "MOD", "XPY": "**", "EXPT": "**"}
_LOGIC = ("AND", "OR", "XOR")
_ORDERS = {"REVERSE": 0, "WORD": 1, "HIGH/LOW": 2}
_DRAWN = ("ADD", "SUB", "MUL")


def _binary(w: Writer, i: Instruction) -> list[ast.Item]:
    target = w.place(i.operands[2])
    a, b = w.read(i.operands[0]), w.read(i.operands[1])
    if target is None or a is None or b is None:
        return []
    if i.name in _DRAWN and target.type in (DINT, LINT, REAL) and target.whole is None and all(
            v.type == target.type for v in (a, b)):
        pins = [("IN1", convert(a, target.type)), ("IN2", convert(b, target.type))]
        return [w.block(i.name, i.span, pins, outputs=[("OUT", target.expr)])]
    value = arithmetic.binary(_OPERATORS[i.name], a, b, is_real(target.type), w.support)
    return [w.store(target, value, i.span)]


def _logic(w: Writer, i: Instruction) -> list[ast.Item]:
    target = w.place(i.operands[2])
    a, b = w.read(i.operands[0]), w.read(i.operands[1])
    if target is None or a is None or b is None:
        return []
    return [w.store(target, arithmetic.logic(i.name, a, b, i.span), i.span)]


def _unary(w: Writer, i: Instruction) -> list[ast.Item]:
    target, x = w.place(i.operands[1]), w.read(i.operands[0])
    if target is None or x is None:
        return []
    if i.name in ("NEG", "NOT"):
        value = arithmetic.unary("-" if i.name == "NEG" else "NOT", x, i.span)
    else:
        if is_real(target.type) and i.name in ("SQR", "SQRT") and not is_real(x.type):
            x = Value(convert(x, target.type), target.type, x.span)
        value = arithmetic.function(i.name, x, i.span, w.support)
    return [w.store(target, value, i.span)]


def _compute(w: Writer, i: Instruction) -> list[ast.Item]:
    target = w.place(i.operands[0])
    if target is None:
        return []
    value = w.read(i.operands[1], real=is_real(target.type))
    return [] if value is None else [w.store(target, value, i.span)]


def _move(w: Writer, i: Instruction) -> list[ast.Item]:
    target = w.place(i.operands[1])
    source = w.read(i.operands[0], hint=target.type if target is not None else None)
    if target is None or source is None:
        return []
    if isinstance(source.type, Structure) or isinstance(target.type, Structure):
        w.reading.malformed(i.span, "MOV of a structure", help="COP copies structures")
        return []
    return [w.store(target, source, i.span)]


def _masked_move(w: Writer, i: Instruction) -> list[ast.Item]:
    source, mask, target = w.read(i.operands[0]), w.read(i.operands[1]), w.place(i.operands[2])
    if source is None or mask is None or target is None:
        return []
    width = bits_of(source, mask, target)
    through = joined("AND", as_bits(source, width), as_bits(mask, width))
    kept = joined("AND", as_bits(target, width), ast.Unary("NOT", as_bits(mask, width), mask.span))
    return [w.store(target, from_bits(joined("OR", through, kept), width), i.span)]


def _distribute(w: Writer, i: Instruction) -> list[ast.Item]:
    source, from_, target, to, length = (
        w.place(text) if at == 2 else w.read(text) for at, text in enumerate(i.operands))
    if None in (source, from_, target, to, length):
        return []
    numbers = [convert(v, DINT) for v in (source, from_, target, to, length)]
    return [w.store(target, Value(call(w.support.use("logix_btd"), i.span, *numbers), DINT, i.span), i.span)]


def _swap(w: Writer, i: Instruction) -> list[ast.Item]:
    """SWPB(source, order, destination); of an INT the two bytes."""
    source, target, order = w.read(i.operands[0]), w.place(i.operands[2]), i.operands[1].text.upper()
    if source is None or target is None:
        return []
    if order not in _ORDERS or not is_integer(source.type) or WIDTHS[source.type.name] > 32:
        w.reading.malformed(i.span, f"SWPB cannot reorder {order[:20]} of this",
                            help="the order is REVERSE, WORD or HIGH/LOW, the source an INT or DINT")
        return []
    mode = 2 if WIDTHS[source.type.name] == 16 else _ORDERS[order]
    number = ast.Literal(mode, None, str(mode), i.span)
    swapped = Value(call(w.support.use("logix_swap"), i.span, convert(source, DINT), number), DINT, i.span)
    return [w.store(target, swapped, i.span)]


def _angle(w: Writer, i: Instruction) -> list[ast.Item]:
    y, x, target = w.read(i.operands[0]), w.read(i.operands[1]), w.place(i.operands[2])
    if y is None or x is None or target is None:
        return []
    type_ = LREAL if LREAL in (y.type, x.type) else REAL
    name = w.support.use("logix_atan2", T=type_.name)
    value = Value(call(name, i.span, convert(y, type_), convert(x, type_)), type_, i.span)
    return [w.store(target, value, i.span)]


def _clear(w: Writer, i: Instruction) -> list[ast.Item]:
    target = w.place(i.operands[0])
    if target is None:
        return []
    if isinstance(target.type, Structure):
        name = w.support.use("logix_clear_one", T=target.type.name)
        return [w.block(name, i.span, [("place", target.expr)])]
    if isinstance(target.type, Text):
        empty = Value(ast.Literal(b"", None, "''", i.span), Text(1), i.span)
        return [w.store(target, empty, i.span)]
    if target.type == BOOL and target.whole is None:
        return [ast.Coil("R", target.expr, i.span)]
    return [w.store(target, literal(0.0 if is_real(target.type) else 0, i.span), i.span)]


TABLE = {
    **dict.fromkeys(_OPERATORS, (3, 3, _binary)), **dict.fromkeys(_LOGIC, (3, 3, _logic)),
    **dict.fromkeys(("NEG", "NOT", *arithmetic.FUNCTIONS), (2, 2, _unary)),
    "CPT": (2, 2, _compute), "MOV": (2, 2, _move), "MOVE": (2, 2, _move), "MVM": (3, 3, _masked_move),
    "BTD": (5, 5, _distribute), "CLR": (1, 1, _clear), "SWPB": (3, 3, _swap), "ATAN2": (3, 3, _angle),
}
