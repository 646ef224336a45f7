"""Ends work that does not come back, at the line where it is: for code of the project in Python.

A timer of real time looks from time to time whether the same work is still being done. It is there only while
there is such work, so that nothing is paid for by the work but two additions.
"""

from __future__ import annotations

import signal
import sys
from types import FrameType

LOOK = 0.75
"""Seconds between two looks. Work that two of them find is ended: below the patience of ``runtime.guard``,
which knows no lines of Python."""


class Endless(BaseException):
    """Raised in the work that does not come back. No Exception: work may catch those."""


class Patience:
    """``begin`` and ``end`` are called around the work, in the main thread."""

    __slots__ = ("_count", "_seen", "_looking", "_before")

    def __init__(self) -> None:
        self._count = 0  # odd while there is work
        self._seen, self._looking, self._before = -1, False, signal.SIG_DFL

    def begin(self) -> None:
        self._count += 1
        if not self._looking:
            self._looking = True
            self._before = signal.signal(signal.SIGALRM, self._look)
            signal.setitimer(signal.ITIMER_REAL, LOOK, LOOK)

    def end(self) -> None:
        self._count += 1

    def _look(self, number: int, frame: FrameType | None) -> None:
        seen, self._seen = self._seen, self._count
        if seen != self._count:
            return
        if self._count % 2 == 0:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, self._before)
            self._looking = False
        elif sys.gettrace() is None:  # a person with a debugger may take any time
            raise Endless
