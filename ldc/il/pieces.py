"""The pieces of a POU: stretches of code between which nothing is kept but variables.

A piece is a rung, or several when one begins with what another left in the accumulator. Whoever executes
a PROGRAM piece by piece (tasks that pre-empt each other) or cuts it apart (C functions) does so there.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from itertools import accumulate

from ldc.il.flat import Flat
from ldc.il.program import Instr, Unit
from ldc.records import record

FORGETS = frozenset({"LD", "LDN", "LABEL", "CAL", "JMP", "RET", "EXT"})
"""Instructions that neither use the accumulator nor keep it."""


def seams(flat: Flat) -> tuple[int, ...]:
    """The first positions of rungs that take over neither the accumulator nor open parentheses."""
    found, open_ = [], 0
    for at, instr in enumerate(flat.code):
        if not open_ and instr.op in FORGETS and at in flat.starts:
            found.append(at)
        open_ += (instr.op[-1] == "(") - (instr.op == ")")
    return tuple(found)


@record
class Pieces:
    """``begins``: the first position of each piece, ``rungs``: the number of its first rung."""

    begins: tuple[int, ...]
    rungs: tuple[int, ...]

    def number(self, at: int) -> int:
        """The piece that a position lies in."""
        return bisect_right(self.begins, at) - 1

    def entered(self, flat: Flat) -> frozenset[int]:
        """The positions that a jump from another piece leads to."""
        return frozenset(target for at, target in flat.targets.items()
                         if target < len(flat.code) and self.number(at) != self.number(target))


def pieces(flat: Flat) -> Pieces:
    """The pieces of a POU, in order."""
    begins = tuple(sorted({0, *seams(flat)})) if flat.code else ()
    return Pieces(begins, tuple(flat.places[at][0] for at in begins))


class Passes:
    """What further passes of the loops of a unit cost. ``one``: what an instruction costs, in ns."""

    def __init__(self, unit: Unit, flat: Flat, one: Callable[[Instr], int]) -> None:
        self._sums = list(accumulate(map(one, flat.code), initial=0))
        self._pieces = pieces(flat) if unit.kind == "PROGRAM" else None

    def cost(self, at: int, target: int) -> int:
        """Of the pass that a jump back from ``at`` begins. In a PROGRAM a jump to another piece begins that
        one, which costs what it costs each time."""
        if self._pieces is not None and self._pieces.number(at) != self._pieces.number(target):
            return 0
        return self._sums[at + 1] - self._sums[target]
