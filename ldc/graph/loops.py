"""What blocks in a loop read from a net that is not complete yet (DESIGN section 3 rule 5).

At such a read, elements that came before give what they gave now, those that come later what they gave
in the previous execution. With several reads of one net the two parts grow and shrink from read to
read, so each is kept in temporaries that build on one another: linear in feeders and reads together.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence

from ldc.graph.network import PARALLEL, Rope
from ldc.graph.tree import Tap
from ldc.model.elements import Net

Kept = tuple[Net, Rope]


def stale_reads(
    shares: Sequence[tuple[int, Net]], readers: Sequence[int], uses: int, fresh: Iterator[Net],
) -> tuple[list[Rope], list[Kept]]:
    """The rope for each reader, and what is to be kept for them.

    ``shares``: position in the schedule and net of each feeder's share; ``readers``: positions of the
    blocks; ``uses``: how many pins they read it by; both ascending. ``fresh``: numbers for new nets.
    """
    if uses == 1:
        (at,) = readers
        return [_either([Tap(net, position >= at) for position, net in shares])], []
    kept: list[Kept] = []
    now: list[list[Tap]] = [[] for _ in readers]
    last: list[list[Tap]] = [[] for _ in readers]
    for position, net in shares:
        at = bisect_right(readers, position)
        if at < len(readers):
            now[at].append(Tap(net))
        if at:
            last[at - 1].append(Tap(net, True))
    ready = _chain(now, fresh, kept)
    before = _chain(last[::-1], fresh, kept)[::-1]
    return [_either([*a, *b]) for a, b in zip(ready, before)], kept


def _chain(groups: list[list[Tap]], fresh: Iterator[Net], kept: list[Kept]) -> list[list[Tap]]:
    """For each group the OR of it and all groups before, as at most one tap."""
    found: list[list[Tap]] = []
    known: list[Tap] = []
    for group in groups:
        known = [*known, *group]
        if len(known) > 1:
            net = next(fresh)
            kept.append((net, _either(known)))
            known = [Tap(net)]
        found.append(known)
    return found


def _either(taps: Sequence[Tap]) -> Rope:
    rope: Rope = taps[0]
    for tap in taps[1:]:
        rope = (PARALLEL, rope, tap)
    return rope
