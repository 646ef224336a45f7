"""Values at several places of a buffer, read at once: one call for those who look at all of them again and
again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from operator import itemgetter
from struct import Struct, calcsize


def row(places: Sequence[tuple[int, str]], order: str = "=") -> tuple[Struct, itemgetter | None]:
    """What reads places at once, and what puts their values into the order of ``places``, None where they
    come in it. ``order``: of bytes, as ``struct`` calls it."""
    ascending = sorted(set(places))
    numbers = {place: number for number, place in enumerate(ascending)}
    words, end = order, 0
    for at, code in ascending:
        words += f"{at - end}x{code}"
        end = at + calcsize(f"{order}{code}")
    chosen = [numbers[place] for place in places]
    return Struct(words), None if chosen == list(range(len(ascending))) else itemgetter(*chosen)


def together(buffer: bytearray | memoryview, places: Sequence[tuple[int, str]]) -> Callable[[], tuple]:
    """A function that gives the values in the order of ``places``: byte offset and what ``struct`` calls one
    value of the machine's own byte order, ``f``, ``?``. A place has one name; it may be there twice."""
    words, chosen = row(places)
    read = partial(words.unpack_from, buffer)
    return read if chosen is None else lambda: chosen(read())
