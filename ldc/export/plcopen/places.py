"""Where the elements of a rung lie, in the units of a TC6 drawing: columns and lines as in the pictures of
ldc, columns as wide as their texts."""

from __future__ import annotations

from collections.abc import Callable

from ldc.draw.arrange import Arrangement, arrange
from ldc.draw.figures import Figure
from ldc.draw.labels import BlockPins, Options, text_width
from ldc.draw.sketch import RAIL, RIGHT
from ldc.parser import ast
from ldc.parser.unparse import expr_text
from ldc.records import record

LINE, CHARACTER, GAP = 24, 8, 20
SYMBOL, HALF = 21, 7
"""Width of a contact or coil, and how far its wires are below its upper edge (it is 15 high)."""
TITLE = 30
"""From the upper edge of a block to its first pin."""
RAIL_WIDTH = 10


@record
class Box:
    """An element: left and upper edge, size, where its power wires lie, and the columns of its nets.
    ``rows``: how far below the power wire each row of pins is. ``local``: it begins at a rail of its own."""

    x: int
    y: int
    width: int
    height: int
    wire: int
    head_x: int
    tail_x: int
    rows: tuple[int, ...] = ()
    local: bool = False

    @property
    def right(self) -> int:
        return self.x + self.width


@record
class Places:
    """Boxes by ``id`` of the node; ``width`` up to the right rail; ``height``: what the rung takes."""

    boxes: dict[int, Box]
    width: int
    height: int


def places(rung: ast.Rung, pins_of: Callable[[ast.Block], BlockPins | None]) -> Places:
    """The places of all elements of a rung whose upper edge is at 0."""
    found = arrange(rung, Options(pins_of=pins_of))
    needs = [SYMBOL + GAP] * found.columns
    for figure in found.figures:
        needs[figure.column] = max(needs[figure.column], sum(_widths(figure)))
    at = [RAIL_WIDTH + GAP]
    for need in needs:
        at.append(at[-1] + need + GAP)
    drawn = (figure for figure in found.figures if not isinstance(figure.node, ast.Junction))
    boxes = {id(figure.node): _box(figure, found, at, needs) for figure in drawn}
    return Places(boxes, at[-1], found.lines * LINE)


def _widths(figure: Figure) -> tuple[int, int, int]:
    """Room left of the figure, its own width, room right of it."""
    node = figure.node
    if isinstance(node, ast.Block):
        return _beside(node, False), max(figure.box * CHARACTER, 60), _beside(node, True)
    if isinstance(node, ast.Jump):
        return 0, text_width(node.target) * CHARACTER + GAP, 0
    if isinstance(node, ast.Contact | ast.Coil):
        text = text_width(expr_text(node.expr if isinstance(node, ast.Contact) else node.target)) * CHARACTER
        side = max(0, text - SYMBOL) // 2 + CHARACTER
        return side, SYMBOL, side
    return 0, 0, 0


def _beside(block: ast.Block, output: bool) -> int:
    """Room for the values at the pins of a side."""
    texts = [pin.value for pin in block.pins if pin.output is output
             and not isinstance(pin.value, ast.Branches | ast.Junction)]
    return max((value_width(expr_text(text)) + GAP for text in texts), default=0)


def value_width(text: str) -> int:
    return max(text_width(text) * CHARACTER + 10, 30)


def _box(figure: Figure, found: Arrangement, at: list[int], needs: list[int]) -> Box:
    before, width, behind = _widths(figure)
    spare = needs[figure.column] - before - width - behind
    x = at[figure.column] + before + (spare if isinstance(figure.node, ast.Jump) else spare // 2)
    wire = figure.y * LINE
    nets = tuple(RAIL_WIDTH if net == RAIL else at[-1] if net == RIGHT else at[found.rank[net]] - GAP // 2
                 for net in (figure.head, figure.tail))
    rows = tuple(row.offset * LINE for row in figure.rows)
    if rows:
        return Box(x, wire - TITLE, width, TITLE + rows[-1] + LINE // 2, wire, *nets, rows,
                   figure.head in found.starts)
    return Box(x, wire - HALF, width, 2 * HALF + 1, wire, *nets, (), figure.head in found.starts)
