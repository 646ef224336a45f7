"""How late a processor is woken: a histogram in words that one process writes and others read.

Bins are a quarter of an octave wide, from 1 us on, so that a figure is at most 25 % too high; the greatest is
exact.
"""

from __future__ import annotations

from ldc.records import record


BINS = 96
"""The last one holds everything from 14 s on."""

WORDS = BINS + 3
"""Words of 8 bytes that a histogram takes."""

_COUNT, _MISSED, _MOST = BINS, BINS + 1, BINS + 2
_LEAST = 1024


class Lateness:
    """Over ``WORDS`` words, all 0 at first (``memoryview.cast("Q")``)."""

    __slots__ = ("_words",)

    def __init__(self, words: memoryview) -> None:
        self._words = words

    def add(self, late_ns: int, missed: int) -> None:
        """A period that began so late, after as many that were missed."""
        words = self._words
        value = late_ns if late_ns > _LEAST else _LEAST
        octave = value.bit_length() - 11
        at = 4 * octave + (value >> octave + 8 & 3)
        words[at if at < BINS else BINS - 1] += 1
        words[_COUNT] += 1
        if missed:
            words[_MISSED] += missed
        if late_ns > words[_MOST]:
            words[_MOST] = late_ns

    def figures(self) -> Figures:
        """What was added until now."""
        words = self._words
        return Figures(tuple(words[:BINS]), words[_COUNT], words[_MISSED], words[_MOST])


@record
class Figures:
    """``bins``: how often; ``count``: periods that began; ``missed``: those that did not, because the one
    before was too long or began too late; ``most_ns``: the greatest lateness."""

    bins: tuple[int, ...]
    count: int
    missed: int
    most_ns: int

    def quantile(self, share: float) -> int:
        """A lateness in ns that this share of the periods did not exceed: the upper edge of a bin, at most
        the greatest; 0 when nothing began."""
        below = 0
        for at, count in enumerate(self.bins):
            below += count
            if below and below >= share * self.count:
                return min(upper(at), self.most_ns) if at < BINS - 1 else self.most_ns
        return 0

    def rows(self) -> list[tuple[int, int, int]]:
        """Octaves from the first to the last that has any: lower and upper edge in ns, and how often."""
        octaves = [sum(self.bins[at : at + 4]) for at in range(0, BINS, 4)]
        used = [n for n, count in enumerate(octaves) if count]
        if not used:
            return []
        return [(_LEAST << n if n else 0, _LEAST << n + 1, octaves[n]) for n in range(used[0], used[-1] + 1)]


def upper(at: int) -> int:
    """The upper edge of a bin, in ns."""
    return (at % 4 + 5) << at // 4 + 8
