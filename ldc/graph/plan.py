"""What is kept and where power flows: the choices before the reduction (DESIGN section 3 rule 6).

A net is kept (a temporary, or a hidden memory in a loop) when more than one tree needs it: several
pins, a pin and an element, an output pin and others, a block in a loop. A net that feeds one pin and
nothing else becomes that pin's own tree.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import count

from ldc.graph.loops import stale_reads
from ldc.graph.memory import loop_nets, stale_nets
from ldc.graph.network import SERIES, SINK, Network, Rope
from ldc.graph.order import Turn
from ldc.graph.rung import RAIL, RungGraph
from ldc.graph.tree import Tap
from ldc.model.elements import Block, Net
from ldc.records import record


@record
class Choice:
    """``cuts``: nets that must be kept; ``alone``: elements that get a step of their own."""

    cuts: frozenset[Net] = frozenset()
    alone: frozenset[int] = frozenset()


class Plan:
    """The arcs of a rung under a choice.

    ``network``: to be reduced. ``pins``: per block, its pins that nets feed, each with its rope or with
    the net whose rope it gets. ``steps``: ropes that stand alone. ``kept``: nets with a step (where
    something is left to keep) or kept by a block. ``outputs``: see ``SPTree``.
    """

    def __init__(self, graph: RungGraph, turns: Sequence[Turn], choice: Choice) -> None:
        self.graph, self.choice = graph, choice
        self.loops = loop_nets(graph, turns) if any(turn.stale for turn in turns) else {}
        self.pins: dict[int, list[tuple[str, Rope | Net]]] = {}
        self.steps: list[tuple[Net | None, Rope]] = []
        self.outputs: list[tuple[int, str, Net]] = []
        self._stale = {t.element: (set(t.stale), stale_nets(graph, t)) for t in turns if t.stale}
        self._fresh = count(max((len(graph.net_names), *(kept + 1 for kept in self.loops.values()))))
        self._split = {net for (_, net), kept in self.loops.items() if kept != net}
        self._reads: dict[tuple[int, Net], Rope] = {}
        self._count_uses()
        self.kept = self._find_kept()
        self.network = Network((*self.kept, *self.pin_nets))
        if self._split:
            position = {turn.element: at for at, turn in enumerate(turns)}
            for net in sorted(self._split):
                self._split_net(net, position)
        for turn in turns:
            self._add(turn.element)

    def _count_uses(self) -> None:
        graph = self.graph
        self.arc_uses = [0] * len(graph.net_names)
        self.pin_uses: list[list[tuple[int, str]]] = [[] for _ in graph.net_names]
        self.pin_fed: set[Net] = set()
        for index, element in enumerate(graph.elements):
            stale = self._stale[index][1] if index in self._stale else ()
            if not isinstance(element, Block):
                self.arc_uses[graph.heads[index]] += 1
                continue
            if element.power_in is not None and graph.heads[index] not in stale:
                self.arc_uses[graph.heads[index]] += 1
            for pin in element.inputs:
                if isinstance(pin.source, int) and pin.source not in stale:
                    self.pin_uses[pin.source].append((index, pin.pin))
            self.pin_fed.update(pin.target for pin in element.outputs if isinstance(pin.target, int))

    def _find_kept(self) -> set[Net]:
        kept = {net for net in self.pin_fed if self.used(net)}
        kept.update(net for net in self.choice.cuts if net != RAIL)
        kept.update(self.loops.values())
        self.pin_nets: dict[Net, tuple[int, str]] = {}
        for net, pins in enumerate(self.pin_uses):
            if not pins or net == RAIL or net in kept:
                continue
            if len(pins) > 1 or self.arc_uses[net]:
                kept.add(net)
            else:
                self.pin_nets[net] = pins[0]
        return kept

    def used(self, net: Net) -> bool:
        return bool(self.arc_uses[net] or self.pin_uses[net]) or net in self._split

    def _split_net(self, net: Net, position: Mapping[int, int]) -> None:
        """A loop net that several elements feed: each keeps its own share, the net is their OR."""
        shares = []
        for feeder in self.graph.incoming[net]:
            share = self.loops.get((feeder, net))
            if share is None:
                share = self.loops[feeder, net] = next(self._fresh)
                self.network.terminals.add(share)
            shares.append((position[feeder], share))
            if self.arc_uses[net] or self.pin_uses[net]:
                self.network.add(RAIL, net, Tap(share))
        readers = sorted((position[i], i) for i, (_, nets) in self._stale.items() if net in nets)
        uses = sum(self.graph.sources(i).count(net) for _, i in readers)
        ropes, kept = stale_reads(sorted(shares), [at for at, _ in readers], uses, self._fresh)
        self._reads.update(((i, net), rope) for (_, i), rope in zip(readers, ropes))
        self.steps += kept

    def _add(self, index: int) -> None:
        """The arc of an element, and what its pins take and give."""
        graph, element = self.graph, self.graph.elements[index]
        start, rope = self._from(index, graph.heads[index]), index
        end = self._to(index, graph.tails[index])
        if isinstance(element, Block):
            if element.power_in is None:
                start = RAIL
            if element.power_out is None:
                end = SINK
            self._add_pins(index, element)
        if not isinstance(start, int):
            start, rope = RAIL, (SERIES, start, index)
        if index in self.choice.alone:
            self.steps.append((None if end == SINK else end, rope))
        else:
            self.network.add(start, end, rope)

    def _add_pins(self, index: int, block: Block) -> None:
        for pin in block.inputs:
            if isinstance(pin.source, int):
                source = self._from(index, pin.source)
                self.pins.setdefault(index, []).append((pin.pin, Tap(RAIL) if source == RAIL else source))
        for pin in block.outputs:
            if isinstance(pin.target, int) and (index, pin.target) in self.loops:
                share = self.loops[index, pin.target]
                if share != pin.target:
                    self.outputs.append((index, pin.pin, share))

    def _from(self, index: int, net: Net) -> Net | Rope:
        """Where the power of ``net`` comes from: the net itself, or a rope of taps when it is kept."""
        if index in self._stale and net in self._stale[index][1]:
            return self._reads[index, net] if net in self._split else Tap(net, True)
        return Tap(net) if net in self.kept else net

    def _to(self, index: int, net: Net) -> Net:
        if (index, net) in self.loops:
            return self.loops[index, net]
        return net if net == RAIL or self.used(net) else SINK
