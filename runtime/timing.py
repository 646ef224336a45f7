"""Tasks of one machine that take time: each is a thread of the control level (docs/scheduling.md).

Between the tasks priority decides, as IEC 61131-3 (2.7.2) says it: one of higher priority pre-empts one of
lower between two rungs. Tasks become due at the ticks at which a machine without cost executes them at once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, MutableSequence
from operator import length_hint

from runtime.cost import Cost, Costs
from runtime.faults import Place, TaskTooLong
from runtime.machine import Machine, Schedule
from runtime.scheduler.report import Row, rows
from runtime.scheduler.scheduler import Scheduler
from runtime.scheduler.thread import Entry, Thread
from runtime.vm import paced


class Timing:
    """Runs ``machine``; a ``paced.Machine`` is pre-empted between rungs, in another one a task is one piece.

    ``watchdogs``: task name in capitals -> ns that an execution may take from its begin to its end, the time
    in which it is pre-empted included; one that takes longer is stopped by a fault at the next rung boundary.
    """

    def __init__(self, machine: Machine, cost: Cost, watchdogs: Mapping[str, int] | None = None,
                 log: MutableSequence[Entry] | None = None) -> None:
        self.machine = machine
        self._start = machine.now_ns  # after a warm start the program's time goes on, the scheduler's begins
        self._watchdogs = watchdogs or {}
        self._whole = None if isinstance(machine, paced.Machine) else _Whole(machine, cost)
        self.threads = tuple(Thread(s.task.name, "control", None, self._work(s), priority=s.task.priority)
                             for s in machine.schedules)
        self.scheduler = Scheduler([self.threads], log)

    def scan(self) -> None:
        """One tick: what is due is activated, then time goes on to the next tick. A task by SINGLE is
        activated by an event, the others by their periods."""
        for schedule in self.machine.begin():
            if schedule.single is None:
                self.scheduler.release(0, schedule.task.name)
            else:
                self.scheduler.raise_event(0, schedule.task.name)
        self.scheduler.run(self.machine.now_ns - self._start + self.machine.period_ns)
        self.machine.end()

    def rows(self) -> tuple[Row, ...]:
        """What became of the tasks so far."""
        machine = self.machine
        processor = machine.program.resources[machine.resource].processor
        return rows(processor, self.threads, self.scheduler.now_ns)

    def _work(self, schedule: Schedule):
        limit = self._watchdogs.get(schedule.task.name.upper())

        def work(now_ns: int) -> Iterator[int] | None:
            if schedule.stopped:
                return None
            if self._whole is None:
                pieces = self.machine.pieces(schedule, self._start + now_ns)
            else:
                pieces = self._whole.execute(schedule, self._start + now_ns)
            return pieces if limit is None else _Watched(pieces, self, schedule, now_ns, limit)

        return work


class _Whole:
    """Executions of tasks in one piece that costs what all rungs cost, further passes of loops left out."""

    def __init__(self, machine: Machine, cost: Cost) -> None:
        costs, part = Costs(machine.program, cost), machine.program.resources[machine.resource]
        runs = [sum(costs.rungs(machine.program.unit(run.pou))) for run in part.runs]
        self._machine = machine
        self._total = {id(s): cost.task + sum(runs[n] for n in s.runs) for s in machine.schedules}

    def execute(self, schedule: Schedule, now_ns: int) -> Iterator[int]:
        deque(self._machine.pieces(schedule, now_ns), maxlen=0)
        return iter((self._total[id(schedule)],))


class _Watched:
    """The pieces of an execution that may last ``limit`` ns from ``began``."""

    def __init__(self, pieces: Iterator[int], timing: Timing, schedule: Schedule, began: int,
                 limit: int) -> None:
        self._pieces, self._timing, self._schedule = pieces, timing, schedule
        self._began, self._limit = began, limit

    def _lasts(self) -> int:
        return self._timing.scheduler.now_ns - self._began

    def __iter__(self) -> _Watched:
        return self

    def __length_hint__(self) -> int:
        # One that ended too late has to be asked once more, for its fault.
        return length_hint(self._pieces, 1) or self._lasts() > self._limit

    def __next__(self) -> int:
        lasts = self._lasts()
        if lasts > self._limit and not self._schedule.stopped:
            self._timing.machine.stop(self._schedule, TaskTooLong(lasts, self._limit), (self._place(),))
        if self._schedule.stopped:
            raise StopIteration
        return next(self._pieces)

    def _place(self) -> Place:
        """The rung that was executed last; of a task in one piece its last one."""
        if isinstance(self._pieces, paced.Pieces):
            return self._pieces.place
        program = self._timing.machine.program
        run = program.resources[self._timing.machine.resource].runs[self._schedule.runs[-1]]
        unit = program.unit(run.pou)
        last = unit.rungs[-1]
        return Place(unit.name, last.key, -1, -1, last.span)
