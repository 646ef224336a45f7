"""The process that makes further ones while the master scans: a fork of the master itself would keep its
scans waiting, and could not be made beside its threads.

It was forked when nothing ran yet, and has all that a slave needs as it was then. What it makes is adopted by
the master, which is told its number, so that it is a child like those of the start.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Mapping

from runtime.realtime import processes
from runtime.realtime.processes import Child

_BORN = struct.Struct("<BI")


class Spare:
    """``works``: by the number of a process, its name and what it does when it is made anew. To be made
    after all that the works need, and before there are threads. ``ordinary`` makes this process one that
    keeps nobody waiting."""

    def __init__(self, works: Mapping[int, tuple[str, Callable[[], int]]], ordinary: Callable[[], None]
                 ) -> None:
        self._names = {number: name for number, (name, _) in works.items()}
        processes.adopt()
        orders, self._orders = os.pipe()
        self._answers, answers = os.pipe()
        master = os.getpid()

        def work() -> int:
            os.close(self._orders)
            ordinary()
            while order := os.read(orders, 1):
                name, made = works[order[0]]
                _born(order[0], name, made, master, answers)
            return 0

        self.child = processes.start("spare", work)
        os.close(orders)
        os.close(answers)
        os.set_blocking(self._answers, False)

    def make(self, number: int) -> bool:
        """Asks for a process; ``made`` tells when it is there. Whether there is somebody to ask."""
        if self.child.look() is not None:
            return False
        os.write(self._orders, bytes((number,)))
        return True

    def made(self) -> dict[int, Child]:
        """Those that are there since the call before, by their numbers."""
        try:
            told = os.read(self._answers, 1 << 12)
        except BlockingIOError:
            return {}
        return {number: Child(self._names[number], pid) for number, pid in _BORN.iter_unpack(told)}

    def close(self, beat: Callable[[], None]) -> dict[int, Child]:
        """No further ones; those that are there by now and were not told yet. ``beat`` is called
        meanwhile."""
        os.close(self._orders)
        processes.finish([self.child], beat)
        last = self.made()
        os.close(self._answers)
        return last


def _born(number: int, name: str, work: Callable[[], int], master: int, answers: int) -> None:
    """A process whose parent ends at once is adopted by the nearest one above that wants to."""
    between = os.fork()
    if between:
        os.waitpid(between, 0)
        return
    try:
        child = processes.start(name, work, master)
        os.write(answers, _BORN.pack(number, child.pid))
    finally:
        os._exit(0)
