"""The current result where ways meet in IL text: a label does not change it (2nd edition, 3.2.1).

Typed IL has nothing in the accumulator behind a label. So each way to a label behind which it is worked on
stores it in a temporary, from which it is loaded behind the label.
"""

from __future__ import annotations

from collections.abc import Iterable

from ldc.expr import Place
from ldc.il.machine import Machine, works_on_result
from ldc.il.scan import Line

_ENDS = ("JMP", "RET")


def wanting(lines: Iterable[Line]) -> set[str]:
    """The labels, in capitals, whose next instruction works on the current result."""
    found: set[str] = set()
    waiting: list[str] = []
    for line in lines:
        if line.label:
            waiting.append(line.label.upper())
        if line.op:
            if works_on_result(line):
                found.update(waiting)
            waiting.clear()
    return found


class Carried:
    """``wanting``: the labels with a way to come that may bring a value; ``places``: where it is kept."""

    def __init__(self, wanting: set[str]) -> None:
        self.wanting = wanting
        self.places: dict[str, Place] = {}

    def leave(self, machine: Machine, label: str, op: str, known: bool) -> None:
        """A way to the label, by ``op``. Without a value there is none behind the label either; where the
        label is ``known`` already, and had one, this is told."""
        key = label.upper()
        if key not in self.wanting:
            return
        if not machine.acc.defined and not known:
            self.wanting.discard(key)
            return
        if not machine.use(op):
            return
        if key not in self.places:
            self.places[key] = machine.temp(machine.acc.type or machine.acc.natural())
        machine.store("ST", self.places[key])

    def arrive(self, machine: Machine, label: str) -> Place | None:
        """What is loaded behind the label; None when a way brings nothing, or none came yet."""
        key = label.upper()
        if not machine.code or machine.code[-1].op not in _ENDS:
            self.leave(machine, label, "LABEL", False)
        if key not in self.places:
            self.wanting.discard(key)
        return self.places.get(key) if key in self.wanting else None
