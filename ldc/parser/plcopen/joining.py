"""Edges between nets joined in series and side by side: the structure of the text of a rung.

It is a matter of the nets alone, so elements are numbers here: what is found for one rung holds for all
rungs of its shape. What a rung does depends on the order of the text, so edges are joined only where the
order stays: contacts may change places with contacts, with nothing else.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from collections import Counter, deque
from collections.abc import Sequence
from typing import NamedTuple

from ldc.records import entity

NOTHING, RAIL = -1, 0
"""No net; the left rail. Others are numbered from 1."""
MAX_DEPTH = 16
"""Braces within braces; what is deeper reads better with junctions."""


class Bare(NamedTuple):
    """An element without what it says: whether it is a contact with a plain operand, the nets before and
    behind it, those that its pins read and write, and those of its pins in the order of the text."""

    contact: bool
    head: int
    tail: int
    reads: tuple[int, ...] = ()
    writes: tuple[int, ...] = ()
    pins: tuple[int, ...] = ()


@entity
class Edge:
    """``items`` in series; a list of edges is one of branches. ``first``: number of its first step.

    An element that is no contact has a turn of its own, contacts between two such elements have one turn
    together. ``low`` and ``high``: first and last turn of ``size`` elements, of which ``at_low`` and
    ``at_high`` have just these. ``held``: a block that waits for networks to come to its pins.
    """

    items: deque[int | list[Edge]]
    head: int
    tail: int
    low: int
    high: int
    first: int
    size: int = 1
    at_low: int = 1
    at_high: int = 1
    depth: int = 0
    held: bool = False

    @property
    def place(self) -> tuple[int, int, int]:
        return self.high, self.low, self.first

    @property
    def branches(self) -> list[Edge] | None:
        """Its branches, when it is nothing else."""
        return self.items[0] if len(self.items) == 1 and isinstance(self.items[0], list) else None


def edges_of(steps: Sequence[Bare]) -> list[Edge]:
    """One for each step. A net that nothing reads is the open end of a wire."""
    read = {step.head for step in steps} | {net for step in steps for net in step.reads}
    edges, turn = [], 0
    for number, step in enumerate(steps):
        turn += turn % 2 if step.contact else 1 + turn % 2
        tail = step.tail if step.tail in read else NOTHING
        edges.append(Edge(deque((number,)), max(step.head, RAIL), tail, turn, turn, number))
    return edges


class Network:
    """Joins edges. ``inner`` and ``outer`` are those that end and begin at a net, ``beside`` those between
    two nets, in their order. ``reader``: the block (its number of step, by which it is in ``blocks``) that
    alone reads a net at a pin; ``waits``: how many such nets it has."""

    def __init__(self, edges: list[Edge], steps: Sequence[Bare], pins: Counter[int]) -> None:
        self.pins = pins
        self.turns = [edge.low for edge in edges]
        self.inner: dict[int, set[Edge]] = {}
        self.outer: dict[int, set[Edge]] = {}
        self.beside: dict[tuple[int, int], list[Edge]] = {}
        self.at_pins: dict[int, Edge] = {}
        self.nets: deque[int] = deque()
        self.added: deque[Edge] = deque()
        values = {net for step in steps for net in step.writes}
        self.reader = {net: number for number, step in enumerate(steps) for net in step.reads
                       if pins[net] == 1 and net not in values}
        self.waits = Counter(self.reader.values())
        self.blocks = {number: edges[number] for number in self.waits}
        for edge in self.blocks.values():
            edge.held = True
        for edge in edges:
            self._add(edge)

    def joined(self) -> list[Edge]:
        """What is left, in the order of the text."""
        self._reduce()
        self.reader.clear()
        for edge in self.blocks.values():
            if edge.held:
                edge.held = False
                self._try(edge)
        self._reduce()
        return sorted((edge for group in self.outer.values() for edge in group), key=lambda e: e.place)

    def _add(self, edge: Edge) -> None:
        self.inner.setdefault(edge.tail, set()).add(edge)
        self.outer.setdefault(edge.head, set()).add(edge)
        if edge.head != RAIL or edge.tail != NOTHING:  # paths from rail to rail stay paths
            group = self.beside.setdefault((edge.head, edge.tail), [])
            if group:
                insort(group, edge, key=lambda e: e.place)
            else:
                group.append(edge)
        self._try(edge)

    def _try(self, edge: Edge) -> None:
        """What can be joined with an edge: what is beside it, and what is before and behind it."""
        if len(self.beside.get((edge.head, edge.tail), ())) > 1:
            self.added.append(edge)
        self.nets += [net for net in (edge.head, edge.tail) if net > RAIL]  # nothing is joined at a rail

    def _take(self, *edges: Edge) -> None:
        for edge in edges:
            self.inner[edge.tail].discard(edge)
            self.outer[edge.head].discard(edge)
            group = self.beside.get((edge.head, edge.tail))
            if group is not None and (at := self._at(edge, group)) is not None:
                del group[at]

    @staticmethod
    def _at(edge: Edge, group: Sequence[Edge]) -> int | None:
        """Where an edge stands among those beside it; None when it stands nowhere (any more)."""
        if len(group) < 2:
            return 0 if group and group[0] is edge else None
        at = bisect_left(group, edge.place, key=lambda e: e.place)
        return at if at < len(group) and group[at] is edge else None

    def _reduce(self) -> None:
        while self.added or self.nets:
            if self.added:
                self._parallel(self.added.popleft())
            else:
                self._net(self.nets.popleft())

    def _fits(self, a: Edge, b: Edge) -> bool:
        """Whether they can stand together in this order: no turn of ``b`` is before one of ``a``, and no
        other element has a turn between."""
        if a.high > b.low or a.held or b.held:
            return False
        if a.low == b.high:
            return True
        own = a.size + b.size
        own -= a.at_low + b.at_low * (b.low == a.low) + b.at_high + a.at_high * (a.high == b.high)
        return bisect_left(self.turns, b.high) - bisect_right(self.turns, a.low) == own

    def _join(self, a: Edge, b: Edge, items: deque, head: int, tail: int, depth: int) -> Edge:
        at_low = a.at_low + b.at_low * (b.low == a.low)
        at_high = b.at_high + a.at_high * (a.high == b.high)
        first, size = min(a.first, b.first), a.size + b.size
        return Edge(items, head, tail, a.low, b.high, first, size, at_low, at_high, depth)

    def _net(self, net: int) -> None:
        """Join what meets at a net, if nothing else does."""
        inner = self.inner.get(net, ())
        if len(inner) != 1:
            return
        before, = inner
        outer = self.outer.get(net, ())
        if len(outer) == 1 and not self.pins[net]:
            after, = outer
            if before is not after and self._fits(before, after):
                self._series(before, after)
        elif not outer and net in self.reader and before.head == RAIL:
            self._to_pin(before, self.reader[net])

    def _series(self, a: Edge, b: Edge) -> None:
        self._take(a, b)
        items = a.items
        if len(a.items) >= len(b.items):
            items.extend(b.items)
        else:
            items = b.items
            items.extendleft(reversed(a.items))
        self._add(self._join(a, b, items, a.head, b.tail, max(a.depth, b.depth)))

    def _parallel(self, edge: Edge) -> None:
        """Join an edge with one of those beside it."""
        group = self.beside.get((edge.head, edge.tail), ())
        at = self._at(edge, group) if len(group) > 1 else None
        if at is None:
            return
        for a, b in zip(group[max(0, at - 1) : at + 1], group[max(1, at) : at + 2]):
            depth = max(e.depth + (e.branches is None) for e in (a, b))
            if depth <= MAX_DEPTH and self._fits(a, b):
                self._take(a, b)
                less, more = sorted((a.branches or [a], b.branches or [b]), key=len)
                more += less
                self._add(self._join(a, b, deque((more,)), a.head, a.tail, depth))
                return

    def _to_pin(self, network: Edge, number: int) -> None:
        """Put a network to the pin that alone reads it."""
        block = self.blocks[number]
        block.held = False
        if network.depth == MAX_DEPTH or not self._fits(network, block):
            block.held = True
            return
        self._take(network, block)
        self.at_pins[network.tail] = network
        joined = self._join(network, block, block.items, block.head, block.tail, network.depth + 1)
        self.blocks[number] = joined
        self.waits[number] -= 1
        joined.held = self.waits[number] > 0
        self._add(joined)


