"""A running program: the scan cycle, tasks, virtual time, faults (DESIGN sections 3, 5 and 8).

A scan latches what was written to inputs, executes the tasks that are due, and ends; time then goes on
by the base tick. Between scans all variables stand still, so whatever is read there is consistent.
What an engine does in its own way is below "of the engine"; ``runtime.vm`` and ``runtime.native`` are two.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from math import gcd

from ldc.expr import Place
from ldc.il.program import Program, Task
from ldc.records import record
from ldc.types import Type
from runtime import checksum
from runtime.faults import Fault, describe
from runtime.faults import Place as CodePlace
from runtime.forces import Forces
from runtime.layout import Layout
from runtime.outputs import Safe, declared_safe, safe_states
from runtime.symbols import Symbol, Symbols, UnknownSymbol
from runtime.values import coerce, outward

DEFAULT_TICK = 10_000_000


def base_tick(tasks: Iterable[Task]) -> int:
    """Nanoseconds between two scans when nothing says it: the greatest common divisor of the intervals."""
    return gcd(*(task.interval for task in tasks if task.interval)) or DEFAULT_TICK


@dataclass(slots=True, eq=False)
class Schedule:
    """One task: when it is due, whether it was stopped. Times in nanoseconds. ``runs``: the numbers of its
    program instances, in order."""

    task: Task
    runs: tuple[int, ...]
    due: int = 0
    single: Callable[[], bool] | None = None
    single_before: bool = False
    stopped: bool = False


@record
class Checkpoint:
    """The state of a machine between two scans. ``memory``: what its engine made of the variables;
    ``schedules``: due, single_before and stopped of each."""

    memory: object
    schedules: tuple[tuple[int, bool, bool], ...]
    scans: int
    now_ns: int
    faults: tuple[Fault, ...]
    safe: tuple[tuple[Symbol, object], ...]


@dataclass(slots=True, eq=False)
class Machine:
    """Runs one resource of a program.

    ``period_ns``: the base tick, time between two scans; None: the greatest common divisor of the
    tasks' intervals, 10 ms when there is none. A task without interval runs in every scan, one with
    an interval in the first scan at or after each multiple of it; one with SINGLE at a rising edge of
    that variable, sampled when the scan begins (and by its interval only while SINGLE is FALSE).
    Within a scan tasks go by priority, then interval (none: the base tick), then declaration.
    Raises Invalid when a declared safe value does not fit its output.
    """

    program: Program
    resource: int = 0
    period_ns: int | None = None
    scans: int = field(default=0, kw_only=True)
    now_ns: int = field(default=0, kw_only=True)
    faults: list[Fault] = field(default_factory=list, kw_only=True)
    forces: Forces = field(init=False, repr=False)
    layout: Layout = field(init=False, repr=False)
    symbols: Symbols = field(init=False, repr=False)
    schedules: list[Schedule] = field(init=False, repr=False)
    _late: list[tuple[Symbol, object]] = field(init=False, repr=False)
    _safe: list[tuple[Symbol, object]] = field(init=False, repr=False)
    _declared: Safe = field(init=False, repr=False)
    _always: bool = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.layout = self._load()
        self.symbols = Symbols(self.layout)
        self.forces = Forces(self)
        self._late, self._safe = [], []
        self._declared = declared_safe(self.program, self.symbols)
        part = self.program.resources[self.resource]
        if self.period_ns is None:
            self.period_ns = base_tick(part.tasks)
        if self.period_ns <= 0:
            raise ValueError("the period must be longer than nothing")
        schedules = []
        for number, task in enumerate(part.tasks):
            runs = tuple(n for n, run in enumerate(part.runs) if run.task.upper() == task.name.upper())
            single = self._single(task.single) if task.single is not None else None
            made = Schedule(task, runs, 0, single)
            schedules.append(((task.priority, task.interval or self.period_ns, number), made))
        self.schedules = [made for _, made in sorted(schedules, key=lambda s: s[0])]
        self._always = all(s.single is None and not s.task.interval for s in self.schedules)

    def _single(self, place: Place) -> Callable[[], bool]:
        symbol = self.symbols.find(str(place))
        return lambda: bool(self.value(symbol))

    # ---- of the engine ---------------------------------------------------------------------------

    def _load(self) -> Layout:
        """Makes memory and code ready for the first scan."""
        raise NotImplementedError

    def value(self, symbol: Symbol) -> object:
        """The machine's own value of a symbol, now."""
        raise NotImplementedError

    def assign(self, symbol: Symbol, value: object) -> None:
        """Writes one of the machine's own values, now."""
        raise NotImplementedError

    def _latch(self) -> None:
        """Inputs that were written since the last scan become visible; the time is set."""
        raise NotImplementedError

    def _execute(self, schedule: Schedule) -> None:
        """Runs the program instances of a task in order; stops the task at a fault."""
        raise NotImplementedError

    def _first_scan_done(self) -> None:
        """The first scan is over."""
        raise NotImplementedError

    def _capture(self) -> object:
        """The values of all variables, for ``_put_back``."""
        raise NotImplementedError

    def _put_back(self, memory: object) -> None:
        """All variables as they were; the same memory can be put back again."""
        raise NotImplementedError

    def prepare(self, changes: Iterable[tuple[Symbol, object]]) -> object:
        """Changes of inputs in the form that ``feed`` takes most quickly. What is prepared is fed once, in
        the same order, and nothing else writes inputs meanwhile."""
        return tuple(changes)

    def feed(self, prepared: object) -> None:
        """Writes what ``prepare`` gave: visible when the next scan begins."""
        for symbol, value in prepared:
            self.put(symbol, value)

    # ---- values ----------------------------------------------------------------------------------

    def set(self, path: str, value: object) -> None:
        """Writes a variable: an input (%I) becomes visible when the next scan begins, others at once.

        ``value``: bool, int, float or str (text of an IEC value unless the variable is a string).
        Raises UnknownSymbol for the path, ValueError for the value.
        """
        symbol = self.symbols.find(path)
        self.put(symbol, coerce(value, symbol.type))

    def put(self, symbol: Symbol, value: object) -> None:
        """``set`` for a symbol that was found and a value that was coerced before."""
        if symbol.area == "I":
            self._late.append((symbol, value))
        else:
            self.assign(symbol, value)

    def get(self, path: str) -> bool | int | float | str:
        """The value of a variable as the last scan left it. Raises UnknownSymbol."""
        symbol = self.symbols.find(path)
        return outward(self.value(symbol), symbol.type)

    def paths(self) -> list[tuple[str, Type]]:
        """Path and type of every scalar, in declared order; not the compiler's own memories."""
        return [(s.path, s.type) for s in self.symbols.all()]

    def find(self, paths: Iterable[str]) -> tuple[Symbol, ...]:
        """The symbols of some paths, for repeated access. Raises UnknownSymbol."""
        return tuple(self.symbols.find(path) for path in paths)

    def known(self, paths: Iterable[str]) -> list[Symbol | None]:
        """The symbols of some paths, None for those that are none."""
        found: list[Symbol | None] = []
        for path in paths:
            try:
                found.append(self.symbols.find(path))
            except UnknownSymbol:
                found.append(None)
        return found

    def sample(self, symbols: Iterable[Symbol]) -> list:
        """The machine's own values of some symbols, now."""
        return [self.value(symbol) for symbol in symbols]

    def reader(self, symbols: Iterable[Symbol]) -> Callable[[], tuple]:
        """``sample`` for those who ask again and again: a function of no arguments; equal tuples, equal
        values."""
        wanted = tuple(symbols)
        return lambda: tuple(map(self.value, wanted))

    def writer(self, symbols: Iterable[Symbol]) -> Callable[[Sequence], None]:
        """``assign`` for those who write the same symbols again and again: a function of their values."""
        wanted = tuple(symbols)

        def write(values: Sequence) -> None:
            for symbol, value in zip(wanted, values, strict=True):
                self.assign(symbol, value)

        return write

    def safe_values(self, runs: Iterable[int]) -> list[tuple[Symbol, object]]:
        """The outputs that some program instances (by number) write, each with its safe value."""
        return safe_states(self._declared, self.layout, self.symbols, tuple(runs))

    def outputs(self) -> Mapping[str, object]:
        """Address or path and value of every located output, as the last scan left them."""
        return {s.path: outward(self.value(s), s.type) for s in self.symbols.located("Q")}

    def checksum(self) -> str:
        """A checksum of all variables with state, the same on every engine (see ``runtime.checksum``)."""
        return checksum.of(self.symbols.all(hidden=True), self.value)

    # ---- the scan --------------------------------------------------------------------------------

    def scan(self) -> None:
        """One scan. A fault stops its task and is added to ``faults``; the others go on."""
        if self.forces.rows:
            self.forces.latch(self._latch)
        else:
            self._latch()
        for schedule in self.schedules if self._always else self.due():
            if not schedule.stopped:
                self._execute(schedule)
        self.end()

    def begin(self) -> list[Schedule]:
        """The first part of a scan for those who execute tasks themselves: latches, tells what is due."""
        self.latch()
        return [s for s in (self.schedules if self._always else self.due()) if not s.stopped]

    def pieces(self, schedule: Schedule, now_ns: int | None = None) -> Iterator[int]:
        """One execution of a task that is due, in indivisible pieces: each ``next`` executes one and tells
        what it cost, in ns. Here the task is one piece without cost. ``now_ns``: the time when it begins,
        when that is later than the scan."""
        self._execute(schedule)
        yield 0

    def settle(self) -> None:
        """What holds after the code of a scan: safe values of outputs of tasks that were stopped, forces."""
        for symbol, value in self._safe:
            self.assign(symbol, value)
        if self.forces.rows:
            self.forces.hold()

    def end(self) -> None:
        """The last part of a scan."""
        if self._safe or self.forces.rows:
            self.settle()
        if not self.scans:
            self._first_scan_done()
        self.scans += 1
        self.now_ns += self.period_ns

    def latch_late(self) -> None:
        """Inputs that were written one by one, in that order."""
        for symbol, value in self._late:
            self.assign(symbol, value)
        self._late.clear()

    def due(self) -> list[Schedule]:
        """The tasks to execute in this scan, in order; their next times are set."""
        found = []
        for schedule in self.schedules:
            interval, wanted = schedule.task.interval, False
            single = schedule.single is not None and schedule.single()
            if interval:
                wanted = self.now_ns >= schedule.due and not single
                if self.now_ns >= schedule.due:
                    schedule.due = (self.now_ns // interval + 1) * interval
            elif schedule.single is None:
                wanted = True
            if wanted or (single and not schedule.single_before):
                found.append(schedule)
            schedule.single_before = single
        return found

    def stop(self, schedule: Schedule, error: Exception, trace: tuple[CodePlace, ...]) -> None:
        """Stops a task by a fault at the last place of ``trace``; its outputs go to their safe values."""
        schedule.stopped = True
        code, message, help_ = describe(error)
        place = trace[-1] if trace else CodePlace("", "", -1)
        self.faults.append(Fault(code, message, help_, schedule.task.name, place, trace[:-1],
                                 self.scans, self.now_ns))
        self._safe += safe_states(self._declared, self.layout, self.symbols, schedule.runs)

    # ---- between two scans (DESIGN section 7) ------------------------------------------------------

    def latch(self) -> None:
        """Inputs that were written become visible now, forced ones as they are forced: no code runs before
        the next scan begins."""
        if self.forces.rows:
            self.forces.latch(self._latch)
        else:
            self._latch()

    def checkpoint(self) -> Checkpoint:
        """The state between two scans, with the inputs that were written."""
        self.latch()
        schedules = tuple((s.due, s.single_before, s.stopped) for s in self.schedules)
        return Checkpoint(self._capture(), schedules, self.scans, self.now_ns, tuple(self.faults),
                          tuple(self._safe))

    def restore(self, kept: Checkpoint) -> None:
        """Back to a state of this machine."""
        self._put_back(kept.memory)
        for schedule, (due, before, stopped) in zip(self.schedules, kept.schedules, strict=True):
            schedule.due, schedule.single_before, schedule.stopped = due, before, stopped
        self.scans, self.now_ns = kept.scans, kept.now_ns
        self.faults[:], self._safe[:] = kept.faults, kept.safe

    def close(self) -> None:
        """Gives up what the engine holds of the system, and what holds the machine itself: its memory is free
        when nobody else knows it. It is not run any more."""
        self.forces.close()
        for schedule in self.schedules:
            schedule.single = None

    def take_over(self, other: Machine) -> None:
        """Goes on where another machine stands between two scans; variables were copied before.

        Forces go on by their paths. Tasks of the same name keep when they are due and whether they are
        stopped. A further task is due at the next multiple of its interval; its SINGLE shows no edge in the
        first scan.
        """
        self.scans, self.now_ns = other.scans, other.now_ns
        self.forces = other.forces.follow(self)
        self.faults[:] = other.faults
        if self.scans:
            self._first_scan_done()
        known = {s.task.name.upper(): s for s in other.schedules}
        self._safe.clear()
        for schedule in self.schedules:
            before, interval = known.get(schedule.task.name.upper()), schedule.task.interval
            if before is not None:
                schedule.due, schedule.single_before = before.due, before.single_before
                schedule.stopped = before.stopped
            else:
                schedule.due = -(-self.now_ns // interval) * interval if interval else 0
                schedule.single_before = schedule.single is not None and schedule.single()
                schedule.stopped = False
            if schedule.stopped:
                self._safe += safe_states(self._declared, self.layout, self.symbols, schedule.runs)
