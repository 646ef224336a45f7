"""The power that reaches the right end of each rung, seen while a scan is stepped (for the live table)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from ldc.expr import FieldStep, Place
from ldc.graph.rung import RAIL, RungGraph
from ldc.il.program import STORES, Instr
from ldc.model.elements import Block, Coil
from ldc.pipeline import RungBuild
from ldc.records import record, replace
from ldc.types import BOOL
from runtime.faults import FAULTS
from runtime.vm.frame import Frame
from runtime.vm.machine import Machine
from runtime.vm.stepping import Stepper

_JUMPS = frozenset(("JMP", "JMPC", "RET", "RETC"))


@record
class Row:
    """A rung of a program instance; its names as people know them. ``number``: of its code in the POU."""

    program: str
    pou: str
    number: int
    name: str


class Powers:
    """``rows``: the rungs of all program instances, in order. ``at``: the power at the right end of each
    as the last stepped scan left it, the OR of its ends; a rung that was not executed has none."""

    def __init__(self, machine: Machine, units: Mapping[str, Sequence[RungBuild]]) -> None:
        self._machine, self._stepper = machine, Stepper(machine)
        builds = {name.upper(): rungs for name, rungs in units.items()}
        runs = machine.program.resources[machine.resource].runs
        used = {run.pou.upper() for run in runs}
        # Between the rungs of a chart stands the code of its control; an action may be called from nowhere.
        places = {pou: {rung.key: n for n, rung in enumerate(machine.program.unit(pou).rungs)}
                  for pou in used}
        self.rows = tuple(Row(run.name, run.pou.upper(), places[run.pou.upper()][build.code.key],
                              _name(run.name, build, len(runs) > 1))
                          for run in runs for build in builds.get(run.pou.upper(), ())
                          if build.code.key in places[run.pou.upper()])
        self._ends = {(pou, places[pou][build.code.key]): dict(_ends(build.graph)) for pou in used
                      for build in builds.get(pou, ())
                      if build.graph is not None and build.code.key in places[pou]}
        self._seen: dict[tuple[str, int], dict[int, bool]] = {}
        self._called: tuple[Frame, tuple[str, int], int, Place] | None = None

    def scan(self) -> None:
        """One scan of the machine, with the same results as ``machine.scan()``, slower."""
        self._seen = {}
        self._called = None
        self._stepper.begin()
        while self._stepper.frames:
            self._watch(self._stepper.frames)
            self._stepper.step()
        self._settle()

    def at(self, row: Row) -> bool | None:
        """The power at the right end of a rung; None when the rung was not executed, or not to its end."""
        seen = self._seen.get((row.program, row.number), {})
        if any(seen.values()):
            return True
        ends = self._ends.get((row.pou, row.number), {})
        return False if ends and len(seen) == len(ends) else None

    def _watch(self, frames: list[Frame]) -> None:
        """Notes the power when the next instruction is one of an element at a right end."""
        if len(frames) > 1:
            return
        self._settle()
        frame = frames[0]
        instr, rung = frame.flat.code[frame.at], frame.flat.places[frame.at][0]
        ends = self._ends.get((frame.unit.name.upper(), rung), {})
        key = frame.path, rung
        if frame.flat.places[frame.at][1] == 0:
            self._seen[key] = {}
        end = ends.get(instr.element)
        if end is None:
            return
        if _shows(instr, end):
            self._seen[key][instr.element] = instr.op in ("JMP", "RET") or bool(frame.accumulator)
        elif end == "FUNCTION":
            self._seen[key].setdefault(instr.element, True)
        elif instr.op == "CAL" and end not in ("COIL", "JUMP"):
            place = instr.operand
            self._called = frame, key, instr.element, replace(
                place, type=BOOL, steps=(*place.steps, FieldStep(end)))

    def _settle(self) -> None:
        """After a call: the output that the power leaves by."""
        if self._called is not None:
            frame, key, element, place = self._called
            self._called = None
            try:
                self._seen[key][element] = bool(frame.value(place))
            except FAULTS:
                del self._seen[key]


def _shows(instr: Instr, end: str) -> bool:
    """Whether the accumulator before the instruction is the power of an end of this kind: a coil stores it
    (an edge coil in its last ST), a jump goes by it, and a function is passed over without it."""
    if end == "COIL":
        return instr.op in STORES
    return end == "JUMP" and instr.op in _JUMPS or end == "FUNCTION" and instr.op == "JMPCN"


def _ends(graph: RungGraph) -> Iterator[tuple[int, str]]:
    """The elements at right ends, and what they are: COIL, JUMP, FUNCTION, or a block's output pin."""
    for index, element in enumerate(graph.elements):
        if graph.tails[index] == RAIL or graph.outgoing[graph.tails[index]]:
            continue
        if not isinstance(element, Block):
            yield index, "COIL" if isinstance(element, Coil) else "JUMP"
        elif element.is_function:
            yield index, "FUNCTION"
        elif element.power_out is not None:
            yield index, element.power_out


def _name(program: str, build: RungBuild, several: bool) -> str:
    name = build.rung.name or build.code.key
    return f"{program}.{name}" if several else name
