"""What a drawing is made of: shapes in character cells, which text and SVG both render.

``x`` counts columns and ``y`` lines, from 0; lines run through the middle of a cell.
"""

from __future__ import annotations

from math import ceil, floor

from ldc.records import record


@record
class Wire:
    """From cell to cell, both included; ``x1 <= x2`` and ``y1 <= y2``. ``on``: powered, if known."""

    x1: int
    y1: int
    x2: int
    y2: int
    on: bool | None = None


@record
class Rail:
    """A power rail; ``local`` for the rail of a pin's network."""

    x: int
    y1: int
    y2: int
    local: bool = False


@record
class Symbol:
    """A contact or a coil, three cells wide around ``x``; ``modifier`` as in the text."""

    kind: str
    modifier: str
    x: int
    y: int
    on: bool | None = None
    mark: str | None = None
    full: str = ""


@record
class Box:
    """The frame of a block or of an expression; the border runs through the outer cells."""

    kind: str
    x: int
    y: int
    width: int
    height: int
    on: bool | None = None
    mark: str | None = None
    full: str = ""


@record
class Label:
    """``text`` at cell ``x``: its first cell (``start``), its ``middle`` (which may lie
    between two cells) or its last (``end``).

    ``role``: operand, name, type, pin, value, expression, note, tag, jump, caret. ``full`` is the
    whole text when ``text`` was cut.
    """

    text: str
    x: float
    y: int
    anchor: str
    role: str
    full: str = ""
    mark: str | None = None
    on: bool | None = None

    def begin(self, size: int) -> int:
        """The first cell of a text of ``size`` columns; a middle between cells goes to the left."""
        if self.anchor == "middle":
            at = self.x - (size - 1) / 2
            return ceil(at) if self.x == int(self.x) else floor(at)
        return int(self.x) if self.anchor == "start" else int(self.x) - size + 1


@record
class Dot:
    """Wires that meet here are one net."""

    x: int
    y: int
    on: bool | None = None


@record
class Arrow:
    """The wire goes on at the arrow of the same number: ``out`` at the end of a band, else the start
    of one. ``x`` is the cell of the arrow head, the number stands outside."""

    x: int
    y: int
    number: int
    out: bool
    on: bool | None = None


Shape = Wire | Rail | Symbol | Box | Label | Dot | Arrow


@record
class Drawing:
    """Shapes in ``width`` columns and ``height`` lines. ``cuts``: columns (the first of the right part)
    where it may be cut. ``zone``: the column behind which only the coils at the right stand."""

    width: int
    height: int
    shapes: tuple[Shape, ...]
    cuts: tuple[int, ...] = ()
    zone: int = 0


def extent(shape: Shape) -> tuple[int, int]:
    """The first and the last line of a shape."""
    match shape:
        case Wire() | Rail():
            return shape.y1, shape.y2
        case Box():
            return shape.y, shape.y + shape.height - 1
    return shape.y, shape.y
