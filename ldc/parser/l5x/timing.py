"""Timers and counters (1756-RM003, timer and counter instructions): functions on their structures."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.types import Structure

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer

_KINDS = {"TON": "TIMER", "TOF": "TIMER", "RTO": "TIMER", "CTU": "COUNTER", "CTD": "COUNTER"}
_PRESCAN = {
    "TON": {"EN": False, "TT": False, "DN": False, "ACC": 0}, "TOF": {"EN": False, "TT": False, "DN": False},
    "RTO": {"EN": False, "TT": False}, "CTU": {"CU": True}, "CTD": {"CD": True},
}
"""What the controller gives to members before the first scan; a counter is kept from counting in it."""


def _counts(w: Writer, i: Instruction) -> list[ast.Item]:
    kind = _KINDS[i.name]
    found = w.structure(i.operands[0], kind)
    if found is None:
        return []
    value, type_ = found
    for member, number in _PRESCAN[i.name].items():
        w.start(value, (member,), number)
    for text, member in zip(i.operands[1:], ("PRE", "ACC"), strict=False):
        if text.text == "?":
            continue
        number = w.read(text)
        if number is None:
            return []
        if not isinstance(number.number, int):
            w.reading.malformed(text, f"the {member} of {i.name} is no whole number",
                                help=f"write `?` here and give the tag's .{member} its value")
            return []
        if member == "PRE" or number.number:
            w.start(value, (member,), number.number)
    return [w.block(w.support.use(f"logix_{i.name.lower()}", **{kind: type_.name}), i.span,
                    [(kind.lower(), value.expr)], "power", "OUT")]


def _reset(w: Writer, i: Instruction) -> list[ast.Item]:
    value = w.place(i.operands[0])
    if value is None:
        return []
    kind = value.type.foreign if isinstance(value.type, Structure) else ""
    if kind not in ("TIMER", "COUNTER", "CONTROL"):
        w.reading.malformed(i.operands[0], f"`{i.operands[0].text[:40]}` is no TIMER, COUNTER or CONTROL",
                            help="RES needs one of these")
        return []
    name = w.support.use(f"logix_res_{kind.lower()}", **{kind: value.type.name})
    return [w.block(name, i.span, [(kind.lower(), value.expr)])]


TABLE = {**dict.fromkeys(_KINDS, (1, 3, _counts)), "RES": (1, 1, _reset)}
