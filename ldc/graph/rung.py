"""RungGraph: a rung as a directed graph, nodes = nets, edges = elements (SPEC section 9, step 1)."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from ldc.library import functions
from ldc.model.elements import Block, Element, Net, PinIn
from ldc.records import record
from ldc.source import Span
from ldc.types import BOOL, Elementary, Type, storage

if TYPE_CHECKING:
    import networkx as nx

RAIL: Net = 0


@record
class JunctionUse:
    """A place where the drawing names a net."""

    name: str
    net: Net
    span: Span


@record
class RungGraph:
    """One rung. Element ``i`` is the i-th in drawing order; ``heads[i]`` is the net that its power
    comes from and ``tails[i]`` the net that its power goes to.

    Net 0 is the left rail. Every path end that no element continues is a net without successors.
    A block whose ``power_in`` is None has its head at the rail (it waits for nothing); one whose
    ``power_out`` is None feeds nothing through its tail. Further nets of a block are the ``int``
    sources and targets of its pins. ``key`` is the rung's identity (its name, or digest and ordinal).
    """

    key: str
    name: str | None
    title: str | None
    elements: tuple[Element, ...]
    heads: tuple[Net, ...]
    tails: tuple[Net, ...]
    net_names: tuple[str, ...]
    span: Span
    net_types: tuple[Type, ...] = ()
    junctions: tuple[JunctionUse, ...] = ()

    def net_type(self, net: Net) -> Type:
        return self.net_types[net] if net < len(self.net_types) else BOOL

    def widening(self, pin: PinIn) -> tuple[Elementary, Elementary] | None:
        """The types between which the value of the net at a pin is widened; None when it is not."""
        given, taken = storage(self.net_type(pin.source)), storage(pin.type)
        if given == taken or not (isinstance(given, Elementary) and isinstance(taken, Elementary)):
            return None
        return (given, taken) if functions.widens(given, taken) else None

    def sources(self, index: int) -> tuple[Net, ...]:
        """The nets that element ``index`` waits for: its head first, then the nets at its pins."""
        element = self.elements[index]
        if not isinstance(element, Block):
            return (self.heads[index],)
        pins = tuple(p.source for p in element.inputs if isinstance(p.source, int))
        return pins if element.power_in is None else (self.heads[index], *pins)

    def targets(self, index: int) -> tuple[Net, ...]:
        """The nets that element ``index`` feeds: its tail first, then the nets at its output pins."""
        element = self.elements[index]
        if not isinstance(element, Block):
            return (self.tails[index],)
        pins = tuple(p.target for p in element.outputs if isinstance(p.target, int))
        return pins if element.power_out is None else (self.tails[index], *pins)

    @cached_property
    def incoming(self) -> tuple[tuple[int, ...], ...]:
        """Per net, the elements that feed it, in drawing order."""
        table: list[list[int]] = [[] for _ in self.net_names]
        for index in range(len(self.elements)):
            for net in self.targets(index):
                if not table[net] or table[net][-1] != index:
                    table[net].append(index)
        return tuple(map(tuple, table))

    @cached_property
    def outgoing(self) -> tuple[tuple[int, ...], ...]:
        """Per net, the elements that wait for it (by power or by a pin), in drawing order."""
        table: list[list[int]] = [[] for _ in self.net_names]
        for index in range(len(self.elements)):
            for net in self.sources(index):
                if not table[net] or table[net][-1] != index:
                    table[net].append(index)
        return tuple(map(tuple, table))

    @cached_property
    def in_order(self) -> bool:
        """Whether the drawing order feeds every net before it is used: no loop, nothing to sort."""
        last = [feeders[-1] if feeders else -1 for feeders in self.incoming]
        return all(last[net] < index for index in range(len(self.elements)) for net in self.sources(index))

    @cached_property
    def graph(self) -> nx.MultiDiGraph:
        """The networkx view: edge keys are (element index, input ordinal, output ordinal)."""
        import networkx as nx  # slow to load, and only this view needs it

        graph = nx.MultiDiGraph()
        graph.add_nodes_from(range(len(self.net_names)))
        for index in range(len(self.elements)):
            for i, u in enumerate(self.sources(index) or (RAIL,)):
                for o, v in enumerate(self.targets(index) or (self.tails[index],)):
                    graph.add_edge(u, v, key=(index, i, o))
        return graph
