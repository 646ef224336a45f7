"""Pauses of the computer: a virtual machine loses a processor for half a second now and then.

A test in real time that fails while its processor stood still says nothing of the program. Watchers, one on
each processor with a priority above all that is tested and an ordinary one, note when they woke up late.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
import time

TRIES = 4
LONG = 0.04
"""Seconds: what is tested gives up somebody who is silent for 50 ms and more."""
_STEP = 0.005
_HIGHEST = 99


class Watchers:
    """From their making to ``end``; times are those of ``time.monotonic``."""

    def __init__(self) -> None:
        self._notes = tempfile.TemporaryFile("w+")
        self._processes = [
            subprocess.Popen([sys.executable, "-S", __file__, cpu, str(os.getpid())], stdout=self._notes)
            for cpu in ("any", *map(str, sorted(os.sched_getaffinity(0))))]

    def longest(self, since: float) -> float:
        """Seconds of the longest pause that ended after ``since``, 0.0 without one above ``LONG``."""
        time.sleep(2 * _STEP)  # one that lasts until now
        notes = os.pread(self._notes.fileno(), os.fstat(self._notes.fileno()).st_size, 0)
        pauses = (map(float, line.split()) for line in notes.decode("ascii").splitlines())
        return max((length for end, length in pauses if end >= since), default=0.0)

    def end(self) -> None:
        for process in self._processes:
            process.kill()
            process.wait()
        self._notes.close()


def _watch(cpu: str, parent: int) -> None:
    if cpu != "any":
        with contextlib.suppress(OSError):  # who may not claim a processor sees more pauses
            os.sched_setaffinity(0, {int(cpu)})
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_HIGHEST))
    while os.getppid() == parent:
        due = time.monotonic() + _STEP
        time.sleep(_STEP)
        now = time.monotonic()
        if now - due > LONG:
            os.write(1, f"{now} {now - due}\n".encode("ascii"))


if __name__ == "__main__":
    _watch(sys.argv[1], int(sys.argv[2]))
