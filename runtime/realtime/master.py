"""The master in real time: its scans at their time, transfers in between, and who is lost meanwhile."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from runtime.machine import Machine
from runtime.master.findings import LinkFault, ScanOverdue
from runtime.master.part import MasterPart
from runtime.master.waiting import StepWaits
from runtime.realtime.board import Board
from runtime.realtime.pace import Pace
from runtime.realtime.processes import Child

POLL_NS = 1_000_000
SILENCE_NS = 50_000_000
"""How long a process may tell nothing before people are told: an ordinary one may be kept waiting for as
long."""


@dataclass(slots=True)
class Watched:
    """A process beside the master. ``slave``: its number, None for the plant."""

    child: Child
    number: int
    slave: int | None
    beats: int = 0
    heard_ns: int = 0
    silent: bool = False


class MasterLoop:
    """``part``: None when the program needs no other processor. ``tell`` is given sentences for people;
    ``beat`` is called while a scan is waited for."""

    def __init__(self, machine: Machine, part: MasterPart | None, board: Board, pace: Pace,
                 watched: list[Watched], tell: Callable[[str], None], beat: Callable[[], None]) -> None:
        self._machine, self._part, self._board, self._pace = machine, part, board, pace
        self._watched, self._tell, self._beat = watched, tell, beat
        self._slice = POLL_NS if part is not None and part.proxies else 20 * POLL_NS
        self._ended: Callable[[], bool] = lambda: False

    @property
    def over(self) -> bool:
        """The plant has ended: there is nothing to control any more."""
        return any(each.slave is None and each.child.status is not None for each in self._watched)

    @property
    def findings(self) -> tuple[LinkFault | ScanOverdue | StepWaits, ...]:
        """What people are to be told when the run ends, beside the faults of tasks."""
        return () if self._part is None else self._part.told

    def until(self, ended: Callable[[], bool]) -> None:
        """What tells that somebody ends the run: waiting ends then."""
        self._ended = ended

    def scan(self) -> None:
        """Waits until the next scan is due, and executes it. The time of the program goes on by all periods
        that have passed: what was missed is not made up for."""
        missed = self._pace.wait(self._meanwhile, self._slice)
        if missed is None:
            return
        self._machine.now_ns += missed * self._machine.period_ns
        if self._part is None:
            self._machine.scan()
        else:
            self._look()
            self._part.scan()
            self._part.communicate()
            self._part.customised()
        self._board.beat(0)

    def _meanwhile(self) -> bool:
        if self._part is not None:
            self._part.communicate()
        self._beat()
        return not self._ended()

    def _look(self) -> None:
        """Tells people of a process that has ended or does not go on. What becomes of its algorithms is
        decided by P: the master part asks those that are quiet, and no answer is a fault of the link
        (SPEC 2.5)."""
        now = self._pace.now_ns
        for each in self._watched:
            beats = self._board.beats(each.number)
            if beats != each.beats:
                if each.silent:
                    self._tell(f"{each.child.name} goes on")
                each.beats, each.heard_ns, each.silent = beats, now, False
            elif not each.silent and (each.child.look() is not None or now - each.heard_ns > SILENCE_NS):
                each.silent = True
                gone = each.child.status is not None
                what = each.child.end if gone else "does not go on"
                self._tell(f"{each.child.name} {what}, at {now // 1_000_000} ms")
