"""How a chart hangs together on paper: a tree of steps and transitions that grows downwards, one level below
the other, with jumps and wires where it is no tree.

A transition hangs below its first source, a step below the first transition that leads to it. Whatever else
leads there from above is a wire that ends in a convergence; what leads back is a jump.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from ldc.parser import sfc
from ldc.records import record

STEP, TRANSITION, JUMP, WIRE = "step", "transition", "jump", "wire"
_LONGEST = 24
"""Levels that a wire to a step may pass; beyond that it is a jump."""


@dataclass(slots=True)
class Part:
    """``index`` of the step or transition; of a jump or a wire, that of the part it leads to. ``level``: 0 at
    the top, steps on even ones, transitions on odd ones. A wire begins at ``level`` and ends above that of
    the part it leads to."""

    kind: str
    index: int
    level: int
    children: list[Part] = field(default_factory=list)


@record
class Plan:
    """``roots``: where charts begin; ``steps`` and ``transitions`` by index; ``joined``: by kind and index,
    the wires that end at a part."""

    roots: tuple[Part, ...]
    steps: tuple[Part, ...]
    transitions: tuple[Part, ...]
    joined: dict[tuple[str, int], list[Part]]


def test_order(transitions: Sequence[sfc.Transition]) -> list[int]:
    """Indexes in the order in which transitions are tested: by priority, then as written."""
    def rank(index: int) -> tuple[bool, int]:
        priority = transitions[index].priority
        return priority is None, priority or 0

    return sorted(range(len(transitions)), key=rank)


def plan(chart: sfc.SfcBody) -> Plan:
    """The plan of a chart without mistakes. What leads away from a step is drawn from left to right in the
    order in which it is tested."""
    return _Planner(chart).plan()


class _Planner:
    def __init__(self, chart: sfc.SfcBody) -> None:
        self.chart = chart
        number = {step.name.upper(): index for index, step in enumerate(chart.steps)}
        self.sources = [[number[name.name.upper()] for name in t.sources] for t in chart.transitions]
        self.targets = [[number[name.name.upper()] for name in t.targets] for t in chart.transitions]
        self.leaving: list[list[int]] = [[] for _ in chart.steps]
        for index in test_order(chart.transitions):
            for source in self.sources[index]:
                self.leaving[source].append(index)
        first = [i for i, step in enumerate(chart.steps) if step.initial]
        self.begin = (*first, *(i for i in range(len(chart.steps)) if not chart.steps[i].initial))
        self.step_level: dict[int, int] = {}
        self.way_level: dict[int, int] = {}
        self.entering: list[list[int]] = [[] for _ in chart.steps]

    def plan(self) -> Plan:
        back, turn = self._depth_first()
        self._levels(back)
        for index, ways in enumerate(self.entering):
            ways.sort(key=turn.__getitem__)
            lowest = self.step_level[index] - _LONGEST
            self.entering[index] = [w for at, w in enumerate(ways) if not at or self.way_level[w] >= lowest]
        return self._tree()

    # ---- levels

    def _depth_first(self) -> tuple[set[tuple[int, int]], dict[int, int]]:
        """From where charts begin: transitions with the steps that they lead back to; and the turns of
        transitions, which are about their order from left to right."""
        back: set[tuple[int, int]] = set()
        turn: dict[int, int] = {}
        active, seen = set(), set()
        for begin in self.begin:
            work = [] if begin in seen else [(begin, self._leading(begin))]
            active.update(step for step, _ in work)
            while work:
                step, edges = work[-1]
                way, target = next(edges, (-1, -1))
                if way < 0:
                    active.discard(step)
                    work.pop()
                    continue
                seen.add(step)
                turn.setdefault(way, len(turn))
                if target in active:
                    back.add((way, target))
                elif target not in seen:
                    active.add(target)
                    work.append((target, self._leading(target)))
        return back, turn

    def _leading(self, step: int) -> Iterator[tuple[int, int]]:
        return ((way, target) for way in self.leaving[step] for target in self.targets[way])

    def _levels(self, back: set[tuple[int, int]]) -> None:
        """Place transitions below all of their sources, and steps below all that leads to them without
        leading back. A step that waits for itself in spite of that comes first."""
        waiting = [0] * len(self.leaving)
        for way, targets in enumerate(self.targets):
            for target in targets:
                waiting[target] += (way, target) not in back
        missing = [len(sources) for sources in self.sources]
        ready = deque(index for index in self.begin if not waiting[index])
        for index in self.begin:
            ready.append(index)
            while ready:
                step = ready.popleft()
                if step in self.step_level:
                    continue
                above = (self.way_level[way] for way in self.entering[step])
                self.step_level[step] = max(above, default=-1) + 1
                for way in self.leaving[step]:
                    missing[way] -= 1
                    if not missing[way]:
                        self._place(way, back, waiting, ready)

    def _place(self, way: int, back: set[tuple[int, int]], waiting: list[int], ready: deque[int]) -> None:
        self.way_level[way] = max(self.step_level[source] for source in self.sources[way]) + 1
        for target in self.targets[way]:
            if target in self.step_level:
                continue  # a jump
            self.entering[target].append(way)
            waiting[target] -= (way, target) not in back
            if not waiting[target]:
                ready.append(target)

    # ---- the tree

    def _tree(self) -> Plan:
        steps = tuple(Part(STEP, i, self.step_level[i]) for i in range(len(self.leaving)))
        ways = tuple(Part(TRANSITION, i, self.way_level[i]) for i in range(len(self.sources)))
        joined: dict[tuple[str, int], list[Part]] = {}
        for index, part in enumerate(steps):
            for way in self.leaving[index]:
                if self.sources[way][0] == index:
                    part.children.append(ways[way])
                else:
                    wire = Part(WIRE, way, part.level + 1)
                    part.children.append(wire)
                    joined.setdefault((TRANSITION, way), []).append(wire)
        drawn = {(way, step) for step, entering in enumerate(self.entering) for way in entering}
        for way, part in enumerate(ways):
            for target in self.targets[way]:
                if (way, target) not in drawn:
                    part.children.append(Part(JUMP, target, part.level + 1))
                elif way == self.entering[target][0]:
                    part.children.append(steps[target])
                else:
                    wire = Part(WIRE, target, part.level + 1)
                    part.children.append(wire)
                    joined.setdefault((STEP, target), []).append(wire)
        roots = tuple(steps[index] for index in self.begin if not self.entering[index])
        return Plan(roots, steps, ways, joined)
