"""The steps of a rung as paths: branches in braces where the drawing is series-parallel, junctions elsewhere.

Steps are edges between nets. Two edges in series or side by side become one until nothing more can be joined;
a network that feeds nothing but a pin goes to the pin. Rungs of one shape, of which a program has many, are
joined once.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from functools import lru_cache
from operator import attrgetter

from ldc.parser import ast
from ldc.parser.plcopen.joining import NOTHING, RAIL, Bare, Edge, Network, edges_of
from ldc.parser.plcopen.ordering import in_turn
from ldc.records import entity, replace

RAIL_NET = ""
_MOST = 200
"""Steps of a rung whose shape may come again."""

_OPERANDS = (ast.Name, ast.Direct, ast.Member, ast.Index, ast.Literal)


@entity
class Step:
    """An element between two nets (None: none; RAIL_NET: the left rail), and the nets at its pins."""

    order: tuple[int, ...]
    item: ast.Item
    head: str | None
    tail: str | None
    reads: tuple[str, ...] = ()
    writes: tuple[str, ...] = ()


def write(steps: Sequence[Step]) -> tuple[ast.Path, ...]:
    """The paths of a rung. Where a loop makes it impossible to feed everything before it is read, what is on it
    stays in drawing order, and the schedule opens the loop (DESIGN section 3, rule 5)."""
    steps = sorted(steps, key=attrgetter("order"))
    numbers: dict[str | None, int] = {None: NOTHING, RAIL_NET: RAIL}
    shape = tuple([_bare(step, numbers) for step in steps])
    plan = (_plan if len(steps) <= _MOST else _plan.__wrapped__)(shape)
    return tuple([_path(items, steps, numbers) for items in plan])


def _bare(step: Step, numbers: dict[str | None, int]) -> Bare:
    item, number = step.item, numbers.setdefault
    head, tail = number(step.head, len(numbers) - 1), number(step.tail, len(numbers) - 1)
    if type(item) is ast.Contact and not step.reads:
        return Bare(isinstance(item.expr, _OPERANDS), head, tail)
    reads, writes = (tuple([number(net, len(numbers) - 1) for net in nets]) for nets in (step.reads, step.writes))
    pins = ()
    if type(item) is ast.Block:
        pins = tuple([number(p.value.name, len(numbers) - 1) for p in item.pins
                      if isinstance(p.value, ast.Junction)])
    return Bare(False, head, tail, reads, writes, pins)


# ---- what a shape gives: paths of numbers of steps and of makers of items, which ask for the steps

_Nets = dict[str | None, int]
_Item = int | Callable[[Sequence[Step], _Nets], ast.Item]
_Items = tuple[_Item, ...]


@lru_cache(maxsize=1024)
def _plan(drawn: tuple[Bare, ...]) -> tuple[_Items, ...]:
    order, is_fed_first = in_turn(drawn)
    shape = [drawn[number] for number in order]
    edges = edges_of(shape)
    pins = Counter(net for step in shape for net in (*step.reads, *step.writes))
    if not is_fed_first:
        return _Writer(drawn, order, edges, pins, {}).paths()
    network = Network(edges, shape, pins)
    return _Writer(drawn, order, network.joined(), pins, network.at_pins).paths()


def _path(items: _Items, steps: Sequence[Step], numbers: _Nets) -> ast.Path:
    made = tuple([steps[i].item if type(i) is int else i(steps, numbers) for i in items])
    return ast.Path(made, made[0].span)


class _Writer:
    """Edges as paths; nets that need a name get one in the order of the text. ``order``: the number of the step
    that an edge has at each of its own numbers."""

    def __init__(self, shape: tuple[Bare, ...], order: Sequence[int], edges: list[Edge], pins: Counter[int],
                 at_pins: dict[int, Edge]) -> None:
        self.shape, self.order, self.edges, self.at_pins = shape, order, edges, at_pins
        self.uses = Counter(net for edge in edges for net in (edge.head, edge.tail) if net > RAIL)
        self.uses.update(pins)
        self.names: dict[int, str] = {}

    def paths(self) -> tuple[_Items, ...]:
        found: list[list[_Item]] = []
        before: Edge | None = None
        for edge in self.edges:
            if before is None or edge.head == RAIL or edge.head != before.tail:
                self._end(found, before)
                found.append([self._junction(edge.head, edge)] if edge.head > RAIL else [])
            elif self.uses[edge.head] > 2:
                found[-1].append(self._junction(edge.head, edge))
            found[-1] += self._items(edge)
            before = edge
        self._end(found, before)
        return tuple(map(tuple, found))

    def _end(self, found: list[list[_Item]], edge: Edge | None) -> None:
        if edge is not None and edge.tail > RAIL:
            found[-1].append(self._junction(edge.tail, edge))

    def _name(self, net: int) -> str:
        return self.names.setdefault(net, f"n{len(self.names) + 1}")

    def _junction(self, net: int, edge: Edge) -> _Item:
        at = edge.items[0]
        while isinstance(at, list):
            at = at[0].items[0]
        at, name = self.order[at], self._name(net)
        return lambda steps, numbers: ast.Junction(name, steps[at].item.span)

    def _items(self, edge: Edge) -> list[_Item]:
        return [self._branches(i) if isinstance(i, list) else self._item(self.order[i]) for i in edge.items]

    def _branches(self, edges: list[Edge]) -> _Item:
        series = [tuple(self._items(edge)) for edge in sorted(edges, key=lambda e: e.place)]

        def branches(steps: Sequence[Step], numbers: _Nets) -> ast.Branches:
            paths = tuple([_path(items, steps, numbers) for items in series])
            return ast.Branches(paths, paths[0].span)

        return branches

    def _item(self, number: int) -> _Item:
        pins = self.shape[number].pins
        if not pins:
            return number
        drawn = {net: self._at_pin(net) for net in pins}

        def block(steps: Sequence[Step], numbers: _Nets) -> ast.Block:
            item = steps[number].item
            return replace(item, pins=tuple([
                replace(p, value=drawn[numbers[p.value.name]](p.value, steps, numbers))
                if isinstance(p.value, ast.Junction) else p for p in item.pins]))

        return block

    def _at_pin(
        self, net: int
    ) -> Callable[[ast.Junction, Sequence[Step], _Nets], ast.Branches | ast.Junction]:
        network = self.at_pins.get(net)
        if network is None:
            name = self._name(net)
            return lambda junction, steps, numbers: ast.Junction(name, junction.span)
        branches = self._branches(network.branches or [network])
        return lambda junction, steps, numbers: branches(steps, numbers)
