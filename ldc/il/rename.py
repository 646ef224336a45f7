"""Places of IL with other names for their variables."""

from __future__ import annotations

from collections.abc import Callable

from ldc.expr import Const, IndexStep, Load, Place
from ldc.il.program import Instr
from ldc.records import replace

NameOf = Callable[[Place], str]
"""The name that the root of a place gets."""


def renamed(instr: Instr, name_of: NameOf) -> Instr:
    """The instruction with the names; those in indexes too."""
    def own(operand: Const | Place | None) -> Const | Place | None:
        return _place(operand, name_of) if isinstance(operand, Place) else operand

    return replace(instr, operand=own(instr.operand), args=tuple(map(own, instr.args)),
                   outputs=tuple((pin, own(place)) for pin, place in instr.outputs))


def _place(place: Place, name_of: NameOf) -> Place:
    steps = tuple(_step(s, name_of) if isinstance(s, IndexStep) else s for s in place.steps)
    return replace(place, root=name_of(place), steps=steps)


def _step(step: IndexStep, name_of: NameOf) -> IndexStep:
    indexes = (Load(_place(i.place, name_of)) if isinstance(i, Load) else i for i in step.indexes)
    return IndexStep(tuple(indexes), step.bounds)
