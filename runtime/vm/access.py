"""Loads and stores of places in generated code: fields, checked indexes, bits, packed variables."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ldc.expr import BitStep, Const, FieldStep, IndexStep, Place, strides
from ldc.types import BOOL, String, Type, is_scalar
from runtime.layout import Packed, slot
from runtime.vm import expression as ex
from runtime.vm.expression import Expression
from runtime.vm.names import Root, constant_offset, is_single
from runtime.vm.writer import BadCode, Writer


class Access(Writer):
    """``settled`` are locals that are surely written before they are read, ``unsettled`` the others."""

    def _use_local(self, text: str) -> None:
        if text not in self.settled:
            self.unsettled.add(text)

    def _load(self, operand: Const | Place) -> Expression:
        if isinstance(operand, Const):
            return ex.constant(self.pool.rounded(operand), operand.type)
        root = self.names.root(operand)
        if root.text.startswith("l_"):
            self._use_local(root.text)
        value = Expression(root.text, operand.type, reads=frozenset((root.key,)))
        if root.packed and not operand.steps:
            value.depth = 1
        for number, step in enumerate(operand.steps, 1):
            value = self._step(value, step, operand.type, operand.steps[number:])
        return value

    def _step(self, value: Expression, step: object, type_: Type, rest: Sequence[object]) -> Expression:
        match step:
            case FieldStep(name):
                return Expression(f"{value.text}.{slot(name)}", type_, reads=value.reads)
            case BitStep():
                text, _ = ex.within(value, ex.BIT_AND)
                return Expression(f"{text} & {step.weight} != 0", BOOL, ex.COMPARE, value.reads)
            case IndexStep():
                offset = constant_offset(step)
                if offset is not None:
                    return Expression(f"{value.text}[{offset}]", type_, reads=value.reads)
                index = self._offset(step)
                name = self._fresh()
                self._emit(f"{name} = {value.text}[{index}]")
                # What is read of an element is read later, a value is read now.
                is_value = not rest or type(rest[0]) is BitStep
                return Expression(name, type_, reads=ex.NOTHING if is_value else value.reads)
        raise BadCode(f"no such step: {step!r}")

    def _offset(self, step: IndexStep) -> str:
        """The checked flat offset as Python text; evaluates the indexes now, in order."""
        parts = []
        for index, (low, high), stride in zip(step.indexes, step.bounds, strides(step.bounds), strict=True):
            operand = index if isinstance(index, Const) else index.place
            at = self._load(operand)
            name = self._fresh()
            shift = f" - {low}" if low > 0 else f" + {-low}" if low else ""
            text, _ = ex.within(at, ex.SUM)
            self._emit(f"{name} = {text}{shift}")
            self._emit(f"if not 0 <= {name} <= {high - low}: _bad_index({name}, {low}, {high})")
            parts.append(name if stride == 1 else f"{name} * {stride}")
        return " + ".join(parts)

    def _target(self, place: Place) -> tuple[str, Callable[[str], str] | None]:
        """What to assign to: ``(python target, None)``, or a function from value text to a statement."""
        root = self.names.root(place)
        self._hazard(root, place)
        if root.text.startswith("l_"):
            self._settle(root.text, not place.steps)
        if root.packed and is_single(root.packed):
            return "", self._packed_store(root.packed, place)
        if not place.steps:
            if root.packed:
                return "", lambda value: f"{root.text}[:] = {value}"
            if root.cell:
                self.written.add(root.cell)
            return root.text, None
        text = root.text
        for step in place.steps:
            match step:
                case FieldStep(name):
                    text = f"{text}.{slot(name)}"
                case IndexStep():
                    offset = constant_offset(step)
                    text = f"{text}[{self._offset(step) if offset is None else offset}]"
                case BitStep():
                    if root.cell and len(place.steps) == 1:
                        self.written.add(root.cell)
                    return "", _bit_store(text, step.weight)
        return text, None

    def _hazard(self, root: Root, place: Place) -> None:
        self._before_store(None if root.shared and place.steps else root.key)

    def _settle(self, local: str, whole: bool) -> None:
        if whole and local not in self.unsettled and self.indent == 1 and not self.plan.segments:
            self.settled.add(local)
        elif local not in self.settled:
            self.unsettled.add(local)

    def _packed_store(self, home: Packed, place: Place) -> Callable[[str], str]:
        if place.steps:
            bit = place.steps[-1].bit
            at = f"{home.name}[{home.location.byte + bit // 8}]"
            return _bit_store(at, 1 << bit % 8)
        if home.location.size == "X":
            return _bit_store(f"{home.name}[{home.location.byte}]", 1 << home.location.bit)
        view = self.names.root(place).text.removesuffix(".get()")
        return lambda value: f"{view}.set({value})"

    def _store(self, place: Place, value: Expression) -> None:
        target, statement = self._target(place)
        value = self._cut(self._whole(value), place.type)
        self._emit(statement(value.text) if statement else f"{target} = {value.text}")

    def _cut(self, value: Expression, type_: Type) -> Expression:
        """What is stored of the value: strings cut to their variable, aggregates copied."""
        if isinstance(type_, String):
            if isinstance(value.type, String) and value.type.length <= type_.length:
                return value
            text, depth = ex.within(value, ex.ATOM)
            return Expression(f"{text}[:{type_.length}]", type_, ex.ATOM, value.reads, depth + 1)
        if not is_scalar(type_):
            return Expression(f"{self.pool.copier(type_)}({value.text})", type_, ex.ATOM, value.reads, 1)
        return value


def _bit_store(target: str, mask: int) -> Callable[[str], str]:
    return lambda value: f"{target} = {target} | {mask} if {value} else {target} & {~mask}"
