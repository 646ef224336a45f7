"""Which jumps of a POU become Python ``if`` blocks and ``while`` loops, and which need a dispatch loop.

A forward jump over a properly nested range becomes ``if``; a jump that skips the other arm becomes
``else``. A backward jump whose range is entered at its start only, and left by jumps behind its end only,
becomes ``while`` (loops.py). What is left (ranges that cross) goes through segments: pieces of the body in a
loop that skips to the segment asked for.
"""

from __future__ import annotations

from bisect import bisect_right

from ldc.il.flat import Flat
from ldc.il.loops import Loops, find_loops
from ldc.records import record

DEEPEST = 30
_ROUNDS = 8


@record
class Plan:
    """``blocks``: jump position -> end of its ``if``; ``others``: position of a JMP -> end of the ``else``
    that starts right after it; ``segments``: positions where segments begin, in order (empty: no dispatch
    loop); ``loops``: those that become ``while``."""

    blocks: dict[int, int]
    others: dict[int, int]
    segments: tuple[int, ...]
    loops: Loops


def plan(flat: Flat) -> Plan:
    """Decides for every jump. A range that a segment begins in is decided again, a few times at most;
    after that all jumps go through the dispatch loop."""
    if not flat.targets:
        return Plan({}, {}, (), Loops({}, frozenset()))
    irregular: set[int] = set()
    refused: set[int] = set()
    for _ in range(_ROUNDS):
        loops = find_loops(flat.targets, refused)
        blocks, others, found = _nest(flat, irregular, loops)
        irregular |= found
        # A jump through the dispatch loop cannot be made from inside of a ``while``, nor into one.
        broken = {head for head, last in loops.ends.items()
                  if any(head <= at <= last or head < flat.targets[at] <= last for at in irregular)}
        if not found and not broken:
            break
        refused |= broken
    else:
        blocks, others, irregular, loops = {}, {}, set(flat.targets), Loops({}, frozenset())
    cuts = sorted({flat.targets[at] for at in irregular})
    segments = tuple(sorted({0, *cuts})) if irregular else ()
    return Plan(blocks, others, segments, loops)


def _nest(flat: Flat, irregular: set[int], loops: Loops) -> tuple[dict[int, int], dict[int, int], set[int]]:
    """One pass: the blocks, the else arms, and the jumps that must be irregular beyond those known."""
    cuts = sorted({flat.targets[at] for at in irregular})
    labels = sorted(flat.labels)
    blocks: dict[int, int] = {}
    others: dict[int, int] = {}
    found: set[int] = set()
    open_ends: list[int] = []
    for at in sorted(flat.targets.keys() | loops.ends.keys()):
        while open_ends and open_ends[-1] <= at:
            open_ends.pop()
        if at in loops.ends:  # a label, no jump
            open_ends.append(loops.ends[at] + 1)
            continue
        target = flat.targets[at]
        if at in irregular or at in loops.jumps:
            continue
        arm = _is_else(flat, at, open_ends)
        outer = open_ends[-2 if arm else -1] if len(open_ends) > arm else len(flat.code)
        if target <= at or target > outer or len(open_ends) >= DEEPEST or _any_within(cuts, at, target) \
                or (flat.code[at].op == "JMP" and not arm and _any_within(labels, at, target)):
            found.add(at)
        elif arm:
            others[at] = target
            open_ends[-1] = target
        else:
            blocks[at] = target
            open_ends.append(target)
    return blocks, others, found


def _is_else(flat: Flat, at: int, open_ends: list[int]) -> bool:
    """Whether the JMP ends the first arm of an ``if`` whose condition alone leads behind it."""
    return flat.code[at].op == "JMP" and open_ends[-1:] == [at + 1] and open_ends[-2:-1] != [at + 1]


def _any_within(positions: list[int], at: int, target: int) -> bool:
    """Whether one of the sorted positions lies inside the range of a jump, its two ends apart."""
    first = bisect_right(positions, at)
    return first < len(positions) and positions[first] < target
