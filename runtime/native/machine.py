"""A machine whose tasks are native code; memory and time are those of every machine (DESIGN section 5)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from ldc.il import block
from runtime.in_block import FIRST_SCAN, InBlock
from runtime.layout import Layout
from runtime.machine import Schedule
from runtime.native.library import Code, Library
from runtime.symbols import Symbol

# By number of their 64-bit word.
_NOW, _WATCHDOG = 0, 1
MOST = (1 << 63) - 1


@dataclass(slots=True, eq=False)
class Machine(InBlock):
    """``native``: what was built of ``program``. Raises WrongLibrary when it was another one."""

    native: Code = field(kw_only=True)
    library: Library = field(init=False, repr=False)
    _words: memoryview = field(init=False, repr=False)
    _pointer: object = field(init=False, repr=False)
    _run: Callable[..., int] = field(init=False, repr=False)
    _fed: bytes | None = field(init=False, repr=False)
    _ahead: bytearray = field(init=False, repr=False)
    _prepared: int = field(init=False, repr=False)

    def _load(self) -> Layout:
        layout = self._find_places(self.native.block)
        data = self.native.block.initial()
        data[FIRST_SCAN] = 1
        self.library = Library(self.native)
        self._pointer, self.memory = self.library.memory(data)
        self._words, self._run = self.memory.cast("q"), self._entry()
        self._fed, self._ahead, self._prepared = None, bytearray(), 0
        return layout

    def _entry(self) -> Callable[..., int]:
        """The function of the library that executes."""
        return self.library.run

    def close(self) -> None:
        InBlock.close(self)
        self.library.close()

    # ---- of the engine ---------------------------------------------------------------------------

    def prepare(self, changes: Iterable[tuple[Symbol, object]]) -> object:
        """The bytes of all inputs after the changes, so that ``feed`` is one copy."""
        begin, end = self.plan.inputs()
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
            begin, end = self.plan.inputs()
            self.memory[begin:end] = self._fed
            self._fed = None
        if self._late:
            self.latch_late()
        self._words[_NOW] = self.now_ns

    def _execute(self, schedule: Schedule) -> None:
        limit = schedule.task.watchdog
        self._words[_WATCHDOG] = min(limit, MOST)
        run, pointer = self._run, self._pointer
        for number in schedule.runs:
            if run(pointer, number):
                self.stop(schedule, *self.library.fault(self.memory, limit))
                return

    def _first_scan_done(self) -> None:
        self.memory[FIRST_SCAN] = 0
