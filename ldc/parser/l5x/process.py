"""Scaling, and the PID instruction with independent gains."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser.l5x import arithmetic
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.types import LREAL, REAL, is_integer
from ldc.parser.l5x.values import Value, call, convert, literal

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer


def _scale_parameters(w: Writer, i: Instruction) -> list[ast.Item]:
    """SCP: a line through two points, in REAL."""
    target = w.place(i.operands[-1])
    values = [w.read(text) for text in i.operands[:-1]]
    if target is None or None in values:
        return []
    name = w.support.use("logix_scp")
    result = call(name, i.span, *(convert(v, REAL) for v in values))
    return [w.store(target, Value(result, REAL, i.span), i.span)]


def _scale(w: Writer, i: Instruction) -> list[ast.Item]:
    """SCL: source * rate + offset; a whole rate is in ten-thousandths, as in an SLC 500."""
    target = w.place(i.operands[-1])
    source, rate, offset = (w.read(text) for text in i.operands[:-1])
    if None in (target, source, rate, offset):
        return []
    if is_integer(rate.type):
        wide = [Value(convert(v, LREAL), LREAL, v.span) for v in (source, rate, offset)]
        product = arithmetic.binary("*", wide[0], wide[1], True, w.support)
        scaled = arithmetic.binary("/", product, literal(10000.0, i.span), True, w.support)
        value = arithmetic.binary("+", scaled, wide[2], True, w.support)
    else:
        product = arithmetic.binary("*", source, rate, True, w.support)
        value = arithmetic.binary("+", product, offset, True, w.support)
    return [w.store(target, value, i.span)]


def _pid(w: Writer, i: Instruction) -> list[ast.Item]:
    """PID(control, process variable, tieback, control variable, master loop, inhold bit, inhold value)."""
    found = w.structure(i.operands[0], "PID")
    variable, output = w.read(i.operands[1]), w.place(i.operands[3])
    if found is None or variable is None or output is None:
        return []
    for text, what in ((i.operands[2], "a tieback"), (i.operands[4], "a master loop"),
                       (i.operands[5], "an inhold bit")):
        if text.text not in ("0", "?"):
            w.reading.unsupported(text, f"PID with {what}", "write 0 here, and give .SP or .SO by MOV")
            return []
    block = w.block(w.support.use("logix_pid", PID=found[1].name), i.span,
                    [("variable", convert(variable, REAL)), ("loop", found[0].expr)])
    out = Value(ast.Member(found[0].expr, "OUT", i.span), REAL, i.span)
    return [block, w.store(output, out, i.span)]


TABLE = {"SCP": (6, 6, _scale_parameters), "SCL": (4, 4, _scale), "PID": (7, 9, _pid)}
