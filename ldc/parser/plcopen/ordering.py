"""In which order the elements of a rung take their turns: the drawing order, brought into one in which
everything is fed before it is read.

Like the joining of edges this is a matter of the nets alone, and holds for all rungs of one shape.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from heapq import heapify, heappop, heappush

from ldc.parser.plcopen.joining import NOTHING, Bare


def in_turn(steps: Sequence[Bare]) -> tuple[list[int], bool]:
    """The numbers of the steps, each behind those of what feeds it, and True; in drawing order, and False, if
    a loop forbids."""
    drawn = list(range(len(steps)))
    feeders: dict[int, int] = {}
    for step in steps:
        for net in _fed(step):
            feeders[net] = feeders.get(net, 0) + 1
    waiting: dict[int, list[int]] = {}
    missing = []
    for number, step in enumerate(steps):
        nets = {net for net in (step.head, *step.reads) if net in feeders}
        missing.append(len(nets))
        for net in nets:
            waiting.setdefault(net, []).append(number)
    ready = [number for number, count in enumerate(missing) if not count]
    heapify(ready)
    done: list[int] = []
    while ready:
        number = heappop(ready)
        done.append(number)
        for net in _fed(steps[number]):
            feeders[net] -= 1
            for other in waiting.get(net, ()) if not feeders[net] else ():
                missing[other] -= 1
                if not missing[other]:
                    heappush(ready, other)
    return (done, True) if len(done) == len(steps) else (drawn, False)


def _fed(step: Bare) -> Collection[int]:
    """The nets that a step feeds."""
    return {net for net in (step.tail, *step.writes) if net != NOTHING}
