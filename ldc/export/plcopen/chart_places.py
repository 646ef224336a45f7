"""Where the parts of a chart lie, in the units of a TC6 drawing.

Every part has an axis, on which its wires lie. The first child hangs on the axis of its parent, the others
to its right, as near as what lies on their levels lets them. Levels lie below each other with room for the
bars of divergences and convergences between them, so that no bar is on another one or on a part.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from ldc.export.plcopen.chart_plan import STEP, WIRE, Part, Plan
from ldc.export.plcopen.places import GAP
from ldc.records import record

_WIRE = 10
"""Room on both sides of a wire."""


@record
class Extent:
    """How much room a part takes left and right of its axis, and its height."""

    left: int
    right: int
    height: int


@record
class ChartPlaces:
    """By ``id`` of the part: ``axis``; ``below`` and ``above``, where the bar of the divergence below it and
    of the convergence above it lies. ``levels``: the upper edges of levels."""

    axis: dict[int, int]
    levels: list[int]
    below: dict[int, int]
    above: dict[int, int]


Bars = dict[int, tuple[int, int]]
"""From where to where bars reach, by ``id`` of their part."""


def chart_places(plan: Plan, extent: Callable[[Part], Extent]) -> ChartPlaces:
    """The places of all parts. ``extent`` is asked for all parts but wires."""
    parts = list(_all(plan.roots))
    extents = {id(part): extent(part) for part in parts if part.kind != WIRE}
    axis = _axes(plan, extents)
    level = {id(part): part.level for part in parts}
    heights = [0] * (max(level.values(), default=-1) + 1)
    for key, found in extents.items():
        heights[level[key]] = max(heights[level[key]], found.height)
    under, over = (_lanes(bars, level) for bars in _bars(plan, axis))
    lanes_under, lanes_over = (_count(lanes, level, len(heights)) for lanes in (under, over))
    y, tops, levels, ends = GAP, [], [], []
    for height, above, below in zip(heights, lanes_over, lanes_under, strict=True):
        tops.append(y)
        levels.append(y + above * GAP)
        ends.append(levels[-1] + height + GAP)
        y = ends[-1] + below * GAP
    return ChartPlaces(axis, levels, {key: ends[level[key]] + lane * GAP for key, lane in under.items()},
                       {key: tops[level[key]] + lane * GAP for key, lane in over.items()})


def _all(roots: Iterable[Part]) -> Iterator[Part]:
    """Parts before their children, from left to right."""
    work = list(roots)[::-1]
    while work:
        part = work.pop()
        yield part
        work += reversed(part.children)


# ---- from left to right


@dataclass(slots=True)
class _Outline:
    """A part with all that hangs below it: the most that is left of its axis, and what is right of it by
    level. ``shifts``: how far right of it the axes of its children are."""

    left: int
    right: dict[int, int]
    shifts: tuple[int, ...] = ()


def _axes(plan: Plan, extents: dict[int, Extent]) -> dict[int, int]:
    whole = Part(STEP, -1, -1, list(plan.roots))
    extents = {**extents, id(whole): Extent(0, 0, 0)}
    ends = {id(wire): (plan.steps if kind == STEP else plan.transitions)[index].level
            for (kind, index), wires in plan.joined.items() for wire in wires}
    outlines: dict[int, _Outline] = {}
    for part in reversed(list(_all([whole]))):
        if part.kind == WIRE:
            passed = range(part.level, ends[id(part)])
            outlines[id(part)] = _Outline(_WIRE, dict.fromkeys(passed, _WIRE))
        else:
            outlines[id(part)] = _outline(part, extents[id(part)], outlines)
    axis = {id(whole): outlines[id(whole)].left + GAP}
    for part in _all([whole]):
        for child, shift in zip(part.children, outlines[id(part)].shifts, strict=True):
            axis[id(child)] = axis[id(part)] + shift
    return axis


def _outline(part: Part, own: Extent, outlines: dict[int, _Outline]) -> _Outline:
    """Takes over the outline of the first child, so that a level is looked at again only where something
    stands beside it."""
    left, right, shifts = own.left, {}, []
    for child in part.children:
        outline = outlines[id(child)]
        passed = dict.fromkeys(range(part.level + 1, child.level), _WIRE)  # by the wire to a deeper child
        if not shifts:
            left, right = max(left, outline.left), outline.right
            right |= passed
            shifts.append(0)
            continue
        rooms = outline.right | passed
        beside = (right[level] for level in rooms if level in right)
        shift = max(shifts[-1] + _WIRE, max(beside, default=0)) + outline.left + GAP
        right |= {level: shift + room for level, room in rooms.items()}
        shifts.append(shift)
    right[part.level] = own.right
    return _Outline(left, right, tuple(shifts))


# ---- from top to bottom


def _bars(plan: Plan, axis: dict[int, int]) -> tuple[Bars, Bars]:
    """The bars below and above parts."""
    below = {id(part): (axis[id(part)], axis[id(part.children[-1])])
             for part in _all(plan.roots) if len(part.children) > 1}
    above = {}
    for (kind, index), wires in plan.joined.items():
        part = (plan.steps if kind == STEP else plan.transitions)[index]
        places = [axis[id(part)], *(axis[id(wire)] for wire in wires)]
        above[id(part)] = (min(places), max(places))
    return below, above


def _lanes(bars: Bars, level: dict[int, int]) -> dict[int, int]:
    """A lane for each bar, so that bars of one level that share one do not meet."""
    made: dict[int, int] = {}
    ends: dict[int, list[tuple[int, int]]] = {}
    for key, (left, right) in sorted(bars.items(), key=lambda bar: bar[1]):
        lanes = ends.setdefault(level[key], [])
        lane = heapq.heappop(lanes)[1] if lanes and lanes[0][0] < left else len(lanes)
        heapq.heappush(lanes, (right, lane))
        made[key] = lane
    return made


def _count(lanes: dict[int, int], level: dict[int, int], levels: int) -> list[int]:
    """How many lanes each level has."""
    counts = [0] * levels
    for key, lane in lanes.items():
        counts[level[key]] = max(counts[level[key]], lane + 1)
    return counts
