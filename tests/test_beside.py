"""Work in a copy of this process gives what it gives here, whatever becomes of the copy."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from ldc import beside
from ldc.beside import Beside
from ldc.diagnostics import Diagnostics
from ldc.parser.plcopen import document, read
from ldc.source import SourceFile
from plcopen_xml import coil, contact, ladder, rail

HERE = os.getpid()
BOOLS = "a q : BOOL"


@pytest.fixture(autouse=True)
def _two_processors(monkeypatch) -> Iterator[None]:
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1}, raising=False)
    monkeypatch.setattr(threading, "active_count", lambda: 1)  # what runs the tests may have some
    yield
    with pytest.raises(ChildProcessError):  # no copy is left, running or ended
        os.waitpid(-1, os.WNOHANG)


def found(work: Callable[[], object], pays: bool = True) -> object:
    with Beside(work, pays) as asked:
        return asked.result()


def test_the_work_is_done_in_another_process_and_changes_nothing_here() -> None:
    made = []
    assert found(lambda: made.append(1) or (os.getpid() != HERE, "ä" * 300_000, frozenset("ab"), None)) == (
        True, "ä" * 300_000, frozenset("ab"), None)
    assert not made


@pytest.mark.parametrize("why", ["does not pay", "one processor", "threads", "no process"])
def test_without_a_copy_the_work_is_done_here(why: str, monkeypatch) -> None:
    def refused() -> int:
        raise BlockingIOError

    if why == "one processor":
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0})
    if why == "no process":
        monkeypatch.setattr(os, "fork", refused)
    if why == "threads":
        monkeypatch.setattr(threading, "active_count", lambda: 2)
    before = len(os.listdir("/proc/self/fd"))
    assert found(os.getpid, pays=why != "does not pay") == HERE
    assert len(os.listdir("/proc/self/fd")) == before


@pytest.mark.parametrize("end", [signal.SIGKILL, signal.SIGSEGV])
def test_what_a_copy_that_is_ended_does_not_say_is_found_here(end: int) -> None:
    assert found(lambda: os.getpid() if os.getpid() == HERE else os.kill(os.getpid(), end)) == HERE


def test_half_a_result_is_none(monkeypatch) -> None:
    write = os.write
    monkeypatch.setattr(os, "write", lambda pipe, left: write(pipe, left[:9]) if len(left) > 9 else os._exit(0))
    assert found(lambda: (os.getpid() == HERE, "much more than that")) == (True, "much more than that")


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit, RecursionError])
def test_what_the_work_raises_is_raised_here(error: type[BaseException]) -> None:
    def work() -> None:
        raise error("x")

    with pytest.raises(error, match="x"):
        found(work)


def test_a_copy_that_nobody_waits_for_is_ended() -> None:
    with pytest.raises(KeyboardInterrupt), Beside(lambda: signal.pause()):
        raise KeyboardInterrupt
    with Beside(lambda: signal.pause()):
        pass


def test_an_interrupt_from_the_keyboard_ends_both_with_one_word(tmp_path: Path) -> None:
    text = """import os, signal
from ldc.beside import Beside
os.sched_getaffinity = lambda _: {0, 1}
print("once", end="")
try:
    with Beside(lambda: signal.pause()) as asked:
        os.killpg(0, signal.SIGINT)
        asked.result()
except KeyboardInterrupt:
    print(" interrupted")
"""
    ended = subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, start_new_session=True,
                           cwd=Path(beside.__file__).parent.parent, timeout=20)
    assert (ended.stdout, ended.stderr, ended.returncode) == ("once interrupted\n", "", 0)


@pytest.mark.parametrize("damage", [None, ("</project>", ""), ("<types>", "<!DOCTYPE x><types>"),
                                    ("<coil ", '<coil delay="T#1s" ')])
def test_a_drawing_is_read_the_same(damage: tuple[str, str] | None, monkeypatch) -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a"), coil(3, "q", 2))
    xml = xml.replace(*damage, 1) if damage else xml
    seen = []
    for long in (10**9, 0):
        monkeypatch.setattr(document, "_LONG", long)
        diagnostics = Diagnostics()
        file = read(SourceFile("plc.xml", xml), diagnostics)
        seen.append((repr(file.pous), [(d.code, d.message, d.primary.span.start) for d in diagnostics]))
    assert seen[0] == seen[1] and bool(seen[0][1]) == (damage is not None)
