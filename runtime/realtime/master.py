"""The master in real time: its scans at their time, transfers in between, who is lost meanwhile and is
started anew."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from dataclasses import dataclass

from runtime.machine import Machine
from runtime.master.part import Finding, MasterPart
from runtime.online.controller import Controller
from runtime.realtime.board import Board
from runtime.realtime.pace import Pace
from runtime.realtime.processes import Child
from runtime.realtime.spare import Spare

POLL_NS = 1_000_000
SILENCE_NS = 100_000_000
"""How long a process may tell nothing before people are told: an ordinary one may be kept waiting for as
long."""

COMING_NS = 2_000_000_000
"""How long a process may take until it is there, at the start or when it is started anew."""


@dataclass(slots=True)
class Watched:
    """A process beside the master. ``slave``: its number, None for the plant. ``silent``: it was lost, as far
    as people were told. ``since_ns``: since when it is being started anew, None while it is not; ``asked``:
    its new process was asked for."""

    child: Child
    number: int
    slave: int | None
    beats: int = 0
    heard_ns: int = 0
    silent: bool = False
    since_ns: int | None = None
    asked: bool = False


class MasterLoop:
    """``runner``: what executes scans; ``part``: None when the program needs no other processor, and asks
    ``ready`` in a reset. ``spare`` starts slaves anew, None without any. ``tell`` is given sentences for
    people; ``beat`` is called while a scan is waited for. ``lost``: a process has ended before its time."""

    def __init__(self, runner: Machine | Controller, part: MasterPart | None, board: Board, pace: Pace,
                 watched: list[Watched], spare: Spare | None, tell: Callable[[str], None],
                 beat: Callable[[], None]) -> None:
        self._runner, self._part, self._board, self._pace = runner, part, board, pace
        self._watched, self._spare, self._tell, self._beat = watched, spare, tell, beat
        self.lost = False
        self._slice = POLL_NS if part is not None and part.proxies else 20 * POLL_NS
        self._ended: Callable[[], bool] = lambda: False

    @property
    def over(self) -> bool:
        """The plant has ended: there is nothing to control any more."""
        return any(each.slave is None and each.child.status is not None for each in self._watched)

    @property
    def machine(self) -> Machine:
        """That of the program that runs."""
        return self._runner.machine if isinstance(self._runner, Controller) else self._runner

    @property
    def findings(self) -> tuple[Finding, ...]:
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
        machine = self.machine
        machine.now_ns += missed * machine.period_ns
        if self._part is None:
            self._runner.scan()
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
                    what = "goes on" if each.since_ns is None else "was started anew"
                    self._tell(f"{each.child.name} {what}, at {now // 1_000_000} ms")
                each.beats, each.heard_ns, each.silent = beats, now, False
            elif not each.silent and (each.child.look() is not None or now - each.heard_ns > SILENCE_NS):
                each.silent = True
                gone = each.child.status is not None
                self.lost |= gone
                what = each.child.end if gone else "does not go on"
                self._tell(f"{each.child.name} {what}, at {now // 1_000_000} ms")

    # ---- slaves that are started anew ------------------------------------------------------------

    def ready(self) -> bool:
        """Somebody acknowledges: whether all slaves are there. One that is lost is ended, if it is not over
        yet, and a new process takes its place; to be asked until it is there, or is given up."""
        now, waits = self._pace.now_ns, False
        for number, child in self._spare.made().items() if self._spare is not None else ():
            each = next(each for each in self._watched if each.number == number)
            each.child, each.beats, each.heard_ns = child, self._board.beats(number), now
        for each in self._watched:
            if each.slave is not None and (each.silent or each.since_ns is not None):
                waits |= self._returns(each, now)
        if not waits and self._part is not None:
            self._part.communicate()  # who has begun anew has said so
        return not waits

    def _returns(self, each: Watched, now: int) -> bool:
        """The next thing for a slave that is lost; whether there is more to wait for."""
        if each.since_ns is None:
            each.since_ns, each.asked = now, False
        if not each.silent:
            each.since_ns = None
            return False
        if now - each.since_ns > COMING_NS:
            self._tell(f"{each.child.name} cannot be started anew, at {now // 1_000_000} ms")
            each.since_ns = None
            return False
        if each.asked:
            return True
        if each.child.look() is None:
            os.kill(each.child.pid, signal.SIGKILL)
        else:
            self.lost = True
            each.asked = self._spare.make(each.number)
        return True
