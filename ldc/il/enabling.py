"""EN and ENO of calls in IL text: what they jump over, and what they tell (docs/il.md).

While EN is FALSE nothing is called, outputs keep their values, the result of a function is 0 and ENO is
FALSE.
"""

from __future__ import annotations

from ldc.expr import Const, Place
from ldc.il.arguments import argument_value, load, name_span
from ldc.il.machine import Machine
from ldc.il.scan import Argument
from ldc.model import call_findings
from ldc.model.values import same
from ldc.model.wiring import EN
from ldc.symbols import Signature
from ldc.types import BOOL, Type, default, is_scalar


class Enabling:
    """EN and ENO of one call. ``add`` takes them out of its arguments; the code of the call stands between
    ``begin`` and ``end``."""

    def __init__(self, machine: Machine) -> None:
        self.machine = machine
        self.enable: Argument | None = None
        self.told: Argument | None = None
        self._flag: Place | None = None
        self._result: Place | None = None
        self._skip = ""

    def add(self, argument: Argument, signature: Signature | None = None) -> bool:
        """Whether the argument is EN or ENO, and no pin that the block itself declares."""
        key = argument.name.upper() if argument.name is not None else ""
        if key not in ("EN", "ENO") or argument.output != (key == "ENO"):
            return False
        if signature is not None and signature.pin(key) is not None:
            return False
        first = self.told if argument.output else self.enable
        if first is not None:
            call_findings.pin_twice(self.machine.diagnostics, name_span(self.machine, argument), key,
                                    "given again", name_span(self.machine, first), "leave one of the two out")
        elif argument.output:
            self.told = argument
        else:
            self.enable = argument
        return True

    def begin(self, result: Type | None = None) -> None:
        """``result``: that of a function, which is 0 when it is not called."""
        machine = self.machine
        if self.enable is None:
            return
        self._open(result)
        value = argument_value(machine, self.enable, EN)
        if value is not None:
            load(machine, value)
        self._only_when_set()

    def divide(self, divisor: Place | Const, result: Type) -> None:
        """With ENO a division by 0 is not made, and ENO tells."""
        if self.told is None:
            return
        if self._flag is None:
            self._open(result)
        self.machine.emit("LD", divisor, divisor.type)
        self.machine.emit("NE", Const(default(divisor.type), divisor.type), divisor.type)
        self._only_when_set()

    def end(self) -> None:
        machine = self.machine
        if self._result is not None:
            machine.emit("ST", self._result, self._result.type)
        if self._skip:
            machine.emit("LABEL", name=self._skip)
        target = None
        if self.told is not None:
            target = machine.operands.place(self.told.start, self.told.end, write=True)
        if target is not None and not same(target.type, BOOL):
            machine.mismatch("ENO", BOOL, target.type)
        elif target is not None:
            machine.emit("LD", self._flag or Const(True, BOOL))
            machine.emit("STN" if self.told.negated else "ST", target)
        if self._result is not None:
            machine.emit("LD", self._result, self._result.type)

    def _open(self, result: Type | None) -> None:
        machine = self.machine
        machine.define(None)
        self._flag, self._skip = machine.temp(BOOL), machine.label()
        if result is not None:
            self._result = machine.temp(result)
            if is_scalar(result):
                machine.emit("LD", Const(default(result), result), result)
                machine.emit("ST", self._result, result)

    def _only_when_set(self) -> None:
        """What follows is done when the accumulator is TRUE."""
        self.machine.emit("ST", self._flag)
        self.machine.emit("JMPCN", name=self._skip)


def apart(machine: Machine, arguments: list[Argument], signature: Signature
          ) -> tuple[list[Argument], Enabling]:
    """The other arguments of a call, and its EN and ENO."""
    enabling = Enabling(machine)
    return [a for a in arguments if not enabling.add(a, signature)], enabling
