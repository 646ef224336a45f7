"""Absolute deadlines: a period after the other on the clock that only goes forward."""

from __future__ import annotations

import time
from collections.abc import Callable

from runtime.realtime.lateness import Lateness


class Pace:
    """Period n begins ``start_ns + n * period_ns`` on ``time.monotonic_ns``, the first one at the
    ``start_ns`` that ``begin`` is given.

    ``now_ns``: the time since ``start_ns`` at which the period that runs was to begin. It is what a processor
    takes for the time, so that work that is due in every period is not passed over because one period begins
    a little earlier in itself than the one before.
    """

    __slots__ = ("period_ns", "now_ns", "_start", "_next", "_lateness")

    def __init__(self, period_ns: int, lateness: Lateness) -> None:
        self.period_ns, self.now_ns = period_ns, 0
        self._start, self._next, self._lateness = 0, 0, lateness

    def begin(self, start_ns: int) -> None:
        self._start = self._next = start_ns

    def join(self) -> None:
        """Begins with the next period: those before were not for this process."""
        passed = max(time.monotonic_ns() - self._start, 0)
        self._next = self._start + -(-passed // self.period_ns) * self.period_ns

    def wait(self, meanwhile: Callable[[], bool] | None = None, slice_ns: int = 0) -> int | None:
        """Sleeps until the next period begins. How many were missed before it: they are left out, since two
        in a row would shorten no time of the plant. ``meanwhile`` is called again and again, ``slice_ns``
        apart; None is returned when it gives False."""
        while (left := self._next - time.monotonic_ns()) > 0:
            if meanwhile is not None:
                if not meanwhile():
                    return None
                left = min(self._next - time.monotonic_ns(), slice_ns)
            if left > 0:
                time.sleep(left / 1e9)
        late = time.monotonic_ns() - self._next
        missed = late // self.period_ns
        self.now_ns = self._next - self._start + missed * self.period_ns
        self._next += (missed + 1) * self.period_ns
        self._lateness.add(late, missed)
        return missed
