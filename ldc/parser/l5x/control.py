"""The order of rungs: labels and jumps, subroutines, ends, master control zones."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser.l5x import types
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.types import BOOL

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer


def _jump(w: Writer, i: Instruction) -> list[ast.Item]:
    label = i.operands[0].text
    target = w.labels.get(label.upper())
    if target is None:
        w.reading.malformed(i.operands[0], f"there is no LBL({label[:40]}) in this routine",
                            help="add the label, or jump to another one")
        return []
    return [ast.Jump(target, i.span)]


def _label(w: Writer, i: Instruction) -> list[ast.Item]:
    """The name of the rung; the writer of the routine has seen it."""
    return []


def _end(w: Writer, i: Instruction) -> list[ast.Item]:
    return [ast.Jump(w.leave, i.span)]


def _zone(w: Writer, i: Instruction) -> list[ast.Item]:
    """The first opens a zone: its rungs have the power that this rung has; the next one closes it."""
    if w.zone is not None:
        w.zone = None
        return []
    w.zone = w.local("mcr", types.written(BOOL, i.span), i.span)
    return [ast.Coil("", ast.Name(w.zone, i.span), i.span)]


def _call(w: Writer, i: Instruction) -> list[ast.Item]:
    if w.routines is None:
        w.reading.unsupported(i.span, "JSR in an Add-On Instruction", "call another Add-On Instruction")
        return []
    return w.routines.call(w, i)


def _break(w: Writer, i: Instruction) -> list[ast.Item]:
    """BRK: the FOR that called this routine ends, and the routine."""
    if w.routines is None:
        w.reading.unsupported(i.span, "BRK in an Add-On Instruction", "write the loop in Structured Text")
        return []
    return [ast.Coil("S", w.routines.broken(w, i.span), i.span), ast.Jump(w.leave, i.span)]


def _parameters(w: Writer, i: Instruction) -> list[ast.Item]:
    """SBR: the caller has put its values into these tags."""
    return []


def _return(w: Writer, i: Instruction) -> list[ast.Item]:
    if w.routines is None:
        return [ast.Jump(w.leave, i.span)]
    return w.routines.leave(w, i)


TABLE = {
    "JMP": (1, 1, _jump), "LBL": (1, 1, _label), "TND": (0, 0, _end), "MCR": (0, 0, _zone),
    "JSR": (1, None, _call), "SBR": (0, None, _parameters), "RET": (0, None, _return),
    "BRK": (0, 0, _break),
}
