"""Work in a process of its own: who heeds its signals, up to its end (`ldc/cli/apart.py`)."""

from __future__ import annotations

import mmap
import os
import signal
import time

import native
import pytest

from ldc.components import host
from ldc.diagnostics import Diagnostics
from runtime.guard import Beat, guarded
from runtime.realtime import processes


def test_work_that_is_orderly_gets_the_interrupt_from_its_first_moment() -> None:
    """Before it has a handler of its own too: an interrupt while a run starts ends it."""
    def work(beat: Beat) -> int:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(10)
        return 0

    assert guarded(work, orderly=True) == 130


@pytest.mark.parametrize("orderly", [True, False])
def test_the_process_above_leaves_an_interrupt_to_orderly_work(orderly: bool) -> None:
    """And passes on what only it was sent."""
    def work(beat: Beat) -> int:
        came: list[int] = []
        if orderly:
            signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
        time.sleep(0.2)
        os.kill(os.getppid(), signal.SIGINT)
        time.sleep(0.5)
        return 7 + len(came)

    if orderly:
        assert guarded(work, orderly=True) == 8
    else:
        with pytest.raises(KeyboardInterrupt):
            guarded(work)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_to_wait_for_processes_that_do_not_end_is_no_hang() -> None:
    """A run in real time ends slaves that stand still; its trace was lost when that took long."""
    def work(beat: Beat) -> int:
        beat()
        child = processes.start("stands", lambda: time.sleep(60) or 0)
        os.kill(child.pid, signal.SIGSTOP)
        processes.finish([child], beat, seconds=1.5)
        return 0

    assert guarded(work, hang=0.5) == 0


@native.needs_gcc
def test_a_signal_at_the_very_end_of_work_does_not_end_it_otherwise() -> None:
    """The timer of the plant, an interrupt: they came while the stack for signals was there no more."""
    handler = host.guard_library(Diagnostics())

    def work(beat: Beat) -> int:
        came: list[int] = []
        signal.signal(signal.SIGALRM, lambda number, frame: came.append(number))
        own = Beat(mmap.mmap(-1, 16 * 1024))
        own.watch([], handler)
        del own
        os.kill(os.getpid(), signal.SIGALRM)
        return 7 + len(came)

    assert guarded(work) == 8
