"""Slaves and the plant in real time: what their processes do, period by period, until the master ends
the run."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from math import gcd

from ldc.il.placement import Placed
from runtime.faults import TaskTooLong
from runtime.realtime.board import Board
from runtime.realtime.pace import Pace
from runtime.slave.part import SlavePart

POLL_NS = 1_000_000
"""The time between two looks at transfers, at most (SPEC 6.1)."""


def slave_period(placed: Iterable[Placed], slave: int) -> int:
    """In ns: the greatest that all algorithms of a slave are executed in time with, and that of the looks at
    transfers at most."""
    return gcd(POLL_NS, *(p.period_ns for p in placed if p.slave == slave))


def run_slave(part: SlavePart, board: Board, number: int, pace: Pace, patience_ns: int,
              anew: bool = False, watchdog_ns: int | None = None) -> None:
    """Emergency before communication before algorithms, as their levels are. ``number``: of the process.
    ``patience_ns``: after as long without a period the master has given this slave up. ``anew``: it takes the
    place of one that was lost, and is there when its master knows that. ``watchdog_ns``: what the algorithms
    of a period may take of real time; longer is a fault, as soon as they have ended."""
    _begin(board, number, pace)
    emergencies, saves, keeps = board.emergencies, board.saves, board.keeps(number)
    if anew:
        pace.join()
        part.restart({entry.path: entry for entry in board.kept(number)})
    while not board.stopping:
        missed = pace.wait()
        if board.emergencies != emergencies or missed * pace.period_ns > patience_ns:
            emergencies = board.emergencies
            part.emergency()
        part.communicate()
        begin = time.monotonic_ns()
        opened = part.execute()
        if watchdog_ns is not None and (lasts := time.monotonic_ns() - begin) > watchdog_ns:
            part.overdue(TaskTooLong(lasts, watchdog_ns))
            opened = True
        if opened:
            part.communicate()
        if keeps and board.saves != saves:
            saves = board.saves
            board.keep(number, saves, part.retained())
        anew = anew and part.waiting
        if not anew:
            board.beat(number)
    if keeps:
        board.keep(number, board.saves, part.retained())


def run_plant(step: Callable[[int, int], None], board: Board, number: int, pace: Pace) -> None:
    """Steps of the plant at their time; those that were missed are made up for, because nature waits for
    nobody."""
    _begin(board, number, pace)
    while not board.stopping:
        missed = pace.wait()
        for late in range(missed, -1, -1):
            step(pace.now_ns - late * pace.period_ns, pace.period_ns)
        board.beat(number)


def _begin(board: Board, number: int, pace: Pace) -> None:
    """Waits until all are there, or the run is ended before."""
    board.arrive(number)
    while board.start_ns == 0 and not board.stopping:
        time.sleep(0.001)
    pace.begin(board.start_ns)
