"""What a drawing must keep to before it means something (SPEC section 9 step 1); only checks.

``findings.py`` says it to the user. A rung that breaks a rule is not compiled.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.graph import findings
from ldc.graph.order import has_loop
from ldc.graph.rung import RAIL, RungGraph
from ldc.graph.tree import SPTree
from ldc.library import functions
from ldc.model.elements import Block, Contact, Jump, Net
from ldc.types import BOOL, Elementary, String, Type, storage


def check(graph: RungGraph, diagnostics: Diagnostics) -> bool:
    """Reports everything that is wrong with the wiring; whether the rung may be compiled."""
    if not graph.elements:
        findings.empty(graph, diagnostics)
        return False
    rules = _Rules(graph, diagnostics)
    rules.elements()
    bridged = not rules.ok
    rules.nets()
    rules.values()
    rules.junctions()
    if not bridged and has_loop(graph):
        rules.loops()
    return rules.ok


class _Rules:
    def __init__(self, graph: RungGraph, diagnostics: Diagnostics) -> None:
        self.graph, self.diagnostics = graph, diagnostics
        self.ok = True
        self.settled: set[Net] = {RAIL}

    def _wrong(self, report, *what, net: Net = RAIL) -> None:
        """An error; no further one is told about ``net``."""
        self.ok = False
        self.settled.add(net)
        report(self.graph, *what, self.diagnostics)

    def elements(self) -> None:
        """Both ends on one net, the rail fed, something behind a jump or a block that gives no power."""
        graph = self.graph
        for index, element in enumerate(graph.elements):
            head, tail = graph.heads[index], graph.tails[index]
            kind = type(element)
            if head == tail and (kind is not Block or element.power_in and element.power_out):
                self._wrong(findings.short, index, net=tail)
            elif tail == RAIL and (kind is not Block or element.power_out):
                self._wrong(findings.feeds_rail, index, element.span)
            if kind is Jump and graph.outgoing[tail] and tail != RAIL:
                self._wrong(findings.after_jump, index, net=tail)
            elif kind is Block:
                for pin in element.outputs:
                    if pin.target == RAIL and isinstance(pin.target, int):
                        self._wrong(findings.feeds_rail, index, pin.span)
                if element.power_out is None and tail != RAIL and graph.outgoing[tail]:
                    self._wrong(findings.no_power_out, index, net=tail)

    def nets(self) -> None:
        """A net that nothing feeds, and contacts whose power reaches nothing."""
        graph = self.graph
        for net in range(1, len(graph.net_names)):
            feeders, users = graph.incoming[net], graph.outgoing[net]
            if users and not feeders and net not in self.settled:
                self._wrong(findings.never_fed, net, net=net)
            elif feeders and not users and net not in self.settled:
                loose = [f for f in feeders if isinstance(graph.elements[f], Contact)]
                if loose:
                    self._wrong(findings.dangling, loose, net=net)

    def values(self) -> None:
        """Nets that carry something else than power, and the pins on every net."""
        graph = self.graph
        for net, type_ in enumerate(graph.net_types):
            if type_ == BOOL or net in self.settled:
                continue
            sources = [(f, p.span) for f in graph.incoming[net] if isinstance(graph.elements[f], Block)
                       for p in graph.elements[f].outputs if p.target == net and isinstance(p.target, int)]
            sources += [(f, graph.elements[f].span) for f in graph.incoming[net]
                        if graph.tails[f] == net and getattr(graph.elements[f], "power_out", "") is not None]
            if len(sources) > 1:
                self._wrong(findings.two_sources, net, [span for _, span in sorted(sources)], net=net)
            powered = [u for u in graph.outgoing[net] if graph.heads[u] == net]
            if powered:
                self._wrong(findings.value_as_power, net, powered, net=net)
        for element in graph.elements:
            if isinstance(element, Block):
                self._pins(element)

    def _pins(self, block: Block) -> None:
        for pin in block.inputs:
            if not isinstance(pin.source, int) or pin.source in self.settled - {RAIL}:
                continue
            given, taken = storage(self.graph.net_type(pin.source)), storage(pin.type)
            if not _same(given, taken) and self.graph.widening(pin) is None:
                conversion = None
                if isinstance(given, Elementary | String) and isinstance(taken, Elementary | String):
                    conversion = functions.conversion(given, taken)
                self._wrong(findings.net_mismatch, pin, conversion)

    def junctions(self) -> None:
        """A name that joins nothing."""
        uses: dict[str, int] = {}
        for use in self.graph.junctions:
            uses[use.name.upper()] = uses.get(use.name.upper(), 0) + 1
        for use in self.graph.junctions:
            if uses[use.name.upper()] == 1 and use.net not in self.settled - {RAIL}:
                findings.single_use(use, self.diagnostics)

    def loops(self) -> None:
        """Loops need a block, and power from the rail."""
        if loop := _first_component(self.graph, blocks=False):
            self._wrong(findings.loop_without_block, loop)
        if not self.ok:
            return
        reached = _reached(self.graph)
        lost = [index for index in range(len(self.graph.elements)) if index not in reached]
        if lost:
            self._wrong(findings.no_path, lost)
            return
        if loop := _first_component(self.graph, blocks=True):
            findings.loop_through_block(self.graph, loop, self.diagnostics)


def _same(a: Type, b: Type) -> bool:
    if isinstance(a, String) and isinstance(b, String):
        return a.name == b.name
    return a == b


def _first_component(graph: RungGraph, *, blocks: bool) -> list[int]:
    """The elements of the first loop in drawing order (strongly connected), with or without blocks."""
    import networkx as nx  # slow to load, and only rungs with loops need it

    digraph = nx.DiGraph()
    for index, element in enumerate(graph.elements):
        if blocks or not isinstance(element, Block):
            digraph.add_edges_from((-net, index + 1) for net in graph.sources(index) if net)
            digraph.add_edges_from((index + 1, -net) for net in graph.targets(index) if net)
    loops = [sorted(node - 1 for node in component if node > 0)
             for component in nx.strongly_connected_components(digraph) if len(component) > 1]
    return min(loops, default=[])


def _reached(graph: RungGraph) -> set[int]:
    """The elements that power can come to: from the left rail, or from a block that needs none."""
    reached = {index for index, element in enumerate(graph.elements)
               if RAIL in graph.sources(index) or isinstance(element, Block) and element.power_in is None}
    work = sorted(reached)
    while work:
        for net in graph.targets(work.pop()):
            for user in graph.outgoing[net]:
                if user not in reached:
                    reached.add(user)
                    work.append(user)
    return reached


def note_bridge(graph: RungGraph, tree: SPTree, diagnostics: Diagnostics) -> None:
    """Tells that a rung is not series-parallel and how many temporaries that costs. Nothing for a rung
    with a loop: ``check`` told about that."""
    kept = {step.net for step in tree.steps if step.net is not None}
    if kept and not tree.previous:
        findings.bridge(graph, sorted(kept), diagnostics)
