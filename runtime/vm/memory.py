"""The memory of one machine: values of every type, function block classes, byte images.

Scalars are Python values (BOOL bool, integers and times int, REAL float, STRING bytes, WSTRING str),
arrays flat row-major lists, structures and instances objects of a class with ``__slots__`` per type.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from struct import Struct as Packer

from ldc.il.layout import state
from ldc.il.program import Unit
from ldc.records import replace
from ldc.symbols import Location, Variable
from ldc.types import (
    BOOL, Array, Elementary, Field, Instance, Struct, Type, Value, default, is_scalar, storage)
from runtime.layout import Cell, Home, Layout, Packed, slot
from runtime.symbols import Key, Symbol

_FORMAT = {("int", 8): "<b", ("int", 16): "<h", ("int", 32): "<i", ("int", 64): "<q",
           ("real", 32): "<f", ("real", 64): "<d", ("time", 64): "<q"}
_UNSIGNED = {8: "<B", 16: "<H", 32: "<I", 64: "<Q"}


class Bits:
    """One packed scalar in a byte image: ``get()`` and ``set(value)``."""

    __slots__ = ("_image", "_byte", "_mask", "_packer")

    def __init__(self, image: bytearray, location: Location, type_: Type) -> None:
        self._image, self._byte = image, location.byte
        self._mask = 1 << location.bit if location.size == "X" else 0
        kind, bits = storage(type_).kind, location.bits
        self._packer = None if self._mask else Packer(_FORMAT.get((kind, bits)) or _UNSIGNED[bits])

    def get(self):
        if self._mask:
            return self._image[self._byte] & self._mask != 0
        return self._packer.unpack_from(self._image, self._byte)[0]

    def set(self, value) -> None:
        if not self._mask:
            self._packer.pack_into(self._image, self._byte, value)
        elif value:
            self._image[self._byte] |= self._mask
        else:
            self._image[self._byte] &= ~self._mask


class BitsArray:
    """A packed array; behaves like the flat list that other arrays are."""

    __slots__ = ("_items",)

    def __init__(self, image: bytearray, location: Location, type_: Array) -> None:
        first = location.byte * 8 + location.bit
        self._items = [Bits(image, Location(location.area, location.size, at // 8, at % 8), type_.element)
                       for at in range(first, first + type_.count * location.bits, location.bits)]

    def __len__(self) -> int:
        return len(self._items)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return [item.get() for item in self._items[index]]
        return self._items[index].get()

    def __setitem__(self, index, value) -> None:
        if isinstance(index, slice):
            for item, one in zip(self._items[index], value, strict=True):
                item.set(one)
        else:
            self._items[index].set(value)

    def __iter__(self):
        return (item.get() for item in self._items)


class Memory:
    """Makes and copies values; knows the classes of function blocks and structures.

    ``namespace``: the cells of a resource by name, images and packed variables included.
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self._classes: dict[str | Struct, type] = {}
        self.namespace: dict[str, object] = {
            f"image_{area}": bytearray(size) for area, size in layout.image_bytes.items()}
        for root in layout.roots():
            self._place(root.home, root.variable.type, root.variable.initial)

    def _place(self, home: Home, type_: Type, initial: Value | None) -> None:
        if isinstance(home, Cell):
            if initial is not None or home.name not in self.namespace:
                self.namespace[home.name] = self.fresh(type_, initial)
            return
        name = packed_name(home)
        if name not in self.namespace:
            kind = BitsArray if isinstance(home.type, Array) else Bits
            self.namespace[name] = kind(self.namespace[home.name], home.location, home.type)
        if initial is not None:
            view = self.namespace[name]
            if isinstance(view, Bits):
                view.set(initial)
            else:
                view[:] = initial

    def block_class(self, unit: Unit) -> type:
        """The class of a function block: one slot per variable that has state."""
        key = unit.name.upper()
        if key not in self._classes:
            slots = tuple(slot(v.name) for v in state(unit))
            self._classes[key] = type(f"FB_{slot(unit.name)}", (), {"__slots__": slots})
        return self._classes[key]

    def _struct_class(self, struct: Struct) -> type:
        if struct not in self._classes:
            slots = tuple(slot(f.name) for f in struct.fields)
            self._classes[struct] = type(f"T_{slot(struct.name)}", (), {"__slots__": slots})
        return self._classes[struct]

    def fresh(self, type_: Type, initial: Value | None = None):
        """A new value of the type; ``initial`` as in ``ldc.types.Value``, None for the type's own."""
        match type_:
            case Array(element=element, count=count):
                values = initial if initial is not None else (None,) * count
                if is_scalar(element):
                    plain = default(element)
                    return [plain if v is None else v for v in values]
                return [self.fresh(element, v) for v in values]
            case Struct(fields=fields):
                given = {name.upper(): value for name, value in initial or ()}
                made = self._struct_class(type_)()
                for f in fields:
                    setattr(made, slot(f.name), self.fresh(f.type, given.get(f.name.upper(), f.initial)))
                return made
            case Instance(pou=pou):
                unit = self.layout.units[pou.upper()]
                given = {name.upper(): value for name, value in initial or ()}
                made = self.block_class(unit)()
                for v in state(unit):
                    setattr(made, slot(v.name), self.fresh(v.type, given.get(v.name.upper(), v.initial)))
                return made
        value = default(type_) if initial is None else initial
        return float(value) if isinstance(type_, Elementary) and type_.kind == "real" else value

    def copier(self, type_: Type) -> Callable:
        """A function that copies an array, a structure or an instance deeply."""
        match type_:
            case Array(element=element) if is_scalar(element):
                return list
            case Array(element=element):
                copy_one = self.copier(element)
                return lambda value: [copy_one(v) for v in value]
            case Struct(fields=fields):
                return self._member_copier(self._struct_class(type_), fields)
            case Instance(pou=pou):
                unit = self.layout.units[pou.upper()]
                return self._member_copier(self.block_class(unit), state(unit))
        raise TypeError(f"a value of {type_} cannot be assigned")


    def _member_copier(self, make: type, members: Sequence[Field] | Sequence[Variable]) -> Callable:
        parts = [(slot(m.name), None if is_scalar(m.type) else self.copier(m.type)) for m in members]

        def copy(value):
            made = make()
            for name, deep in parts:
                part = getattr(value, name)
                setattr(made, name, deep(part) if deep else part)
            return made

        return copy


def packed_name(home: Packed) -> str:
    """The namespace entry of the view on a packed variable."""
    at, kind = home.location, str(home.type)
    return f"view_{slot(f'{at.area}{at.size}{at.byte}_{at.bit}_{kind}')}"


def read(namespace: dict[str, object], home: Home):
    """The value of a root variable."""
    if isinstance(home, Cell):
        return namespace[home.name]
    view = namespace[packed_name(home)]
    return view.get() if isinstance(view, Bits) else view


def write(namespace: dict[str, object], home: Home, value) -> None:
    """Sets a root variable; packed arrays are written element by element."""
    if isinstance(home, Cell):
        namespace[home.name] = value
        return
    view = namespace[packed_name(home)]
    if isinstance(view, Bits):
        view.set(value)
    else:
        view[:] = value


def get(namespace: dict[str, object], symbol: Symbol):
    """The value of a scalar now, as the machine keeps it."""
    value = inside(read(namespace, symbol.home), symbol.keys)
    if symbol.bit is None:
        return value
    found = value >> symbol.bit & (1 << symbol.type.bits) - 1
    return found != 0 if symbol.type == BOOL else found


def inside(value, keys: Sequence[Key]):
    """A part of an instance, structure or array."""
    for key in keys:
        value = getattr(value, key) if isinstance(key, str) else value[key]
    return value


def put(namespace: dict[str, object], symbol: Symbol, value) -> None:
    """Writes a value that is already one of the machine's (see ``runtime.values.coerce``)."""
    if symbol.bit is not None:
        old, whole = get(namespace, replace(symbol, bit=None)), symbol.whole
        ones = (1 << symbol.type.bits) - 1 << symbol.bit
        value = (old & ~ones | value << symbol.bit) & (1 << whole.bits) - 1
        if value > whole.range[1]:
            value -= 1 << whole.bits
    if not symbol.keys:
        write(namespace, symbol.home, value)
        return
    put_inside(read(namespace, symbol.home), symbol.keys, value)


def put_inside(owner, keys: Sequence[Key], value) -> None:
    """Writes a part of an instance, structure or array."""
    owner = inside(owner, keys[:-1])
    if isinstance(last := keys[-1], str):
        setattr(owner, last, value)
    else:
        owner[last] = value

