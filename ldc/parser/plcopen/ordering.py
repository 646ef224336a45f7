"""In which order the elements of a rung take their turns: the drawing order, brought into one in which
everything is fed before it is read.

Like the joining of edges this is a matter of the nets alone, and holds for all rungs of one shape.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from heapq import heapify, heappop, heappush

from ldc.parser.plcopen.joining import NOTHING, Bare


Signal = int | tuple[str, int]
"""A net; of one on a loop what comes from outside of the loop; or that a step of a loop is done."""


def in_turn(steps: Sequence[Bare]) -> tuple[list[int], bool]:
    """The numbers of the steps, each behind those of what feeds it, and whether that is possible: those of a
    loop follow each other in drawing order."""
    gives = [_fed(step) for step in steps]
    feeders = {net for nets in gives for net in nets}
    takes = [{net for net in (step.head, *step.reads) if net in feeders} for step in steps]
    done = _sorted(gives, takes)
    if len(done) == len(steps):
        return done, True
    return _sorted(*_opened(gives, takes)), False


def _sorted(gives: Sequence[Collection[Signal]], takes: Sequence[Collection[Signal]]) -> list[int]:
    """The numbers, as early as possible, each behind all that give what it takes; without those for which a
    loop forbids that."""
    feeders: dict[Signal, int] = {}
    for signals in gives:
        for signal in signals:
            feeders[signal] = feeders.get(signal, 0) + 1
    waiting: dict[Signal, list[int]] = {}
    for number, signals in enumerate(takes):
        for signal in signals:
            waiting.setdefault(signal, []).append(number)
    missing = [len(signals) for signals in takes]
    ready = [number for number, count in enumerate(missing) if not count]
    heapify(ready)
    done: list[int] = []
    while ready:
        number = heappop(ready)
        done.append(number)
        for signal in gives[number]:
            feeders[signal] -= 1
            for other in waiting.get(signal, ()) if not feeders[signal] else ():
                missing[other] -= 1
                if not missing[other]:
                    heappush(ready, other)
    return done


def _opened(gives: Sequence[Collection[int]], takes: Sequence[Collection[int]]
            ) -> tuple[list[set[Signal]], list[set[Signal]]]:
    """What steps give and take when those of a loop wait for each other in drawing order only."""
    import networkx as nx  # few drawings need it

    graph = nx.DiGraph()
    for number, (given, taken) in enumerate(zip(gives, takes)):
        graph.add_edges_from((number, ("net", net)) for net in given)
        graph.add_edges_from((("net", net), number) for net in taken)
    loops = [found for found in nx.strongly_connected_components(graph) if len(found) > 1]
    of = {node: at for at, found in enumerate(loops) for node in found}
    new_gives: list[set[Signal]] = [set(given) for given in gives]
    new_takes: list[set[Signal]] = [set(taken) for taken in takes]
    entered = {net for number, given in enumerate(gives) for net in given
               if of.get(("net", net), -1) not in (-1, of.get(number))}
    for number, (given, taken) in enumerate(zip(gives, takes)):
        new_gives[number] |= {("outside", net) for net in given
                              if net in entered and of.get(number) != of[("net", net)]}
        if number in of:
            own = {net for net in taken if of.get(("net", net)) == of[number]}
            new_takes[number] = new_takes[number] - own | {("outside", net) for net in own & entered}
    for found in loops:
        members = sorted(node for node in found if isinstance(node, int))
        for before, number in zip(members, members[1:]):
            new_gives[before].add(("done", before))
            new_takes[number].add(("done", before))
    return new_gives, new_takes


def _fed(step: Bare) -> Collection[int]:
    """The nets that a step feeds."""
    return {net for net in (step.tail, *step.writes) if net != NOTHING}
