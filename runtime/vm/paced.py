"""A virtual machine whose tasks can be pre-empted between rungs, and whose code takes time.

The body of a PROGRAM is a generator that stops between rungs; blocks and functions called in a rung belong to
its piece, and so do loops inside of it. Results are those of the machine that executes at once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import accumulate

from ldc.il.program import Unit
from runtime.cost import Cost, Costs
from runtime.faults import FAULTS, Place
from runtime.layout import FIRST_SCAN, NOW
from runtime.machine import Schedule
from runtime.vm import machine
from runtime.vm.calls import Calls
from runtime.vm.codegen import Body
from runtime.vm.loader import Code, Watchdog, load
from runtime.vm.names import Names
from runtime.vm.writer import FORGETS


class PacedBody(Body):
    """``costs``: what each backward jump adds is a constant of its place in the code."""

    def __init__(self, unit: Unit, names: Names, function: str, pool: Calls, costs: Costs) -> None:
        super().__init__(unit, names, function, pool)
        self._sums = list(accumulate(map(costs.one, self.flat.code), initial=0))
        self._paced = unit.kind == "PROGRAM"
        self._first = self.flat.places[0][0] if self.flat.places else 0

    def _prologue(self) -> list[str]:
        return [*super()._prologue(), f"rung = {self._first}"] if self._paced else super()._prologue()

    def _result(self) -> str:
        return "return rung" if self._paced else super()._result()

    def _body(self) -> None:
        super()._body()
        if self._paced:
            self._emit("return rung")
            self._emit("yield")  # never reached: it makes a body with one rung a generator too

    def _rung(self, at: int) -> None:
        number = self.flat.places[at][0]
        if not self._paced or self.stack or self.flat.code[at].op not in FORGETS:
            return
        if at in self.flat.labels:
            self._emit(f"if rung != {number}: yield rung")
        elif at:
            self._emit("yield rung")
        self._emit(f"rung = {number}")

    def _tick(self, target: int) -> None:
        self._emit(f"_tick({self._sums[self.at + 1] - self._sums[target]})")


@dataclass(slots=True)
class Meter(Watchdog):
    """Adds up in ``spent`` what further passes of loops cost, in ns."""

    spent: int = 0

    def tick(self, cost: int = 0) -> None:
        self.spent += cost
        Watchdog.tick(self)


@dataclass(slots=True, eq=False)
class Machine(machine.Machine):
    """``cost``: what execution costs. A scan by ``scan`` takes no time: who executes tasks by ``pieces`` lets
    it go by."""

    cost: Cost = field(kw_only=True, default_factory=Cost)
    costs: dict[int, tuple[int, ...]] = field(init=False, repr=False)

    def _code(self) -> Code:
        costs = Costs(self.program, self.cost)

        def body(unit: Unit, names: Names, function: str, pool: Calls) -> Body:
            return PacedBody(unit, names, function, pool, costs)

        code = load(self.program, self.resource, self.bindings, body, Meter())
        units = code.layout.units
        self.costs = {n: costs.rungs(units[run.pou.upper()])
                      for n, (run, _) in enumerate(code.layout.programs)}
        return code

    def _execute(self, schedule: Schedule) -> None:
        deque(self.pieces(schedule), maxlen=0)

    def pieces(self, schedule: Schedule, now_ns: int | None = None) -> Iterator[int]:
        return Pieces(self, schedule, self.now_ns if now_ns is None else now_ns)


class Pieces:
    """One execution of a task: each ``next`` executes one rung and tells what it cost, in ns. The time and
    FIRST_SCAN stand still in it, whatever other tasks execute between two pieces. A fault stops the task; the
    rung that it happened in costs nothing. The length hint is 0 after the last piece, else 1."""

    def __init__(self, on: Machine, schedule: Schedule, now_ns: int) -> None:
        self._machine, self._schedule, self._now = on, schedule, now_ns
        self._namespace, self._meter = on.code.namespace, on.code.watchdog
        self._first = self._namespace[FIRST_SCAN]
        self._left = schedule.task.watchdog
        self._extra = on.cost.task
        self._runs = iter(schedule.runs)
        self._rung = 0
        self._number = -1
        self._body: Iterator[int] | None = None
        self._enter()

    def _enter(self) -> None:
        """Goes on with the next program instance of the task."""
        number = next(self._runs, None)
        if number is None:
            self._body = None
        else:
            self._number, self._body = number, self._machine.code.bodies[number]()

    def __iter__(self) -> Pieces:
        return self

    def __length_hint__(self) -> int:
        return self._body is not None

    def __next__(self) -> int:
        if self._body is None or self._schedule.stopped:
            raise StopIteration
        namespace, meter = self._namespace, self._meter
        namespace[NOW], namespace[FIRST_SCAN] = self._now, self._first
        meter.limit, meter.left, meter.spent = self._schedule.task.watchdog, self._left, 0
        number = self._number
        try:
            self._rung = next(self._body)
        except StopIteration as end:
            self._rung = end.value
            self._enter()
        except FAULTS as error:
            self._machine.stop(self._schedule, error, self._machine.code.trace(error.__traceback__))
            self._body = None
            return 0
        self._left = meter.left
        costs = self._machine.costs[number]
        spent = (costs[self._rung] if costs else 0) + meter.spent + self._extra
        self._extra = 0
        return spent

    @property
    def place(self) -> Place:
        """The rung that was executed last."""
        layout = self._machine.code.layout
        unit = layout.units[layout.programs[self._number][0].pou.upper()]
        if not unit.rungs:
            return Place(unit.name, "", -1)
        rung = unit.rungs[self._rung]
        return Place(unit.name, rung.key, -1, -1, rung.span)
