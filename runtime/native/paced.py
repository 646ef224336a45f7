"""A native machine whose tasks can be pre-empted between rungs, and whose code takes time.

Its code was built to be executed piece by piece (``ldc.backends.c.emit.plan`` with a cost); pieces, costs and
results are those of ``runtime.vm.paced``.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial

from ldc.records import record
from runtime.cost import Cost
from runtime.machine import Schedule
from runtime.native import machine
from runtime.pieces import PieceCosts, Pieces, piece_costs

# Of ldc_pace by number: words of 64 bits, then of 32 bits.
_NOW, _WATCHDOG, _SPENT = 0, 1, 2
_FIRST_SCAN, _PART, _AT = 6, 7, 8
_BEGIN = 0xFFFF_FFFF
_ENDS, _FAULT = -1, -2


@record
class Pace:
    """Of a program instance: ``step`` executes its next piece; its ``ldc_pace`` as words of 64 and 32 bits;
    ``firsts``: the number of the first rung of each piece."""

    step: Callable[[], int]
    words: memoryview
    halves: memoryview
    firsts: tuple[int, ...]


@dataclass(slots=True, eq=False)
class Machine(machine.Machine):
    """``cost``: what execution costs; the native code was built for it. A scan by ``scan`` takes no time: who
    executes tasks by ``pieces`` lets it go by."""

    cost: Cost = field(kw_only=True)
    paces: tuple[Pace, ...] = field(init=False, repr=False)
    _costs: PieceCosts = field(init=False, repr=False)

    def __post_init__(self) -> None:
        machine.Machine.__post_init__(self)
        self._costs = piece_costs(self, self.cost)
        runs = len(self.layout.programs)
        parts = self.native.map[len(self.native.map) - runs:]
        self.paces = tuple(self._pace(number, firsts or (0,)) for number, (_, firsts) in enumerate(parts))

    def _pace(self, number: int, firsts: tuple[int, ...]) -> Pace:
        pointer, view = self.library.pace()
        step = partial(self._run, self._pointer, number, pointer)
        return Pace(step, view[:24].cast("q"), view[:40].cast("I"), firsts)

    def _entry(self) -> Callable[..., int]:
        return self.library.step

    def _execute(self, schedule: Schedule) -> None:
        deque(self.pieces(schedule), maxlen=0)

    def pieces(self, schedule: Schedule, now_ns: int | None = None) -> Iterator[int]:
        now = self.now_ns if now_ns is None else now_ns
        return _Pieces(self, schedule, now, self._costs, self.cost.task)


class _Pieces(Pieces):
    """``_pace``: of the program instance in work."""

    __slots__ = ("_pace",)

    def _begin(self, number: int) -> None:
        pace = self._pace = self._machine.paces[number]
        pace.words[_NOW], pace.words[_WATCHDOG] = self._now, min(self._left, machine.MOST)
        pace.halves[_FIRST_SCAN], pace.halves[_AT] = self._first, _BEGIN

    def __next__(self) -> int:
        schedule = self._schedule
        if not self._goes_on or schedule.stopped:
            raise StopIteration
        pace, costs = self._pace, self._costs
        status = pace.step()
        if status == _FAULT:
            on = self._machine
            on.stop(schedule, *on.library.fault(on.memory, schedule.task.watchdog))
            self._goes_on = False
            return 0
        rung = self._rung = pace.firsts[pace.halves[_PART]]
        spent = costs[rung] + pace.words[_SPENT] + self._extra
        self._extra = 0
        if status == _ENDS:
            self._left = pace.words[_WATCHDOG]
            self._enter()
        return spent
