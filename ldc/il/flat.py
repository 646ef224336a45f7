"""The body of a POU as one list of instructions with its jumps resolved."""

from __future__ import annotations

from ldc.il.program import Instr, Unit
from ldc.records import record

JUMPS = ("JMP", "JMPC", "JMPCN")


@record
class Flat:
    """The body of a unit as one list. ``places[i]`` is (rung number, instruction number) of ``code[i]``;
    ``targets`` maps the position of a jump to the position that it goes to (``len(code)``: the end);
    ``labels`` are all positions that something jumps to, ``starts`` the first positions of rungs."""

    code: tuple[Instr, ...]
    places: tuple[tuple[int, int], ...]
    targets: dict[int, int]
    labels: frozenset[int]
    starts: frozenset[int]


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
