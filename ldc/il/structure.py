"""IL as statements with typed expressions: what backends for other languages start from.

The accumulator is executed symbolically: it is an expression until a store, call or jump needs it. What
an unevaluated expression reads is evaluated into a temporary before a statement changes it, so the
statements, in their order, do what the instructions do. Expressions are those of ``ldc.expr``; they are
pure, no deeper than ``DEEPEST``, and a FUNCTION of the project is never inside of one.

Left to the backend: indexes of targets are checked when their statement is executed (of ``Latch`` and
``CallBlock`` only when the condition holds), in the order written; strings are cut and structures copied
by ``Assign``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from ldc.expr import Apply, Const, Expr, IndexStep, Load, Place
from ldc.il.flat import Flat, flatten
from ldc.il.homes import INTRINSIC
from ldc.il.pieces import FORGETS, seams
from ldc.il.program import COMPARISON, LOGIC, Instr, Unit
from ldc.il.statements import (
    Assign, CallBlock, CallFunction, CallNative, Goto, Label, Latch, Return, Statement)
from ldc.records import record
from ldc.symbols import Location, Variable
from ldc.types import BOOL, Type, holds_blocks

DEEPEST = 40
_NOTHING: frozenset[str] = frozenset()
_EVERYTHING = "*"


@record
class Structured:
    """``temporaries`` are those that were made for the statements, beside ``unit.variables``; each is
    written before it is read. ``seams``: positions of rungs that take over none of them from before."""

    unit: Unit
    flat: Flat
    statements: tuple[Statement, ...]
    temporaries: tuple[Variable, ...]
    seams: frozenset[int]


def may_fault(expr: Apply | Load) -> bool:
    """Whether evaluating the node itself (not its arguments) can end in a run-time fault: a division by
    what is no constant other than 0, an index that is computed."""
    if isinstance(expr, Load):
        return bool(expr.place.steps) and any(
            isinstance(i, Load) for i in expr.place.indexes())
    if expr.op not in ("DIV", "MOD", "DIVTIME"):
        return False
    divisor = expr.args[1]
    return not isinstance(divisor, Const) or not divisor.value


def structure(unit: Unit, functions: Mapping[str, Unit], shared: Iterable[Variable] = (),
              alone: Callable[[Apply | Load], bool] = may_fault) -> Structured:
    """The statements of a unit of a verified program.

    ``functions``: the FUNCTIONs of the project by name in capitals; ``shared``: the global variables;
    ``alone`` tells the nodes that are to be the whole value of an ``Assign``, evaluated in order.
    Raises ValueError for IL that no verified program holds, LookupError for a missing label.
    """
    return _Structure(unit, functions, shared, alone).run()


@dataclass(slots=True)
class _Value:
    """``reads``: keys of what the expression depends on; ``depth``: how deep it nests."""

    expr: Expr
    reads: frozenset[str] = _NOTHING
    depth: int = 0

    @property
    def type(self) -> Type:
        return self.expr.type


class _Structure:
    def __init__(self, unit: Unit, functions: Mapping[str, Unit], shared: Iterable[Variable],
                 alone: Callable[[Apply | Load], bool]) -> None:
        self.unit, self.functions, self.alone = unit, functions, alone
        self.flat = flatten(unit)
        self.kinds = {v.name.upper(): v.kind for v in unit.variables}
        self.globals = {v.name.upper(): v for v in shared}
        self.located = {v.name.upper(): v.location for v in unit.variables if v.location}
        self.keys: dict[tuple[str, bool], str | None] = {}
        self.made: list[Statement] = []
        self.temporaries: dict[str, Variable] = {}
        self.counts: dict[Type, int] = {}
        self.stems: dict[Type, str] = {}
        self.stack: list[tuple[str, _Value | None, Type]] = []
        self.acc: _Value | None = None
        self.at = 0

    def run(self) -> Structured:
        handlers = _HANDLERS
        begins = frozenset(seams(self.flat))
        for at, instr in enumerate(self.flat.code):
            self.at = at
            if at in self.flat.labels:
                self.acc = None
                self.made.append(Label(at))
            if at in begins:
                self.counts.clear()
            handlers[instr.op](self, instr)
        if len(self.flat.code) in self.flat.labels:
            self.made.append(Label(len(self.flat.code)))
        if self.stack:
            raise ValueError(f"{self.unit.name}: {len(self.stack)} parentheses are open at the end")
        return Structured(self.unit, self.flat, tuple(self.made), tuple(self.temporaries.values()),
                          begins)

    # ---- values

    def temporary(self, type_: Type) -> Place:
        """A new one; numbers begin again in every rung, as nothing is kept from one to the next."""
        stem = self.stems.get(type_)
        if stem is None:
            # From the type alone where it can be, so that an edit elsewhere renames nothing here.
            plain = stem = "_ldc_v_" + "".join(c for c in str(type_).lower() if c.isalnum())
            while stem in self.stems.values():
                stem = f"{plain}_{len(self.stems)}"
            self.stems[type_] = stem
        number = self.counts[type_] = self.counts.get(type_, 0) + 1
        name = f"{stem}_{number}"
        if name not in self.temporaries:
            self.temporaries[name] = Variable(name, type_, "temp")
        return Place(name, type_)

    def key(self, place: Place) -> str | None:
        """What stores and loads of one variable, and of those that may overlap with it, have in common;
        None for what the program cannot change."""
        known = (place.root, place.is_global)
        if known not in self.keys:
            self.keys[known] = self._key(place.root.upper(), place.is_global)
        return self.keys[known]

    def _key(self, name: str, is_global: bool) -> str | None:
        if is_global and name in INTRINSIC:
            return None
        if name[0] == "%":
            return "%" + Location.parse(name).area
        if is_global or self.kinds[name] == "external":
            declared = self.globals.get(name)
            if declared is not None and declared.location:
                return "%" + declared.location.area
            # The instance that is executed may be a global one: its members are reached by two names.
            instance = declared is None or holds_blocks(declared.type)
            return _EVERYTHING if instance else "global " + name
        return "%" + self.located[name].area if name in self.located else name

    def load(self, operand: Const | Place) -> _Value:
        if isinstance(operand, Const):
            return _Value(operand)
        key = self.key(operand)
        reads = {key} if key else set()
        for step in operand.steps:
            if isinstance(step, IndexStep):
                reads |= {k for i in step.indexes if isinstance(i, Load) and (k := self.key(i.place))}
        value = _Value(Load(operand), frozenset(reads))
        return self.spilled(value) if self.alone(value.expr) else value

    def apply(self, op: str, args: tuple[_Value, ...], type_: Type) -> _Value:
        reads, depth = _NOTHING, 0
        for arg in args:
            reads, depth = reads | arg.reads, max(depth, arg.depth)
        depth += 1
        value = _Value(Apply(op, tuple(a.expr for a in args), type_), reads, depth)
        return self.spilled(value) if depth >= DEEPEST or self.alone(value.expr) else value

    def spilled(self, value: _Value) -> _Value:
        """Evaluates now, into a temporary that nothing else writes."""
        place = self.temporary(value.type)
        self.made.append(Assign(self.at, place, value.expr))
        return _Value(Load(place))

    def inverted(self, value: _Value) -> _Value:
        expr = value.expr
        if isinstance(expr, Const) and expr.type == BOOL:
            return _Value(Const(not expr.value, BOOL))
        return self.apply("NOT", (value,), value.type)

    def accumulator(self) -> _Value:
        if self.acc is None:
            raise ValueError(f"{self.unit.name}: the accumulator is undefined at instruction {self.at}")
        return self.acc

    def live(self) -> bool:
        """Whether the next instruction uses the accumulator."""
        following = self.at + 1
        if following >= len(self.flat.code) or following in self.flat.labels:
            return False
        instr = self.flat.code[following]
        return not self.nullary(instr.name) if instr.op == "FN" else instr.op not in FORGETS

    def nullary(self, name: str) -> bool:
        function = self.functions.get(name.upper())
        return function is not None and not function.arguments

    def keep(self) -> _Value:
        """The accumulator as something that may be used twice."""
        acc = self.accumulator()
        if acc.depth and self.live():
            acc = self.acc = self.spilled(acc)
        return acc

    def before(self, key: str) -> None:
        """Evaluates what reads ``key`` (``*``: anything that can be changed) and is still needed."""
        def hit(reads: frozenset[str]) -> bool:
            return bool(reads) and (key == _EVERYTHING or key in reads or _EVERYTHING in reads)

        for i, (op, left, type_) in enumerate(self.stack):
            if left is not None and hit(left.reads):
                self.stack[i] = op, self.spilled(left), type_
        if self.acc is not None and hit(self.acc.reads) and self.live():
            self.acc = self.spilled(self.acc)

    def settle(self) -> None:
        """Evaluates all deferred operands: what follows may change anything or be skipped."""
        for i, (op, left, type_) in enumerate(self.stack):
            if left is not None and (left.reads or left.depth):
                self.stack[i] = op, self.spilled(left), type_

    # ---- instructions

    def ld(self, instr: Instr) -> None:
        value = self.load(instr.operand)
        self.acc = self.inverted(value) if instr.op == "LDN" else value

    def st(self, instr: Instr) -> None:
        value = self.keep()
        if instr.op == "STN":
            value = self.inverted(value)
        self.store(instr.operand, value)

    def store(self, target: Place, value: _Value) -> None:
        # A bit or an element changes the whole variable as well.
        self.before(self.key(target) or _EVERYTHING)
        self.made.append(Assign(self.at, target, value.expr))

    def latch(self, instr: Instr) -> None:
        condition = self.keep()
        if isinstance(condition.expr, Const) and not condition.expr.value:
            return
        expr = condition.expr
        self.before(self.key(instr.operand) or _EVERYTHING)
        self.made.append(Latch(self.at, instr.operand, expr, instr.op == "S"))

    def invert(self, instr: Instr) -> None:
        self.acc = self.inverted(self.accumulator())

    def operator(self, instr: Instr) -> None:
        left = self.accumulator()
        # Loading may spill an element; what the left side reads is not changed by that.
        self.combine(instr.op, left, self.load(instr.operand), instr.type)

    def combine(self, op: str, left: _Value, right: _Value, type_: Type) -> None:
        if op in ("ANDN", "ORN", "XORN"):
            op, right = op[:-1], self.inverted(right)
        result = BOOL if op in COMPARISON else left.type if op in LOGIC else type_
        self.acc = self.apply(op, (left, right), result)

    def open(self, instr: Instr) -> None:
        self.stack.append((instr.op[:-1], self.accumulator(), instr.type))
        self.acc = None if instr.operand is None else self.load(instr.operand)

    def close(self, instr: Instr) -> None:
        if not self.stack:
            raise ValueError(f"{self.unit.name}: nothing to close at instruction {self.at}")
        op, left, type_ = self.stack.pop()
        self.combine(op, left, self.accumulator(), type_)

    def label(self, instr: Instr) -> None:
        self.acc = None

    def condition(self, instr: Instr, always: str) -> Expr | None:
        """The condition of JMP*, CAL* and RET*; None when there is none."""
        if instr.op == always:
            return None
        kept = self.keep()
        return self.inverted(kept).expr if instr.op.endswith("CN") else kept.expr

    def jump(self, instr: Instr) -> None:
        self.settle()
        condition = self.condition(instr, "JMP")
        self.made.append(Goto(self.at, self.flat.targets[self.at], condition))

    def leave(self, instr: Instr) -> None:
        self.made.append(Return(self.at, self.condition(instr, "RET")))

    def call(self, instr: Instr) -> None:
        condition = self.condition(instr, "CAL")
        if instr.op == "CAL":
            self.acc = None
        self.before(_EVERYTHING)
        self.made.append(CallBlock(self.at, instr.operand, condition))

    def native(self, instr: Instr) -> None:
        self.acc = None
        elapsed = self.load(instr.operand)
        self.before(_EVERYTHING)
        self.made.append(CallNative(self.at, elapsed.expr))

    def function(self, instr: Instr) -> None:
        function = self.functions.get(instr.name.upper())
        args = () if self.nullary(instr.name) else (self.accumulator(),)
        args += tuple([self.load(a) for a in instr.args])
        if function is None:
            self.acc = self.apply(instr.name, args, instr.type)
            return
        self.acc = None
        self.before(_EVERYTHING)
        types = {v.name.upper(): v.type for v in function.variables}
        result = None if function.result is None else self.temporary(function.result)
        taken = tuple((name, self.temporary(types[name.upper()])) for name, _ in instr.outputs)
        self.made.append(CallFunction(self.at, function, tuple(a.expr for a in args), result, taken))
        self.acc = None if result is None else _Value(Load(result))
        for (_, target), (_, place) in zip(instr.outputs, taken, strict=True):
            self.store(target, _Value(Load(place)))


_OPERATORS = ("AND", "OR", "XOR", "ANDN", "ORN", "XORN", "ADD", "SUB", "MUL", "DIV", "MOD",
              "GT", "GE", "EQ", "NE", "LE", "LT")
_S = _Structure
_HANDLERS: dict[str, Callable[[_Structure, Instr], None]] = {
    "LD": _S.ld, "LDN": _S.ld, "ST": _S.st, "STN": _S.st, "S": _S.latch, "R": _S.latch, "NOT": _S.invert,
    ")": _S.close, "LABEL": _S.label, "CAL": _S.call, "CALC": _S.call, "CALCN": _S.call, "FN": _S.function,
    "RET": _S.leave, "RETC": _S.leave, "RETCN": _S.leave, "JMP": _S.jump, "JMPC": _S.jump,
    "JMPCN": _S.jump, "EXT": _S.native,
} | dict.fromkeys(_OPERATORS, _S.operator) | {f"{op}(": _S.open for op in _OPERATORS}
