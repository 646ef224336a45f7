"""The field: what is wired to the controller, as words that plant and processors share (SPEC 1.2, 12).

Every point is one 32-bit word in the byte order of the machine: local pins of algorithms, and located inputs
and outputs of the master. Its one writer is the plant (what the controller reads), the slave or the master.
The same over bytes of a process and over shared memory; nothing is copied.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial

from ldc.il.placement import Point
from ldc.similar import similar
from runtime.places import together

Value = bool | int | float
_FORMATS = {"f32": "f", "i32": "i", "u32": "I", "bool32": "I"}
_WORDS = _FORMATS | {"bool32": "?3x" if sys.byteorder == "little" else "3x?"}
"""A point in a row of several, as ``struct`` calls it."""


class UnknownPoint(LookupError):
    """The field has no point of that path; the message names near ones."""


def field_size(places: Mapping[str, Point]) -> int:
    """Bytes that a field with these points takes."""
    return 4 * max((place.index + 1 for place in places.values()), default=0)


class Field:
    """``places``: the points by path in capitals (``ldc.il.placement.points``). ``asked``: those of them that
    somebody has asked for, so that nobody copies what nobody reads."""

    __slots__ = ("places", "asked", "_views", "_bytes")

    def __init__(self, buffer: bytearray | memoryview, places: Mapping[str, Point]) -> None:
        self.places, self.asked = places, set()
        self._bytes = memoryview(buffer).cast("B")[: len(buffer) // 4 * 4]
        self._views = {code: self._bytes.cast(code) for code in "fiI"}

    def reader(self, path: str) -> Callable[[], Value]:
        """A function that gives the value of a point. Raises UnknownPoint."""
        place = self._find(path)
        view, index = self._views[_FORMATS[place.type]], place.index
        if place.type == "bool32":
            return lambda: view[index] != 0
        return partial(view.__getitem__, index)

    def readers(self, paths: Sequence[str]) -> Callable[[], tuple[Value, ...]]:
        """``reader`` of several points at once, for those who look at all of them again and again. Raises
        UnknownPoint."""
        found = [self._find(path) for path in paths]
        return together(self._bytes, [(4 * place.index, _WORDS[place.type]) for place in found])

    def writer(self, path: str) -> Callable[[Value], None]:
        """A function that writes a point: a REAL is rounded to 32 bits. It raises TypeError and ValueError
        for values that the declared type does not hold. Raises UnknownPoint."""
        place = self._find(path)
        view, index, low, high = self._views[_FORMATS[place.type]], place.index, place.low, place.high

        def switch(value: Value) -> None:
            view[index] = bool(value)

        def bounded(value: Value) -> None:
            if not low <= value <= high:
                raise ValueError(f"`{path}` holds {low} to {high}, not {value}")
            view[index] = value

        if place.type == "f32":
            return partial(view.__setitem__, index)
        return switch if place.type == "bool32" else bounded

    def _find(self, path: str) -> Point:
        key = path.strip().upper()
        if key not in self.places:
            near = similar(key, self.places, 1)
            hint = f", did you mean `{near[0].lower()}`?" if near else ""
            raise UnknownPoint(f"the field has no point `{path}`{hint}")
        self.asked.add(key)
        return self.places[key]

    def extended(self, places: Mapping[str, Point]) -> Field:
        """The same words with the points of another program, which keep the places of those that both have.
        Raises ValueError when there are not enough words."""
        if field_size(places) > len(self._bytes):
            raise ValueError(f"a field of {len(self._bytes)} bytes has no room for {len(places)} points")
        made = Field(self._bytes, places)
        made.asked = self.asked
        return made

    def close(self) -> None:
        """Lets the buffer go, which can be closed then; readers and writers end."""
        for view in self._views.values():
            view.release()
        self._bytes.release()
