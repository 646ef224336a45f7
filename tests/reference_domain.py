"""The oracle's domain of Python values: what one execution of a rung does to a frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import models

from ldc.expr import Expr, Place
from ldc.library import functions
from ldc.library.faults import DivisionByZero
from ldc.model.elements import Block
from ldc.types import Type, default

if TYPE_CHECKING:
    from reference import Frame, ReferenceMachine


class Fault(Exception):
    """A run-time fault: a division by zero, an index out of range, too many jumps."""


class Standard:
    """An instance of a standard block: a model, and its pins as last seen."""

    def __init__(self, kind: str) -> None:
        self.model = models.make(kind)
        self.given: dict[str, Any] = {}

    @property
    def values(self) -> dict[str, Any]:
        return {**self.model.inputs, **self.given, **self.model.outputs}


class Concrete:
    """The domain of Python values, for one execution of a rung in a frame."""

    true, false = True, False

    def __init__(self, machine: ReferenceMachine, frame: Frame) -> None:
        self.machine, self.frame = machine, frame
        self.taken: list[tuple[int, str | None]] = []

    and_ = staticmethod(lambda a, b: a and b)
    or_ = staticmethod(lambda a, b: a or b)
    not_ = staticmethod(lambda a: not a)
    zero = staticmethod(default)
    choose = staticmethod(lambda when, yes, no: yes if when else no)

    def contact(self, expr: Expr, power: bool) -> bool:
        return power and self.machine.value(self.frame, expr)

    def value(self, expr: Expr, when: bool) -> Any:
        return self.machine.value(self.frame, expr) if when else default(expr.type)

    def convert(self, value: Any, source: Type, target: Type) -> Any:
        return functions.meaning(functions.conversion(source, target), (source,), target)(value)

    def store(self, place: Place, value: Any, when: bool) -> None:
        if when:
            self.machine.store(self.frame, place, value)

    def recall(self, name: str, type_: Type | None = None) -> Any:
        return self.frame.hidden.get(name, False if type_ is None else default(type_))

    def remember(self, name: str, value: Any, type_: Type | None = None) -> None:
        self.frame.hidden[name] = value

    def call_block(self, index: int, block: Block, inputs: Mapping[str, Any]) -> Mapping[str, Any]:
        instance = self.machine.load(self.frame, block.instance)
        if isinstance(instance, Standard):
            given, instance.given = {**instance.given, **{p.upper(): v for p, v in inputs.items()}}, {}
            return _Pins(instance.model.step(self.machine.now, **given))
        instance.values.update({pin.upper(): value for pin, value in inputs.items()})
        self.machine.run(instance)
        return _Pins(instance.values)

    def call_function(
        self, index: int, block: Block, enable: bool, inputs: Mapping[str, Any],
    ) -> tuple[bool, Mapping[str, Any]]:
        if not enable:
            return False, _Nothing()
        if not block.signature.standard:
            result, frame = self.machine.call(block.callee, list(inputs.values()))
            return True, _Pins({**frame.values, "OUT": result})
        types = {p.pin: p.type for p in block.inputs}
        taken = tuple(types[pin] if pin in types else block.signature.pin(pin).type for pin in inputs)
        meaning = functions.meaning(block.callee, taken, block.signature.result)
        try:
            return True, {"OUT": meaning(*inputs.values())}
        except DivisionByZero as error:
            if block.power_out == "ENO" or any(p.pin == "ENO" for p in block.outputs):
                return False, _Nothing()
            raise Fault("division by zero") from error

    def jump(self, index: int, label: str | None, when: bool) -> None:
        if when:
            self.taken.append((index, label))


class _Pins(dict):
    """Output pins by name in any case."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        super().__init__({name.upper(): value for name, value in values.items()})

    def __getitem__(self, pin: str) -> Any:
        return super().__getitem__(pin.upper())


class _Nothing(dict):
    """The pins of a function that did not run: nobody may use them."""

    def __missing__(self, pin: str) -> bool:
        return False
