"""A rung as nets, figures and lanes: which wires there are, before anything has a place.

A *lane* is one horizontal wire with figures on it. Lanes lie in groups: the paths of a rung, of a
bracket, of a pin network; the first lane of a bracket continues the lane that the bracket stands on.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

from ldc.draw import figures
from ldc.draw.figures import Figure
from ldc.draw.labels import Options
from ldc.parser import ast
from ldc.records import record

RAIL, RIGHT = 0, 1


@record
class Plan:
    """How to draw what can be drawn in several ways.

    ``joined``: junction occurrences (numbered in text order) that are drawn as connections, the
    others are name tags. ``places``: path of the rung -> (group, position in it) where that path is
    drawn; a path goes only into the bracket of an earlier one. ``railed``: pin networks that are drawn
    from the left rail; others have a rail of their own. ``late``: joined occurrences whose net
    stands as far to the right as what it feeds allows.
    """

    joined: frozenset[int] = frozenset()
    places: tuple[tuple[int, int, int], ...] = ()
    railed: frozenset[int] = frozenset()
    late: frozenset[int] = frozenset()


@dataclass(slots=True)
class Lane:
    items: list[Figure | Group] = field(default_factory=list)
    y: int = 0
    above: int = 1
    below: int = 0


@dataclass(slots=True)
class Group:
    lanes: list[Lane] = field(default_factory=list)


@dataclass(slots=True)
class Sketch:
    """``figures`` with their nets already joined; ``starts``: a rail of a pin network -> the net that
    it stands behind; ``groups``: the brackets in text order, each with the number of its path, but those
    of pin networks; ``networks``: how many pin networks; ``late`` nets as in the plan."""

    root: Group
    figures: list[Figure]
    starts: dict[int, int]
    groups: list[tuple[Group, int]]
    networks: int
    late: set[int]


def sketch(rung: ast.Rung, plan: Plan, options: Options) -> Sketch:
    """The wires of ``rung`` under ``plan``."""
    return _Builder(rung, plan, options).build()


class _Builder:
    def __init__(self, rung: ast.Rung, plan: Plan, options: Options) -> None:
        self.rung, self.plan, self.options = rung, plan, options
        self.parent = [RAIL, RIGHT]
        self.figures: list[Figure] = []
        self.starts: dict[int, int] = {}
        self.groups: list[tuple[Group, int]] = []
        self.path = 0
        self.inside = 0
        self.hubs: dict[str, int] = {}
        self.late: set[int] = set()
        self.networks = 0
        self.marks = figures.marks_of(rung, options)
        self.numbers, self.partial = _numbers(rung, plan)

    # ---- nets -------------------------------------------------------------------------------------

    def net(self) -> int:
        self.parent.append(len(self.parent))
        return len(self.parent) - 1

    def find(self, net: int) -> int:
        while self.parent[net] != net:
            self.parent[net] = self.parent[self.parent[net]]
            net = self.parent[net]
        return net

    def union(self, a: int, b: int) -> None:
        a, b = sorted((self.find(a), self.find(b)))
        self.parent[b] = a

    def hub(self, junction: ast.Junction) -> tuple[int | None, bool]:
        """The net of a junction (None: it is a tag), and whether its name has to be written."""
        name = junction.name.upper()
        if self.numbers[id(junction)] not in self.plan.joined:
            return None, True
        first = name not in self.hubs
        if first:
            self.hubs[name] = self.net()
        if self.numbers[id(junction)] in self.plan.late:
            self.late.add(self.hubs[name])
        return self.hubs[name], first and name in self.partial

    # ---- lanes ------------------------------------------------------------------------------------

    def build(self) -> Sketch:
        root, moved = Group(), []
        places = {path: (group, at) for path, group, at in self.plan.places}
        for self.path, path in enumerate(self.rung.paths):
            free = isinstance(path.items[0], ast.Junction)
            head = self.net() if free else RAIL
            tail = self.net() if _ends_in_junction(path) else RIGHT
            lane = self.lane(path, head, tail, (free, isinstance(path.items[-1], ast.Junction)))
            if self.path in places:
                moved.append((places[self.path], lane))
            else:
                root.lanes.append(lane)
        for (group, at), lane in moved:
            self.groups[group][0].lanes.insert(at, lane)
        for figure in self.figures:
            figure.head, figure.tail = self.find(figure.head), self.find(figure.tail)
            for port, _, _ in figure.ports():
                port.net = None if port.net is None else self.find(port.net)
        starts = {self.find(net): self.find(head) for net, head in self.starts.items()}
        late = {self.find(net) for net in self.late} - {RAIL, RIGHT}
        return Sketch(root, self.figures, starts, self.groups, self.networks, late)

    def lane(self, path: ast.Path, head: int, tail: int, ends: tuple[bool, bool] = (False, False)) -> Lane:
        """The figures of ``path`` from net ``head`` to net ``tail``; ``ends``: whether the wire begins
        or ends at a junction alone, so that a tag may stand there instead of the wire's end."""
        lane, current, last = Lane(), head, len(path.items) - 1
        for index, item in enumerate(path.items):
            if isinstance(item, ast.Junction):
                kind = "label"
                if index == 0 and ends[0]:
                    kind = "source"
                elif index == last and ends[1]:
                    kind = "sink"
                current = self.junction(lane, item, current, kind)
                if index == last:
                    self.union(current, tail)
                continue
            after = tail if index == last else self.net()
            if isinstance(item, ast.Branches):
                lane.items.append(self.group(item, current, after))
            else:
                self.figure(lane, item, current, after)
            current = after
        return lane

    def junction(self, lane: Lane, item: ast.Junction, current: int, kind: str) -> int:
        """Connect or tag the wire at ``current``; the net that the wire goes on with."""
        net, named = self.hub(item)
        if net is not None:
            self.union(current, net)
            kind = "label"
        if not named:
            return current
        figure = figures.tag(item, self.options, self.marks, kind)
        figure.wired_in, figure.wired_out = kind != "source", kind != "sink"
        figure.head, figure.tail = current, self.net()
        lane.items.append(figure)
        self.figures.append(figure)
        return figure.tail

    def group(self, branches: ast.Branches, head: int, tail: int) -> Group:
        group = Group()
        if not self.inside:
            self.groups.append((group, self.path))
        group.lanes += [self.lane(path, head, tail) for path in branches.paths]
        return group

    def figure(self, lane: Lane, item: ast.Item, head: int, tail: int) -> None:
        if isinstance(item, ast.Block):
            figure = self.block(item, head)
        else:
            figure = figures.simple(item, self.options, self.marks)
            figure.wired_out = not isinstance(item, ast.Jump)
        figure.head, figure.tail = head, tail
        lane.items.append(figure)
        self.figures.append(figure)

    def block(self, block: ast.Block, head: int) -> Figure:
        """Pins in rows under the row of the power; a pin's network opens the rows that it needs."""
        left, right, wired_in, wired_out = figures.ports(block, self.options)
        for port in left:
            if isinstance(port.value, ast.Branches):
                port.net, port.group = self.network(port.value, head)
                port.above, port.below = measure_group(port.group)
        for port in (*left, *right):
            if isinstance(port.value, ast.Junction) and port.value.name.upper() not in self.partial:
                port.net, _ = self.hub(port.value)
        figure = figures.block(block, left, right, self.options, self.marks)
        figure.wired_in, figure.wired_out = wired_in, wired_out
        return figure

    def network(self, branches: ast.Branches, head: int) -> tuple[int, Group]:
        start = RAIL
        if self.networks not in self.plan.railed:
            start = self.net()
            self.starts[start] = head
        self.networks += 1
        net = self.net()
        self.inside += 1
        group = self.group(branches, start, net)
        self.inside -= 1
        return net, group


def _numbers(rung: ast.Rung, plan: Plan) -> tuple[dict[int, int], set[str]]:
    """Number by ``id`` of each junction in text order; names of which not all are joined."""
    nodes = [node for node in figures.drawn(rung) if isinstance(node, ast.Junction)]
    names = [node.name.upper() for node in nodes]
    total = Counter(names)
    partial = {name for number, name in enumerate(names) if number not in plan.joined or total[name] == 1}
    return {id(node): number for number, node in enumerate(nodes)}, partial


def _ends_in_junction(path: ast.Path) -> bool:
    last = path.items[-1]
    if isinstance(last, ast.Branches):
        return any(_ends_in_junction(p) for p in last.paths)
    return isinstance(last, ast.Junction)


def measure(lane: Lane) -> tuple[int, int]:
    """Lines that a lane needs above and below its wire."""
    above, below = 1, 0
    for item in lane.items:
        up, down = (item.above, item.below) if isinstance(item, Figure) else measure_group(item)
        above, below = max(above, up), max(below, down)
    lane.above, lane.below = above, below
    return above, below


def measure_group(group: Group) -> tuple[int, int]:
    above, total = 0, -1
    for index, lane in enumerate(group.lanes):
        up, down = measure(lane)
        if index == 0:
            above = up
        else:
            total += up
        total += 1 + down
    return above, total
