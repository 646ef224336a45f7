"""A machine executed one IL instruction at a time, for debugging: same memory, same results, bit by bit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from ldc.il.flat import Flat, flatten
from ldc.il.program import ARITHMETIC, COMPARISON, LOGIC, Instr, Unit
from ldc.types import BOOL, Type, storage
from runtime.faults import FAULTS
from runtime.faults import Place as CodePlace
from runtime.vm.frame import Frame, enter_function
from runtime.vm.machine import Machine, Schedule

_COMPARE: dict[str, Callable] = {
    "GT": lambda a, b: a > b, "GE": lambda a, b: a >= b, "EQ": lambda a, b: a == b,
    "NE": lambda a, b: a != b, "LE": lambda a, b: a <= b, "LT": lambda a, b: a < b}


@dataclass(slots=True, eq=False)
class Stepper:
    """Steps through the scans of ``machine``; between its scans ``machine.scan()`` may be used as well.

    ``breakpoints``: (POU, rung key) where ``run`` stops before the first instruction of the rung.
    ``frames``: the POUs in execution, the innermost last; empty between scans.
    """

    machine: Machine
    breakpoints: set[tuple[str, str]] = field(default_factory=set)
    frames: list[Frame] = field(default_factory=list)
    _todo: list[tuple[Schedule, list[int]]] = field(default_factory=list)
    _flats: dict[str, Flat] = field(default_factory=dict)
    _in_scan: bool = False

    @property
    def place(self) -> CodePlace | None:
        """The instruction that the next step executes; None between scans."""
        return self.frames[-1].place if self.frames else None

    @property
    def accumulator(self) -> object:
        """The current result of the innermost POU; None when it is undefined."""
        return self.frames[-1].accumulator if self.frames else None

    @property
    def deferred(self) -> tuple[tuple[str, object], ...]:
        """Operators and left operands that wait for ``)`` in the innermost POU, the outermost first."""
        return tuple((op, value) for op, value, _, _ in self.frames[-1].deferred) if self.frames else ()

    def begin(self) -> CodePlace | None:
        """Begins a scan when none is open, executes nothing. The first place, None when nothing is due."""
        if not self._in_scan:
            self._begin()
        return self.place

    def step(self) -> CodePlace | None:
        """Executes one instruction, beginning a scan when none is open. The next place, None at the end."""
        if not self._in_scan:
            self._begin()
        if self.frames:
            try:
                self._execute()
                self._settle()
            except FAULTS as error:
                self._fault(error)
                self._settle()
        return self.place

    def step_rung(self) -> CodePlace | None:
        """Steps until another rung or another POU begins, or the scan ends."""
        before = self._rung()
        self.step()
        while self.frames and self._rung() == before:
            self.step()
        return self.place

    def run(self) -> CodePlace | None:
        """Steps until a breakpoint or the end of the scan."""
        was = self._rung()
        while True:
            place = self.step()
            now = self._rung()
            if place is None or (now != was and (place.pou, place.rung) in self.breakpoints):
                return place
            was = now

    def scan(self) -> None:
        """The rest of the scan, or a whole one, breakpoints aside."""
        self.step()
        while self.frames:
            self.step()

    def _rung(self) -> tuple[int, str, str] | None:
        place = self.place
        return (len(self.frames), place.pou, place.rung) if place else None

    # ---- tasks -----------------------------------------------------------------------------------

    def _begin(self) -> None:
        self._in_scan = True
        self._todo = [(s, list(s.runs)) for s in self.machine.begin()]
        self._settle()

    def _settle(self) -> None:
        """Leaves POUs that are at their end, and enters the next program; ends the scan after the last."""
        while True:
            while self.frames and self.frames[-1].at >= len(self.frames[-1].flat.code):
                self._leave()
            if self.frames:
                return
            if not self._todo:
                self._in_scan = False
                self.machine.end()
                return
            schedule, runs = self._todo[0]
            if runs == list(schedule.runs):
                self.machine.code.watchdog.start(schedule.task.watchdog)
            if not runs:
                self._todo.pop(0)
                continue
            number = runs.pop(0)
            run, _ = self.machine.code.layout.programs[number]
            unit = self.machine.code.layout.units[run.pou.upper()]
            self.frames.append(Frame(self.machine.code, unit, self._flat(unit), run.name, program=number))

    def _flat(self, unit: Unit) -> Flat:
        key = unit.name.upper()
        if key not in self._flats:
            self._flats[key] = flatten(unit)
        return self._flats[key]

    def _fault(self, error: Exception) -> None:
        schedule, _ = self._todo.pop(0)
        trace = tuple(frame.place for frame in self.frames)
        self.frames.clear()
        self.machine.stop(schedule, error, trace)

    # ---- instructions ----------------------------------------------------------------------------

    def _execute(self) -> None:
        frame = self.frames[-1]
        instr = frame.flat.code[frame.at]
        op = instr.op
        if op in ("LD", "LDN"):
            frame.accumulator, frame.type = frame.value(instr.operand), instr.operand.type
            if op == "LDN":
                frame.accumulator = _inverted(frame.accumulator, frame.type)
        elif op in ("ST", "STN"):
            value = frame.accumulator
            frame.store(instr.operand, _inverted(value, frame.type) if op == "STN" else value)
        elif op in ("S", "R"):
            if frame.accumulator:
                frame.store(instr.operand, op == "S")
        elif op == "NOT":
            frame.accumulator = _inverted(frame.accumulator, frame.type)
        elif op == ")":
            deferred, left, left_type, type_ = frame.deferred.pop()
            self._apply(frame, deferred, left, left_type, frame.accumulator, frame.type, type_)
        elif op[-1] == "(":
            frame.deferred.append((op[:-1], frame.accumulator, frame.type, instr.type))
            frame.accumulator = None
            if instr.operand is not None:
                frame.accumulator, frame.type = frame.value(instr.operand), instr.operand.type
        elif op == "EXT":
            code = self.machine.code
            code.namespace[code.calls.native(frame.unit)](frame.owner, frame.value(instr.operand))
            frame.accumulator = None
        elif instr.operand is not None and op not in ("CAL", "CALC", "CALCN"):
            right = frame.value(instr.operand)
            self._apply(frame, op, frame.accumulator, frame.type, right, instr.operand.type, instr.type)
        elif op == "FN":
            self._function(frame, instr)
            return
        elif op != "LABEL":
            self._branch(frame, instr)
            return
        else:
            frame.accumulator = None
        frame.at += 1

    def _apply(self, frame: Frame, op: str, left, left_type: Type, right, right_type: Type,
               type_: Type) -> None:
        if op in ("ANDN", "ORN", "XORN"):
            op, right = op[:-1], _inverted(right, right_type)
        if op in COMPARISON:
            frame.accumulator, frame.type = _COMPARE[op](left, right), BOOL
            return
        if op in LOGIC:
            value = left & right if op == "AND" else left | right if op == "OR" else left ^ right
            frame.accumulator, frame.type = value, storage(left_type)
            return
        if op not in ARITHMETIC:
            raise ValueError(f"{op} takes no operand")
        meaning = self.machine.code.calls.meaning_of(op, (left_type, right_type), type_)
        frame.accumulator, frame.type = meaning(left, right), type_

    def _branch(self, frame: Frame, instr: Instr) -> None:
        op = instr.op
        taken = op in ("JMP", "CAL", "RET") or bool(frame.accumulator) is not op.endswith("CN")
        here, frame.at = frame.at, frame.at + 1
        if op == "CAL":
            frame.accumulator = None
        if not taken:
            return
        if op.startswith("JMP"):
            target = frame.flat.targets[here]
            if target <= here:
                frame.at = here
                self.machine.code.watchdog.tick()
            frame.at = target
            frame.accumulator = None
        elif op.startswith("RET"):
            frame.at = len(frame.flat.code)
        else:
            frame.at = here
            owner = frame.value(instr.operand)
            unit = self.machine.code.layout.units[instr.operand.type.pou.upper()]
            self.frames.append(Frame(self.machine.code, unit, self._flat(unit), str(instr.operand), owner))

    def _function(self, frame: Frame, instr: Instr) -> None:
        calls = self.machine.code.calls
        unit = calls.function(instr.name)
        first = [] if calls.ignores_accumulator(instr.name) else [(frame.accumulator, frame.type)]
        given = first + [(frame.value(a), a.type) for a in instr.args]
        if unit is not None:
            values = [v for v, _ in given]
            self.frames.append(enter_function(self.machine.code, unit, self._flat(unit), values))
            return
        meaning = calls.meaning_of(instr.name, tuple(t for _, t in given), instr.type)
        frame.accumulator, frame.type = meaning(*(v for v, _ in given)), instr.type
        frame.at += 1

    def _leave(self) -> None:
        """Ends the innermost POU; its caller goes on, with the result and outputs when it was a FUNCTION."""
        done = self.frames.pop()
        if not self.frames:
            return
        frame = self.frames[-1]
        if done.unit.kind == "FUNCTION":
            instr = frame.flat.code[frame.at]
            frame.accumulator, frame.type = done.locals.get(done.unit.name.upper()), instr.type
            for name, place in instr.outputs:
                frame.store(place, done.locals[name.upper()])
        frame.at += 1


def _inverted(value, type_: Type):
    type_ = storage(type_)
    return not value if type_ == BOOL else value ^ type_.range[1]
