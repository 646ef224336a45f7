"""Series/parallel reduction of a network with one source and many terminals (SPEC section 9 step 2).

Arcs carry ropes: an element index, a ``Tap``, or ``(SERIES | PARALLEL, left, right)``, so that joining
two is O(1) however long they are; ``ropes.py`` makes trees of them.
"""

from __future__ import annotations

from collections.abc import Iterable

from ldc.graph.rung import RAIL
from ldc.graph.tree import Tap
from ldc.model.elements import Net

SERIES, PARALLEL = "series", "parallel"
Rope = int | Tap | tuple[str, "Rope", "Rope"]

SINK: Net = -1


class Network:
    """Invariant: between two nodes there is at most one arc (a second one is joined in parallel), and
    terminals have no arcs that leave them."""

    def __init__(self, terminals: Iterable[Net]) -> None:
        self.terminals = {RAIL, SINK, *terminals}
        self.after: dict[Net, dict[Net, Rope]] = {RAIL: {}}
        self.before: dict[Net, dict[Net, None]] = {}
        self._work: list[Net] = []

    def add(self, start: Net, end: Net, rope: Rope) -> None:
        arcs = self.after.setdefault(start, {})
        known = arcs.get(end)
        if known is None:
            arcs[end] = rope
            self.before.setdefault(end, {})[start] = None
        else:
            arcs[end] = (PARALLEL, known, rope)
        self._work.append(start)
        self._work.append(end)

    def reduce(self, order: Iterable[Net]) -> list[tuple[Net, Rope]]:
        """Reduces until every arc leads from the rail to a terminal. Where that is stuck, the first
        node of ``order`` (topological) that is left is cut: its power is kept, and its arcs start at
        the rail with a tap of it. Returns the nodes that were cut, each with its rope. Linear."""
        kept = []
        self._contract()
        for node in order:
            if node not in self.before or node in self.terminals:
                continue
            leaving = self.after.pop(node, None)
            (start, *others) = self.before.pop(node)
            assert start == RAIL and not others, "what comes before a node in the order is gone"
            kept.append((node, self.after[RAIL].pop(node)))
            for end, rope in (leaving or {}).items():
                del self.before[end][node]
                self.add(RAIL, end, (SERIES, Tap(node), rope))
            self._contract()
        return kept

    def _contract(self) -> None:
        """Joins the arcs at each node that one arc enters and one leaves."""
        work, after, before, terminals = self._work, self.after, self.before, self.terminals
        while work:
            node = work.pop()
            if node in terminals:
                continue
            entering, leaving = before.get(node), after.get(node)
            if not entering or not leaving or len(entering) != 1 or len(leaving) != 1:
                continue
            (start,), ((end, rope),) = entering, leaving.items()
            del before[node], after[node], before[end][node]
            self.add(start, end, (SERIES, after[start].pop(node), rope))
