"""A check of typed IL itself: what every engine may take for granted about a unit.

Only for our own faults: a unit that comes from ``lower`` or ``text`` has no findings.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from ldc.expr import Const, Expr, IndexStep, Load, Place
from ldc.il.accumulator import allowed
from ldc.il.program import ARITHMETIC, COMPARISON, LOGIC, NUMBER, STORES, Instr, Operand, RungCode, Unit
from ldc.library import functions
from ldc.records import record
from ldc.symbols import Variable
from ldc.types import BOOL, Instance, String, Type, is_scalar, storage

_NEGATED = {op + "N": op for op in LOGIC}
_OPERATORS = frozenset((*LOGIC, *_NEGATED, *ARITHMETIC, *COMPARISON))
_CONDITIONAL = frozenset(("JMPC", "JMPCN", "CALC", "CALCN", "RETC", "RETCN"))
_CONTROL = frozenset(("JMP", "LABEL", "CAL", "RET")) | _CONDITIONAL


@record
class Finding:
    """What is wrong with instruction ``index`` of the rung ``rung``."""

    rung: str
    index: int
    message: str

    def __str__(self) -> str:
        return f"{self.rung}[{self.index}]: {self.message}"


def check_unit(unit: Unit, units: Iterable[Unit] = ()) -> list[Finding]:
    """Types of every instruction, labels, parentheses, variables, the accumulator. ``units``: the
    FUNCTIONs that it may call; calls of others are not looked into."""
    known = {u.name.upper(): u for u in units}
    variables = {v.name.upper(): v for v in unit.variables}
    labels = [r.label for r in unit.rungs if r.label is not None]
    labels += [i.name for r in unit.rungs for i in r.code if i.op == "LABEL"]
    findings = [Finding("", -1, f"label {name} stands twice")
                for name, count in Counter(labels).items() if count > 1]
    targets = frozenset(labels)
    for rung in unit.rungs:
        findings += _Check(rung, variables, targets, known).run()
    return findings


class _Check:
    """Walks one rung with the type of the accumulator (None: undefined) and the open parentheses."""

    def __init__(self, rung: RungCode, variables: dict[str, Variable], labels: frozenset[str],
                 units: dict[str, Unit]) -> None:
        self.rung, self.variables, self.labels, self.units = rung, variables, labels, units
        self.acc: Type | None = None
        self.stack: list[tuple[Instr, Type | None]] = []

    def run(self) -> Iterator[Finding]:
        for index, instr in enumerate(self.rung.code):
            if instr.op not in NUMBER:
                yield Finding(self.rung.key, index, f"unknown operation {instr.op}")
                continue
            for message in (*self._operands(instr), *self._instruction(instr)):
                yield Finding(self.rung.key, index, f"{instr.op}: {message}")
        if self.stack:
            yield Finding(self.rung.key, len(self.rung.code), "a parenthesis is never closed")

    # -- operands

    def _operands(self, instr: Instr) -> Iterator[str]:
        for operand in (instr.operand, *instr.args, *(p for _, p in instr.outputs)):
            if isinstance(operand, Place):
                yield from self._place(operand)

    def _place(self, place: Place) -> Iterator[str]:
        if not place.is_global:
            variable = self.variables.get(place.root.upper())
            if variable is None:
                yield f"there is no variable {place.root}"
            elif not place.steps and variable.type != place.type:
                yield f"{place.root} is {variable.type}, not {place.type}"
        for step in place.steps:
            if isinstance(step, IndexStep):
                for index in step.indexes:
                    yield from self._index(index)

    def _index(self, index: Expr) -> Iterator[str]:
        if isinstance(index, Load):
            yield from self._place(index.place)
        elif not isinstance(index, Const):
            yield "an index is an expression"

    # -- instructions

    def _instruction(self, instr: Instr) -> Iterator[str]:
        op = instr.op
        if op in _CONTROL:
            yield from self._control(instr)
        elif op in ("LD", "LDN"):
            yield from self._matches(instr)
            if op == "LDN" and not allowed("NOT", instr.type):
                yield f"{instr.type} cannot be negated"
            self.acc = instr.type
        elif op in STORES:
            yield from self._store(instr)
        elif op == "FN":
            yield from self._function(instr)
        elif op == "NOT":
            yield from self._needs(instr.type)
            if not allowed(op, instr.type):
                yield f"{instr.type} cannot be negated"
        elif op == ")":
            yield from self._close(instr)
        elif op[-1] == "(":
            yield from self._needs(instr.type)
            self.stack.append((instr, self.acc))
            self.acc = instr.operand.type if instr.operand is not None else None
        elif op in _OPERATORS:
            yield from self._needs(instr.type)
            yield from self._matches(instr)
            yield from self._join(op, instr.type)

    def _needs(self, type_: Type) -> Iterator[str]:
        if self.acc is None:
            yield "the accumulator is undefined"
        elif not alike(self.acc, type_):
            yield f"the accumulator is {self.acc}, not {type_}"

    def _matches(self, instr: Instr) -> Iterator[str]:
        operand: Operand | None = instr.operand
        if operand is None:
            yield "the operand is missing"
        elif not alike(operand.type, instr.type):
            yield f"{_text(operand)} is {operand.type}, not {instr.type}"

    def _join(self, op: str, type_: Type) -> Iterator[str]:
        plain = _NEGATED.get(op, op)
        if not is_scalar(type_) or not allowed(plain, storage(type_)):
            yield f"does not work on {type_}"
        self.acc = BOOL if plain in COMPARISON else type_

    def _close(self, instr: Instr) -> Iterator[str]:
        if not self.stack:
            yield "nothing is open"
            return
        opened, _ = self.stack.pop()
        if not alike(instr.type, opened.type):
            yield f"closes {opened.op} of {opened.type} as {instr.type}"
        yield from self._needs(opened.type)
        yield from self._join(opened.op[:-1], opened.type)

    def _store(self, instr: Instr) -> Iterator[str]:
        if not isinstance(instr.operand, Place):
            yield "stores to no variable"
            return
        yield from self._matches(instr)
        if instr.op in ("S", "R"):
            yield from self._needs(BOOL)
        yield from self._needs(instr.operand.type)
        if instr.op == "STN" and not allowed("NOT", instr.type):
            yield f"{instr.type} cannot be negated"

    def _function(self, instr: Instr) -> Iterator[str]:
        unit = self.units.get(instr.name.upper())
        if unit is not None or not functions.is_function(instr.name) and functions.lookup(instr.name) is None:
            yield from self._user_function(instr, unit)
        else:
            found = functions.resolve(instr.name, (self.acc, *(a.type for a in instr.args)))
            if self.acc is None:
                yield "the accumulator is undefined"
            elif isinstance(found, str):
                yield found
            else:
                given = (self.acc, *(a.type for a in instr.args))
                if not all(alike(a, b) for a, b in zip(given, found.parameters)):
                    yield f"{instr.name} takes {', '.join(map(str, found.parameters))}"
                if not alike(found.result, instr.type):
                    yield f"{instr.name} gives {found.result}, not {instr.type}"
        self.acc = instr.type

    def _user_function(self, instr: Instr, unit: Unit | None) -> Iterator[str]:
        if unit is None:
            return
        pins = unit.arguments
        given = [self.acc, *(a.type for a in instr.args)] if pins else []
        if len(given) != len(pins) or not all(
                a is not None and alike(a, pin.type) for a, pin in zip(given, pins)):
            yield f"{unit.name} takes {', '.join(str(p.type) for p in pins) or 'nothing'}"
        outputs = {v.name.upper(): v.type for v in unit.variables if v.kind in ("output", "in_out")}
        for name, place in instr.outputs:
            type_ = outputs.get(name.upper())
            if type_ is None or not alike(type_, place.type):
                yield f"{unit.name} has no output {name} of {place.type}"
        if unit.result is not None and not alike(unit.result, instr.type):
            yield f"{unit.name} gives {unit.result}, not {instr.type}"

    def _control(self, instr: Instr) -> Iterator[str]:
        op = instr.op
        if self.stack:
            yield "stands within parentheses"
        if op in _CONDITIONAL:
            yield from self._needs(BOOL)
        if op[:3] == "JMP" and instr.name not in self.labels:
            yield f"there is no label {instr.name}"
        if op[:3] == "CAL":
            called = instr.operand
            if not isinstance(called, Place) or not isinstance(called.type, Instance):
                yield "calls no instance"
        if op not in _CONDITIONAL:
            self.acc = None


def alike(a: Type, b: Type) -> bool:
    """Whether values of both types are stored alike; the length of a string does not count."""
    a, b = storage(a), storage(b)
    return a == b or isinstance(a, String) and isinstance(b, String) and a.name == b.name


def _text(operand: Operand) -> str:
    return str(operand) if isinstance(operand, Place) else repr(operand.value)
