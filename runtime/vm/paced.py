"""A virtual machine whose tasks can be pre-empted between rungs, and whose code takes time.

The body of a PROGRAM is a generator that stops between pieces (``ldc.il.pieces``); blocks and functions
called in a rung belong to its piece, and so do loops inside of it. Results are those of the machine that
executes at once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

from ldc.il.pieces import Passes, pieces
from ldc.il.program import Unit
from runtime.cost import Cost, Costs
from runtime.faults import FAULTS
from runtime.layout import FIRST_SCAN, NOW
from runtime.machine import Schedule
from runtime.pieces import PieceCosts, Pieces, piece_costs
from runtime.vm import machine
from runtime.vm.calls import Calls
from runtime.vm.codegen import Body
from runtime.vm.loader import Code, Watchdog, load
from runtime.vm.names import Names


class PacedBody(Body):
    """``costs``: what each backward jump adds is a constant of its place in the code."""

    def __init__(self, unit: Unit, names: Names, function: str, pool: Calls, costs: Costs) -> None:
        super().__init__(unit, names, function, pool)
        self._passes = Passes(unit, self.flat, costs.one)
        self._paced = unit.kind == "PROGRAM"
        self._pieces = pieces(self.flat)
        self._begins = frozenset(self._pieces.begins)
        self._entered = self._pieces.entered(self.flat)

    def _prologue(self) -> list[str]:
        first = self._pieces.rungs[0] if self._pieces.rungs else 0
        return [*super()._prologue(), f"rung = {first}"] if self._paced else super()._prologue()

    def _result(self) -> str:
        return "return rung" if self._paced else super()._result()

    def _body(self) -> None:
        super()._body()
        if self._paced:
            self._emit("return rung")
            self._emit("yield")  # never reached: it makes a body with one rung a generator too

    def _arrive(self, at: int) -> None:
        if not self._paced or not (at in self._begins or at in self._entered):
            return
        number = self._pieces.rungs[self._pieces.number(at)]
        if at in self.flat.labels:
            self._emit(f"if rung != {number}: yield rung")
        elif at:
            self._emit("yield rung")
        self._emit(f"rung = {number}")

    def _tick(self, target: int) -> None:
        self._emit(f"_tick({self._passes.cost(self.at, target)})")


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
    _costs: PieceCosts = field(init=False, repr=False)

    def __post_init__(self) -> None:
        machine.Machine.__post_init__(self)
        self._costs = piece_costs(self, self.cost)

    def _code(self) -> Code:
        costs = Costs(self.program, self.cost)

        def body(unit: Unit, names: Names, function: str, pool: Calls) -> Body:
            return PacedBody(unit, names, function, pool, costs)

        return load(self.program, self.resource, self.bindings, body, Meter())

    def _execute(self, schedule: Schedule) -> None:
        deque(self.pieces(schedule), maxlen=0)

    def pieces(self, schedule: Schedule, now_ns: int | None = None) -> Iterator[int]:
        now = self.now_ns if now_ns is None else now_ns
        return _Pieces(self, schedule, now, self._costs, self.cost.task)


class _Pieces(Pieces):
    """``_body``: the generator of the program instance in work."""

    __slots__ = ("_namespace", "_meter", "_body")

    def _begin(self, number: int) -> None:
        code = self._machine.code
        self._namespace, self._meter, self._body = code.namespace, code.watchdog, code.bodies[number]()

    def __next__(self) -> int:
        schedule = self._schedule
        if not self._goes_on or schedule.stopped:
            raise StopIteration
        namespace, meter, costs = self._namespace, self._meter, self._costs
        namespace[NOW], namespace[FIRST_SCAN] = self._now, self._first
        meter.limit, meter.left, meter.spent = schedule.task.watchdog, self._left, 0
        try:
            rung = self._rung = next(self._body)
        except StopIteration as end:
            rung = self._rung = end.value
            self._left = meter.left
            self._enter()
        except FAULTS as error:
            self._machine.stop(schedule, error, self._machine.code.trace(error.__traceback__))
            self._goes_on = False
            return 0
        else:
            self._left = meter.left
        spent = costs[rung] + meter.spent + self._extra
        self._extra = 0
        return spent
