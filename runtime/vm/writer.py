"""Python lines under construction: temporaries, and what must be evaluated before something changes."""

from __future__ import annotations

from ldc.il.control import Plan, plan
from ldc.il.flat import Flat, flatten
from ldc.il.pieces import FORGETS
from ldc.il.program import Unit
from ldc.types import Type
from runtime.vm import expression as ex
from runtime.vm.calls import Calls
from runtime.vm.expression import Expression
from runtime.vm.names import Names

LONGEST, DEEPEST = 600, 25


class BadCode(Exception):
    """IL that verification should have refused; a bug of the compiler, never of the user."""


class Writer:
    """The state of the translation of one unit. ``function``: the Python name to define; ``pool``: what the
    code of all units calls. ``at`` is the flat position of the instruction in work; ``acc`` the accumulator,
    None when undefined; ``stack`` the deferred (operator, left operand, type)."""

    def __init__(self, unit: Unit, names: Names, function: str, pool: Calls) -> None:
        self.unit, self.names, self.pool, self.function = unit, names, pool, function
        self.flat: Flat = flatten(unit)
        self.plan: Plan = plan(self.flat)
        self.lines: list[str] = []
        self.origins: list[int] = []
        self.indent = 1
        self.at = -1
        self.temporaries = 0
        self.written: set[str] = set()
        self.acc: Expression | None = None
        self.stack: list[tuple[str, Expression | None, Type]] = []
        self.settled: set[str] = set()
        self.unsettled: set[str] = set()

    def _emit(self, text: str) -> None:
        self.lines.append(" " * self.indent + text)
        self.origins.append(self.at)

    def _fresh(self) -> str:
        self.temporaries += 1
        return f"t{self.temporaries}"

    def _spill(self, value: Expression) -> Expression:
        """Evaluates now, into a local that nothing else writes."""
        value = self._whole(value)
        name = self._fresh()
        self._emit(f"{name} = {value.text}")
        return Expression(name, value.type)

    def _whole(self, value: Expression) -> Expression:
        return ex.wrapped(value, self._fresh()) if value.unwrapped else value

    def _small(self, value: Expression) -> Expression:
        """The value, evaluated now when its text is too long or too deep for the Python compiler."""
        return self._spill(value) if value.depth > DEEPEST or len(value.text) > LONGEST else value

    def _accumulator(self) -> Expression:
        if self.acc is None:
            raise BadCode(f"{self.unit.name}: the accumulator is undefined at instruction {self.at}")
        return self.acc

    def _live(self) -> bool:
        """Whether the next instruction uses the accumulator."""
        following = self.at + 1
        if following >= len(self.flat.code) or following in self.flat.labels:
            return False
        instr = self.flat.code[following]
        if instr.op == "FN":
            return not self.pool.ignores_accumulator(instr.name)
        return instr.op not in FORGETS

    def _before_store(self, key: str | None) -> None:
        """Evaluates what reads ``key`` (None: anything that is not a local of ours) and is still needed."""
        for i, (op, left, type_) in enumerate(self.stack):
            if left is not None and left.reads and (key is None or key in left.reads):
                self.stack[i] = (op, self._spill(left), type_)
        acc = self.acc
        if acc is not None and acc.reads and (key is None or key in acc.reads) and self._live():
            self.acc = self._spill(acc)

    def _keep(self) -> Expression:
        """The accumulator as something that may be written twice."""
        acc = self._whole(self._accumulator())
        if not acc.is_atom and self._live():
            acc = self._spill(acc)
        self.acc = acc
        return acc

    def _settle_stack(self) -> None:
        """Evaluates all deferred operands: what follows may change anything or be skipped."""
        for i, (op, left, type_) in enumerate(self.stack):
            if left is not None and (left.reads or not left.is_atom):
                self.stack[i] = (op, self._spill(left), type_)
