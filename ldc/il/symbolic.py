"""Values and memory of the self-check: one run covers 4,096 assignments of the operands at once.

A BOOL is a Python integer of 4,096 bits, one per assignment. Every operand that is read for the first
time (a variable, the output of a block, a comparison) gets a column: the first twelve together run
through all their 2^12 combinations, further ones are random. What is not BOOL is a term, compared by
structure; blocks and functions are uninterpreted: equal inputs in equal order give equal outputs. So
equality on all columns is a proof for rungs with at most twelve operands, for every block, every value
and, since hidden memories are operands too, for every number of scans (ADR 0004).
"""

from __future__ import annotations

import random
from math import prod

from ldc.expr import Apply, BitStep, Const, Expr, FieldStep, IndexStep, Load, Place
from ldc.il.values import typed_function
from ldc.library import functions
from ldc.records import record, replace
from ldc.symbols import Location
from ldc.types import BOOL, LINT, TIME, Type, storage

LANES = 4096
ALL = (1 << LANES) - 1
EXHAUSTIVE = 12
_COMPARISON_CHAINS = frozenset(("GT", "GE", "EQ", "NE", "LE", "LT"))


def _columns() -> tuple[int, ...]:
    columns = []
    for n in range(EXHAUSTIVE):
        half = 1 << n
        block, width = ((1 << half) - 1) << half, 2 * half
        while width < LANES:
            block |= block << width
            width *= 2
        columns.append(block)
    return tuple(columns)


_COLUMNS = _columns()


class Term:
    """An interned expression; equal structure is the same object."""

    __slots__ = ("key", "number")

    def __init__(self, key: tuple, number: int) -> None:
        self.key = key
        self.number = number


# A value that is not BOOL: one term, or terms with the (disjoint) assignments in which each holds.
Cases = tuple[tuple[Term, int], ...]
Value = int | Term | Cases


class Operands:
    """The table of terms and columns that all runs of one self-check share."""

    def __init__(self) -> None:
        self.columns: dict[Term, int] = {}
        # By identity, since the same objects are read over and over; held, so that none is reused.
        self.places: dict[int, tuple[Place, Key]] = {}
        self._keys: dict[tuple, Key] = {}
        self._terms: dict[tuple, Term] = {}

    def term(self, *key: object) -> Term:
        known = self._terms.get(key)
        if known is None:
            known = self._terms[key] = Term(key, len(self._terms))
        return known

    def key(self, root: tuple, steps: tuple) -> Key:
        known = self._keys.get((root, steps))
        if known is None:
            known = self._keys[root, steps] = Key(root, steps)
        return known

    def column(self, term: Term) -> int:
        known = self.columns.get(term)
        if known is None:
            n = len(self.columns)
            known = _COLUMNS[n] if n < EXHAUSTIVE else random.Random(n).getrandbits(LANES)
            self.columns[term] = known
        return known

    @property
    def exhaustive(self) -> bool:
        return len(self.columns) <= EXHAUSTIVE


class Key:
    """Where a place lies: ``root`` (a variable or a byte image) and the way from there; interned."""

    __slots__ = ("root", "steps")

    def __init__(self, root: tuple, steps: tuple) -> None:
        self.root = root
        self.steps = steps


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

    # -- logic on assignments

    def choose(self, when: int, yes: Value, no: Value) -> Value:
        """``yes`` where ``when``, else ``no``."""
        if when == ALL or yes is no:
            return yes
        if when == 0:
            return no
        if isinstance(yes, int) and isinstance(no, int):
            return yes & when | no & ~when & ALL
        merged: dict[Term, int] = {}
        for value, lanes in ((yes, when), (no, ALL & ~when)):
            for term, holds in self.cases(value):
                if holds & lanes:
                    merged[term] = merged.get(term, 0) | holds & lanes
        return _canonical(merged)

    def cases(self, value: Value) -> Cases:
        if isinstance(value, Term):
            return ((value, ALL),)
        if isinstance(value, tuple):
            return value
        yes, no = self.operands.term("const", True), self.operands.term("const", False)
        return tuple((t, lanes) for t, lanes in ((yes, value), (no, ALL & ~value)) if lanes)

    def boolean(self, value: Value) -> int:
        """A BOOL from a term: its column (or the constant that it is)."""
        if isinstance(value, int):
            return value
        result = 0
        for term, lanes in self.cases(value):
            if term.key[0] == "const":
                result |= lanes if term.key[1] else 0
            else:
                result |= lanes & self.operands.column(term)
        return result

    def apply(self, op: str, args: list[Value], type_: Type, seen: tuple | None = None) -> Value:
        """A function as an uninterpreted term, for every combination of cases of its arguments. ``seen``: the
        globals when it was called, if that is over."""
        combinations = _combined([self.cases(arg) for arg in args])
        context = self.seen(op) if seen is None else seen
        merged: dict[Term, int] = {}
        for key, lanes in combinations:
            term = self.operands.term(op, type_, *key, *context)
            merged[term] = merged.get(term, 0) | lanes
        value = _canonical(merged)
        return self.boolean(value) if type_ == BOOL else value

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
            return _logic(op, [self.boolean(v) for v in values])
        type_, types = storage(type_), [storage(t) for t in types]
        if op in _COMPARISON_CHAINS and len(values) > 2:
            pairs = [self.operator(op, [a, b], types[:2], BOOL) for a, b in zip(values, values[1:])]
            return _logic("AND", pairs)
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
            if _order(first) > _order(second):
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
            cases = self.cases(index) if isinstance(index, tuple) else ((index, ALL),)
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
            value = self.choose(lanes, self._read_key(other, place.type), value)
        return value

    def _read_key(self, key: Key, type_: Type) -> Value:
        current = self._current.get(key.root)
        if current is None:
            current = self._current[key.root] = {}
        value = current.get(key)
        if value is None:
            value = self._read(key, len(self.logs.get(key.root, ())), type_)
            if type_ is BOOL or type_ == BOOL:
                value = self.boolean(value)
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
                    return self.choose(when, self.boolean(value), self.boolean(before))
                return self.choose(when, value, before)
            if _may_overlap(steps, key.steps):
                written = tuple((way, self._where(value, when), when) for way, value, when, _ in log[: n + 1])
                return self.operands.term("within", key.root, key.steps, self._epoch(key.root), written)
        return self.operands.term("var", key.root, key.steps, self._epoch(key.root))

    def _where(self, value: Value, when: int) -> tuple | int:
        """What was written on the assignments ``when``; what it would have been on others is nothing."""
        if isinstance(value, int):
            return value & when
        return tuple((term.number, lanes & when) for term, lanes in self.cases(value) if lanes & when)

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
            value, when = self.choose(when, value, last), when | before
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
            values.append((steps, self.boolean(value) if type_ == BOOL else value))
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


def _combined(args: list[Cases]) -> list[tuple[tuple, int]]:
    """The combinations of cases that occur, with their assignments: one after the other, or, when the cases
    are many, by assignment, so that the work is bounded by the number of assignments."""
    if prod(map(len, args)) > LANES:
        found: dict[tuple, int] = {}
        for lane, key in enumerate(zip(*map(_by_lane, args), strict=True)):
            found[key] = found.get(key, 0) | 1 << lane
        return list(found.items())
    combinations: list[tuple[tuple, int]] = [((), ALL)]
    for arg in args:
        combinations = [((*key, term), lanes & holds) for key, lanes in combinations
                        for term, holds in arg if lanes & holds]
    return combinations


def _by_lane(cases: Cases) -> list[Term]:
    """The term of every assignment."""
    found = [cases[0][0]] * LANES
    for term, lanes in cases[1:]:
        while lanes:
            lane = lanes.bit_length() - 1
            found[lane] = term
            lanes ^= 1 << lane
    return found


def _canonical(merged: dict[Term, int]) -> Value:
    if len(merged) == 1:
        return next(iter(merged))
    return tuple(sorted(merged.items(), key=lambda case: case[0].number))


def _order(value: Value) -> object:
    if isinstance(value, Term):
        return (0, value.number)
    return (2, [(t.number, lanes) for t, lanes in value]) if isinstance(value, tuple) else (1, value)


def _logic(op: str, values: list[int]) -> int:
    result = values[0]
    if op == "NOT":
        return ALL & ~result
    for value in values[1:]:
        result = result & value if op == "AND" else result | value if op == "OR" else result ^ value
    return result


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
