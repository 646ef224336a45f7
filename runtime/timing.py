"""Tasks of one machine that take time: each is a thread of the control level (docs/scheduling.md).

Between the tasks priority decides, as IEC 61131-3 (2.7.2) says it: one of higher priority pre-empts one of
lower between two rungs. Tasks become due at the ticks at which a machine without cost executes them at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, MutableSequence
from operator import length_hint

from runtime.faults import Place, TaskOverdue, TaskTooLong
from runtime.machine import Machine, Schedule
from runtime.pieces import Pieces
from runtime.scheduler.report import Row, rows
from runtime.scheduler.scheduler import OVERRUNS, Scheduler
from runtime.scheduler.thread import Entry, Thread, Work


class Executions:
    """How tasks of ``machine``, which executes in pieces (``runtime.pieces``), take their time.

    ``watchdogs``: task name in capitals -> ns that an execution may take from its begin to its end by
    ``clock``, the time in which it is pre-empted included; one that takes longer is stopped by a fault at its
    next rung.
    """

    def __init__(self, machine: Machine, watchdogs: Mapping[str, int], clock: Callable[[], int]) -> None:
        self.machine, self.clock = machine, clock
        self._watchdogs = watchdogs

    def begin(self, schedule: Schedule, now_ns: int) -> Iterator[int]:
        """The pieces of one execution. ``now_ns``: what its timers see."""
        pieces = self.machine.pieces(schedule, now_ns)
        limit = self._watchdogs.get(schedule.task.name.upper())
        return pieces if limit is None else _Watched(pieces, self, schedule, limit)

    def place(self, schedule: Schedule, pieces: Iterator[int] | None) -> Place:
        """The rung of an execution that was executed last; of one that has not begun, the last of its
        task."""
        while isinstance(pieces, _Watched):
            pieces = pieces.pieces
        if isinstance(pieces, Pieces):
            return pieces.place
        machine = self.machine
        run = machine.program.resources[machine.resource].runs[schedule.runs[-1]]
        unit = machine.program.unit(run.pou)
        key, span = (unit.rungs[-1].key, unit.rungs[-1].span) if unit.rungs else ("", None)
        return Place(unit.name, key, -1, -1, span)


class _Watched:
    """The pieces of an execution that may last ``limit`` ns from its first piece."""

    def __init__(self, pieces: Iterator[int], by: Executions, schedule: Schedule, limit: int) -> None:
        self.pieces, self._by, self._schedule, self._limit = pieces, by, schedule, limit
        self._began: int | None = None

    def _lasts(self) -> int:
        if self._began is None:
            self._began = self._by.clock()
        return self._by.clock() - self._began

    def __iter__(self) -> _Watched:
        return self

    def __length_hint__(self) -> int:
        # One that ended too late has to be asked once more, for its fault.
        return length_hint(self.pieces, 1) or self._lasts() > self._limit

    def __next__(self) -> int:
        lasts = self._lasts()
        if lasts > self._limit and not self._schedule.stopped:
            error = TaskTooLong(lasts, self._limit)
            self._by.machine.stop(self._schedule, error, (self._by.place(self._schedule, self.pieces),))
        if self._schedule.stopped:
            raise StopIteration
        return next(self.pieces)


class Timing:
    """Runs ``machine``, its tasks as threads; ``watchdogs`` as of Executions; ``log``: of the scheduler."""

    def __init__(self, machine: Machine, watchdogs: Mapping[str, int] | None = None,
                 log: MutableSequence[Entry] | None = None) -> None:
        self.machine = machine
        self._executions = Executions(machine, watchdogs or {}, lambda: self.scheduler.now_ns)
        self.threads = tuple(map(self._thread, machine.schedules))
        self.scheduler = Scheduler([self.threads], log)
        self.scheduler.now_ns = self._began = machine.now_ns

    def scan(self) -> None:
        """One tick: what is due is activated, then time goes on to the next tick. A task by SINGLE is
        activated by an event, the others by their periods."""
        for schedule in self.machine.begin():
            thread = self.scheduler.thread(0, schedule.task.name)
            if schedule.single is None:
                self.scheduler.release(thread)
            else:
                self.scheduler.raise_event(thread)
        self.scheduler.run(self.machine.now_ns + self.machine.period_ns)
        self.machine.end()

    def rows(self) -> tuple[Row, ...]:
        """What became of the tasks so far."""
        machine = self.machine
        processor = machine.program.resources[machine.resource].processor
        return rows(processor, self.threads, self.scheduler.now_ns, self._began)

    def _thread(self, schedule: Schedule) -> Thread:
        def overdue(now_ns: int) -> None:
            """R3: the task is stopped at its next rung."""
            lasts, period = now_ns - thread.released, schedule.task.interval or self.machine.period_ns
            error = TaskOverdue(OVERRUNS, period, max(thread.counts.worst, lasts))
            self.machine.stop(schedule, error, (self._executions.place(schedule, thread.pieces),))

        thread = Thread(schedule.task.name, "control", None, self._work(schedule),
                        priority=schedule.task.priority, on_watchdog=overdue)
        return thread

    def _work(self, schedule: Schedule) -> Work:
        def work(now_ns: int) -> Iterator[int] | None:
            return None if schedule.stopped else self._executions.begin(schedule, now_ns)

        return work
