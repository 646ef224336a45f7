"""The meaning of a series/parallel tree, in the same domains as the reference (``evaluate.py``)."""

from __future__ import annotations

from typing import Any

from ldc.graph.evaluate import Domain, join, recall, remember, run_block, run_plain, widened
from ldc.graph.memory import Memories
from ldc.graph.order import Turn
from ldc.graph.rung import RAIL, RungGraph
from ldc.graph.tree import Leaf, SPTree, Tree
from ldc.graph.walk import FORK, JOIN, LEAF, NEXT, PIN, TAP, operations
from ldc.model.elements import Block, Net


def evaluate_tree(
    graph: RungGraph, tree: SPTree, turns: tuple[Turn, ...], domain: Domain, memories: Memories,
) -> dict[Net, Any]:
    """Executes the steps once; returns what is kept for nets. ``turns`` is not needed: the tree has
    its own order, which the comparison with ``evaluate`` judges."""
    return _Run(graph, tree, domain, memories).run()


class _Run:
    def __init__(self, graph: RungGraph, tree: SPTree, domain: Domain, memories: Memories) -> None:
        self.graph, self.tree, self.domain, self.memories = graph, tree, domain, memories
        self.kept: dict[Net, Any] = {RAIL: domain.true}
        self.outputs = {(index, pin): net for index, pin, net in tree.outputs}

    def run(self) -> dict[Net, Any]:
        for step in self.tree.steps:
            power = self.power(step.tree)
            if step.net is not None:
                self.keep(step.net, power)
        return self.kept

    def keep(self, net: Net, power: Any) -> None:
        self.kept[net] = join(self.domain, self.kept.get(net), power)
        if net in self.memories.nets:
            remember(self.memories.nets[net], self.kept[net], self.domain, self.memories)

    def power(self, tree: Tree) -> Any:
        domain = self.domain
        power = domain.true
        saved: list[Any] = []
        pins: list[tuple[str, Any]] = []
        for op, what in operations(tree):
            if op == LEAF:
                given = dict(pins[-len(what.pins):]) if what.pins else {}
                del pins[len(pins) - len(what.pins):]
                power = self.leaf(what, power, given)
            elif op == TAP:
                name = self.memories.nets[what.net] if what.previous else None
                value = self.kept[what.net] if name is None else recall(name, domain, self.memories)
                # A tap that stands alone may carry a value that is not BOOL.
                power = value if power is domain.true else domain.and_(power, value)
            elif op == FORK:
                saved.append((power, None))
            elif op == NEXT:
                start, joined = saved[-1]
                saved[-1] = start, join(domain, joined, power)
                power = start
            elif op == JOIN:
                power = join(domain, saved.pop()[1], power)
            elif op == PIN:
                saved.append(power)
                power = domain.true
            else:
                pins.append((what, power))
                power = saved.pop()
        return power

    def leaf(self, leaf: Leaf, power: Any, pins: dict[str, Any]) -> Any:
        element = self.graph.elements[leaf.index]
        if not isinstance(element, Block):
            return run_plain(leaf.index, element, power, self.domain, self.memories)
        pins = widened(self.graph, element, pins, self.domain)
        power, given = run_block(leaf.index, element, power, pins, self.domain)
        drawn = [p for p in element.outputs if isinstance(p.target, int)]
        for pin, (net, value) in zip(drawn, given, strict=True):
            self.keep(self.outputs.get((leaf.index, pin.pin), net), value)
        return power
