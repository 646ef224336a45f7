"""Structured IL as the lines of C functions.

Nothing branches but jumps, calls and faults: BOOLs are bytes that are 0 or 1, joined by ``&`` and ``|``.
What can fault is a statement that leaves the function with the place of the fault (docs/native.md).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from ldc.backends.c import components, functions
from ldc.backends.c.ctypes import by_address, is_string, width
from ldc.backends.c.places import Address
from ldc.backends.c.values import Callee, Values
from ldc.expr import Apply, Expr, Load
from ldc.il.pieces import Passes
from ldc.il.statements import (
    Assign, CallBlock, CallFunction, CallNative, Goto, Label, Latch, Return, Statement)
from ldc.il.structure import may_fault
from ldc.types import Array, Type, storage


@dataclass(slots=True)
class Part(Values):
    """One C function in work. ``callees``: POUs by name in capitals; ``labels``: the C label of a flat
    position of this part; ``far``: the number by which a part is left for a label of another one; ``passes``:
    what further passes of loops cost, None: nobody asks."""

    callees: Mapping[str, Callee] = field(default_factory=dict)
    labels: Mapping[int, str] = field(default_factory=dict)
    passes: Passes | None = None
    far: Mapping[int, int] = field(default_factory=dict)
    _line: tuple[str, int] | None = None

    def add(self, statements: Iterable[Statement]) -> None:
        """Translates statements, in order."""
        for statement in statements:
            self.at = statement.at
            if not isinstance(statement, Label):
                self._source()
            _STATEMENTS[type(statement)](self, statement)

    def _source(self) -> None:
        """A ``#line`` where the next statement stands on another line of the sources."""
        rung, index = self.code.flat.places[self.at]
        body = self.code.unit.rungs[rung]
        span = body.code[index].span or body.span
        if span is None:
            return
        at = span.source.name, span.position[0]
        if at != self._line:
            self._line = at
            path = at[0].replace("\\", "\\\\").replace('"', '\\"').replace("\n", " ")
            self.lines.append(f'#line {at[1]} "{path}"')

    # ---- statements

    def assign(self, statement: Assign) -> None:
        value = statement.value
        if isinstance(value, Apply) and alone(value):
            if is_string(value.type):
                into = self.read(*self.checked(statement.target))
                args = [(self.expr(a), a.type) for a in value.args]
                self.lines += functions.text(value.op, args, value.type, into)
                return
            divisor = self.expr(value.args[1])
            self.lines.append(f"if (LDC_RARE({divisor} == 0)) return ldc_division({self.where()});")
        elif isinstance(value, Load) and may_fault(value):
            self._copy(statement.target, value.type, *self.checked(value.place))
            return
        elif isinstance(value, Load) and by_address(value.type):
            self._copy(statement.target, value.type, self.names.reach(value.place).address)
            return
        text = self.expr(value)
        target, more = self.checked(statement.target)
        self._store(target, more, text, value.type)

    def _copy(self, target, type_: Type, at: Address, more: str = "") -> None:
        """A value from a place; arrays of image bits are unpacked and packed."""
        if at.bit is not None and isinstance(type_, Array):
            into = self.whole(*self.checked(target))
            self.lines.append(f"ldc_unpack({into}, {at.base} + {at.offset}, {at.bit}, {type_.count});")
            return
        self._store(*self.checked(target), self.read(at, more), type_)

    def _store(self, at: Address, more: str, text: str, type_: Type) -> None:
        if at.bit is not None and isinstance(type_, Array):
            self.lines.append(f"ldc_pack({at.base} + {at.offset}, {at.bit}, {text}, {type_.count});")
        elif at.bit is not None and more:
            self.lines.append(f"ldc_put_bit({at.base} + {at.offset}, {at.bit}{more}, {text});")
        elif at.bit is not None or at.part is not None:
            target, c, bit = self._bits(at, more)
            kept = f"({c})~(({c})1 << {bit})"
            self.lines.append(f"{target} = ({c})((({c}){target} & {kept}) | ({c})(({c}){text} << {bit}));")
        elif is_string(at.type):
            self.lines.append(f"ldc_put({self.whole(at, more)}, {at.type.length}, {text}, {width(at.type)});")
        elif by_address(at.type):
            size = self.names.block.measure(at.type)
            self.lines.append(f"__builtin_memmove({self.whole(at, more)}, {text}, {size});")
        else:
            self.lines.append(f"{self.whole(at, more)} = {text};")

    def _bits(self, at: Address, more: str) -> tuple[str, str, int]:
        """For one bit of something: what holds it, the unsigned C type of that, the number of the bit."""
        if at.bit is not None:
            return f"LDC_AT(uint8_t, {at.base}, {at.offset})", "uint8_t", at.bit
        return self.whole(at, more), f"uint{storage(at.whole).bits}_t", at.part

    def latch(self, statement: Latch) -> None:
        reach = self.names.reach(statement.target)
        condition = self.expr(statement.condition)
        if reach.indexes:
            self.lines.append(f"if ({condition}) {{")
            self._store(*self.checked(statement.target), str(int(statement.value)), statement.target.type)
            self.lines.append("}")
            return
        at = reach.address
        if at.bit is None and at.part is None:
            target = self.whole(at, "")
            change = f"|= {condition}" if statement.value else f"&= !{condition}"
            self.lines.append(f"{target} {change};")
            return
        target, c, bit = self._bits(at, "")
        mask = f"({c})(({c}){condition} << {bit})"
        self.lines.append(f"{target} |= {mask};" if statement.value else f"{target} &= ({c})~{mask};")

    def call_block(self, statement: CallBlock) -> None:
        callee = self.callees[statement.instance.type.pou.upper()]
        if statement.condition is not None:
            self.lines.append(f"if ({self.expr(statement.condition)}) {{")
        at, more = self.checked(statement.instance)
        self._called(callee, f"{self.shared.call(callee)}(m, {at.base} + {at.offset}{more})")
        if statement.condition is not None:
            self.lines.append("}")

    def _called(self, callee: Callee, call: str) -> None:
        self.lines.append(f"if (LDC_RARE({call})) return ldc_note({self.where()});" if callee.faults
                          else f"{call};")

    def call_function(self, statement: CallFunction) -> None:
        callee = self.callees[statement.function.name.upper()]
        args = ["m"]
        for given in statement.arguments:
            args.append(self.expr(given))
        wanted = {name.upper(): place for name, place in statement.outputs}
        if statement.function.result is not None:
            args.append(self._out(statement.result))
        for variable in statement.function.variables:
            if variable.kind in ("output", "in_out"):
                place = wanted.get(variable.name.upper())
                args.append("0" if place is None else self._out(place))
        self._called(callee, f"{self.shared.call(callee)}({', '.join(args)})")

    def _out(self, place) -> str:
        """The address of a temporary that takes an output."""
        at = self.names.reach(place).address
        return ("" if by_address(at.type) else "&") + self.whole(at, "")

    def call_native(self, statement: CallNative) -> None:
        callee = components.callee(self.code.unit)
        self.lines.append(f"{self.shared.call(callee)}(m, s, {self.expr(statement.elapsed)});")

    def label(self, statement: Label) -> None:
        if statement.at in self.labels:
            self.lines.append(f"{self.labels[statement.at]}:;")

    def goto(self, statement: Goto) -> None:
        steps = []
        if statement.target <= statement.at:
            steps.append(f"if (LDC_RARE(!LDC_SYSTEM(m)->watchdog--)) return ldc_expired({self.where()});")
            cost = 0 if self.passes is None else self.passes.cost(statement.at, statement.target)
            if cost:
                steps.append(f"LDC_SYSTEM(m)->spent += {cost};")
        near = self.labels.get(statement.target)
        steps.append(f"goto {near};" if near else f"return {self.far[statement.target]};")
        self._when(statement.condition, steps)

    def leave(self, statement: Return) -> None:
        self._when(statement.condition, ["return LDC_RETURN;"])

    def _when(self, condition: Expr | None, steps: list[str]) -> None:
        text = " ".join(steps)
        self.lines.append(text if condition is None else f"if ({self.expr(condition)}) {{ {text} }}")


def alone(expr: Apply | Load) -> bool:
    """Nodes that become statements of their own: what can fault, and strings that are made."""
    if isinstance(expr, Apply) and is_string(expr.type):
        return expr.op not in functions.CHOICES
    return may_fault(expr)


_STATEMENTS: dict[type, Callable] = {
    Assign: Part.assign, Latch: Part.latch, CallBlock: Part.call_block, CallFunction: Part.call_function,
    CallNative: Part.call_native, Label: Part.label, Goto: Part.goto, Return: Part.leave,
}
