"""Algorithms as a slave executes them: native code on structures that stay, or IL on a machine of its own.

Both have one interface. Parameters arrive as the values of P, in the order of ``Placed.parameters``; local
pins are words of the field, read before an execution and written after it (docs/components.md).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

from ldc.expr import Place
from ldc.il.external import Binding
from ldc.il.placement import ERROR, Placed, same_body
from ldc.il.program import Instr, Program, Resource, Run, RungCode, Task, Unit
from ldc.records import record
from ldc.symbols import Variable
from ldc.types import BOOL, Instance, blocks_in
from runtime.faults import Fault
from runtime.field import Field
from runtime.layout import lay_out
from runtime.symbols import Symbol
from runtime.vm.machine import Machine
from runtime.vm.memory import Memory, inside, put_inside

NOT_A_NUMBER, OUT_OF_RANGE = 6, 7
"""What ``error`` becomes for a local input that is no number, or outside of its range (SPEC 2.4)."""

NO_ERROR = 15
"""What ``error`` becomes when a component sets it to a number that only faults have (``SLAVE_FAULTS``)."""

_ALONE, _IT = "ALONE", "it"
_MOST = 0xFFFFFFFF
_MOST_NS = _MOST * 1000


class AlgorithmFault(Exception):
    """IL that was executed on a slave came to a fault. It is not to be executed any more."""

    def __init__(self, fault: Fault) -> None:
        self.fault = fault
        super().__init__(fault.message)

    @property
    def error(self) -> int:
        """The code of the fault as ``error`` tells it: 801 for LD0801."""
        return int(self.fault.code[2:])


class Algorithm(Protocol):
    """What a slave executes. ``error``: what the last execution left there, 0 for nothing."""

    error: int

    def take(self, values: Sequence[bool | int | float]) -> None:
        """New parameters. They count from the next execution on."""

    def execute(self, dt_ns: int) -> bool:
        """One execution, ``dt_ns`` after the last one, 0 for the first after a START. Whether it may have
        more to do: it has power, or has changed its outputs or its state. Raises AlgorithmFault."""

    def outputs(self) -> tuple[bool | int | float, ...]:
        """The values of ``Placed.feedback`` without ``error`` and AFS."""

    def safe(self) -> None:
        """Local outputs get their initial values."""

    def values(self, symbols: Sequence[Symbol]) -> list[object]:
        """Values of its memory; a symbol without keys is its clock, in ns."""

    def put(self, values: Iterable[tuple[Symbol, object]]) -> None:
        """Writes to its memory, before the first execution."""


@record
class Maker:
    """Makes algorithms of one unit. ``program``: what it needs to run alone; ``bindings``: native code in
    it; ``libraries``: the same, open: a loader finds them by name although the files may be gone by now."""

    unit: Unit
    program: Program
    bindings: tuple[Binding, ...]
    libraries: tuple[object, ...] = ()

    def same(self, other: Maker) -> bool:
        """Whether all that is executed is the same: an algorithm that goes on over an online change keeps its
        state."""
        ours, theirs = self.program.units, other.program.units
        return len(ours) == len(theirs) and all(map(same_body, ours, theirs))

    def __call__(self, placed: Placed, field: Field) -> Algorithm:
        """Raises OSError when native code cannot be loaded, MissingNative when it is not bound."""
        if self.unit.external is None:
            return UnitAlgorithm(self.program, self.unit, placed, field, self.bindings)
        return NativeAlgorithm(self.program, self.unit, placed, field, self.bindings)


def makers(program: Program, bindings: Iterable[Binding] = ()) -> dict[str, Maker]:
    """How the algorithms of a program are made, by the names of their units in capitals. Raises OSError when
    native code cannot be loaded."""
    bound = tuple(bindings) if program.algorithms else ()
    full = {u.name.upper(): u for u in (*program.units, *program.algorithms)}
    opened = tuple(map(_opened, bound))
    return {unit.name.upper(): Maker(unit, _alone(program, unit, full), bound, opened)
            for unit in program.algorithms}


def _opened(binding: Binding) -> object:
    from runtime.c_interface import ffi  # which only native code needs

    return ffi.dlopen(str(binding.library))


def _alone(program: Program, unit: Unit, full: dict[str, Unit]) -> Program:
    """A program that executes one instance of a unit in every scan, and has nothing else."""
    needed: dict[str, Unit] = {}
    _collect(unit, full, needed)
    frame = Unit("PROGRAM", _ALONE, (Variable(_IT, Instance(unit.name.upper())),),
                 (RungCode("call", (Instr("CAL", Place(_IT, Instance(unit.name.upper()))),)),))
    resource = Resource("slave", "slave", (Task("algorithm"),), (Run(_ALONE, _ALONE, "algorithm"),))
    return Program((*needed.values(), frame), program.types, (), (resource,))


def _collect(unit: Unit, full: dict[str, Unit], needed: dict[str, Unit]) -> None:
    """A unit and what it calls, callees first."""
    if unit.name.upper() in needed:
        return
    names = [i.name for rung in unit.rungs for i in rung.code if i.op == "FN"]
    for name in (*names, *(pou for v in unit.variables for pou in blocks_in(v.type))):
        if name.upper() in full:
            _collect(full[name.upper()], full, needed)
    needed[unit.name.upper()] = unit


class NativeAlgorithm:
    """The entry of a component in C or C++, called on its three structures."""

    __slots__ = ("error", "outputs", "_native", "_call", "_before", "_pins", "_values", "_reads", "_writes",
                 "_told", "_place", "_enabled", "_powered", "_instance")

    def __init__(self, program: Program, unit: Unit, placed: Placed, field: Field,
                 bindings: Iterable[Binding]) -> None:
        from runtime.vm import external  # loads cffi, which only native code needs

        binding = next((b for b in bindings if b.unit.upper() == unit.name.upper()), None)
        if binding is None:
            raise external.MissingNative(unit)
        native = self._native = external.Native(unit, binding)
        native.attach()
        self._call = native.call
        self._instance = Memory(lay_out(program)).fresh(Instance(unit.name))
        for structure, data in (native.given, native.made, native.kept):
            structure.fill(data, self._instance)
        (given, put), (made, out) = native.given, native.made
        self._before: tuple[bytes, ...] = ()
        self._pins = tuple(given.cell(put, p.name) for p in placed.parameters)
        self._values: list[bool | int | float | None] = [None] * len(self._pins)
        self._reads = tuple((field.reader(p.path), *given.cell(put, p.name), p.low, p.high)
                            for p in placed.local if not p.output)
        self._writes = tuple((*made.cell(out, p.name), field.writer(p.path), p.initial)
                             for p in placed.local if p.output)
        self._told, self._place = made.cell(out, ERROR)
        self.outputs = made.cells(out, [p.name for p in placed.feedback if p.name not in (ERROR, "AFS")])
        self._enabled, self._powered = placed.enabled, not placed.enabled
        self.error = 0
        self.safe()

    def take(self, values: Sequence[bool | int | float]) -> None:
        held = self._values
        for number, value in enumerate(values):
            if value != held[number]:
                held[number] = value
                view, at = self._pins[number]
                view[at] = value
        if self._enabled:
            self._powered = bool(held[0])
        if self._powered:
            self._before = ()

    def execute(self, dt_ns: int) -> bool:
        error, powered = 0, self._powered
        if not powered and not self._before:
            self._before = self._state()
        for read, view, at, low, high in self._reads:
            value = read()
            if low <= value <= high:
                view[at] = value
            else:
                error = OUT_OF_RANGE if value == value else NOT_A_NUMBER
        if error or self.error:
            self._told[self._place] = error
        if not error:
            call = self._call  # a slot is slow where a method is looked for
            call(dt_ns // 1000 if dt_ns < _MOST_NS else _MOST)
            error = self._told[self._place]
        self.error = error
        for view, at, write, _ in self._writes:
            write(view[at])
        if powered:
            return True
        before, self._before = self._before, self._state()
        return self._before != before

    def _state(self) -> tuple[bytes, ...]:
        return bytes(self._native.made[1]), bytes(self._native.kept[1])

    def safe(self) -> None:
        for view, at, write, initial in self._writes:
            view[at] = initial
            write(initial)

    def values(self, symbols: Sequence[Symbol]) -> list[object]:
        for structure, data in (self._native.made, self._native.kept):
            structure.take(data, self._instance)
        return [inside(self._instance, symbol.keys) for symbol in symbols]

    def put(self, values: Iterable[tuple[Symbol, object]]) -> None:
        for symbol, value in values:
            put_inside(self._instance, symbol.keys, value)
        for structure, data in (self._native.made, self._native.kept):
            structure.fill(data, self._instance)


class UnitAlgorithm:
    """A component in IL or ST: its whole unit, checks and all, on a virtual machine. Its clock counts the
    times between executions, so that it stands still while nothing is executed."""

    __slots__ = ("error", "outputs", "_machine", "_power", "_values", "_inputs", "_reads", "_writes", "_all",
                 "_before", "_error")

    def __init__(self, program: Program, unit: Unit, placed: Placed, field: Field,
                 bindings: Iterable[Binding]) -> None:
        machine = self._machine = Machine(program, period_ns=1, bindings=tuple(bindings))

        def symbol(name: str):
            return machine.symbols.find(f"{_IT}.{name}")

        self._inputs = tuple(symbol(p.name) for p in placed.parameters)
        self._values: list[bool | int | float | None] = [None] * len(self._inputs)
        self._reads = tuple((field.reader(p.path), symbol(p.name)) for p in placed.local if not p.output)
        self._writes = tuple((field.writer(p.path), symbol(p.name), p.initial)
                             for p in placed.local if p.output)
        fed = [symbol(p.name) for p in placed.feedback if p.name not in (ERROR, "AFS")]
        self.outputs = machine.reader(fed)
        self._all = machine.reader(machine.symbols.all())
        self._error = symbol(ERROR)
        self._power = symbol(placed.parameters[0].name) if placed.enabled else None
        self._before: tuple = ()
        self.error = 0
        self.safe()

    def take(self, values: Sequence[bool | int | float]) -> None:
        held, machine = self._values, self._machine
        for number, value in enumerate(values):
            if value != held[number]:
                held[number] = value
                symbol = self._inputs[number]
                machine.assign(symbol, bool(value) if symbol.type == BOOL else value)

    def execute(self, dt_ns: int) -> bool:
        machine = self._machine
        powered = self._power is None or machine.value(self._power)
        if not powered and not self._before:
            self._before = self._all()
        for read, symbol in self._reads:
            machine.assign(symbol, read())
        machine.now_ns += dt_ns
        now = machine.now_ns
        machine.scan()
        machine.now_ns = now
        if machine.faults:
            self.safe()
            raise AlgorithmFault(machine.faults[-1])
        self.error = machine.value(self._error)
        for write, symbol, _ in self._writes:
            write(machine.value(symbol))
        if powered:
            self._before = ()
            return True
        before, self._before = self._before, self._all()
        return self._before != before

    def safe(self) -> None:
        for write, symbol, initial in self._writes:
            self._machine.assign(symbol, initial)
            write(initial)

    def values(self, symbols: Sequence[Symbol]) -> list[object]:
        machine = self._machine
        return [machine.value(symbol) if symbol.keys else machine.now_ns for symbol in symbols]

    def put(self, values: Iterable[tuple[Symbol, object]]) -> None:
        for symbol, value in values:
            if symbol.keys:
                self._machine.assign(symbol, value)
            else:
                self._machine.now_ns = value
