"""Structures of C over bytes: values of an instance to where native code reads them, and back.

``struct`` packs in the machine's own way, as the compiler of C does: each member at a multiple of its size.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from struct import Struct, calcsize

from ldc.il import c_types
from ldc.symbols import Variable
from ldc.types import Array, String, Type
from runtime.layout import slot
from runtime.places import together

_CODES = {"bool": "?", "int8_t": "b", "uint8_t": "B", "int16_t": "h", "uint16_t": "H", "int32_t": "i",
          "uint32_t": "I", "int64_t": "q", "uint64_t": "Q", "float": "f", "double": "d"}


def code(type_: Type) -> str:
    """How ``struct`` calls a type that C knows: ``f``, ``10h``, a string of 8 bytes ``H8s0H``."""
    match type_:
        case Array(element=String() as element, count=count):
            return code(element) * count
        case Array(element=Array() as element, count=count):
            return code(element) * count
        case Array(element=element, count=count):
            return f"{count}{code(element)}"
        case String(length=length):
            return f"H{length}s0H"
    return _CODES[c_types.scalar(type_)]


def words(type_: Type, value: object) -> Iterator[object]:
    """A value as what ``struct`` packs by ``code``."""
    match type_:
        case Array(element=element):
            for one in value:
                yield from words(element, one)
        case String():
            yield from (len(value), value)
        case _:
            yield value


def taken(type_: Type, found: Iterator[object]) -> object:
    """The value of a type, of what ``struct`` has unpacked by ``code``."""
    match type_:
        case Array(element=element, count=count):
            return [taken(element, found) for _ in range(count)]
        case String(length=length):
            filled, text = next(found), next(found)
            return text[: min(filled, length)]
    return next(found)


class Structure:
    """The members of ``ldc_in``, ``ldc_out`` or ``ldc_state`` (``c_types.structure``) and the bytes that they
    take: ``size``."""

    __slots__ = ("size", "_names", "_types", "_plain", "_words", "_places")

    def __init__(self, variables: Sequence[Variable]) -> None:
        self._names = tuple(slot(v.name) for v in variables)
        self._types = tuple(v.type for v in variables)
        self._plain = not any(isinstance(type_, Array | String) for type_ in self._types)
        codes, widest = "@", "B"
        self._places: dict[str, tuple[str, int]] = {}
        for v in variables:
            one = code(v.type)
            aligned = f"0{'H' if 'H' in one else one[-1]}"
            self._places[v.name] = one, calcsize(codes + aligned)
            codes, widest = codes + aligned + one, max(widest, aligned[-1], key=calcsize)
        self._words = Struct(f"{codes}0{widest}")
        self.size = max(self._words.size, 1)

    def fill(self, buffer: bytearray, instance: object) -> None:
        """The members get the values that the instance has."""
        found = [getattr(instance, name) for name in self._names]
        if not self._plain:
            found = [word for pair in zip(self._types, found, strict=True) for word in words(*pair)]
        self._words.pack_into(buffer, 0, *found)

    def take(self, buffer: bytearray, instance: object) -> None:
        """The instance gets the values of the members."""
        found = self._words.unpack_from(buffer)
        if not self._plain:
            rest = iter(found)
            found = [taken(type_, rest) for type_ in self._types]
        for name, value in zip(self._names, found, strict=True):
            setattr(instance, name, value)

    def cell(self, buffer: bytearray, name: str) -> tuple[memoryview, int]:
        """Where a scalar member lies: a view, and its place in it. It takes no number that the type does not
        hold (ValueError)."""
        one, at = self._places[name]
        size = calcsize(one)
        return memoryview(buffer)[: len(buffer) // size * size].cast("B").cast(one), at // size

    def cells(self, buffer: bytearray, names: Sequence[str]) -> Callable[[], tuple]:
        """What gives the values of some scalar members."""
        return together(buffer, [(at, one) for one, at in map(self._places.__getitem__, names)])
