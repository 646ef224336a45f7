"""Values at several places of a buffer, read at once: one call for those who look at all of them again and
again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from operator import itemgetter
from struct import Struct, calcsize


def together(buffer: bytearray | memoryview, places: Sequence[tuple[int, str]]) -> Callable[[], tuple]:
    """A function that gives the values in the order of ``places``: byte offset and what ``struct`` calls one
    value of the machine's own byte order, ``f``, ``?``. A place has one name; it may be there twice."""
    ascending = sorted(set(places))
    numbers = {place: number for number, place in enumerate(ascending)}
    words, end = "=", 0
    for at, code in ascending:
        words += f"{at - end}x{code}"
        end = at + calcsize(f"={code}")
    read = partial(Struct(words).unpack_from, buffer)
    order = [numbers[place] for place in places]
    if order == list(range(len(ascending))):
        return read
    chosen = itemgetter(*order)
    return lambda: chosen(read())
