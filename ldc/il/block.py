"""The memory of native code: one block of bytes, outside of the code (DESIGN sections 4 and 5).

    0      system: time, watchdog, fault record (SYSTEM bytes, ``ldc_runtime.h`` has the fields)
           of each area I, Q, M: a byte for each bit address, then the byte image of wider addresses
           data: what ``ldc.il.layout`` places

All numbers are little-endian and aligned to their size. BOOL is a byte 0 or 1; a string is its length
(16 bit) and its characters (bytes, of WSTRING 16 bit units). A bit address lies in the byte image only
where a wider address overlaps with it. Areas grow by powers of two, so that a further address seldom moves
anything; they never shrink when those of the previous compile are given.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from ldc.il.homes import BY_SIZE, Cell, Home, end_of, homes, located
from ldc.il.layout import Layout, measure, state
from ldc.il.program import Program, Unit
from ldc.records import record
from ldc.symbols import Location, Variable
from ldc.types import Array, Elementary, Instance, String, Struct, Type, Value, default, is_scalar, storage

SYSTEM = 1024
_LEAST = 64
_FORMAT = {"int": {8: "b", 16: "h", 32: "i", 64: "q"}, "real": {32: "f", 64: "d"}, "time": {64: "q"},
           "bool": {1: "B"}}
_UNSIGNED = {8: "B", 16: "H", 32: "I", 64: "Q"}


@record
class Spot:
    """Where a variable lies: ``offset`` in bytes from the begin of the block; ``bit`` 0 to 7 when it is
    one bit (or an array of bits, one behind the other) of the byte image."""

    offset: int
    type: Type
    bit: int | None = None


@dataclass(frozen=True)
class Block:
    """``areas``: bytes reserved for I, Q and M."""

    program: Program
    resource: int
    layout: Layout
    areas: tuple[tuple[str, int], ...]
    homes: dict[tuple[Location, Type], Home]

    @cached_property
    def units(self) -> dict[str, Unit]:
        return {u.name.upper(): u for u in self.program.units}

    @cached_property
    def shared(self) -> dict[str, Variable]:
        """The global variables by name in capitals."""
        return {v.name.upper(): v for v in self.program.globals}

    @cached_property
    def _starts(self) -> dict[str, int]:
        found, at = {}, SYSTEM
        for area, size in self.areas:
            found[area] = at
            at += 9 * size
        found["D"] = at
        return found

    @cached_property
    def size(self) -> int:
        """Of the whole block, in bytes."""
        return self._starts["D"] + -(-max(self.layout.size, 8) // 8) * 8

    @cached_property
    def _symbols(self) -> dict[str, int]:
        return {s.path.upper(): s.offset for s in self.layout.symbols if s.area == "D"}

    def inputs(self) -> tuple[int, int]:
        """Begin and end of the bytes of the area I."""
        return self._starts["I"], self._starts["Q"]

    def located(self, at: Location, type_: Type) -> Spot:
        """The place of a located variable."""
        start, size = self._starts[at.area], dict(self.areas)[at.area]
        if at.size == "X" and isinstance(self.homes[at, type_], Cell):
            return Spot(start + 8 * at.byte + at.bit, type_)
        return Spot(start + 8 * size + at.byte, type_, at.bit if at.size == "X" else None)

    def direct(self, address: str) -> Spot:
        """The place of an address that is used without a declaration."""
        at = Location.parse(address)
        return self.located(at, BY_SIZE[at.size])

    def variable(self, path: str, variable: Variable) -> Spot:
        """The place of a global (``path`` is its name) or of a variable of a program instance
        (``instance.name``)."""
        if variable.location is not None:
            return self.located(variable.location, variable.type)
        return Spot(self._starts["D"] + self._symbols[path.upper()], variable.type)

    def member(self, type_: Type, name: str) -> tuple[int, Type]:
        """Offset and type of a field of a structure or a variable of an instance."""
        return self._members[type_][name.upper()]

    def members(self, type_: Type) -> dict[str, tuple[int, Type]]:
        """Offsets and types of all of them, by name in capitals."""
        return self._members[type_]

    @cached_property
    def _members(self) -> _Members:
        return _Members(self.units)

    def initial(self) -> bytearray:
        """The block before the first scan."""
        data = bytearray(self.size)
        part = self.program.resources[self.resource]
        roots = [(v.name, v) for v in self.program.globals]
        for run in part.runs:
            roots += [(f"{run.name}.{v.name}", v) for v in state(self.units[run.pou.upper()])]
        for path, variable in roots:
            spot = self.variable(path, variable)
            # Of several variables at one address a declared value wins.
            if variable.location is None or variable.initial is not None:
                self.fill(data, spot, variable.initial)
        return data

    def fill(self, data: bytearray, spot: Spot, value: Value | None) -> None:
        """Writes an initial value as in ``ldc.types.Value``, None for the type's own."""
        match spot.type:
            case Array(element=element, count=count):
                values = (None,) * count if value is None else value
                if all(v is None for v in values) and _blank(element):
                    return
                size = 1 if spot.bit is not None else self.measure(element)
                for n, one in enumerate(values):
                    self.fill(data, element_spot(spot, n, size, element), one)
            case Struct(fields=fields):
                self._fill_members(data, spot, [(f.name, f.initial) for f in fields], value)
            case Instance(pou=pou):
                known = [(v.name, v.initial) for v in state(self.units[pou.upper()])]
                self._fill_members(data, spot, known, value)
            case _:
                write(data, spot, default(spot.type) if value is None else value)

    def _fill_members(self, data: bytearray, spot: Spot, known: list, value: Value | None) -> None:
        given = {name.upper(): one for name, one in value or ()}
        for name, initial in known:
            offset, type_ = self.member(spot.type, name)
            self.fill(data, Spot(spot.offset + offset, type_), given.get(name.upper(), initial))

    def measure(self, type_: Type) -> int:
        """Bytes of a value; elements of arrays lie that far apart."""
        return measure(type_, self.units)[0]


def make(program: Program, layout: Layout, resource: int = 0,
         areas: Mapping[str, int] | None = None) -> Block:
    """The block of one resource of a program with the layout of its image; ``areas``: those of a block that
    it is to resemble. The model bounds addresses, and so the areas."""
    units = {u.name.upper(): u for u in program.units}
    places = located(program, program.resources[resource], units)
    sizes = {area: (areas or {}).get(area, _LEAST) for area in "IQM"}
    for at, type_ in places:
        needed = (end_of(at, type_) + 7) // 8
        while sizes[at.area] < needed:
            sizes[at.area] *= 2
    return Block(program, resource, layout, tuple(sizes.items()), homes(places))


class _Members(dict):
    """Members of structures and instances by name in capitals, laid out when they are asked for."""

    def __init__(self, units: dict[str, Unit]) -> None:
        self._units = units

    def __missing__(self, type_: Type) -> dict[str, tuple[int, Type]]:
        if isinstance(type_, Struct):
            members = [(f.name, f.type) for f in type_.fields]
        else:
            members = [(v.name, v.type) for v in state(self._units[type_.pou.upper()])]
        found, end = {}, 0
        for name, inner in members:
            size, align = measure(inner, self._units)
            offset = -(-end // align) * align
            found[name.upper()] = offset, inner
            end = offset + size
        self[type_] = found
        return found


def element_spot(spot: Spot, number: int, size: int, element: Type) -> Spot:
    """The place of the element ``number`` of an array."""
    if spot.bit is None:
        return Spot(spot.offset + number * size, element)
    at = spot.bit + number
    return Spot(spot.offset + at // 8, element, at % 8)


def _blank(type_: Type) -> bool:
    """Whether the initial value of the type is all zero bytes."""
    return is_scalar(type_) and not default(type_)


def read(data, spot: Spot):
    """The scalar at a place, as ``ldc.types`` keeps values. ``data``: anything with a buffer."""
    if spot.bit is not None:
        return bool(data[spot.offset] >> spot.bit & 1)
    if isinstance(spot.type, String):
        count = data[spot.offset] | data[spot.offset + 1] << 8
        begin = spot.offset + 2
        if spot.type.name == "STRING":
            return bytes(data[begin:begin + count])
        return bytes(data[begin:begin + 2 * count]).decode("utf-16-le", "surrogatepass")
    kind = storage(spot.type)
    if kind.kind == "bool":
        return data[spot.offset] != 0
    return struct.unpack_from(code(kind), data, spot.offset)[0]


def write(data, spot: Spot, value) -> None:
    """Writes a scalar that fits its type; of a WSTRING what fits into its 16-bit units."""
    if spot.bit is not None:
        kept = data[spot.offset] & ~(1 << spot.bit)
        data[spot.offset] = kept | bool(value) << spot.bit
    elif isinstance(spot.type, String):
        wide = spot.type.name != "STRING"
        raw = value.encode("utf-16-le", "surrogatepass") if wide else value
        raw = raw[:spot.type.length * (2 if wide else 1)]
        struct.pack_into("<H", data, spot.offset, len(raw) // (2 if wide else 1))
        data[spot.offset + 2:spot.offset + 2 + len(raw)] = raw
    else:
        struct.pack_into(code(storage(spot.type)), data, spot.offset, value)


def code(kind: Elementary) -> str:
    """The format of ``struct`` for a stored elementary type."""
    return "<" + (_FORMAT.get(kind.kind) or _UNSIGNED)[kind.bits]
