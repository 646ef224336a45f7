"""Which jumps of a POU become Python ``if`` blocks, and which need a dispatch loop.

A forward jump over a properly nested range becomes ``if``; a jump that skips the other arm becomes
``else``. What is left (backward jumps, ranges that cross) goes through segments: pieces of the body
in a loop that skips to the segment asked for.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

from ldc.il.program import Instr, Unit

JUMPS = ("JMP", "JMPC", "JMPCN")
DEEPEST = 30
_ROUNDS = 8


@dataclass(frozen=True, slots=True)
class Flat:
    """The body of a unit as one list. ``places[i]`` is (rung number, instruction number) of ``code[i]``;
    ``targets`` maps the position of a jump to the position that it goes to (``len(code)``: the end);
    ``labels`` are all positions that something jumps to, ``starts`` the first positions of rungs."""

    code: tuple[Instr, ...]
    places: tuple[tuple[int, int], ...]
    targets: dict[int, int]
    labels: frozenset[int]
    starts: frozenset[int]


@dataclass(frozen=True, slots=True)
class Plan:
    """``blocks``: jump position -> end of its ``if``; ``others``: position of a JMP -> end of the ``else``
    that starts right after it; ``segments``: positions where segments begin, in order (empty: no loop);
    ``loops``: whether some jump goes backward."""

    blocks: dict[int, int]
    others: dict[int, int]
    segments: tuple[int, ...]
    loops: bool


def flatten(unit: Unit) -> Flat:
    """Resolves labels: first in the rung of the jump, then in the whole POU. LookupError when missing."""
    code: list[Instr] = []
    places: list[tuple[int, int]] = []
    whole: dict[str, int] = {}
    local: dict[tuple[int, str], int] = {}
    starts = []
    for number, rung in enumerate(unit.rungs):
        starts.append(len(code))
        if rung.label:
            whole[rung.label.upper()] = len(code)
        for index, instr in enumerate(rung.code):
            if instr.op == "LABEL":
                local[number, instr.name.upper()] = len(code)
                whole.setdefault(instr.name.upper(), len(code))
            code.append(instr)
            places.append((number, index))
    targets = {}
    for at, instr in enumerate(code):
        if instr.op in JUMPS:
            name = instr.name.upper()
            target = local.get((places[at][0], name), whole.get(name))
            if target is None:
                raise LookupError(f"{unit.name}: no label {instr.name}")
            targets[at] = target
    return Flat(tuple(code), tuple(places), targets, frozenset(targets.values()), frozenset(starts))


def plan(flat: Flat) -> Plan:
    """Decides for every jump. A range that a segment begins in is decided again, a few times at most;
    after that all jumps go through the loop."""
    if not flat.targets:
        return Plan({}, {}, (), False)
    irregular: set[int] = set()
    blocks, others, found = _nest(flat, irregular)
    for _ in range(_ROUNDS):
        if not found:
            break
        irregular |= found
        blocks, others, found = _nest(flat, irregular)
    if found:
        blocks, others, irregular = {}, {}, set(flat.targets)
    cuts = sorted({flat.targets[at] for at in irregular})
    segments = tuple(sorted({0, *cuts})) if irregular else ()
    return Plan(blocks, others, segments, any(flat.targets[at] <= at for at in irregular))


def _nest(flat: Flat, irregular: set[int]) -> tuple[dict[int, int], dict[int, int], set[int]]:
    """One pass: the blocks, the else arms, and the jumps that must be irregular beyond those known."""
    cuts = sorted({flat.targets[at] for at in irregular})
    labels = sorted(flat.labels)
    blocks: dict[int, int] = {}
    others: dict[int, int] = {}
    found: set[int] = set()
    open_ends: list[int] = []
    for at in sorted(flat.targets):
        target = flat.targets[at]
        while open_ends and open_ends[-1] <= at:
            open_ends.pop()
        if at in irregular:
            continue
        arm = _is_else(flat, at, open_ends)
        outer = open_ends[-2 if arm else -1] if len(open_ends) > arm else len(flat.code)
        if target <= at or target > outer or len(open_ends) >= DEEPEST or _any_within(cuts, at, target) \
                or (flat.code[at].op == "JMP" and not arm and _any_within(labels, at, target)):
            found.add(at)
        elif arm:
            others[at] = target
            open_ends[-1] = target
        else:
            blocks[at] = target
            open_ends.append(target)
    return blocks, others, found


def _is_else(flat: Flat, at: int, open_ends: list[int]) -> bool:
    """Whether the JMP ends the first arm of an ``if`` whose condition alone leads behind it."""
    return flat.code[at].op == "JMP" and open_ends[-1:] == [at + 1] and open_ends[-2:-1] != [at + 1]


def _any_within(positions: list[int], at: int, target: int) -> bool:
    """Whether one of the sorted positions lies inside the range of a jump, its two ends apart."""
    first = bisect_right(positions, at)
    return first < len(positions) and positions[first] < target
