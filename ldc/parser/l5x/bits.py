"""Contacts, coils, one-shots and comparisons."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser.l5x import arithmetic
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.types import BOOL, DINT, LREAL, REAL, is_integer, is_real
from ldc.parser.l5x.values import Value, boolean, call, common, convert, literal, real_text

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer

_COMPARISONS = {"EQU": "=", "NEQ": "<>", "GRT": ">", "GEQ": ">=", "LES": "<", "LEQ": "<=",
                "EQ": "=", "NE": "<>", "GT": ">", "GE": ">=", "LT": "<", "LE": "<="}
_WITHOUT_EFFECT = {
    "NOP": "does nothing", "IOT": "outputs are written at the end of the scan",
    "UID": "no task interrupts another within a rung", "UIE": "no task interrupts another within a rung",
}
_LARGEST = {REAL: 3.4028234663852886e38, LREAL: 1.7976931348623157e308}


def _contact(w: Writer, i: Instruction) -> list[ast.Item]:
    value = w.read(i.operands[0], hint=BOOL)
    return [] if value is None else [w.contact(value, i.span, i.name == "XIO")]


def _coil(w: Writer, i: Instruction) -> list[ast.Item]:
    value = w.place(i.operands[0], BOOL)
    if value is None:
        return []
    if i.name == "OTE":
        w.start(value, (), False)
        return [w.coil(value, i.span)]
    if value.whole is not None:
        return [w.set_bit(value, i.span, boolean(i.name == "OTL", i.span))]
    return [ast.Coil("S" if i.name == "OTL" else "R", value.expr, i.span)]


def _ons(w: Writer, i: Instruction) -> list[ast.Item]:
    """Power for one scan at its rise: ``{ [/s] | (s) [FALSE] }``."""
    storage = w.place(i.operands[0], BOOL)
    if storage is None:
        return []
    w.start(storage, (), True)
    return [_parallel(i, [w.contact(storage, i.span, True)],
                      [w.coil(storage, i.span), w.always(False, i.span)])]


def _osr(w: Writer, i: Instruction) -> list[ast.Item]:
    """The output for one scan at a rise; the power goes on: ``{ [/s] (q) | (s) }``."""
    storage, output = w.place(i.operands[0], BOOL), w.place(i.operands[1], BOOL)
    if storage is None or output is None:
        return []
    w.start(storage, (), True)
    w.start(output, (), False)
    return [_parallel(i, [w.contact(storage, i.span, True), w.coil(output, i.span)],
                      [w.coil(storage, i.span)])]


def _osf(w: Writer, i: Instruction) -> list[ast.Item]:
    """The output for one scan when the power goes; the power goes on."""
    storage, output = w.place(i.operands[0], BOOL), w.place(i.operands[1], BOOL)
    if storage is None or output is None:
        return []
    if output.whole is not None:
        w.reading.unsupported(i.operands[1], "OSF with a bit of an integer as its output",
                              "give it a BOOL tag")
        return []
    w.start(storage, (), False)
    w.start(output, (), False)
    block = w.block(w.support.use("logix_osf"), i.span, [("storage", storage.expr)], "power", "OUT",
                    [("fell", output.expr)])
    return [block, w.coil(storage, i.span)]


def _parallel(i: Instruction, *levels: list[ast.Item]) -> ast.Branches:
    return ast.Branches(tuple(ast.Path(tuple(items), i.span) for items in levels), i.span)


def _never(w: Writer, i: Instruction) -> list[ast.Item]:
    return [w.always(False, i.span)]


def _nothing(w: Writer, i: Instruction) -> list[ast.Item]:
    w.reading.left_out(i.span, i.name, _WITHOUT_EFFECT[i.name])
    return []


def _compare(w: Writer, i: Instruction) -> list[ast.Item]:
    a, b = w.read(i.operands[0]), w.read(i.operands[1])
    if a is None or b is None:
        return []
    return [w.contact(arithmetic.compare(_COMPARISONS[i.name], a, b, i.span), i.span)]


def _limit(w: Writer, i: Instruction) -> list[ast.Item]:
    low, test, high = (w.read(text) for text in i.operands)
    if low is None or test is None or high is None:
        return []
    type_ = common(low.type, test.type, high.type)
    name = w.support.use("logix_lim", T=type_.name if type_ else "DINT")
    arguments = tuple(ast.Argument(None, convert(v, type_), False, v.span) for v in (low, test, high))
    return [ast.Contact("", ast.Call(name, arguments, i.span), i.span)]


def _masked(w: Writer, i: Instruction) -> list[ast.Item]:
    source, mask, other = (w.read(text) for text in i.operands)
    if source is None or mask is None or other is None:
        return []
    left = arithmetic.logic("AND", source, mask, i.span)
    right = arithmetic.logic("AND", other, mask, i.span)
    return [w.contact(arithmetic.compare("=", left, right, i.span), i.span)]


def _cmp(w: Writer, i: Instruction) -> list[ast.Item]:
    value = w.read(i.operands[0])
    if value is None:
        return []
    if is_integer(value.type) or is_real(value.type):
        value = arithmetic.compare("<>", value, _zero(value), i.span)
    return [ast.Contact("", value.expr, i.span)]


def _special(w: Writer, i: Instruction) -> list[ast.Item]:
    """IsNAN and IsINF."""
    value = w.read(i.operands[0], real=True)
    if value is None:
        return []
    if i.name == "ISNAN":
        return [ast.Contact("", ast.Binary("<>", value.expr, value.expr, i.span), i.span)]
    if not is_real(value.type):
        return [w.always(False, i.span)]
    size = call("ABS", i.span, value.expr)
    limit = ast.Literal(_LARGEST[value.type], None, real_text(_LARGEST[value.type]), i.span)
    return [ast.Contact("", ast.Binary(">", size, limit, i.span), i.span)]


def _transition(w: Writer, i: Instruction) -> list[ast.Item]:
    """DTR(source, mask, reference): power for one scan when the masked source has changed."""
    source, mask, before = w.read(i.operands[0]), w.read(i.operands[1]), w.place(i.operands[2])
    if source is None or mask is None or before is None:
        return []
    if before.type != DINT:
        w.reading.malformed(i.operands[2], "the reference of DTR is no DINT", help="give it a DINT tag")
        return []
    masked = convert(arithmetic.logic("AND", source, mask, i.span), DINT)
    return [w.block(w.support.use("logix_dtr"), i.span, [("masked", masked), ("before", before.expr)],
                    "power", "OUT")]


def _zero(value: Value) -> Value:
    return literal(0.0 if is_real(value.type) else 0, value.span)


TABLE = {
    "XIC": (1, 1, _contact), "XIO": (1, 1, _contact),
    "OTE": (1, 1, _coil), "OTL": (1, 1, _coil), "OTU": (1, 1, _coil),
    "ONS": (1, 1, _ons), "OSR": (2, 2, _osr), "OSF": (2, 2, _osf),
    "AFI": (0, 0, _never), "NOP": (0, 0, _nothing), "UID": (0, 0, _nothing), "UIE": (0, 0, _nothing),
    "IOT": (1, 1, _nothing),
    **dict.fromkeys(_COMPARISONS, (2, 2, _compare)), "LIM": (3, 3, _limit), "LIMIT": (3, 3, _limit),
    "MEQ": (3, 3, _masked), "CMP": (1, 1, _cmp), "DTR": (3, 3, _transition),
    "ISNAN": (1, 1, _special), "ISINF": (1, 1, _special),
}
