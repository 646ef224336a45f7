"""A shared object of native code, loaded: its functions and the places of its faults (docs/native.md)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ldc.il.block import Block
from ldc.il.external import Binding
from ldc.records import record
from runtime import fault_record
from runtime.c_interface import ffi
from runtime.faults import Place

ABI = 1
PACE = 40
"""The size of ``ldc_pace`` without its frame."""


class WrongLibrary(Exception):
    """The file is no native code for this program, or of another version of the interface."""


@record
class Code:
    """What a build gave: the shared object, the memory that it works on, for every driver of it the name of
    the POU and the first rung of each part, and the components that it calls, by their numbers."""

    path: Path
    block: Block
    map: fault_record.Parts
    bindings: tuple[Binding, ...] = ()


class Library:
    """The loaded code. ``run(memory, n)`` executes program instance n; not 0: a fault is in the memory. Code
    of a program that takes time has ``step(memory, n, pace)`` instead: one piece, where ``pace`` stands."""

    def __init__(self, code: Code) -> None:
        """Raises OSError when the file cannot be loaded, WrongLibrary when it is not of this program."""
        self.code = code
        self._library = ffi.dlopen(str(code.path.absolute()))
        try:
            fits = self._library.ldc_abi() == ABI and self._library.ldc_size() == code.block.size
        except AttributeError:
            fits = False
        if not fits:
            ffi.dlclose(self._library)
            raise WrongLibrary(f"{code.path} is no native code for this program")
        self._components = [self._bound(number, binding) for number, binding in enumerate(code.bindings)]

    def _bound(self, number: int, binding: Binding):
        """Loads a component and tells the code where it is."""
        component = ffi.dlopen(str(binding.library))
        memory = ffi.addressof(component, "ldc_memory") if binding.size else ffi.NULL
        self._library.ldc_bind(number, ffi.addressof(component, "ldc_entry"), memory)
        return component

    @property
    def run(self) -> Callable[[object, int], int]:
        return self._library.ldc_run

    @property
    def step(self) -> Callable[[object, int, object], int]:
        return self._library.ldc_step

    def pace(self):
        """Where an execution piece by piece stands: the C structure, and a view on it."""
        pointer = ffi.new("uint8_t[]", PACE + self._library.ldc_frame())
        return pointer, memoryview(ffi.buffer(pointer)).cast("B")

    def close(self) -> None:
        """Unloads the code; it must not be run any more."""
        for library in (self._library, *self._components):
            ffi.dlclose(library)

    def memory(self, data: bytes):
        """Memory for the code to work on, with these bytes: the C pointer, and a view on it."""
        pointer = ffi.new("uint8_t[]", len(data))
        view = memoryview(ffi.buffer(pointer)).cast("B")
        view[:] = data
        return pointer, view

    def fault(self, memory: memoryview, limit: int) -> tuple[Exception, tuple[Place, ...]]:
        """The fault that a run ended in, and where: calls first. ``limit``: of the watchdog."""
        return fault_record.read(self.code.block, self.code.map, memory, limit)

