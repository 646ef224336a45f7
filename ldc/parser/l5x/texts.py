"""Strings: positions count from 1, as in IEC 61131-3."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.types import DINT, STRING, Type
from ldc.parser.l5x.values import Value, call, convert, literal

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer


def _function(w: Writer, i: Instruction) -> list[ast.Item]:
    """The last operand is the destination."""
    target = w.place(i.operands[-1])
    values = [w.read(text) for text in i.operands[:-1]]
    if target is None or None in values:
        return []
    name, numbers, type_ = _FORMS[i.name]
    arguments = [convert(v, DINT) if at in numbers else v.expr for at, v in enumerate(values)]
    if i.name == "INSERT":
        # Logix tells where the text begins, IEC 61131-3 behind which character.
        arguments[2] = ast.Binary("-", arguments[2], literal(1, i.span).expr, i.span)
    if name.startswith("logix"):
        name = w.support.use(name)
    return [w.store(target, Value(call(name, i.span, *arguments), type_, i.span), i.span)]


_FORMS: dict[str, tuple[str, tuple[int, ...], Type]] = {
    "CONCAT": ("CONCAT", (), STRING), "MID": ("MID", (1, 2), STRING), "DELETE": ("DELETE", (1, 2), STRING),
    "INSERT": ("INSERT", (2,), STRING), "FIND": ("logix_find", (2,), DINT),
    "UPPER": ("logix_upper", (), STRING), "LOWER": ("logix_lower", (), STRING),
    "DTOS": ("DINT_TO_STRING", (0,), STRING), "STOD": ("logix_stod", (), DINT),
}
"""The function, which operands are numbers, and what comes out."""
_COUNTS = {"CONCAT": 3, "MID": 4, "DELETE": 4, "INSERT": 4, "FIND": 4}

TABLE: dict[str, tuple[int, int, Callable]] = {
    name: (_COUNTS.get(name, 2), _COUNTS.get(name, 2), _function) for name in _FORMS
}
