"""The steps of a rung as paths: branches in braces where the drawing is series-parallel, junctions elsewhere.

Steps are edges between nets. Two edges in series or side by side become one until nothing more can be joined;
a network that feeds nothing but a pin goes to the pin. What a rung does depends on the order of the text, so
edges are joined only where the order stays: contacts may change places with contacts, with nothing else.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from collections import Counter, deque
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ldc.parser import ast

RAIL_NET = ""
MAX_DEPTH = 16
"""Braces within braces; what is deeper reads better with junctions."""

_OPERANDS = (ast.Name, ast.Direct, ast.Member, ast.Index, ast.Literal)


@dataclass(slots=True)
class Step:
    """An element between two nets (None: none; RAIL_NET: the left rail), and the nets at its pins."""

    order: tuple[int, ...]
    item: ast.Item
    head: str | None
    tail: str | None
    reads: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()


@dataclass(slots=True, eq=False)
class _Edge:
    """``items`` in series; a list of edges is one of branches. ``first``: number of its first step.

    An element that is no contact has a turn of its own, contacts between two such elements have one turn
    together. ``low`` and ``high``: first and last turn of ``size`` elements, of which ``at_low`` and
    ``at_high`` have just these. ``held``: a block that waits for networks to come to its pins.
    """

    items: deque[ast.Item | list[_Edge]]
    head: str
    tail: str | None
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
    def branches(self) -> list[_Edge] | None:
        """Its branches, when it is nothing else."""
        return self.items[0] if len(self.items) == 1 and isinstance(self.items[0], list) else None


def write(steps: Sequence[Step], ordered: bool) -> tuple[ast.Path, ...]:
    """The paths of a rung. ``ordered``: everything is fed before it is read, so that the order of the steps
    is that of their turns; a rung with a loop keeps all its nets and the order of its steps."""
    edges = _edges(steps)
    pins = Counter(net for step in steps for net in (*step.reads, *step.writes))
    if not ordered:
        return _Writer(edges, pins, {}).paths()
    network = _Network(edges, steps, pins)
    return _Writer(network.joined(), pins, network.at_pins).paths()


def _edges(steps: Sequence[Step]) -> list[_Edge]:
    """One for each step. A net that nothing reads is the open end of a wire."""
    read = {step.head for step in steps} | {net for step in steps for net in step.reads}
    edges, turn = [], 0
    for number, step in enumerate(steps):
        contact = isinstance(step.item, ast.Contact) and isinstance(step.item.expr, _OPERANDS)
        turn += turn % 2 if contact else 1 + turn % 2
        tail = step.tail if step.tail in read else None
        edges.append(_Edge(deque((step.item,)), step.head or RAIL_NET, tail, turn, turn, number))
    return edges


class _Network:
    """Joins edges. ``inner`` and ``outer`` are those that end and begin at a net, ``beside`` those between
    two nets, in their order. ``reader``: the block (its number of step, by which it is in ``blocks``) that
    alone reads a net at a pin; ``waits``: how many such nets it has."""

    def __init__(self, edges: list[_Edge], steps: Sequence[Step], pins: Counter[str]) -> None:
        self.pins = pins
        self.turns = [edge.low for edge in edges]
        self.inner: dict[str | None, set[_Edge]] = {}
        self.outer: dict[str, set[_Edge]] = {}
        self.beside: dict[tuple[str, str | None], list[_Edge]] = {}
        self.at_pins: dict[str, _Edge] = {}
        self.nets: deque[str] = deque()
        self.added: deque[_Edge] = deque()
        values = {net for step in steps for net in step.writes}
        self.reader = {net: number for number, step in enumerate(steps) for net in step.reads
                       if pins[net] == 1 and net not in values}
        self.waits = Counter(self.reader.values())
        self.blocks = {number: edges[number] for number in self.waits}
        for edge in self.blocks.values():
            edge.held = True
        for edge in edges:
            self._add(edge)

    def joined(self) -> list[_Edge]:
        """What is left, in the order of the text."""
        self._reduce()
        self.reader.clear()
        for edge in self.blocks.values():
            if edge.held:
                edge.held = False
                self._try(edge)
        self._reduce()
        return sorted((edge for group in self.outer.values() for edge in group), key=lambda e: e.place)

    def _add(self, edge: _Edge) -> None:
        self.inner.setdefault(edge.tail, set()).add(edge)
        self.outer.setdefault(edge.head, set()).add(edge)
        if edge.head != RAIL_NET or edge.tail is not None:  # paths from rail to rail stay paths
            group = self.beside.setdefault((edge.head, edge.tail), [])
            if group:
                insort(group, edge, key=lambda e: e.place)
            else:
                group.append(edge)
        self._try(edge)

    def _try(self, edge: _Edge) -> None:
        """What can be joined with an edge: what is beside it, and what is before and behind it."""
        if len(self.beside.get((edge.head, edge.tail), ())) > 1:
            self.added.append(edge)
        self.nets += [net for net in (edge.head, edge.tail) if net]  # nothing is joined at a rail

    def _take(self, *edges: _Edge) -> None:
        for edge in edges:
            self.inner[edge.tail].discard(edge)
            self.outer[edge.head].discard(edge)
            group = self.beside.get((edge.head, edge.tail))
            if group is not None and (at := self._at(edge, group)) is not None:
                del group[at]

    @staticmethod
    def _at(edge: _Edge, group: Sequence[_Edge]) -> int | None:
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

    def _fits(self, a: _Edge, b: _Edge) -> bool:
        """Whether they can stand together in this order: no turn of ``b`` is before one of ``a``, and no
        other element has a turn between."""
        if a.high > b.low or a.held or b.held:
            return False
        if a.low == b.high:
            return True
        own = a.size + b.size
        own -= a.at_low + b.at_low * (b.low == a.low) + b.at_high + a.at_high * (a.high == b.high)
        return bisect_left(self.turns, b.high) - bisect_right(self.turns, a.low) == own

    def _join(self, a: _Edge, b: _Edge, items: deque, head: str, tail: str | None, depth: int) -> _Edge:
        at_low = a.at_low + b.at_low * (b.low == a.low)
        at_high = b.at_high + a.at_high * (a.high == b.high)
        first, size = min(a.first, b.first), a.size + b.size
        return _Edge(items, head, tail, a.low, b.high, first, size, at_low, at_high, depth)

    def _net(self, net: str) -> None:
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
        elif not outer and net in self.reader and before.head == RAIL_NET:
            self._to_pin(before, self.reader[net])

    def _series(self, a: _Edge, b: _Edge) -> None:
        self._take(a, b)
        items = a.items
        if len(a.items) >= len(b.items):
            items.extend(b.items)
        else:
            items = b.items
            items.extendleft(reversed(a.items))
        self._add(self._join(a, b, items, a.head, b.tail, max(a.depth, b.depth)))

    def _parallel(self, edge: _Edge) -> None:
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

    def _to_pin(self, network: _Edge, number: int) -> None:
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


class _Writer:
    """Edges as paths; nets that need a name get one in the order of the text."""

    def __init__(self, edges: list[_Edge], pins: Counter[str], at_pins: dict[str, _Edge]) -> None:
        self.edges, self.at_pins = edges, at_pins
        self.uses = Counter(net for edge in edges for net in (edge.head, edge.tail) if net)
        self.uses.update(pins)
        self.names: dict[str, str] = {}

    def paths(self) -> tuple[ast.Path, ...]:
        found: list[list[ast.Item]] = []
        before: _Edge | None = None
        for edge in self.edges:
            if before is None or not edge.head or edge.head != before.tail:
                self._end(found, before)
                found.append([self._junction(edge.head, edge)] if edge.head else [])
            elif self.uses[edge.head] > 2:
                found[-1].append(self._junction(edge.head, edge))
            found[-1] += self._items(edge)
            before = edge
        self._end(found, before)
        return tuple(ast.Path(tuple(items), items[0].span) for items in found)

    def _end(self, found: list[list[ast.Item]], edge: _Edge | None) -> None:
        if edge is not None and edge.tail:
            found[-1].append(self._junction(edge.tail, edge))

    def _name(self, net: str) -> str:
        return self.names.setdefault(net, f"n{len(self.names) + 1}")

    def _junction(self, net: str, edge: _Edge) -> ast.Junction:
        item = edge.items[0]
        while isinstance(item, list):
            item = item[0].items[0]
        return ast.Junction(self._name(net), item.span)

    def _items(self, edge: _Edge) -> list[ast.Item]:
        return [self._branches(i) if isinstance(i, list) else self._item(i) for i in edge.items]

    def _branches(self, edges: list[_Edge]) -> ast.Branches:
        series = [tuple(self._items(edge)) for edge in sorted(edges, key=lambda e: e.place)]
        paths = tuple(ast.Path(items, items[0].span) for items in series)
        return ast.Branches(paths, paths[0].span)

    def _item(self, item: ast.Item) -> ast.Item:
        if not isinstance(item, ast.Block):
            return item
        drawn = (replace(p, value=self._at_pin(p.value)) if isinstance(p.value, ast.Junction) else p
                 for p in item.pins)
        return replace(item, pins=tuple(drawn))

    def _at_pin(self, junction: ast.Junction) -> ast.Branches | ast.Junction:
        network = self.at_pins.get(junction.name)
        if network is None:
            return ast.Junction(self._name(junction.name), junction.span)
        return self._branches(network.branches or [network])
