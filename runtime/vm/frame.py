"""A POU in execution, one instruction at a time: its variables, accumulator and deferred operations."""

from __future__ import annotations

from dataclasses import dataclass, field

from ldc.expr import BitStep, Const, FieldStep, IndexStep, Place, strides
from ldc.il.flat import Flat
from ldc.il.program import Unit
from ldc.symbols import Location
from ldc.types import String, Type, is_scalar
from runtime.faults import IndexOutOfRange
from runtime.faults import Place as CodePlace
from runtime.layout import INTRINSIC, Home, Layout, slot
from runtime.vm.arithmetic import cut
from runtime.vm.loader import Code
from runtime.vm.memory import Memory, read, write


@dataclass(slots=True, eq=False)
class Frame:
    """``path`` is the program instance's name, or the instance as written at the call, for display.

    ``owner``: the object of a function block; ``program``: the number of the program instance;
    a FUNCTION has neither. ``locals`` holds temporaries, and all variables of a FUNCTION.
    ``accumulator`` is None when it is undefined.
    """

    code: Code
    unit: Unit
    flat: Flat
    path: str
    owner: object = None
    program: int | None = None
    at: int = 0
    accumulator: object = None
    type: Type | None = None
    deferred: list[tuple[str, object, Type, Type]] = field(default_factory=list)
    locals: dict[str, object] = field(default_factory=dict)
    kinds: dict[str, str] = field(init=False)

    def __post_init__(self) -> None:
        self.kinds = {v.name.upper(): v.kind for v in self.unit.variables}
        for v in self.unit.variables:
            if self._is_local(v.name.upper()) and v.kind != "external" and v.name.upper() not in self.locals:
                self.locals[v.name.upper()] = self._memory.fresh(v.type, v.initial)

    @property
    def _memory(self) -> Memory:
        return self.code.memory

    @property
    def _layout(self) -> Layout:
        return self.code.layout

    @property
    def place(self) -> CodePlace:
        """Where the frame stands."""
        at = min(self.at, len(self.flat.code) - 1)
        if at < 0:
            return CodePlace(self.unit.name, "", -1)
        rung, index = self.flat.places[at]
        instr = self.flat.code[at]
        return CodePlace(self.unit.name, self.unit.rungs[rung].key, index, instr.element,
                         instr.span or self.unit.rungs[rung].span)

    def _is_local(self, upper: str) -> bool:
        return self.unit.kind == "FUNCTION" or self.kinds[upper] == "temp"

    # ---- values ----------------------------------------------------------------------------------

    def value(self, operand: Const | Place) -> object:
        """The value of an operand. Raises IndexOutOfRange."""
        if isinstance(operand, Const):
            return self.code.calls.rounded(operand)
        value = self._read_root(operand)
        for step in operand.steps:
            value = self._inside(value, step)
        return value

    def store(self, place: Place, value: object) -> None:
        """Writes a place: strings are cut, arrays and structures copied. Raises IndexOutOfRange."""
        if isinstance(place.type, String):
            value = cut(value, place.type)
        elif not is_scalar(place.type):
            value = self._memory.copier(place.type)(value)
        self._write(place, list(place.steps), value)

    def _write(self, place: Place, steps: list, value: object) -> None:
        if not steps:
            self._write_root(place, value)
            return
        last = steps[-1]
        if isinstance(last, BitStep):
            whole = self._read_root(place)
            for step in steps[:-1]:
                whole = self._inside(whole, step)
            self._write(place, steps[:-1], whole | last.weight if value else whole & ~last.weight)
            return
        owner = self._read_root(place)
        for step in steps[:-1]:
            owner = self._inside(owner, step)
        if isinstance(last, FieldStep):
            setattr(owner, slot(last.name), value)
        else:
            owner[self._offset(last)] = value

    def _inside(self, value, step: object) -> object:
        match step:
            case FieldStep(name):
                return getattr(value, slot(name))
            case BitStep(bit):
                return bool(value >> bit & 1)
        return value[self._offset(step)]

    def _offset(self, step: IndexStep) -> int:
        total = 0
        for index, (low, high), stride in zip(step.indexes, step.bounds, strides(step.bounds), strict=True):
            at = self.value(index if isinstance(index, Const) else index.place)
            if not low <= at <= high:
                raise IndexOutOfRange(at, low, high)
            total += (at - low) * stride
        return total

    def _home(self, place: Place, upper: str) -> Home | None:
        """Where a variable of the namespace lives; None for one of the instance or a local."""
        if place.is_global or self.kinds[upper] == "external":
            if upper[0] == "%":
                return self._layout.direct[str(Location.parse(upper))].home
            return self._layout.globals[upper].home
        if self._is_local(upper) or self.program is None:
            return None
        return self._layout.programs[self.program][1][upper].home

    def _read_root(self, place: Place) -> object:
        upper = place.root.upper()
        if place.is_global and upper in INTRINSIC:
            return self.code.namespace[INTRINSIC[upper]]
        home = self._home(place, upper)
        if home is not None:
            return read(self.code.namespace, home)
        return self.locals[upper] if self._is_local(upper) else getattr(self.owner, slot(upper))

    def _write_root(self, place: Place, value: object) -> None:
        upper = place.root.upper()
        home = self._home(place, upper)
        if home is not None:
            write(self.code.namespace, home, value)
        elif self._is_local(upper):
            self.locals[upper] = value
        else:
            setattr(self.owner, slot(upper), value)


def enter_function(code: Code, unit: Unit, flat: Flat, arguments: list[object]) -> Frame:
    """The frame of a FUNCTION called with values for ``unit.arguments``."""
    given = {}
    changed = unit.changed
    for variable, value in zip(unit.arguments, arguments, strict=True):
        aggregate = not is_scalar(variable.type) and variable in changed
        given[variable.name.upper()] = code.memory.copier(variable.type)(value) if aggregate else value
    return Frame(code, unit, flat, unit.name, locals=given)


