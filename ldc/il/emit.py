"""Typed expressions to IL: one accumulator, deferred operators, few instructions.

The number of instructions for a network of contacts is the known minimum, leaves plus, per
operator, one closing parenthesis for every composite operand but the first (DESIGN section 3,
rule 7): the composite operand that nests deepest goes first and needs none.
"""

from __future__ import annotations

from collections.abc import Iterator

from ldc.expr import Apply, BitStep, Const, FieldStep, IndexStep, Load, Place
from ldc.il.program import ARITHMETIC, COMPARISON, LOGIC, Instr
from ldc.il.values import (
    Held,
    Value,
    all_negated,
    as_expr,
    is_not,
    is_real,
    is_simple,
    simple_indexes,
    typed_function,
)
from ldc.source import Span
from ldc.symbols import Variable
from ldc.types import BOOL, LINT, TIME, Type

# Python and old controllers both limit nesting; deeper expressions go through temporaries.
_DEEPEST = 40
_KEEPS_ACC = frozenset(("ST", "STN", "S", "R", "JMPC", "JMPCN", "RETC", "RETCN"))
_LOADS = frozenset(("LD", "LDN"))
_OPERATORS = frozenset((*LOGIC, *ARITHMETIC, *COMPARISON, "NOT"))


class _Gap:
    """Where a held value was computed; becomes the store to its temporary once that is needed."""

    __slots__ = ("store",)

    def __init__(self) -> None:
        self.store: Instr | None = None


class Emitter:
    """Appends instructions for one rung and keeps track of what the accumulator holds.

    A held value is stored to a temporary only when something needs it after the accumulator was
    overwritten: every point that makes one leaves a gap, which is filled then or dropped.
    """

    def __init__(self, key: str, max_paren_depth: int | None = None) -> None:
        self.key = key
        self.max_paren_depth = max_paren_depth
        self.out: list[Instr | _Gap] = []
        self.element = -1
        self.span: Span | None = None
        self.temps: dict[str, Variable] = {}
        self._acc: Held | None = None
        self._gaps: list[tuple[_Gap, int, Span | None]] = []
        self._counts: dict[Type, int] = {}
        self._labels = 0
        self._depths: dict[int, tuple[Value, int]] = {}
        # For the held value in the accumulator: which expressions can begin with it.
        self._leading: tuple[Held | None, dict[int, tuple[Value, bool]]] = None, {}
        # Which element an expression stems from, by identity; the expression is held with it.
        self._owners: dict[int, tuple[Value, int, Span | None]] = {}

    # -- building blocks

    def put(self, op: str, operand=None, type_: Type = BOOL, name: str = "", args=(), outputs=()) -> None:
        self.out.append(Instr(op, operand, type_, name, args, outputs, self.element, self.span))
        if op not in _KEEPS_ACC:
            self._acc = None

    def temp(self, type_: Type) -> Place:
        """A new temporary of this rung; rungs share names, since temporaries keep nothing."""
        number = self._counts[type_] = self._counts.get(type_, 0) + 1
        stem = "t" if type_ == BOOL else "".join(c for c in str(type_).lower() if c.isalnum())
        name = f"_ldc_{stem}{'' if stem == 't' else '_'}{number}"
        self.temps[name] = Variable(name, type_, "temp")
        return Place(name, type_)

    def mark(self) -> dict[Type, int]:
        """How many temporaries are in use, for ``release``."""
        return dict(self._counts)

    def release(self, mark: dict[Type, int]) -> None:
        """What was taken since ``mark`` may be taken again: nothing that was held is needed any more."""
        self._counts = dict(mark)
        self._acc = None

    def own(self, expr: Value) -> Value:
        """Notes that ``expr``, which may be computed later, stems from the current element."""
        self._owners[id(expr)] = expr, self.element, self.span
        if is_not(expr):
            self.own(expr.args[0])
        return expr

    def label(self) -> str:
        self._labels += 1
        return f"_ldc_{self.key}_{self._labels}"

    def hold(self, type_: Type = BOOL) -> Held:
        """Names what the accumulator holds now."""
        if self._acc is not None:
            return self._acc
        self._acc = Held(len(self._gaps), type_)
        gap = _Gap()
        self._gaps.append((gap, self.element, self.span))
        self.out.append(gap)
        return self._acc

    def held_place(self, held: Held) -> Place:
        """The temporary of a held value; stores it there, at the point where it was computed."""
        gap, element, span = self._gaps[held.id]
        if gap.store is None:
            gap.store = Instr("ST", self.temp(held.type), held.type, element=element, span=span)
        return gap.store.operand

    def value(self, expr: Value) -> None:
        """Leaves the value of ``expr`` in the accumulator."""
        if isinstance(expr, Held) and expr == self._acc:
            return
        self._generate(self._prepare(expr, self._budget))

    def held(self, expr: Value) -> Held:
        """Computes ``expr`` now, once."""
        if isinstance(expr, Held):
            return expr
        self.value(expr)
        return self.hold(expr.type)

    def store(self, place: Place, op: str = "ST") -> None:
        """``place`` must have been through ``place()``: its indexes are simple."""
        self.put(op, place, place.type)

    def simple(self, expr: Value) -> Const | Place:
        """An IL operand with the value of ``expr``: itself, or a temporary computed now."""
        match expr:
            case Const():
                return expr
            case Load(place):
                return self.place(place)
            case Held():
                return self.held_place(expr)
        self.value(expr)
        spill = self.temp(expr.type)
        self.put("ST", spill, expr.type)
        return spill

    def place(self, place: Place) -> Place:
        """The place with every index a constant or a variable."""
        if not place.steps or all(isinstance(s, FieldStep | BitStep) or simple_indexes(s)
                                  for s in place.steps):
            return place
        steps = tuple(
            s if not isinstance(s, IndexStep)
            else IndexStep(tuple(as_expr(self.simple(i)) for i in s.indexes), s.bounds)
            for s in place.steps)
        return Place(place.root, place.type, steps, place.is_global, place.span)

    def finish(self) -> tuple[Instr, ...]:
        """The instructions, without unused gaps, stores that nobody reads, and loads that the next
        overwrites."""
        code = [i if isinstance(i, Instr) else i.store for i in self.out if isinstance(i, Instr) or i.store]
        read = {place.root for i in code for place in _read_places(i)}
        code = [i for i in code if not (i.op == "ST" and i.operand.root in self.temps
                                        and i.operand.root not in read)]
        self.temps = {name: v for name, v in self.temps.items() if name in read or any(
            place.root == name for i in code for _, place in i.outputs)}
        return tuple(instr for n, instr in enumerate(code)
                     if not (instr.op in ("LD", "LDN") and n + 1 < len(code) and code[n + 1].op in _LOADS))

    # -- before the expression: order operands, spill what IL cannot nest

    @property
    def _budget(self) -> int:
        return _DEEPEST if self.max_paren_depth is None else min(self.max_paren_depth, _DEEPEST)

    def _prepare(self, expr: Value, budget: int) -> Value:
        if isinstance(expr, Load) and not expr.place.steps:
            return expr
        prepared = self._prepared(expr, budget)
        owner = self._owners.get(id(expr))
        if owner is not None and prepared is not expr:
            self._owners[id(prepared)] = prepared, *owner[1:]
        return prepared

    def _prepared(self, expr: Value, budget: int) -> Value:
        match expr:
            case Load(place):
                simple = self.place(place)
                return expr if simple is place else Load(simple, expr.span)
            case Apply(op, args, type_, user=user):
                if op in COMPARISON and len(args) > 2:
                    pairs = [Apply(op, pair, BOOL, expr.span) for pair in zip(args, args[1:])]
                    return self._prepare(Apply("AND", tuple(pairs), BOOL, expr.span), budget)
                if op == "MOVE":
                    return self._prepare(args[0], budget)
                if op == "NEG":
                    minus = Const(-1.0 if is_real(type_) else -1, type_ if type_ != TIME else LINT)
                    return self._prepare(Apply("MUL", (args[0], minus), type_, expr.span), budget)
                if op in LOGIC:
                    return self._prepare_logic(expr, budget)
                function = typed_function(op, tuple(a.type for a in args))
                if function or user or op not in _OPERATORS:
                    rest = tuple(as_expr(self.simple(a)) for a in args[1:])
                    first = tuple(self._prepare(a, budget) for a in args[:1])
                    return Apply(function or op, first + rest, type_, expr.span, user)
                return Apply(op, self._prepare_rest(args, budget), type_, expr.span)
        return expr

    def _prepare_logic(self, expr: Apply, budget: int) -> Apply:
        """AND, OR, XOR commute: put first what needs no parenthesis there."""
        best, best_rank = 0, (-1, -1)
        for n, arg in enumerate(expr.args):
            rank = (1, 0) if self._starts_with_acc(arg) else (0, self._depth(arg))
            if rank > best_rank:
                best, best_rank = n, rank
        args = expr.args if best == 0 else (expr.args[best], *expr.args[:best], *expr.args[best + 1:])
        if best_rank == (0, 0) and is_not(args[0]):
            plain = next((n for n, a in enumerate(args) if not is_not(a)), 0)
            args = (args[plain], *args[:plain], *args[plain + 1:])
        return Apply(expr.op, self._prepare_rest(args, budget), expr.type, expr.span)

    def _prepare_rest(self, args: tuple[Value, ...], budget: int) -> tuple[Value, ...]:
        """Operands after the first are simple, or nest by one; past the limit they are computed before."""
        prepared = []
        for n, arg in enumerate(args):
            if n == 0:
                prepared.append(self._prepare(arg, budget))
            elif is_simple(arg) or is_not(arg) and is_simple(arg.args[0]):
                prepared.append(self._prepare(arg, budget))
            elif budget > 0:
                prepared.append(self._prepare(arg, budget - 1))
            else:
                prepared.append(self.held(arg))
                self.held_place(prepared[-1])
        return tuple(prepared)

    def _depth(self, expr: Value) -> int:
        """Parentheses plus one that ``expr`` nests when it stands first; 0 for what is simple."""
        if not isinstance(expr, Apply) or is_not(expr) and is_simple(expr.args[0]):
            return 0
        known = self._depths.get(id(expr))
        if known is not None:
            return known[1]
        depths = [self._depth(a) for a in expr.args]
        if expr.op in LOGIC:
            depths.sort(reverse=True)
        depth = max(1, depths[0] if depths else 0, *(d + 1 for d in depths[1:] if d))
        self._depths[id(expr)] = expr, depth
        return depth

    def _starts_with_acc(self, expr: Value) -> bool:
        """Whether code for ``expr`` can begin with what the accumulator holds."""
        if self._acc is None or isinstance(expr, Held):
            return self._acc is not None and expr == self._acc
        if not isinstance(expr, Apply):
            return False
        if self._leading[0] != self._acc:
            self._leading = self._acc, {}
        known = self._leading[1].get(id(expr))
        if known is None:
            found = False
            for arg in expr.args if expr.op in LOGIC else expr.args[:1]:
                found = found or self._starts_with_acc(arg)
            known = self._leading[1][id(expr)] = expr, found
        return known[1]

    # -- the expression itself

    def _generate(self, expr: Value) -> None:
        outer = self._enter(expr)
        self._generate_here(expr)
        self.element, self.span = outer

    def _enter(self, expr: Value) -> tuple[int, Span | None]:
        """Instructions from now on stem from ``expr``; gives what they stemmed from before."""
        outer = self.element, self.span
        owner = self._owners.get(id(expr))
        if owner is not None:
            _, self.element, self.span = owner
        if isinstance(expr, Apply) and expr.span is not None:
            self.span = expr.span
        return outer

    def _generate_here(self, expr: Value) -> None:
        if type(expr) is Load:
            self.put("LD", expr.place, expr.place.type)
            return
        match expr:
            case Held():
                if expr != self._acc:
                    self.put("LD", self.held_place(expr), expr.type)
            case Const():
                self.put("LD", expr, expr.type)
            case Apply("NOT", (arg,)) if arg.type == BOOL and is_simple(arg) and arg != self._acc:
                self.put("LDN", self._operand(arg))
            case Apply("NOT", (arg,)):
                self._generate(arg)
                self.put("NOT", None, arg.type)
            case Apply(op, args) if op in LOGIC or op in COMPARISON or op in ARITHMETIC:
                self._generate(args[0])
                for arg in args[1:]:
                    self._apply(op, args[0].type, arg)
            case Apply(op, args, type_):
                if args:
                    self._generate(args[0])
                self.put("FN", None, type_, op, tuple(self._operand(a) for a in args[1:]))

    def _apply(self, op: str, type_: Type, arg: Value) -> None:
        outer = self._enter(arg) if op in LOGIC else (self.element, self.span)
        self._apply_here(op, type_, arg)
        self.element, self.span = outer

    def _apply_here(self, op: str, type_: Type, arg: Value) -> None:
        if is_simple(arg):
            self.put(op, self._operand(arg), type_)
            return
        if op in LOGIC and is_not(arg):
            op, arg = op + "N", arg.args[0]
            if is_simple(arg) and type_ == BOOL:
                self.put(op, self._operand(arg), type_)
                return
        elif op in LOGIC and (swapped := all_negated(arg)):
            op, arg = op + "N", swapped
        outer, self.out, self._acc = self.out, [], None
        opened = len(outer)
        self._generate_nested(outer, opened, op, type_, arg)

    def _generate_nested(self, outer: list, opened: int, op: str, type_: Type, arg: Value) -> None:
        """``OP( first`` … ``)``: the first load goes on the line of the operator."""
        self._generate(arg)
        inner, self.out = self.out, outer
        first = inner[0]
        if first.op == "LD":
            outer.append(Instr(op + "(", first.operand, type_, element=first.element, span=first.span))
            outer.extend(inner[1:])
        else:
            outer.append(Instr(op + "(", None, type_, element=self.element, span=self.span))
            outer.extend(inner)
        self.put(")", None, type_)

    def _operand(self, expr: Value) -> Const | Place:
        match expr:
            case Const():
                return expr
            case Load(place):
                return place
        return self.held_place(expr)


def _read_places(instr: Instr) -> Iterator[Place]:
    """The places whose values an instruction uses."""
    for operand in (instr.operand, *instr.args):
        if isinstance(operand, Place):
            if operand is not instr.operand or instr.op != "ST":
                yield operand
            yield from _indexes(operand)
    for _, place in instr.outputs:
        yield from _indexes(place)


def _indexes(place: Place) -> Iterator[Place]:
    for step in place.steps:
        if isinstance(step, IndexStep):
            for index in step.indexes:
                if isinstance(index, Load):
                    yield index.place
                    yield from _indexes(index.place)
