"""What communication and algorithms take of their processors' time, in virtual time (docs/scheduling.md).

A transfer that is served and an algorithm that is executed are pieces, as a rung is: what they do is done
when they begin, who waits for it is told when their time is over.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from runtime.cost import Cost
from runtime.faults import TaskTooLong
from runtime.master.part import MasterPart
from runtime.protocol.meter import Meter
from runtime.scheduler.thread import Work
from runtime.slave.part import SlavePart

Action = Callable[[], None]


def communication(cost: Cost | None, part: MasterPart | SlavePart, told: Action) -> Work:
    """The work of a communication thread. ``told``: tells the other processors, whenever something may have
    gone on."""
    def at_once(now: int) -> None:
        part.communicate()
        told()

    if cost is None or not (cost.frame or cost.word):
        return at_once
    meter = Meter(cost.frame, cost.word)

    def in_pieces(now: int) -> Iterator[int]:
        for end in part.serving():
            spent = meter.cost(end)
            if spent:
                yield spent
            told()
        told()

    return in_pieces


def algorithms(cost: Cost | None, part: SlavePart, told: Action, clock: Callable[[], int],
               limit: int | None) -> Work:
    """The work of an algorithm thread. ``told``: a transfer is open. ``limit``: ns by ``clock`` that it may
    last from its begin, the time in which it is pre-empted included; longer is a fault."""
    def at_once(now: int) -> None:
        if part.execute():
            told()

    if cost is None or not (cost.algorithm or cost.algorithms):
        return at_once

    def in_pieces(now: int) -> Iterator[int]:
        due, began = part.due(), clock()
        opened = part.execute()
        for placed in due:
            spent = cost.of_unit(placed.unit)
            if spent:
                yield spent
            if limit is not None and (lasts := clock() - began) > limit:
                part.overdue(TaskTooLong(lasts, limit))
                opened = True
                break
        if opened:
            told()

    return in_pieces
