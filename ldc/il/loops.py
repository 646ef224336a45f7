"""Loops in flat IL that Python can say as ``while``."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Mapping, Set

from ldc.records import record

# CPython nests no more than 20 loops in one function.
_DEEPEST, _ROUNDS = 12, 8


@record
class Loops:
    """``ends``: position of the label that a loop begins with -> its last backward jump; ``jumps``: those
    that go to the begin or behind the end of the innermost loop around them."""

    ends: dict[int, int]
    jumps: frozenset[int]


def find_loops(targets: Mapping[int, int], refused: Set[int]) -> Loops:
    """Loops that nest, are entered at their begin only and left behind their end only. ``targets``: where
    the jump at a position goes; ``refused``: begins that must not become loops."""
    ends: dict[int, int] = {}
    for at, target in targets.items():
        # A label is no jump, so that a begin never is one either.
        if target <= at and target not in refused and target not in targets:
            ends[target] = max(at, ends.get(target, 0))
    for _ in range(_ROUNDS):
        jumps, wrong = _classified(targets, ends)
        if not wrong:
            return Loops(ends, frozenset(jumps))
        ends = {head: last for head, last in ends.items() if head not in wrong}
    return Loops({}, frozenset())


def _classified(targets: Mapping[int, int], ends: Mapping[int, int]) -> tuple[set[int], set[int]]:
    """The jumps of the loops, and the loops that cannot be ones."""
    jumps: set[int] = set()
    wrong: set[int] = set()
    heads = sorted(ends)
    around: list[int] = []
    for at in sorted(targets.keys() | ends.keys()):
        while around and ends[around[-1]] < at:
            around.pop()
        if at in ends:
            if len(around) >= _DEEPEST or around and ends[around[-1]] <= ends[at]:
                wrong.add(at)
            around.append(at)
        else:
            jumps |= _judged(at, targets[at], around, ends, heads, wrong)
    return jumps, wrong


def _judged(at: int, target: int, around: list[int], ends: Mapping[int, int], heads: list[int],
            wrong: set[int]) -> set[int]:
    """Whether a jump is one of its loop (then itself is given back); adds loops that it breaks."""
    loop = around[-1] if around else None
    if loop is not None and target in (loop, ends[loop] + 1):
        return {at}
    # Loops that it leaves elsewhere than behind their end ...
    wrong.update(head for head in around if not head <= target <= ends[head])
    # ... and loops that it enters elsewhere than at their begin.
    first = bisect_left(heads, min(at, target))
    for head in heads[first:bisect_left(heads, max(at, target))]:
        if head < target <= ends[head] and not head <= at <= ends[head]:
            wrong.add(head)
    return set()
