"""A machine whose tasks are native code; memory and time are those of every machine (DESIGN section 5)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from ldc.il import block
from ldc.il.block import Spot
from ldc.il.homes import Home
from ldc.types import Array
from runtime import machine
from runtime.layout import Layout, Root, lay_out, slot
from runtime.machine import Schedule
from runtime.native.library import Code, Library
from runtime.symbols import Symbol

# Time and watchdog by number of their 64-bit word, the first scan by byte.
_NOW, _WATCHDOG, _FIRST_SCAN = 0, 1, 16
_MOST = (1 << 63) - 1


@dataclass(slots=True, eq=False)
class Machine(machine.Machine):
    """``native``: what was built of ``program``. Raises WrongLibrary when it was another one."""

    native: Code = field(kw_only=True)
    library: Library = field(init=False, repr=False)
    memory: memoryview = field(init=False, repr=False)
    _words: memoryview = field(init=False, repr=False)
    _pointer: object = field(init=False, repr=False)
    _run: Callable[[object, int], int] = field(init=False, repr=False)
    _roots: dict[Home, Spot] = field(init=False, repr=False)
    _spots: dict[Symbol, Spot] = field(init=False, repr=False)
    _fed: bytes | None = field(init=False, repr=False)
    _ahead: bytearray = field(init=False, repr=False)
    _prepared: int = field(init=False, repr=False)

    def _load(self) -> Layout:
        layout = lay_out(self.program, self.resource)
        data = self.native.block.initial()
        data[_FIRST_SCAN] = 1
        self.library = Library(self.native)
        self._pointer, self.memory = self.library.memory(data)
        self._words, self._run = self.memory.cast("q"), self.library.run
        self._roots = {root.home: self._spot_of(root) for root in layout.roots()}
        self._spots, self._fed, self._ahead, self._prepared = {}, None, bytearray(), 0
        return layout

    def _spot_of(self, root: Root) -> Spot:
        return self.native.block.variable(root.path, root.variable)

    def spot(self, symbol: Symbol) -> Spot:
        """Where the scalar lies in ``memory``."""
        found = self._spots.get(symbol)
        if found is None:
            found = self._spots[symbol] = self._walk(symbol)
        return found

    def _walk(self, symbol: Symbol) -> Spot:
        plan = self.native.block
        spot = self._roots[symbol.home]
        for key in symbol.keys:
            if isinstance(spot.type, Array):
                element = spot.type.element
                size = 1 if spot.bit is not None else plan.measure(element)
                spot = block.element_spot(spot, key, size, element)
            else:
                members = {slot(name): member for name, member in plan.members(spot.type).items()}
                offset, type_ = members[key]
                spot = Spot(spot.offset + offset, type_)
        if symbol.bit is not None:
            spot = Spot(spot.offset + symbol.bit // 8, symbol.type, symbol.bit % 8)
        return spot

    # ---- of the engine ---------------------------------------------------------------------------

    def value(self, symbol: Symbol) -> object:
        return block.read(self.memory, self.spot(symbol))

    def assign(self, symbol: Symbol, value: object) -> None:
        block.write(self.memory, self.spot(symbol), value)

    def prepare(self, changes: Iterable[tuple[Symbol, object]]) -> object:
        """The bytes of all inputs after the changes, so that ``feed`` is one copy."""
        begin, end = self.native.block.inputs()
        if not self._prepared:
            self._ahead[:] = self.memory[:end]
        self._prepared += 1
        for symbol, value in changes:
            block.write(self._ahead, self.spot(symbol), value)
        return bytes(self._ahead[begin:])

    def feed(self, prepared: object) -> None:
        self._prepared -= 1
        self._fed = prepared

    def _latch(self) -> None:
        if self._fed is not None:
            begin, end = self.native.block.inputs()
            self.memory[begin:end] = self._fed
            self._fed = None
        if self._late:
            self.latch_late()
        self._words[_NOW] = self.now_ns

    def _execute(self, schedule: Schedule) -> None:
        limit = schedule.task.watchdog
        self._words[_WATCHDOG] = min(limit, _MOST)
        run, pointer = self._run, self._pointer
        for number in schedule.runs:
            if run(pointer, number):
                self.stop(schedule, *self.library.fault(self.memory, limit))
                return

    def _first_scan_done(self) -> None:
        self.memory[_FIRST_SCAN] = 0
