"""Whether a tree executes the elements in an order equivalent to the schedule (DESIGN section 3 rule 7).

Plain contacts (open, closed, expression) only read, so they may move among themselves; nothing moves
past a coil, a block, an edge contact or a jump, and these keep their order.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Sequence

from ldc.graph.order import Turn
from ldc.graph.rung import RungGraph
from ldc.graph.plan import Plan
from ldc.graph.tree import Leaf, Step
from ldc.graph.walk import LEAF, TAP, operations
from ldc.model.elements import Block, Contact, Net


def executed(graph: RungGraph, plan: Plan, steps: Iterable[Step]) -> tuple[list[int], list[int]]:
    """The elements in the order in which the steps execute them; and the blocks that come only after a
    tap of what they give to a net."""
    order: list[int] = []
    givers = _givers(graph, plan) if plan.pin_fed else {}
    done: set[int] = set()
    late: dict[int, None] = {}
    for step in steps:
        tree = step.tree
        if type(tree) is Leaf and not tree.pins:
            order.append(tree.index)
            done.add(tree.index)
            continue
        for op, what in operations(tree):
            if op == LEAF:
                order.append(what.index)
                done.add(what.index)
            elif op == TAP and what.net in givers and not what.previous:
                late.update(dict.fromkeys(giver for giver in givers[what.net] if giver not in done))
    return order, list(late)


def _givers(graph: RungGraph, plan: Plan) -> dict[Net, list[int]]:
    """The blocks whose output pins are kept under a net."""
    kept = {(index, pin): net for index, pin, net in plan.outputs}
    givers: dict[Net, list[int]] = {}
    for index, element in enumerate(graph.elements):
        for pin in element.outputs if type(element) is Block else ():
            if isinstance(pin.target, int):
                givers.setdefault(kept.get((index, pin.pin), pin.target), []).append(index)
    return givers


def misplaced(graph: RungGraph, turns: Sequence[Turn], order: Sequence[int]) -> list[int]:
    """The fewest elements of ``order`` without which the rest is in an order equivalent to ``turns``."""
    if list(order) == [turn.element for turn in turns]:
        return []
    slots = _slots(graph, turns)
    places = [slots[index] for index in order]
    if all(a <= b for a, b in zip(places, places[1:])):
        return []
    stays = _longest_rise(places)
    return [index for n, index in enumerate(order) if n not in stays]


def _slots(graph: RungGraph, turns: Sequence[Turn]) -> list[int]:
    """Per element: plain contacts between two others share an even slot, each other has an odd one."""
    slots = [0] * len(graph.elements)
    slot = 0
    for turn in turns:
        element = graph.elements[turn.element]
        if type(element) is Contact and element.kind not in ("rising", "falling"):
            slots[turn.element] = slot
        else:
            slots[turn.element] = slot + 1
            slot += 2
    return slots


def _longest_rise(places: Sequence[int]) -> set[int]:
    """Indexes of a longest non-decreasing subsequence. O(n log n)."""
    ends: list[int] = []
    end_at: list[int] = []
    before: list[int] = []
    for n, place in enumerate(places):
        at = bisect_right(ends, place)
        before.append(end_at[at - 1] if at else -1)
        if at == len(ends):
            ends.append(place)
            end_at.append(n)
        else:
            ends[at], end_at[at] = place, n
    found, n = set(), end_at[-1]
    while n >= 0:
        found.add(n)
        n = before[n]
    return found
