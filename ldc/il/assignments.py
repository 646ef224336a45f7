"""Values of the self-check: one run covers 4,096 assignments of the operands at once.

A BOOL is a Python integer of 4,096 bits, one per assignment. Every operand that is read for the first
time (a variable, the output of a block, a comparison) gets a column: the first twelve together run
through all their 2^12 combinations, further ones are random. What is not BOOL is a term, compared by
structure.
"""

from __future__ import annotations

import random
from math import prod

from ldc.expr import Place

LANES = 4096
ALL = (1 << LANES) - 1
EXHAUSTIVE = 12


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
        return canonical(merged)

    def cases(self, value: Value) -> Cases:
        """The terms that a value consists of, with the assignments in which each holds."""
        if isinstance(value, Term):
            return ((value, ALL),)
        if isinstance(value, tuple):
            return value
        yes, no = self.term("const", True), self.term("const", False)
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
                result |= lanes & self.column(term)
        return result


class Key:
    """Where a place lies: ``root`` (a variable or a byte image) and the way from there; interned."""

    __slots__ = ("root", "steps")

    def __init__(self, root: tuple, steps: tuple) -> None:
        self.root = root
        self.steps = steps


def combined(args: list[Cases]) -> list[tuple[tuple, int]]:
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


def canonical(merged: dict[Term, int]) -> Value:
    """Terms with the assignments in which each holds, as a value; equal values are equal objects."""
    if len(merged) == 1:
        return next(iter(merged))
    return tuple(sorted(merged.items(), key=lambda case: case[0].number))


def order(value: Value) -> object:
    """What values are sorted by where the order of operands is free."""
    if isinstance(value, Term):
        return (0, value.number)
    return (2, [(t.number, lanes) for t, lanes in value]) if isinstance(value, tuple) else (1, value)


def logic(op: str, values: list[int]) -> int:
    """AND, OR, XOR of BOOLs, NOT of one."""
    result = values[0]
    if op == "NOT":
        return ALL & ~result
    for value in values[1:]:
        result = result & value if op == "AND" else result | value if op == "OR" else result ^ value
    return result
