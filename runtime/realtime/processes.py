"""Processes of a run in real time: made, given a processor of the computer and priority, and ended.

A child ends with its parent.
"""

from __future__ import annotations

import ctypes
import gc
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from runtime import ending
from runtime.kin import end_with_parent

PRIORITY = 50
"""Of SCHED_FIFO, 1 .. 99: above ordinary processes, below the interrupt threads of most kernels."""

_PR_SET_NAME, _PR_SET_CHILD_SUBREAPER = 15, 36
_DENIED = "not allowed"


@dataclass(slots=True)
class Child:
    """``status``: as ``os.waitstatus_to_exitcode`` tells it, None while the process runs."""

    name: str
    pid: int
    status: int | None = None

    def look(self) -> int | None:
        """Its status when it has ended."""
        if self.status is None:
            done, status = os.waitpid(self.pid, os.WNOHANG)
            if done:
                self.status = os.waitstatus_to_exitcode(status)
        return self.status

    @property
    def end(self) -> str:
        """How it ended, in words. One that notes the place of a crash before it ends (``runtime.guard``) does
        so with 128 and the signal, as shells have it."""
        status = self.status or 0
        number = -status if status < 0 else status - 128
        if number in set(signal.Signals):
            return f"was ended by {signal.Signals(number).name}"
        return f"ended with status {status}"


def adopt() -> None:
    """From now on processes below this one become its children when their parents end."""
    ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0)


def start(name: str, work: Callable[[], int], parent: int | None = None) -> Child:
    """A process that does the work and ends with its status, 3 when it raises, 130 for KeyboardInterrupt;
    `ps` and `top` show it as `ldc NAME`. It is forked: no other thread may run. Interrupts and SIGTERM, which
    come to all processes of a terminal or a service, are left to the parent. ``parent``: who adopts it, when
    this process ends at once."""
    sys.stdout.flush()
    sys.stderr.flush()
    maker = os.getpid()
    pid = os.fork()
    if pid:
        return Child(name, pid)
    status = 3
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        while parent is not None and os.getppid() == maker:
            time.sleep(0.001)
        ctypes.CDLL(None).prctl(_PR_SET_NAME, f"ldc {name}".encode(), 0, 0, 0)
        if end_with_parent(parent or maker):
            status = work()
    except KeyboardInterrupt:  # raised by code of the project, since the keyboard is ignored here
        status = 128 + signal.SIGINT
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stderr.flush()
        os._exit(status)


def finish(children: Sequence[Child], beat: Callable[[], None], seconds: float = 1.0) -> None:
    """Waits for processes that were told to end, and ends those that do not. ``beat`` is called meanwhile:
    who waits does not hang."""
    end = time.monotonic() + seconds
    while any(child.look() is None for child in children) and time.monotonic() < end:
        beat()
        time.sleep(0.005)
    for child in children:
        if child.status is None:
            os.kill(child.pid, signal.SIGKILL)
            child.status = os.waitstatus_to_exitcode(os.waitpid(child.pid, 0)[1])


@contextmanager
def interrupted() -> Iterator[Callable[[], bool]]:
    """Whether SIGINT or SIGTERM came, which end a run after the scan that is executed. Once one has come,
    further ones do nothing: the run is ending."""
    came: list[int] = []
    before = {number: signal.signal(number, lambda number, frame: came.append(number))
              for number in ending.SIGNALS}
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in before.items() if not came else ():
            signal.signal(number, handler)


def cpus(count: int) -> list[int | None]:
    """A processor of the computer for each of some processes, the first for the first, the others share the
    rest; None when there is only one."""
    free = sorted(os.sched_getaffinity(0))
    if len(free) == 1:
        return [None] * count
    rest = free[1:]
    return [free[0], *(rest[n % len(rest)] for n in range(count - 1))][:count]


def claim(cpu: int | None) -> list[str]:
    """Takes a processor of the computer and SCHED_FIFO for this process. What was refused, in words."""
    gc.collect()
    gc.freeze()  # what is there stays: it need not be looked through again and again
    refused = []
    if cpu is None:
        refused.append("pinning: there is one CPU")
    else:
        try:
            os.sched_setaffinity(0, {cpu})
        except OSError:
            refused.append(f"pinning to CPU {cpu}: {_DENIED}")
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except OSError:
        refused.append(f"SCHED_FIFO: {_DENIED} (CAP_SYS_NICE, or a limit `rtprio`)")
    return refused


def give_back(affinity: set[int]) -> None:
    """This process is an ordinary one again."""
    ordinary(affinity)
    gc.unfreeze()


def ordinary(affinity: set[int]) -> None:
    """This thread is an ordinary one, on any of these processors of the computer."""
    os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
    os.sched_setaffinity(0, affinity)
