"""L, the customised program: the sequence of modules that the customised thread executes (SPEC 4,
docs/messages.md).

The program lies in ACPDD as frames (``frames.py``), in one of two buffers. For each step the customised
thread offers its frame (``cb`` := 1); the control thread copies the parameters to LCD, sets the start bit and
confirms (``ca`` := 1); cb := 0; ca := 0. Then the customised thread waits until the module has ended.

A new program goes into the other buffer. The control thread makes it the active one at a boundary: while no
step is offered or runs. What remains of the cycle then follows the module that ended last. State is in words
of ACPDD, so it survives a change of the master's program. What the real L does beyond this is not known: the
papers only cite it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import IntEnum
from struct import Struct

from ldc.il.areas import areas
from ldc.il.coordination import Sequence
from ldc.records import record
from runtime.master.frames import Frame, buffer, conditions, following, frames, parsed
from runtime.protocol.memory import Memory, bit

_ACTIVE, _SEEN, _PHASE, _STEP, _MODULE, _CYCLES, _STAGED = (
    areas()["ACPDD"].base + at for at in range(0, 28, 4))
_STATE = Struct("=IIIII")
"""The first of them."""

_CB, _CA = (bit(areas()["ACPF"].base + at) for at in (0, 32))
_LCF = areas()["LCF"].base

Reader = Callable[[], bool]
Readers = Callable[[str], Reader]


class Phase(IntEnum):
    """Of the customised thread. IDLE: no cycle runs; NEXT: the next step waits for its condition; OFFERED:
    the control thread has to take it; RUNNING: its module is in work; DONE: without ``repeat``, the cycle is
    over and ``start`` has to fall."""

    IDLE = 0
    NEXT = 1
    OFFERED = 2
    RUNNING = 3
    DONE = 4


_PHASES = tuple(Phase)
_RUNNING = Phase.RUNNING
BOUNDARY = (Phase.IDLE, Phase.NEXT, Phase.DONE)
"""When a new program may become the active one."""


@record
class Started:
    """The control thread has taken a step: the start bit of ``module`` and the words at ``addresses`` in LCD
    were written."""

    module: int
    addresses: tuple[int, ...]


@record
class Exchanged:
    """The program of that generation is the active one."""

    generation: int


@record
class Refused:
    """The program of that generation was damaged in memory; the one before goes on."""

    generation: int


Event = Started | Exchanged | Refused


@record
class Awaited:
    """What the customised thread waits for. ``number``: of the step, from 1, 0 before the first one;
    ``module``: of the step; ``path``: of the condition, "" when the module has to end."""

    number: int
    steps: int
    module: str
    path: str


@record
class _Program:
    sequence: Sequence
    frames: tuple[Frame, ...]
    conditions: tuple[Reader | None, ...]
    start: int


_EMPTY = _Program(Sequence(()), (), (None,), 0)


class Customised:
    """Both ends of L over the memory of a master. ``readers``: a path to what reads it now, raises
    LookupError; a condition whose variable a change of the program took away counts as TRUE. ``moves``: how
    often the customised thread has gone on."""

    __slots__ = ("moves", "_memory", "_readers", "_programs", "_last")

    def __init__(self, memory: Memory, readers: Readers) -> None:
        self._memory, self._readers = memory, readers
        self._programs = [_EMPTY, _EMPTY]
        self.moves, self._last = 0, None

    @property
    def phase(self) -> Phase:
        return _PHASES[self._memory.data.load(_PHASE)]

    @property
    def cycles(self) -> int:
        """Cycles that have ended."""
        return self._memory.data.load(_CYCLES)

    @property
    def step(self) -> int:
        """How many steps of this cycle have ended."""
        return self._memory.data.load(_STEP)

    @property
    def awaited(self) -> Awaited | None:
        """What the next thing has to wait for; None when there is nothing more to come."""
        data, phase = self._memory.data, self.phase
        program = self._programs[data.load(_SEEN)].sequence
        number, steps = data.load(_STEP), len(program.steps)
        if phase is Phase.IDLE:
            return Awaited(0, steps, "", program.start) if program.start else None
        if phase is Phase.DONE or number >= steps:
            return None
        step = program.steps[number]
        path = step.when or "" if phase is Phase.NEXT else "" if self._in_work() else step.until or ""
        return Awaited(number + 1, steps, step.name, path)

    def stage(self, sequence: Sequence) -> int:
        """Hands a program over, which begins at the next boundary; its generation. One that was handed over
        and has not begun is replaced. Raises TooLong."""
        data = self._memory.data
        active = data.load(_ACTIVE)
        generation = data.load(buffer(active)) + 1
        content = frames(sequence, generation)
        data.store(_STAGED, 0)
        data.write(buffer(1 - active), content)
        self._programs[1 - active] = self._program(sequence, ())
        data.store(_STAGED, generation)
        return generation

    def bind(self, readers: Readers) -> None:
        """Conditions are read by these from now on: another machine executes the program."""
        self._readers = readers
        self._programs = [self._program(p.sequence, p.frames) for p in self._programs]

    def change(self, sequence: Sequence, modules: Mapping[str, int], readers: Readers) -> int:
        """Between two scans, with a change of the master's program: as ``stage``. ``modules``: the new
        indices by names in capitals. A module of a step that runs keeps running; when it is gone, it has
        ended."""
        data, bits = self._memory.data, self._memory.bits
        self.bind(readers)
        if self.phase is Phase.OFFERED:
            bits.clear(*_CB)
            data.store(_PHASE, Phase.RUNNING if bits.test(*_CA) else Phase.NEXT)
        if self.phase is Phase.RUNNING:
            program = self._programs[data.load(_SEEN)]
            name = program.sequence.steps[data.load(_STEP)].name.upper()
            data.store(_MODULE, modules.get(name, -1) + 1)
        return self.stage(sequence)

    def _program(self, sequence: Sequence, made: tuple[Frame, ...]) -> _Program:
        paths = conditions(sequence)
        return _Program(sequence, made, (None, *map(self._reader, paths)),
                        paths.index(sequence.start) + 1 if sequence.start else 0)

    def _reader(self, path: str) -> Reader | None:
        try:
            return self._readers(path)
        except LookupError:
            return None

    def control(self) -> tuple[Event, ...]:
        """What the control thread does at the begin of a scan (C.START)."""
        data, bits = self._memory.data, self._memory.bits
        events: tuple[Event, ...] = ()
        if (generation := data.load(_STAGED)) and data.load(_PHASE) in BOUNDARY:
            events = (self._exchange(generation),)
        if bits.test(*_CB):
            if not bits.test(*_CA):
                frame = self._programs[data.load(_ACTIVE)].frames[data.load(_STEP)]
                for address, words in frame.parameters:
                    data.write(address, words)
                bits.set(*bit(_LCF + frame.module))
                bits.set(*_CA)
                events += (Started(frame.module, tuple(address for address, _ in frame.parameters)),)
        elif bits.test(*_CA):
            bits.clear(*_CA)
        return events

    def _exchange(self, generation: int) -> Event:
        data = self._memory.data
        other = 1 - data.load(_ACTIVE)
        made = parsed(data, other)
        data.store(_STAGED, 0)
        if made is None:
            return Refused(generation)
        program = self._programs[other]
        self._programs[other] = _Program(program.sequence, made, program.conditions, program.start)
        data.store(_ACTIVE, other)
        return Exchanged(generation)

    def execute(self) -> None:
        """What the customised thread does in the rest of a scan."""
        data, bits = self._memory.data, self._memory.bits
        active, seen, now, _, module = _STATE.unpack(data.read(_ACTIVE, _STATE.size))
        if (now == _RUNNING and self._last is _RUNNING and active == seen and module
                and bits.test(*bit(_LCF + module - 1))):
            return  # as nearly always: its module is in work
        program = self._programs[active]
        if active != seen:
            old = self._programs[seen].sequence
            data.store(_STEP, following(old, data.load(_STEP), program.sequence))
            data.store(_SEEN, active)
            self._last = None
        phase = self.phase
        if phase is Phase.OFFERED and self._memory.bits.test(*_CA):
            data.store(_MODULE, program.frames[data.load(_STEP)].module + 1)
            self._memory.bits.clear(*_CB)
            phase = Phase.RUNNING
        elif phase is Phase.RUNNING and self._ended(program):
            data.store(_STEP, data.load(_STEP) + 1)
            phase = Phase.NEXT
        if phase is Phase.DONE and (program.sequence.repeat or not _true(program, program.start)):
            phase = Phase.IDLE
        if phase is Phase.NEXT and data.load(_STEP) >= len(program.frames):
            data.store(_STEP, 0)
            data.store(_CYCLES, data.load(_CYCLES) + 1)
            phase = Phase.IDLE if program.sequence.repeat else Phase.DONE
        # A program that waits to become active gets the boundary, whatever could be offered now.
        if not data.load(_STAGED):
            if phase is Phase.IDLE and program.frames and _true(program, program.start):
                phase = Phase.NEXT
            if phase is Phase.NEXT and not self._memory.bits.test(*_CA) and _true(
                    program, program.frames[data.load(_STEP)].when):
                self._memory.bits.set(*_CB)
                phase = Phase.OFFERED
        data.store(_PHASE, phase)
        if phase is not self._last:
            self._last = phase
            self.moves += 1

    def _in_work(self) -> bool:
        """The module of the step that runs has not ended."""
        module = self._memory.data.load(_MODULE)
        return bool(module) and self._memory.bits.test(*bit(_LCF + module - 1))

    def _ended(self, program: _Program) -> bool:
        return not self._in_work() and _true(program, program.frames[self._memory.data.load(_STEP)].until)

    def reset(self) -> None:
        """After an emergency: no step is offered or runs; the next cycle begins with its first step."""
        self._memory.bits.clear(*_CB)
        self._memory.bits.clear(*_CA)
        for word in (_STEP, _MODULE, _PHASE):
            self._memory.data.store(word, 0)
        self._last = None


def _true(program: _Program, number: int) -> bool:
    """A condition: none, or one whose variable is gone, is TRUE."""
    reader = program.conditions[number]
    return reader is None or bool(reader())
