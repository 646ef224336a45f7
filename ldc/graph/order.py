"""In which order the elements of a rung are evaluated (DESIGN section 3, rules 2 and 5)."""

from __future__ import annotations

from heapq import heapify, heappop, heappush

from ldc.graph.rung import RAIL, RungGraph
from ldc.model.elements import Block
from ldc.records import record


@record
class Turn:
    """Element ``element`` is evaluated now. ``stale``: its incoming elements that come later in the
    schedule and count with their power of the previous execution (only at a block in a loop)."""

    element: int
    stale: tuple[int, ...] = ()


def schedule(graph: RungGraph) -> tuple[Turn, ...]:
    """Every element once, in the order of rule 2; loops are opened by rule 5. O(n log n) but for
    loops nested in one another.

    Raises ValueError for a loop without a block, which ``rules.check`` reports.
    """
    if graph.in_order:
        return tuple(Turn(index) for index in range(len(graph.elements)))
    return _Schedule(graph).run()


def has_loop(graph: RungGraph) -> bool:
    """Whether some elements wait for each other."""
    if graph.in_order:
        return False
    trial = _Schedule(graph)
    while trial.ready:
        trial.take(heappop(trial.ready), ())
    return len(trial.turns) < len(graph.elements)


class _Schedule:
    def __init__(self, graph: RungGraph) -> None:
        self.graph = graph
        count = len(graph.elements)
        self.done = [False] * count
        self.missing = [len(feeders) for feeders in graph.incoming]
        self.missing[RAIL] = 0
        self.waits = [0] * count
        for net, users in enumerate(graph.outgoing):
            if self.missing[net]:
                for user in users:
                    self.waits[user] += 1
        self.ready = [index for index in range(count) if not self.waits[index]]
        heapify(self.ready)
        self.turns: list[Turn] = []
        self.loops: _Loops | None = None

    def run(self) -> tuple[Turn, ...]:
        count = len(self.graph.elements)
        while len(self.turns) < count:
            if self.ready:
                self.take(heappop(self.ready), ())
                continue
            if self.loops is None:
                self.loops = _Loops(self.graph, self.done, self.missing)
            block = self.loops.first_block()
            stale = {feeder for net in self.graph.sources(block) if net != RAIL
                     for feeder in self.graph.incoming[net] if not self.done[feeder]}
            self.take(block, tuple(sorted(stale)))
        return tuple(self.turns)

    def take(self, index: int, stale: tuple[int, ...]) -> None:
        self.turns.append(Turn(index, stale))
        self.done[index] = True
        completed = []
        for net in dict.fromkeys(self.graph.targets(index)):
            if net == RAIL:
                continue
            self.missing[net] -= 1
            if self.missing[net]:
                continue
            completed.append(net)
            for user in self.graph.outgoing[net]:
                self.waits[user] -= 1
                if not self.waits[user] and not self.done[user]:
                    heappush(self.ready, user)
        if self.loops is not None:
            self.loops.finished(index, completed)


class _Loops:
    """The strongly connected components of what is not yet evaluated, kept while it shrinks.

    Nodes are elements (their index) and incomplete nets (``count`` + net), so that a net with many
    feeders and users costs their sum, not their product. ``blocked`` counts, per component, the arcs
    that enter it from unfinished nodes outside; a component with none waits for no other loop.
    """

    def __init__(self, graph: RungGraph, done: list[bool], missing: list[int]) -> None:
        self.graph, self.done, self.missing = graph, done, missing
        self.count = len(graph.elements)
        self.component: dict[int, int] = {}
        self.members: list[list[int]] = []
        self.blocked: list[int] = []
        self.free: list[tuple[int, int]] = []
        self.opened: int | None = None
        elements = [index for index in range(self.count) if not done[index]]
        nets = [self.count + net for net in range(len(missing)) if missing[net]]
        self.group(elements + nets)

    def successors(self, node: int) -> list[int]:
        if node >= self.count:
            return [user for user in self.graph.outgoing[node - self.count] if not self.done[user]]
        nets = dict.fromkeys(self.graph.targets(node))
        return [self.count + net for net in nets if net != RAIL]

    def unfinished(self, node: int) -> bool:
        return bool(self.missing[node - self.count]) if node >= self.count else not self.done[node]

    def group(self, nodes: list[int]) -> None:
        """Find the components among ``nodes``, which no unfinished node outside them feeds."""
        import networkx as nx  # slow to load, and only rungs with loops need it

        digraph = nx.DiGraph()
        digraph.add_nodes_from(nodes)
        inside = set(nodes)
        digraph.add_edges_from((a, b) for a in nodes for b in self.successors(a) if b in inside)
        fresh = range(len(self.members), len(self.members) + nx.number_strongly_connected_components(digraph))
        for number, members in zip(fresh, nx.strongly_connected_components(digraph)):
            self.members.append(sorted(members))
            self.blocked.append(0)
            self.component.update(dict.fromkeys(members, number))
        for a, b in digraph.edges:
            if self.component[a] != self.component[b]:
                self.blocked[self.component[b]] += 1
        for number in fresh:
            self.offer(number)

    def offer(self, number: int) -> None:
        if self.blocked[number] or len(self.members[number]) < 2:
            return
        elements = (node for node in self.members[number] if node < self.count)
        block = next((e for e in elements if isinstance(self.graph.elements[e], Block)), None)
        if block is not None:
            heappush(self.free, (block, number))

    def finished(self, index: int, nets: list[int]) -> None:
        for node in (index, *(self.count + net for net in nets)):
            own = self.component.get(node)
            for after in self.successors(node):
                other = self.component.get(after)
                if other is None or other == own:
                    continue
                self.blocked[other] -= 1
                self.offer(other)

    def first_block(self) -> int:
        """The first block in drawing order on a loop that waits for no other loop."""
        if self.opened is not None:
            self.group([node for node in self.members[self.opened] if self.unfinished(node)])
        if not self.free:
            raise ValueError(f"rung {self.graph.key}: a loop without a block")
        block, self.opened = heappop(self.free)
        return block
