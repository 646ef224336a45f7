"""The virtual machine: IL as Python functions on one namespace (DESIGN section 5, ADR 0006)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from operator import itemgetter

from ldc.il.external import Binding
from runtime import machine
from runtime.faults import FAULTS
from runtime.layout import FIRST_SCAN, NOW, Cell, Layout
from runtime.machine import Schedule
from runtime.symbols import Symbol, is_cell
from runtime.vm import memory
from runtime.vm.keeper import Keeper
from runtime.vm.loader import Code, Watchdog, load


@dataclass(slots=True, eq=False)
class Machine(machine.Machine):
    """``bindings``: where the native code of components is. ``pending``: inputs for the next scan by the name
    of their cell."""

    bindings: tuple[Binding, ...] = ()
    code: Code = field(init=False, repr=False)
    pending: dict[str, object] = field(init=False, repr=False)
    _namespace: dict[str, object] = field(init=False, repr=False)
    _watchdog: Watchdog = field(init=False, repr=False)
    _keeper: Keeper | None = field(init=False, repr=False, default=None)

    def _load(self) -> Layout:
        self.code = self._code()
        self._namespace, self._watchdog, self.pending = self.code.namespace, self.code.watchdog, {}
        return self.code.layout

    def _code(self) -> Code:
        return load(self.program, self.resource, self.bindings)

    def value(self, symbol: Symbol) -> object:
        return memory.get(self._namespace, symbol)

    def assign(self, symbol: Symbol, value: object) -> None:
        memory.put(self._namespace, symbol, value)

    def reader(self, symbols: Iterable[Symbol]) -> Callable[[], tuple]:
        wanted, namespace = tuple(symbols), self._namespace
        if len(wanted) > 1 and all(map(is_cell, wanted)):
            cells = itemgetter(*(s.home.name for s in wanted))
            return lambda: cells(namespace)
        if all(map(_has_name, wanted)):
            return eval(f"lambda: ({_names(wanted)})", namespace)
        return machine.Machine.reader(self, wanted)

    def writer(self, symbols: Iterable[Symbol]) -> Callable[[Sequence], None]:
        wanted = tuple(symbols)
        if not wanted or not all(s.keys and _has_name(s) for s in wanted):
            return machine.Machine.writer(self, wanted)
        made: dict[str, Callable[[Sequence], None]] = {}
        exec(f"def write(values): {_names(wanted)} = values", self._namespace, made)
        return made["write"]

    def put(self, symbol: Symbol, value: object) -> None:
        if symbol.area == "I" and is_cell(symbol):
            self.pending[symbol.home.name] = value
        else:
            machine.Machine.put(self, symbol, value)

    def prepare(self, changes: Iterable[tuple[Symbol, object]]) -> object:
        cells, others = {}, []
        for symbol, value in changes:
            if is_cell(symbol):
                cells[symbol.home.name] = value
            else:
                others.append((symbol, value))
        return cells, others

    def feed(self, prepared: object) -> None:
        cells, others = prepared
        if self.pending:
            self.pending.update(cells)
        else:
            self.pending = cells
        self._late += others

    def _latch(self) -> None:
        namespace = self._namespace
        if self.pending:
            namespace.update(self.pending)
            self.pending = {}
        if self._late:
            self.latch_late()
        namespace[NOW] = self.now_ns

    def _execute(self, schedule: Schedule) -> None:
        watchdog, bodies = self._watchdog, self.code.bodies
        watchdog.left = watchdog.limit = schedule.task.watchdog
        try:
            for number in schedule.runs:
                bodies[number]()
        except FAULTS as error:
            self.stop(schedule, error, self.code.trace(error.__traceback__))

    def close(self) -> None:
        """Functions and the memory that they work on hold each other: parted, all goes at once, and the
        native code of components is unloaded. Values stay readable."""
        machine.Machine.close(self)
        namespace = self._namespace
        for name in [name for name, entry in namespace.items() if callable(entry)]:
            del namespace[name]

    def _first_scan_done(self) -> None:
        self._namespace[FIRST_SCAN] = False

    def _capture(self) -> object:
        if self._keeper is None:
            self._keeper = Keeper(self.layout)
        return self._keeper.capture(self._namespace)

    def _put_back(self, kept: object) -> None:
        self._keeper.put_back(self._namespace, kept)


def _has_name(symbol: Symbol) -> bool:
    """The code of the program knows it by a name, too: no bit, nothing packed, no element of an array."""
    return (isinstance(symbol.home, Cell) and symbol.bit is None
            and all(isinstance(key, str) for key in symbol.keys))


def _names(symbols: Iterable[Symbol]) -> str:
    """By name, as the code of the program has them: an instance is another object after a state was put
    back."""
    return "".join(f"{'.'.join((s.home.name, *s.keys))}, " for s in symbols)
