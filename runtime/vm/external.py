"""Calls of native code from the virtual machine: values to C structures and back.

The structures live outside of the library, one set per instance, so a library can be exchanged. Globals
that the native code names are copied into the memory that it is given before a call, and back after it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from struct import Struct

from ldc.il import c_types
from ldc.il.external import Binding, Shared
from ldc.il.program import Unit
from runtime.c_interface import ffi
from runtime.vm.c_memory import Structure, code, taken, words
from runtime.vm.memory import Home, read, write


class MissingNative(Exception):
    """A unit has native code and nobody said where it is."""

    def __init__(self, unit: Unit) -> None:
        super().__init__(f"the native code of component {unit.external.component} was not built")


class Native:
    """The native code of a unit with structures of its own: ``given`` to it, ``made`` and ``kept`` by it,
    each with its bytes, and the memory of the globals that it names. ``call`` takes the time since the last
    call in microseconds. Raises OSError when the library cannot be loaded."""

    __slots__ = ("given", "made", "kept", "memory", "call", "_library", "_owned", "_named")

    def __init__(self, unit: Unit, binding: Binding) -> None:
        parts = c_types.members(unit)
        self._library = ffi.dlopen(str(binding.library))
        self.given, self.made, self.kept = (
            (structure, bytearray(structure.size)) for structure in map(Structure, parts.values()))
        self.memory, self._named = bytearray(max(binding.size, 1)), binding.size > 0
        self._owned = ffi.from_buffer("uint8_t[]", self.memory)
        places = (ffi.from_buffer(data) for _, data in (self.given, self.made, self.kept))
        self.call = partial(self._library.ldc_entry, *places)

    def attach(self) -> None:
        """The library works on the memory of this one from now on; another machine may run it, too."""
        if self._named:
            self._library.ldc_memory = self._owned


def call(
    unit: Unit, binding: Binding, namespace: dict[str, object], homes: Mapping[str, Home]
) -> Callable[[object, int], None]:
    """A function that runs the native code on an instance; its second argument is the time since the last
    call in nanoseconds. ``homes``: where the globals are, by name in capitals. Raises OSError when the
    library cannot be loaded."""
    native = Native(unit, binding)
    (given, put), (made, out), (kept, state) = native.given, native.made, native.kept
    reads = [_window(native.memory, s, namespace, homes) for s in binding.shared]
    writes = [_window(native.memory, s, namespace, homes, back=True) for s in binding.shared if s.written]

    def run(instance: object, dt: int) -> None:
        given.fill(put, instance)
        made.fill(out, instance)
        kept.fill(state, instance)
        for copy in reads:
            copy()
        native.attach()
        native.call(min(max(dt // 1000, 0), 0xFFFFFFFF))
        for copy in writes:
            copy()
        made.take(out, instance)
        kept.take(state, instance)

    return run


def _window(
    memory: bytearray,
    shared: Shared,
    namespace: dict[str, object],
    homes: Mapping[str, Home],
    back: bool = False,
) -> Callable[[], None]:
    """Copies a global into the memory that native code is given, or back."""
    home, type_, at = homes[shared.name.upper()], shared.type, shared.offset
    packed = Struct(f"@{code(type_)}")

    def into() -> None:
        packed.pack_into(memory, at, *words(type_, read(namespace, home)))

    def out() -> None:
        write(namespace, home, taken(type_, iter(packed.unpack_from(memory, at))))

    return out if back else into
