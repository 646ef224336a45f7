"""One execution of a task in pieces, of which each costs time: what engines that stop between rungs share.

A piece is a rung (``ldc.il.pieces``) with the blocks, functions and loops in it. All engines make the same
pieces at the same cost, so that tasks pre-empt each other in the same places, whatever executes them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from runtime.cost import Cost, Costs
from runtime.faults import Place
from runtime.machine import Machine, Schedule

PieceCosts = Sequence[Mapping[int, int]]
"""Of each program instance, by the number of the first rung of a piece, what the piece costs in ns."""


def piece_costs(machine: Machine, cost: Cost) -> PieceCosts:
    """What the pieces of a machine's program instances cost."""
    costs, layout = Costs(machine.program, cost), machine.layout
    return tuple(costs.pieces(layout.units[run.pou.upper()]) or {0: 0} for run, _ in layout.programs)


class Pieces:
    """Each ``next`` executes one piece and tells what it cost, in ns. The time and FIRST_SCAN stand still
    in it, whatever other tasks execute between two pieces. A fault stops the task; the piece that it
    happened in costs nothing. The length hint is 0 after the last piece, else 1.

    ``began``: what the begin of an execution costs, in ns. An engine says ``_begin`` and ``__next__``, which
    is called for every rung: it has the costs of the pieces in ``_costs``, adds ``_extra`` to the first one,
    notes the rung in ``_rung``, and goes on by ``_enter``.
    """

    __slots__ = ("_machine", "_schedule", "_now", "_all", "_costs", "_first", "_left", "_extra", "_runs",
                 "_rung", "_number", "_goes_on")

    def __init__(self, machine: Machine, schedule: Schedule, now_ns: int, costs: PieceCosts,
                 began: int) -> None:
        self._machine, self._schedule, self._now, self._all = machine, schedule, now_ns, costs
        self._costs: Mapping[int, int] = {}
        self._first, self._left = not machine.scans, schedule.task.watchdog
        self._extra = began
        self._runs = iter(schedule.runs)
        self._rung, self._number, self._goes_on = 0, -1, True
        self._enter()

    def _begin(self, number: int) -> None:
        """Makes ready for the first piece of a program instance, with ``_left`` backward jumps."""
        raise NotImplementedError

    def _enter(self) -> None:
        """Goes on with the next program instance of the task."""
        number = next(self._runs, None)
        if number is None:
            self._goes_on = False
        else:
            self._number, self._costs = number, self._all[number]
            self._begin(number)

    def __iter__(self) -> Iterator[int]:
        return self

    def __length_hint__(self) -> int:
        return self._goes_on

    def __next__(self) -> int:
        raise NotImplementedError

    @property
    def place(self) -> Place:
        """The rung that was executed last."""
        layout = self._machine.layout
        unit = layout.units[layout.programs[self._number][0].pou.upper()]
        if not unit.rungs:
            return Place(unit.name, "", -1)
        rung = unit.rungs[self._rung]
        return Place(unit.name, rung.key, -1, -1, rung.span)
