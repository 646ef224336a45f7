"""The part of a rung that shows one of its elements: for a message, not for a wall."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice

from ldc.draw.arrange import arrange
from ldc.draw.figures import drawn
from ldc.draw.labels import BlockPins, Options
from ldc.draw.unicode import Canvas
from ldc.draw.wrap import bands
from ldc.parser import ast
from ldc.records import replace

MOST_ELEMENTS = 60
"""Of a rung that is drawn as a whole."""
BEFORE, BEHIND = 4, 2
"""Elements around the marked one when the rung has more."""
MOST_LINES = 16
CUT = "…"


def excerpt(
    rung: ast.Rung, item: ast.Item, style: str, width: int, colour: bool,
    pins_of: Callable[[ast.Block], BlockPins | None],
) -> list[str]:
    """Lines of at most ``width`` columns that show the rung with ``item`` marked (carets, and ``style``
    when there is colour); of a large rung the elements around it, of a high one the lines around it."""
    part, whole = _part(rung, item)
    options = Options(max(width, 60), pins_of, mark={item.span: style}, carets=True)
    lines: list[str] = []
    marked: list[int] = []
    for number, band in enumerate(bands(arrange(part, options), options)):
        if number:
            lines.append("")
        canvas = Canvas(band.width, band.height)
        for shape in band.shapes:
            canvas.draw(shape)
        marked += [len(lines) + y for (_, y), given in canvas.styles.items() if given == style]
        lines += canvas.rows(colour)
    first = min(max(0, max(marked, default=0) + 3 - MOST_LINES), min(marked, default=0))
    last = min(first + MOST_LINES, len(lines))
    shown = lines[first:last]
    if first or not whole:
        shown.insert(0, CUT)
    if last < len(lines) or not whole:
        shown.append(CUT)
    return shown


def _part(rung: ast.Rung, item: ast.Item) -> tuple[ast.Rung, bool]:
    """The rung, or of a large one the path that the element is on, near it; and whether that is all."""
    if _few(rung):
        return rung, True
    for path, at in _trail(rung, item):
        near = replace(path, items=path.items[max(0, at - BEFORE) : at + BEHIND + 1])
        part = replace(rung, paths=(near,))
        if _few(part):
            return part, False
    if isinstance(item, ast.Block):
        item = replace(item, pins=tuple(p for p in item.pins if not isinstance(p.value, ast.Branches)))
    return replace(rung, paths=(ast.Path((item,), item.span),)), False


def _few(rung: ast.Rung) -> bool:
    elements = (item for item in drawn(rung) if not isinstance(item, ast.Junction))
    return sum(1 for _ in islice(elements, MOST_ELEMENTS + 1)) <= MOST_ELEMENTS


def _trail(rung: ast.Rung, item: ast.Item) -> list[tuple[ast.Path, int]]:
    """The paths that lead to an element, the outermost first, each with the position to go on at."""
    work: list[tuple[ast.Path, list | None]] = [(path, None) for path in rung.paths]
    while work:
        path, outer = work.pop()
        for at, found in enumerate(path.items):
            here = [path, at, outer]
            if found is item:
                trail = []
                while here is not None:
                    trail.insert(0, (here[0], here[1]))
                    here = here[2]
                return trail
            if isinstance(found, ast.Branches):
                work += [(inner, here) for inner in found.paths]
            elif isinstance(found, ast.Block):
                work += [(ast.Path((pin.value,), pin.span), here) for pin in found.pins
                         if isinstance(pin.value, ast.Branches | ast.Junction)]
    return []
