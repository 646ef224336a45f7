"""SIGTERM, as `timeout` and services send it: a command ends as by Ctrl-C, and leaves nothing unfinished."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import native
import pytest
from online_runtime import wait_until
from systems import modules

from runtime.ending import Heeded, Terminated
from runtime.guard import guarded

COUNT = "PROGRAM p\nVAR RETAIN\n  n : INT;\nEND_VAR\nRUNG r\n  <ADD(IN1 := n, IN2 := 1, OUT => n)>\nEND_PROGRAM\n"
BOTH = pytest.mark.parametrize("number, status", [(signal.SIGTERM, 143), (signal.SIGINT, 130)],
                               ids=lambda each: getattr(each, "name", ""))


@BOTH
@pytest.mark.parametrize("group", [False, True], ids=["one process", "its group"])
@pytest.mark.parametrize("components", [False, pytest.param(True, marks=native.needs_gcc)],
                         ids=["alone", "with components"])
def test_a_run_that_is_ended_leaves_no_file(tmp_path: Path, number, status, group, components) -> None:
    if components:
        modules(tmp_path, '[sequence]\nsteps = ["first", "second"]\n')
    else:
        (tmp_path / "ldc.toml").touch()
        (tmp_path / "main.ld").write_text(COUNT)
    before = set(tmp_path.iterdir())
    process = subprocess.Popen(
        [sys.executable, "-m", "ldc.cli", "run", ".", "--for", "9h", "--trace", "t.csv", "--retain", "r"], cwd=tmp_path,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    wait_until((tmp_path / "r.before").exists, 30)
    (os.killpg if group else os.kill)(process.pid, number)
    out, err = process.communicate(timeout=30)
    assert (process.returncode, out) == (status, "") and "error" not in err, err
    left = {path.name for path in set(tmp_path.iterdir()) - before}
    assert "r.before" in left and left <= {"r", "r.before"}, "a save may have been between its two names"


def test_work_that_does_not_end_is_ended() -> None:
    """As code in C does not, which hears of no signal."""
    def work(beat) -> int:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
        os.kill(os.getppid(), signal.SIGTERM)
        while True:
            beat()
            time.sleep(0.01)

    begin = time.monotonic()
    with Heeded(), pytest.raises(Terminated):
        guarded(work)
    assert time.monotonic() - begin < 8
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def test_signals_at_once_end_work_without_a_word(capfd: pytest.CaptureFixture[str]) -> None:
    def work(beat) -> int:
        try:
            signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGTERM))
            for number in (signal.SIGINT, signal.SIGTERM, signal.SIGINT):
                os.kill(os.getpid(), number)
            signal.pthread_sigmask(signal.SIG_UNBLOCK, (signal.SIGINT, signal.SIGTERM))
            time.sleep(10)
        finally:
            print("in order")
        return 0

    assert guarded(work) in (130, 143)
    assert capfd.readouterr() == ("in order\n", "")
