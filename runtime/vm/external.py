"""Calls of native code from the virtual machine: values to C structures and back.

The structures live outside of the library, one set per instance, so a library can be exchanged. Globals
that the native code names are copied into the memory that it is given before a call, and back after it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import cffi

from ldc.il import c_types
from ldc.il.external import Binding, Shared
from ldc.il.program import Unit
from ldc.types import BOOL, Array, String, Type, storage
from runtime.layout import slot
from runtime.vm.memory import Home, read, write


class MissingNative(Exception):
    """A unit has native code and nobody said where it is."""

    def __init__(self, unit: Unit) -> None:
        super().__init__(f"the native code of component {unit.external.component} was not built")


def call(
    unit: Unit, binding: Binding, namespace: dict[str, object], homes: Mapping[str, Home]
) -> Callable[[object, int], None]:
    """A function that runs the native code on an instance; its second argument is the time since the last
    call in nanoseconds. ``homes``: where the globals are, by name in capitals. Raises OSError when the
    library cannot be loaded."""
    ffi = declared(unit)
    library = ffi.dlopen(str(binding.library))
    parts = c_types.members(unit)
    fill = [to_c(v.name, v.type) for v in parts["in"]]
    out = [(to_c(v.name, v.type), from_c(v.name, v.type)) for v in parts["out"]]
    state = [(to_c(v.name, v.type), from_c(v.name, v.type)) for v in parts["state"]]
    given, taken, kept = ffi.new("ldc_in *"), ffi.new("ldc_out *"), ffi.new("ldc_state *")
    memory = ffi.new("unsigned char[]", max(binding.size, 1))
    reads = [_window(ffi, memory, s, namespace, homes) for s in binding.shared]
    writes = [_window(ffi, memory, s, namespace, homes, back=True) for s in binding.shared if s.written]
    entry = library.ldc_entry

    def run(instance: object, dt: int) -> None:
        for copy in fill:
            copy(given, instance)
        for copy, _ in out:
            copy(taken, instance)
        for copy, _ in state:
            copy(kept, instance)
        for copy in reads:
            copy()
        library.ldc_memory = memory  # another machine may run the same library
        entry(given, taken, kept, min(max(dt // 1000, 0), 0xFFFFFFFF))
        for copy in writes:
            copy()
        for _, copy in out:
            copy(taken, instance)
        for _, copy in state:
            copy(kept, instance)

    run.owned = library, memory  # views and the entry do not keep what they point into
    return run


@cache
def declared(unit: Unit) -> cffi.FFI:
    """The structures of a unit with native code and its entry, for a library of it."""
    ffi = cffi.FFI()
    # Values of an array are one list here, whatever its dimensions.
    text = [
        c_types.structure(f"ldc_{part}", variables, flat=True)
        for part, variables in c_types.members(unit).items()
    ]
    text.append(
        "extern unsigned char *ldc_memory; void ldc_entry(const ldc_in *, ldc_out *, ldc_state *, uint32_t);"
    )
    ffi.cdef("\n".join(text))
    return ffi


def to_c(name: str, type_: Type) -> Callable[[object, object], None]:
    """Copies a variable of an instance, the second argument, into a structure."""
    attribute, member = slot(name), c_types.member(name)
    set_value = _setter(type_)

    def copy(target: object, instance: object) -> None:
        set_value(target, member, getattr(instance, attribute))

    return copy


def from_c(name: str, type_: Type) -> Callable[[object, object], None]:
    attribute, member = slot(name), c_types.member(name)
    value = _getter(type_)

    def copy(source: object, instance: object) -> None:
        setattr(instance, attribute, value(getattr(source, member)))

    return copy


def _setter(type_: Type) -> Callable[[object, str, object], None]:
    if isinstance(type_, String | Array):
        fill = _filler(type_)
        return lambda target, member, value: fill(getattr(target, member), value)
    return setattr


def _filler(type_: String | Array) -> Callable[[object, object], None]:
    """Copies into a C array or string that exists already."""
    if isinstance(type_, String):

        def text(target: object, value: bytes) -> None:
            target.length = len(value)
            target.text[0 : len(value)] = [bytes((b,)) for b in value]

        return text
    if isinstance(type_.element, String | Array):
        inner = _filler(type_.element)

        def nested(target: object, values: list) -> None:
            for index, value in enumerate(values):
                inner(target[index], value)

        return nested

    def plain(target: object, values: list) -> None:
        target[0 : len(values)] = values

    return plain


def _getter(type_: Type) -> Callable[[object], object]:
    match type_:
        case String(length=length):
            return lambda source: bytes(b for c in source.text[0 : min(source.length, length)] for b in c)
        case Array(element=element):
            value = _getter(element)
            return lambda source: [value(item) for item in source]
    return bool if storage(type_) == BOOL else lambda source: source


def _window(
    ffi: cffi.FFI,
    memory: object,
    shared: Shared,
    namespace: dict[str, object],
    homes: Mapping[str, Home],
    back: bool = False,
) -> Callable[[], None]:
    home = homes[shared.name.upper()]
    element = shared.type
    while isinstance(element, Array):
        element = element.element
    plain = "unsigned char" if storage(element) == BOOL else c_types.scalar(element)
    sizes = "".join(f"[{count}]" for count in c_types.dimensions(shared.type, flat=True))
    view = ffi.cast(f"{plain} (*){sizes}" if sizes else f"{plain} *", memory + shared.offset)
    value = _getter(shared.type)
    fill = _filler(shared.type) if sizes else None

    def into() -> None:
        held = read(namespace, home)
        if fill is None:
            view[0] = held
        else:
            fill(view[0], held)

    def out() -> None:
        write(namespace, home, value(view[0]))

    return out if back else into
