"""A running program: the scan cycle, tasks, virtual time, faults (DESIGN sections 3, 5 and 8).

A scan latches what was written to inputs, executes the tasks that are due, and ends; time then goes on
by the base tick. Between scans all variables stand still, so whatever is read there is consistent.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from math import gcd

from ldc.expr import Place
from ldc.il.external import Binding
from ldc.il.program import Program, Task
from ldc.types import Type
from runtime import checksum
from runtime.faults import FAULTS, Fault, describe
from runtime.faults import Place as CodePlace
from runtime.values import coerce, outward
from runtime.vm.layout import FIRST_SCAN, NOW
from runtime.vm.loader import Code, Watchdog, load
from runtime.vm.outputs import Safe, declared_safe, safe_states
from runtime.vm.symbols import Symbol, Symbols, is_cell

DEFAULT_TICK = 10_000_000


@dataclass(slots=True, eq=False)
class Schedule:
    """One task: when it is due, whether it was stopped. Times in nanoseconds."""

    task: Task
    bodies: tuple[Callable[[], None], ...]
    runs: tuple[int, ...]
    due: int = 0
    single: Callable[[], bool] | None = None
    single_before: bool = False
    stopped: bool = False


@dataclass(slots=True, eq=False)
class Machine:
    """Runs one resource of a program.

    ``period_ns``: the base tick, time between two scans; None: the greatest common divisor of the
    tasks' intervals, 10 ms when there is none. A task without interval runs in every scan, one with
    an interval in the first scan at or after each multiple of it; one with SINGLE at a rising edge of
    that variable, sampled when the scan begins (and by its interval only while SINGLE is FALSE).
    Within a scan tasks go by priority, then interval (none: the base tick), then declaration.
    ``bindings``: where the native code of components is. Raises Invalid when a declared safe value does
    not fit its output.
    """

    program: Program
    resource: int = 0
    period_ns: int | None = None
    bindings: tuple[Binding, ...] = ()
    scans: int = 0
    now_ns: int = 0
    faults: list[Fault] = field(default_factory=list)
    code: Code = field(init=False, repr=False)
    symbols: Symbols = field(init=False, repr=False)
    pending: dict[str, object] = field(init=False, repr=False)
    schedules: list[Schedule] = field(init=False, repr=False)
    _late: list[tuple[Symbol, object]] = field(init=False, repr=False)
    _safe: list[tuple[Symbol, object]] = field(init=False, repr=False)
    _declared: Safe = field(init=False, repr=False)
    _always: bool = field(init=False, repr=False)
    _namespace: dict[str, object] = field(init=False, repr=False)
    _watchdog: Watchdog = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self.code = load(self.program, self.resource, self.bindings)
        self._namespace, self._watchdog = self.code.namespace, self.code.watchdog
        self.symbols = Symbols(self.code.layout)
        self.pending, self._late, self._safe = {}, [], []
        self._declared = declared_safe(self.program, self.symbols)
        part = self.program.resources[self.resource]
        if self.period_ns is None:
            self.period_ns = gcd(*(t.interval for t in part.tasks if t.interval)) or DEFAULT_TICK
        if self.period_ns <= 0:
            raise ValueError("the period must be longer than nothing")
        schedules = []
        for number, task in enumerate(part.tasks):
            runs = tuple(n for n, run in enumerate(part.runs) if run.task.upper() == task.name.upper())
            single = self._single(task.single) if task.single is not None else None
            made = Schedule(task, tuple(self.code.bodies[n] for n in runs), runs, 0, single)
            schedules.append(((task.priority, task.interval or self.period_ns, number), made))
        self.schedules = [made for _, made in sorted(schedules, key=lambda s: s[0])]
        self._always = all(s.single is None and not s.task.interval for s in self.schedules)

    def _single(self, place: Place) -> Callable[[], bool]:
        symbol = self.symbols.find(str(place))
        return lambda: symbol.get(self._namespace)

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
        if symbol.area != "I":
            symbol.set(self._namespace, value)
        elif is_cell(symbol):
            self.pending[symbol.home.name] = value
        else:
            self._late.append((symbol, value))

    def feed(self, cells: dict[str, object]) -> None:
        """Many inputs at once, by the cell that ``Symbol.home`` names; the machine keeps the dictionary."""
        if self.pending:
            self.pending.update(cells)
        else:
            self.pending = cells

    def get(self, path: str) -> bool | int | float | str:
        """The value of a variable as the last scan left it. Raises UnknownSymbol."""
        symbol = self.symbols.find(path)
        return outward(symbol.get(self._namespace), symbol.type)

    def paths(self) -> list[tuple[str, Type]]:
        """Path and type of every scalar, in declared order; not the compiler's own memories."""
        return [(s.path, s.type) for s in self.symbols.all()]

    def find(self, paths: Iterable[str]) -> tuple[Symbol, ...]:
        """The symbols of some paths, for repeated access. Raises UnknownSymbol."""
        return tuple(self.symbols.find(path) for path in paths)

    def sample(self, symbols: Iterable[Symbol]) -> list:
        """The machine's own values of some symbols, now."""
        namespace = self._namespace
        return [symbol.get(namespace) for symbol in symbols]

    def outputs(self) -> Mapping[str, object]:
        """Address or path and value of every located output, as the last scan left them."""
        return {s.path: outward(s.get(self._namespace), s.type) for s in self.symbols.located("Q")}

    def checksum(self) -> str:
        """A checksum of all variables with state, the same on every engine (see ``runtime.checksum``)."""
        return checksum.of(self.symbols.all(hidden=True), self._namespace)

    # ---- the scan --------------------------------------------------------------------------------

    def scan(self) -> None:
        """One scan. A fault stops its task and is added to ``faults``; the others go on."""
        namespace, watchdog = self._namespace, self._watchdog
        if self.pending:
            namespace.update(self.pending)
            self.pending = {}
        if self._late:
            self.latch_late()
        namespace[NOW] = self.now_ns
        for schedule in self.schedules if self._always else self.due():
            if not schedule.stopped:
                watchdog.left = watchdog.limit = schedule.task.watchdog
                try:
                    for body in schedule.bodies:
                        body()
                except FAULTS as error:
                    self.stop(schedule, error, self.code.trace(error.__traceback__))
        if self._safe:
            self._hold_safe()
        if not self.scans:
            namespace[FIRST_SCAN] = False
        self.scans += 1
        self.now_ns += self.period_ns

    def begin(self) -> list[Schedule]:
        """The first part of a scan for an engine that executes tasks itself: latches, tells what is due."""
        namespace = self._namespace
        namespace.update(self.pending)
        self.pending = {}
        self.latch_late()
        namespace[NOW] = self.now_ns
        return [s for s in (self.schedules if self._always else self.due()) if not s.stopped]

    def end(self) -> None:
        """The last part of a scan that ``begin`` started."""
        self._hold_safe()
        self._namespace[FIRST_SCAN] = False
        self.scans += 1
        self.now_ns += self.period_ns

    def latch_late(self) -> None:
        """Input values that are parts of something (packed bits, array elements), in the order written."""
        for symbol, value in self._late:
            symbol.set(self._namespace, value)
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
        self._safe += safe_states(self._declared, self.code.layout, self.symbols, schedule.runs)

    def _hold_safe(self) -> None:
        for symbol, value in self._safe:
            symbol.set(self._namespace, value)
