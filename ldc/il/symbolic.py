"""Memory of the self-check, whose values hold for all assignments at once (``assignments``).

Blocks and functions are uninterpreted: equal inputs in equal order give equal outputs. So equality on
all columns is a proof for rungs with at most twelve operands, for every block, every value and, since
hidden memories are operands too, for every number of scans (ADR 0004).
"""

from __future__ import annotations

from ldc.expr import Apply, BitStep, Const, Expr, FieldStep, IndexStep, Load, Place
from ldc.il.assignments import ALL, Key, Operands, Term, Value, canonical, combined, logic, order
from ldc.il.values import typed_function
from ldc.library import functions
from ldc.records import record, replace
from ldc.symbols import Location
from ldc.types import BOOL, LINT, TIME, Type, storage

_COMPARISON_CHAINS = frozenset(("GT", "GE", "EQ", "NE", "LE", "LT"))


@record
class Taken:
    """An index with the value that it had when it was taken (``Memory.taken``)."""

    value: Value


class Memory:
    """Variables as logs of writes, read back with the conditions under which they were written."""

    def __init__(self, operands: Operands, locations: dict[str, Location] | None = None) -> None:
        self.operands = operands
        self.locations = locations or {}
        # Per root: steps, value, when it was written, type.
        self.logs: dict[tuple, list[tuple[tuple, Value, int, Type]]] = {}
        # What was read or written last, by root and key; a write to a root forgets the rest of it.
        self._current: dict[tuple, dict[Key, Value]] = {}
        self.epochs: dict[tuple | str, int] = {}
        self.events: list[tuple] = []

    def apply(self, op: str, args: list[Value], type_: Type, seen: tuple | None = None) -> Value:
        """A function as an uninterpreted term, for every combination of cases of its arguments. ``seen``: the
        globals when it was called, if that is over."""
        combinations = combined([self.operands.cases(arg) for arg in args])
        context = self.seen(op) if seen is None else seen
        merged: dict[Term, int] = {}
        for key, lanes in combinations:
            term = self.operands.term(op, type_, *key, *context)
            merged[term] = merged.get(term, 0) | lanes
        value = canonical(merged)
        return self.operands.boolean(value) if type_ == BOOL else value

    def seen(self, op: str) -> tuple:
        """What a FUNCTION of the project sees beside its arguments: the globals as they are now."""
        if functions.lookup(op) is not None:
            return ()
        shared = sorted((root for root in self.logs if _shared(root)), key=repr)
        return (self.epochs.get("globals", 0), *((root, self.state(root)) for root in shared))

    # -- expressions

    def value(self, expr: Expr) -> Value:
        if type(expr) is Load:
            return self.read(expr.place)
        match expr:
            case Const(value, type_):
                if type_ == BOOL:
                    return ALL if value else 0
                return self.operands.term("const", value, storage(type_))
            case Apply(op, args, type_):
                return self.operator(op, [self.value(a) for a in args], [a.type for a in args], type_)

    def operator(self, op: str, values: list[Value], types: list[Type], type_: Type,
                 seen: tuple | None = None) -> Value:
        """The meaning of an operator: logic of BOOL is computed, all else is a term. A subrange counts as the
        type that it is a range of: the range holds where a value is stored."""
        if (type_ is BOOL or type_ == BOOL) and op in ("AND", "OR", "XOR", "NOT"):
            return logic(op, [self.operands.boolean(v) for v in values])
        type_, types = storage(type_), [storage(t) for t in types]
        if op in _COMPARISON_CHAINS and len(values) > 2:
            pairs = [self.operator(op, [a, b], types[:2], BOOL) for a, b in zip(values, values[1:])]
            return logic("AND", pairs)
        if op == "MOVE":
            return values[0]
        if op == "NEG":
            minus = -1.0 if getattr(type_, "kind", "") == "real" else -1
            other = LINT if type_ == TIME else type_
            values, types, op = [*values, self.operands.term("const", minus, other)], [type_, other], "MUL"
        op = typed_function(op, tuple(types)) or op
        if op in ("AND", "OR", "XOR", "ADD", "MUL") and len(values) > 2:
            value = values[0]
            for other in values[1:]:
                value = self.operator(op, [value, other], types[:2], type_)
            return value
        if op in ("AND", "OR", "XOR"):
            # Bit strings: the order of operands is free, so it must not tell terms apart.
            first, second = values
            if order(first) > order(second):
                values = [second, first]
        return self.apply(op, values, type_, seen)

    # -- places

    def key(self, place: Place) -> Key:
        """Equal keys are the same memory; located variables lie in the image of their area."""
        known = self.operands.places.get(id(place))
        if known is not None:
            return known[1]
        key = self._key(place)
        if not place.steps or not any(isinstance(s, IndexStep) for s in place.steps):
            self.operands.places[id(place)] = place, key
        return key

    def _key(self, place: Place) -> Key:
        root = place.root.upper()
        steps = tuple([self._step(s) for s in place.steps]) if place.steps else ()
        location = self.locations.get(root) if not root.startswith("%") else Location.parse(root)
        if location is not None:
            first = location.byte * 8 + location.bit
            return self.operands.key(("%", location.area), (("at", first, location.extent), *steps))
        return self.operands.key((place.is_global, root), steps)

    def _step(self, step) -> object:
        match step:
            case FieldStep(name):
                return name.upper()
            case BitStep(bit):
                return ("bit", bit)
        return ("ix", *(i.value if isinstance(i, Const | Taken) else self.value(i) for i in step.indexes))

    def taken(self, place: Place) -> Place:
        """The place with its indexes as they are now, whatever happens to their variables."""
        def now(index: Expr) -> Const | Taken:
            return index if isinstance(index, Const) else Taken(self.value(index))

        steps = tuple(replace(s, indexes=tuple(map(now, s.indexes))) if isinstance(s, IndexStep) else s
                      for s in place.steps)
        return place if steps == place.steps else replace(place, steps=steps)

    def ways(self, place: Place, when: int = ALL) -> list[tuple[Key, int]]:
        """Where the place lies: an index that depends on the assignment (it was computed where power came)
        leads to several keys, each with its part of the assignments ``when``."""
        key = self.key(place)
        if not key.steps or not any(map(_varies, key.steps)):
            return [(key, ALL)]
        found: list[tuple[tuple, int]] = [((), when or ALL)]
        for step in key.steps:
            choices = self._choices(step) if _varies(step) else [(step, ALL)]
            found = [((*way, one), lanes & holds)
                     for way, lanes in found for one, holds in choices if lanes & holds]
        return [(self.operands.key(key.root, way), lanes) for way, lanes in found]

    def _choices(self, step: tuple) -> list[tuple[tuple, int]]:
        """The steps ``("ix", ...)`` with one value for each index."""
        found: list[tuple[tuple, int]] = [(("ix",), ALL)]
        for index in step[1:]:
            cases = self.operands.cases(index) if isinstance(index, tuple) else ((index, ALL),)
            found = [((*one, term), lanes & holds)
                     for one, lanes in found for term, holds in cases if lanes & holds]
        return found

    def read(self, place: Place, when: int = ALL) -> Value:
        """The value of a place; on the assignments outside of ``when`` it may be any."""
        if not place.steps:
            return self._read_key(self.key(place), place.type)
        (key, _), *others = self.ways(place, when)
        value = self._read_key(key, place.type)
        for other, lanes in others:
            value = self.operands.choose(lanes, self._read_key(other, place.type), value)
        return value

    def _read_key(self, key: Key, type_: Type) -> Value:
        current = self._current.get(key.root)
        if current is None:
            current = self._current[key.root] = {}
        value = current.get(key)
        if value is None:
            value = self._read(key, len(self.logs.get(key.root, ())), type_)
            if type_ is BOOL or type_ == BOOL:
                value = self.operands.boolean(value)
            current[key] = value
        return value

    def _read(self, key: Key, upto: int, type_: Type) -> Value:
        log = self.logs.get(key.root, ())
        for n in range(upto - 1, -1, -1):
            steps, value, when, _ = log[n]
            if steps == key.steps:
                if when == ALL:
                    return value
                before = self._read(key, n, type_)
                if type_ == BOOL:
                    return self.operands.choose(when, self.operands.boolean(value), self.operands.boolean(before))
                return self.operands.choose(when, value, before)
            if _may_overlap(steps, key.steps):
                written = tuple((way, self._where(value, when), when) for way, value, when, _ in log[: n + 1])
                return self.operands.term("within", key.root, key.steps, self._epoch(key.root), written)
        return self.operands.term("var", key.root, key.steps, self._epoch(key.root))

    def _where(self, value: Value, when: int) -> tuple | int:
        """What was written on the assignments ``when``; what it would have been on others is nothing."""
        if isinstance(value, int):
            return value & when
        return tuple((term.number, lanes & when) for term, lanes in self.operands.cases(value) if lanes & when)

    def _epoch(self, root: tuple) -> int:
        """Counts the calls that may have changed a variable."""
        own = self.epochs.get(root, 0)
        if _shared(root):
            return max(own, self.epochs.get("globals", 0))
        return own if _made(root) else max(own, self.epochs.get("all", 0))

    def write(self, place: Place, value: Value, when: int) -> None:
        if when == 0:
            return
        for key, lanes in self.ways(place, when):
            self._write(key, value, when & lanes, place.type)

    def _write(self, key: Key, value: Value, when: int, type_: Type) -> None:
        log = self.logs.setdefault(key.root, [])
        if when != ALL and log and log[-1][0] == key.steps:
            _, last, before, _ = log.pop()
            value, when = self.operands.choose(when, value, last), when | before
        self._current[key.root] = {key: value} if when == ALL else {}
        if when == ALL and log and all(entry[0] == key.steps for entry in log):
            log.clear()
        log.append((key.steps, value, when, type_))

    def state(self, root: tuple) -> tuple:
        """What was written to a variable, path by path."""
        log = self.logs.get(root, ())
        values = []
        for steps, type_ in {entry[0]: entry[3] for entry in log}.items():
            value = self._read(self.operands.key(root, steps), len(log), type_)
            values.append((steps, self.operands.boolean(value) if type_ == BOOL else value))
        return tuple(sorted(values, key=lambda item: repr(item[0])) if len(values) > 1 else values)

    def call(self, instance: Place, sees_globals: bool, when: int) -> None:
        """A block runs: it sees its pins (and the globals), and may change its variables (and those)."""
        ways = self.ways(instance, when)
        root = ways[0][0].root
        seen = [(root, self.state(root))]
        if sees_globals:
            others = sorted((r for r in self.logs if r != root and _shared(r)), key=repr)
            seen += [(r, self.state(r)) for r in others]
        called = tuple((key.steps, when & lanes) for key, lanes in ways)
        self.events.append(("call", root, called, when, tuple(seen)))
        self._forget(root)
        if sees_globals:
            self.epochs["globals"] = len(self.events)
            self._current = {root: known for root, known in self._current.items() if not _shared(root)}
            for other in others:
                self._forget(other)

    def perform(self, action: str, when: int) -> None:
        """An action of the POU runs: it sees all of its variables and may change them, but for those that the
        compiler made for the rung."""
        roots = sorted((root for root in self.logs if not _made(root)), key=repr)
        seen = tuple((root, self.state(root)) for root in roots)
        self.events.append(("call", (False, action), (((), when),), when, seen))
        self.epochs["all"] = self.epochs["globals"] = len(self.events)
        self._current = {root: known for root, known in self._current.items() if _made(root)}
        for root in roots:
            self._forget(root)

    def _forget(self, root: tuple) -> None:
        self.logs[root] = []
        self._current.pop(root, None)
        self.epochs[root] = len(self.events)


def _made(root: tuple) -> bool:
    """Whether the compiler made the variable for this rung."""
    return not root[0] and root[1].upper().startswith("_LDC_")


def _shared(root: tuple) -> bool:
    """Whether other POUs can reach the variable: globals and the process image."""
    return root[0] is True or root[0] == "%"


def _varies(step: object) -> bool:
    """Whether the step is an index with several cases."""
    return step[0] == "ix" and any(isinstance(index, tuple) for index in step[1:])


def _may_overlap(a: tuple, b: tuple) -> bool:
    """Whether two different ways from one root can reach the same memory."""
    for x, y in zip(a, b):
        if x == y:
            continue
        if isinstance(x, str) or isinstance(y, str):
            return False
        if x[0] == y[0] == "bit":
            return False
        if x[0] == y[0] == "at":
            return x[1] < y[1] + y[2] and y[1] < x[1] + x[2]
        if x[0] == y[0] == "ix":
            return not any(isinstance(i, int) and isinstance(j, int) and i != j for i, j in zip(x[1:], y[1:]))
        return True
    return True
