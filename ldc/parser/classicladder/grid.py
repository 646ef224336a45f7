"""A rung of ClassicLadder: 10 columns and 6 rows of cells ``type-top-variable/offset``.

``top`` joins the left side of a cell with that of the cell above. Power goes from column to column; the left
of the first column is the rail.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from ldc.parser.classicladder.container import Part
from ldc.parser.foreign import Reading
from ldc.records import record
from ldc.source import Span

MAX_SIDE = 32
_CELL = re.compile(r"\s*(\d{1,4})-(\d)-(\d{1,4})/(-?\d{1,6})\s*", re.ASCII)
FREE, OPEN, CLOSED, RISING, FALLING, WIRE = 0, 1, 2, 3, 4, 9
TIMER, MONOSTABLE, COUNTER, TIMER_IEC, COMPARE = 10, 11, 12, 13, 20
COIL, COIL_NOT, SET, RESET, JUMP, CALL, OPERATE, COVERED = 50, 51, 52, 53, 54, 55, 60, 99
EDITING = 100
"""Cell types from here on are left behind by the editor and mean nothing."""
WIDTHS = {TIMER: 2, MONOSTABLE: 2, COUNTER: 2, TIMER_IEC: 2, COMPARE: 3, OPERATE: 3}
"""Cells from the left end of an element to the one that it is written in; others have one."""


@record
class Cell:
    type: int
    top: bool
    variable: int
    offset: int
    span: Span


@dataclass(slots=True)
class Rung:
    """``cells`` by (column, row)."""

    number: int
    label: str
    comment: str
    following: int
    span: Span
    cells: dict[tuple[int, int], Cell] = field(default_factory=dict)
    width: int = 0
    height: int = 0


def rung(reading: Reading, number: int, part: Part) -> Rung:
    """The rung in a file ``rung_N.csv``; rows that are broken are told and left out."""
    found = Rung(number, part.setting("LABEL").strip(), part.setting("COMMENT").strip(),
                 part.integer("NEXTRUNG", -1), part.span)
    if part.integer("VER", 0) > 3 or part.setting("VER").strip()[:1] not in ("", "1", "2", "3"):
        reading.unsupported(part.settings["VER"].span, f"version {part.setting('VER')[:10]} of rungs",
                            "save it with a version that writes rungs of version 2 or 3")
    for row, line in enumerate(part.written):
        at = 0
        for column in range(MAX_SIDE + 1):
            match = _CELL.match(line.text, at)
            if match is None or column == MAX_SIDE or row == MAX_SIDE:
                reading.malformed(line.span, f"rung {number}: row {row + 1} is no row of cells")
                break
            start = line.span.start
            span = Span(line.span.source, start + match.start(1), start + match.end(4))
            kind, top, variable, offset = (int(group) for group in match.groups())
            found.cells[column, row] = Cell(kind, top != 0, variable, offset, span)
            found.width, found.height = max(found.width, column + 1), row + 1
            at = match.end() + 1
            if line.text[match.end() : at] != ",":
                break
    return found


class Nets:
    """The nets of a rung: net (column, row) is the power at the left side of a cell, named by its top row."""

    def __init__(self, drawn: Rung) -> None:
        self.top: dict[tuple[int, int], tuple[int, int]] = {}
        for column in range(drawn.width + 1):
            for row in range(drawn.height):
                cell = drawn.cells.get((column, row))
                linked = cell is not None and cell.top and row
                self.top[column, row] = self.top[column, row - 1] if linked else (column, row)

    def at(self, column: int, row: int) -> tuple[int, int] | None:
        """The net at the left of a cell; None is the rail."""
        if column <= 0:
            return None
        return self.top.get((column, row), (column, row))
