"""TONR TOFR RTOR CTUD OSRI OSFI: what Structured Text calls where a ladder has TON, CTU and ONS.

All that they take and give lies in their structure (1756-RM003, timer and counter, bit instructions); they
are the instructions of the ladder under a power that is a member.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.types import BOOL, Structure
from ldc.parser.l5x.values import Value

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer

_TIMERS = {"TONR": "logix_ton", "TOFR": "logix_tof", "RTOR": "logix_rto"}
_PRESCAN = {
    "TONR": {"EN": False, "TT": False, "DN": False, "ACC": 0},
    "TOFR": {"EN": False, "TT": False, "DN": False},
    "RTOR": {"EN": False, "TT": False}, "CTUD": {"CU": True, "CD": True},
    "OSRI": {"OUTPUTBIT": False, "STORAGE": True}, "OSFI": {"OUTPUTBIT": False, "STORAGE": False},
}
"""What the controller gives to members before the first scan."""


def _structure(w: Writer, i: Instruction, name: str) -> tuple[Value, Structure] | None:
    found = w.structure(i.operands[0], name)
    if found is not None:
        for member, number in _PRESCAN[i.name].items():
            w.start(found[0], (member,), number)
    return found


def _member(w: Writer, i: Instruction, value: Value, name: str) -> Value:
    return w.operands.member(value, name, i.span)


def _either(
    w: Writer, i: Instruction, value: Value, reset: list[ast.Item], run: list[ast.Item],
) -> list[ast.Item]:
    """What Reset does, and what is done without it."""
    bit = _member(w, i, value, "Reset").expr
    levels = ([ast.Contact("", bit, i.span), *reset], [ast.Contact("/", bit, i.span), *run])
    return [ast.Branches(tuple(ast.Path(tuple(items), i.span) for items in levels), i.span)]


def _timer(w: Writer, i: Instruction) -> list[ast.Item]:
    found = _structure(w, i, "FBD_TIMER")
    if found is None:
        return []
    value, type_ = found
    enable = _member(w, i, value, "TimerEnable").expr
    reset = w.block(w.support.use("logix_res_timer", TIMER=type_.name), i.span, [("timer", value.expr)])
    run = w.block(w.support.use(_TIMERS[i.name], TIMER=type_.name), i.span,
                  [("power", enable), ("timer", value.expr)])
    return _either(w, i, value, [reset], [run])


def _counter(w: Writer, i: Instruction) -> list[ast.Item]:
    found = _structure(w, i, "FBD_COUNTER")
    if found is None:
        return []
    value, type_ = found
    reset = w.block(w.support.use("logix_res_counter", COUNTER=type_.name), i.span, [("counter", value.expr)])
    run = [w.block(w.support.use(f"logix_{name}", COUNTER=type_.name), i.span,
                   [("power", _member(w, i, value, enable).expr), ("counter", value.expr)])
           for name, enable in (("ctu", "CUEnable"), ("ctd", "CDEnable"))]
    done = ast.Binary(">=", _member(w, i, value, "ACC").expr, _member(w, i, value, "PRE").expr, i.span)
    run.append(w.store(_member(w, i, value, "DN"), Value(done, BOOL, i.span), i.span))
    return _either(w, i, value, [reset], run)


def _one_shot(w: Writer, i: Instruction) -> list[ast.Item]:
    found = _structure(w, i, "FBD_ONESHOT")
    if found is None:
        return []
    given, before = (_member(w, i, found[0], name).expr for name in ("InputBit", "storage"))
    new, old = (given, before) if i.name == "OSRI" else (before, given)
    edge = ast.Binary("AND", new, ast.Unary("NOT", old, i.span), i.span)
    return [w.store(_member(w, i, found[0], "OutputBit"), Value(edge, BOOL, i.span), i.span),
            w.store(_member(w, i, found[0], "storage"), Value(given, BOOL, i.span), i.span)]


TABLE = {
    **dict.fromkeys(_TIMERS, (1, 1, _timer)), "CTUD": (1, 1, _counter),
    "OSRI": (1, 1, _one_shot), "OSFI": (1, 1, _one_shot),
}
