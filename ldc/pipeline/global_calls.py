"""Function blocks that are called through global variables: the declarations of the caller do not tell them.

A POU that only reads the outputs of a global instance does not call it, so its instructions are looked at.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.il.program import Unit
from ldc.model.order import ordered
from ldc.model.project import Model
from ldc.source import Span
from ldc.types import Instance, holds_blocks


def callees_first(units: list[Unit], model: Model, diagnostics: Diagnostics) -> list[Unit]:
    """The units, each behind those that it calls; a circle of calls is an error."""
    if not any(holds_blocks(variable.type) for variable in model.globals.values()):
        return units
    calls = {name: {} for name in model.pous} | {unit.name.upper(): _called(unit, model) for unit in units}
    if not any(calls.values()):
        return units
    place = {name: n for n, name in enumerate(ordered(model.pous, calls, diagnostics))}
    return sorted(units, key=lambda unit: place[unit.name.upper()])


def _called(unit: Unit, model: Model) -> dict[str, Span | None]:
    """The POUs of the project whose global instances a unit calls."""
    found: dict[str, Span | None] = {}
    for rung in unit.rungs:
        for instr in rung.code:
            if instr.op == "CAL" and instr.operand.is_global and isinstance(instr.operand.type, Instance):
                name = instr.operand.type.pou.upper()
                if name in model.pous:
                    found.setdefault(name, instr.span)
    return found
