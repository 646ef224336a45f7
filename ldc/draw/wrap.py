"""A drawing wider than the page becomes bands under each other, joined by numbered arrows."""

from __future__ import annotations

from bisect import bisect_right
from itertools import accumulate

from ldc.draw.arrange import Arrangement
from ldc.draw.labels import Options
from ldc.draw.layout import place
from ldc.draw.shapes import Arrow, Drawing, Rail, Shape, Wire, extent
from ldc.records import replace

MARGIN = 5
"""Columns of a continuation: a piece of wire, the arrow head and up to three digits."""


def bands(found: Arrangement, options: Options, fill: int = 0) -> list[Drawing]:
    """The drawing in pieces of at most ``options.width`` columns. Its last piece takes ``fill`` columns
    or more, and as many as the others, so that coils stand under each other."""
    whole = place(found, options)
    cuts = _cuts(whole, options.width)
    pieces = _split(whole, cuts)
    missing = max(fill, *(piece.width for piece in pieces)) - pieces[-1].width
    if missing > 0 and (not cuts or cuts[-1] <= whole.zone + 1):
        return _split(place(found, options, whole.width + missing), cuts)
    return pieces


def _cuts(whole: Drawing, width: int) -> list[int]:
    """Columns to cut at: each band as full as it goes with as few wires cut as possible."""
    cuts: list[int] = []
    if whole.width <= width:
        return cuts
    crossing = _crossing(whole)
    start, prefix = 0, 0
    while whole.width - start + prefix > width:
        end = start + width - prefix - MARGIN
        first = bisect_right(whole.cuts, start)
        usual = whole.cuts[first : bisect_right(whole.cuts, end)] or whole.cuts[first : first + 1]
        if not usual:
            break
        full = [cut for cut in usual if cut - start >= 0.6 * (usual[-1] - start)]
        start = min(full, key=lambda cut: (crossing[cut], -cut))
        cuts.append(start)
        prefix = MARGIN
    return cuts


def _crossing(whole: Drawing) -> list[int]:
    """How many wires run from column ``c - 1`` to ``c``, for each c."""
    change = [0] * (whole.width + 2)
    for shape in whole.shapes:
        if isinstance(shape, Wire):
            change[shape.x1 + 1] += 1
            change[shape.x2 + 1] -= 1
    return list(accumulate(change))


def _split(whole: Drawing, cuts: list[int]) -> list[Drawing]:
    edges = [0, *cuts, whole.width]
    parts: list[list[Shape]] = [[] for _ in edges[1:]]
    crossings: list[list[Wire]] = [[] for _ in cuts]
    for shape in whole.shapes:
        if not isinstance(shape, Wire):
            parts[bisect_right(cuts, shape.x)].append(shape)
            continue
        band, last = bisect_right(cuts, shape.x1), bisect_right(cuts, shape.x2)
        for at in range(band, last):
            crossings[at].append(shape)
        for at in range(band, last + 1):
            left, right = max(shape.x1, edges[at]), min(shape.x2, edges[at + 1] - 1)
            parts[at].append(replace(shape, x1=left, x2=right))
    number, prefix, drawings = 0, 0, []
    numbers: list[tuple[Wire, int]] = []
    for band, part in enumerate(parts):
        start, end = edges[band], edges[band + 1]
        shapes = [_moved(shape, prefix - start) for shape in part]
        for wire, own in numbers:
            y = wire.y1
            shapes += [Wire(prefix - 1, y, prefix, y, wire.on), Arrow(prefix - 2, y, own, False, wire.on)]
        width = prefix + end - start
        numbers = []
        if band < len(cuts):
            for wire in sorted(crossings[band], key=lambda w: w.y1):
                number += 1
                numbers.append((wire, number))
                y = wire.y1
                shapes += [Wire(width - 1, y, width, y, wire.on), Arrow(width + 1, y, number, True, wire.on)]
            width += 2 + len(str(number))
        drawings.append(Drawing(width, whole.height, tuple(shapes)))
        prefix = 2 + len(str(number))
    return [_trimmed(drawing) for drawing in drawings]


def _moved(shape: Shape, dx: int) -> Shape:
    if isinstance(shape, Wire):
        return replace(shape, x1=shape.x1 + dx, x2=shape.x2 + dx)
    return replace(shape, x=shape.x + dx)


def _trimmed(drawing: Drawing) -> Drawing:
    """Without the lines at its top and bottom in which nothing but a rail is."""
    extents = [extent(shape) for shape in drawing.shapes if not isinstance(shape, Rail) or shape.local]
    if not extents:
        return drawing
    top, bottom = min(a for a, _ in extents), max(b for _, b in extents)
    shapes: list[Shape] = []
    for shape in drawing.shapes:
        if isinstance(shape, Rail):
            shapes.append(replace(shape, y1=max(shape.y1, top) - top, y2=min(shape.y2, bottom) - top))
        elif isinstance(shape, Wire):
            shapes.append(replace(shape, y1=shape.y1 - top, y2=shape.y2 - top))
        else:
            shapes.append(replace(shape, y=shape.y - top))
    return Drawing(drawing.width, bottom - top + 1, tuple(shapes))
