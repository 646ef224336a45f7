"""All states that a system can come to, and what can be said of them."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass

import networkx


@dataclass(frozen=True)
class Graph:
    """``follow``: by the number of a state, the numbers of those that follow it, itself left out."""

    states: list
    follow: list[list[int]]

    def __len__(self) -> int:
        return len(self.states)


def explore(start: Hashable, moves: Callable[[Hashable], Iterable[Hashable]], limit: int = 2_000_000
            ) -> Graph:
    """Every state, breadth first. Fails beyond ``limit`` states."""
    states, follow, number = [start], [], {start: 0}
    for at, state in enumerate(states):  # grows meanwhile
        after = set()
        for new in moves(state):
            n = number.setdefault(new, len(states))
            if n == len(states):
                states.append(new)
            after.add(n)
        follow.append(list(after - {at}))
        assert len(states) <= limit, f"more than {limit} states"
    return Graph(states, follow)


def ends(graph: Graph) -> list:
    """The states in which a system can stay for ever: those that nothing follows, and all of a circle that is
    not left any more (a wait that asks two flags in turn is one)."""
    arrows = networkx.DiGraph()
    arrows.add_nodes_from(range(len(graph)))
    arrows.add_edges_from((n, after) for n, found in enumerate(graph.follow) for after in found)
    return [graph.states[n] for circle in networkx.attracting_components(arrows) for n in circle]
