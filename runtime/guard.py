"""Runs work that calls foreign native code in a process of its own, watched: a crash or a hang ends that
process, and tells where.

A handler in C (``ldc/components/guard``) catches the signals that end a process and notes the addresses of
the calls; the libraries' debug information makes a line of the innermost one that lies in a component.
"""

from __future__ import annotations

import mmap
import os
import shutil
import signal
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from ldc.patterns import Pattern
from ldc.records import record
from runtime import ending
from runtime.kin import end_with_parent

HANG = 2.0
"""Seconds without a beat after which work counts as hanging; a scan takes milliseconds."""

_BEATS, _NOTE, _BASES, _SIZE = 0, 8, 512, 16 * 1024
_FINISHED = _SIZE - 8
_MOST = 48
_POLL = 0.02
_MOMENT = 2.0
"""Seconds that work which is ended has for putting things in order."""
_PLACE = Pattern(r"(.+):(\d+)(?: \(discriminator \d+\))?\Z")


@record
class Crash:
    """How the process ended. ``signal``: its number, 0 for an exit that nobody asked for; ``hang``: it was
    stopped because it did not go on. ``file``, ``line``: where in a source, "" and 0 when that is not known;
    ``library``: whose code ran."""

    signal: int
    hang: bool
    library: Path | None = None
    file: str = ""
    line: int = 0

    @property
    def what(self) -> str:
        """In words."""
        if self.hang:
            return "does not end"
        return {
            signal.SIGFPE: "divides by zero",
            signal.SIGSEGV: "reads or writes memory that is not there",
            signal.SIGBUS: "reads or writes memory that is not there",
            signal.SIGILL: "ran into no instruction",
            signal.SIGABRT: "gave up (abort)",
        }.get(self.signal, f"was ended by signal {self.signal}" if self.signal else "left the process")


class Beat:
    """What the work is given: it is called once a scan, and told the libraries that may crash."""

    def __init__(self, memory: mmap.mmap) -> None:
        self._memory, self._count = memory, 0
        self._alive: list = []

    def __call__(self) -> None:
        self._count += 1
        struct.pack_into("<Q", self._memory, _BEATS, self._count)

    def watch(self, libraries: Iterable[Path], handler: Path) -> None:
        """Loads the libraries, notes where they lie in memory, and installs the handler of its library.
        Raises OSError when one cannot be loaded."""
        from runtime.c_interface import ffi  # a run without components does not need it

        self._alive = [ffi.dlopen(str(path)) for path in libraries]
        guard = ffi.dlopen(str(handler), ffi.RTLD_NOW | ffi.RTLD_NODELETE)  # signals come to the very end
        wanted = {str(path.resolve()) for path in libraries}
        bases: dict[str, int] = {}
        with open("/proc/self/maps", encoding="utf-8", errors="replace") as maps:
            for line in maps:
                addresses, _, offset, *_, path = f"{line.rstrip()} ".split(" ", 5)
                path = path.strip()
                if path in wanted:
                    start, end = (int(part, 16) for part in addresses.split("-"))
                    low, high = bases.get(path, (start - int(offset, 16), end))
                    bases[path] = (min(low, start), max(high, end))
        text = "\n".join(f"{low:x} {high:x} {path}" for path, (low, high) in bases.items()).encode()
        text = text[: _FINISHED - _BASES - 1]
        self._memory[_BASES : _BASES + len(text) + 1] = text + b"\0"
        buffer = ffi.from_buffer("int64_t[]", self._memory)
        guard.ldc_guard(buffer + _NOTE // 8)


def guarded(work: Callable[[Beat], int], hang: float = HANG, orderly: bool = False) -> int | Crash:
    """The status that ``work`` returns in a process of its own, or how that process ended. What it prints
    goes where this process prints to. It ends with this process: what ends this one by an exception is an
    interrupt there, and it is given a moment. ``orderly``: this process leaves interrupts and SIGTERM to the
    work, which puts everything in order, and may get them twice."""
    memory, watcher = mmap.mmap(-1, _SIZE), os.getpid()
    # A signal between the fork and the first line of the work would raise in the child as if it was this
    # process.
    signal.pthread_sigmask(signal.SIG_BLOCK, ending.SIGNALS)
    child, before = os.fork(), {}
    if child == 0:
        _exit_with(work, memory, watcher)
    try:
        if orderly:
            before = {number: signal.signal(number, lambda number, frame: _kill(child, number))
                      for number in ending.SIGNALS}
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ending.SIGNALS)
        return _watched(child, memory, hang)
    except BaseException:
        _end(child)
        raise
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _end(child: int) -> None:
    """Asks it to end, and ends it when it does not: it may be in a component. Further signals wait."""
    signal.pthread_sigmask(signal.SIG_BLOCK, ending.SIGNALS)
    _kill(child, signal.SIGTERM)
    end = time.monotonic() + _MOMENT
    try:
        while not os.waitpid(child, os.WNOHANG)[0]:
            if time.monotonic() > end:
                _kill(child, signal.SIGKILL)
            time.sleep(_POLL)
    except ChildProcessError:
        return  # it has ended before
    finally:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ending.SIGNALS)


def _exit_with(work: Callable[[Beat], int], memory: mmap.mmap, watcher: int) -> None:
    """Ends the process with the status of the work; never returns."""
    status = 3
    try:
        ending.heed_once()
        signal.pthread_sigmask(signal.SIG_UNBLOCK, ending.SIGNALS)
        if end_with_parent(watcher):
            status = work(Beat(memory))
        sys.stdout.flush()
        sys.stderr.flush()
    except KeyboardInterrupt as interrupt:
        status = ending.status_of(interrupt)
    except BrokenPipeError:
        status = 141
    finally:
        struct.pack_into("<q", memory, _FINISHED, 1)  # it came to an end of its own accord
        os._exit(status)


def _watched(child: int, memory: mmap.mmap, hang: float) -> int | Crash:
    seen, since, asked = -1, time.monotonic(), False
    looked = since
    while True:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            break
        (beats,) = struct.unpack_from("<Q", memory, _BEATS)
        now = time.monotonic()
        if beats != seen or beats == 0 or now - looked > hang / 2:  # or this process was stopped meanwhile
            seen, since = beats, now
        elif now - since > hang:
            _kill(child, signal.SIGKILL if asked else signal.SIGUSR1)
            asked, since = True, now - hang / 2
        looked = now
        time.sleep(_POLL)
    return _outcome(os.waitstatus_to_exitcode(status), memory, asked)


def _outcome(status: int, memory: mmap.mmap, asked: bool) -> int | Crash:
    (finished,) = struct.unpack_from("<q", memory, _FINISHED)
    if finished and not asked:
        return status
    noted, count = struct.unpack_from("<qq", memory, _NOTE)
    addresses = struct.unpack_from(f"<{min(max(count, 0), _MOST)}Q", memory, _NOTE + 16)
    return Crash(noted or max(-status, 0), asked, *_place(addresses, memory))


def _place(addresses: Sequence[int], memory: mmap.mmap) -> tuple[Path | None, str, int]:
    """The innermost call that lies in a watched library."""
    rows = [row.split(" ", 2) for row in memory[_BASES:_FINISHED].split(b"\0", 1)[0].decode().splitlines()]
    for number, address in enumerate(addresses):
        for low, high, path in rows:
            if int(low, 16) <= address < int(high, 16):
                # What is behind the first address are those to return to, behind the call.
                file, line = _line_of(Path(path), address - int(low, 16) - (number > 0))
                return Path(path), file, line
    return None, "", 0


def _line_of(library: Path, offset: int) -> tuple[str, int]:
    tool = shutil.which("addr2line")
    if tool is None:
        return "", 0
    done = subprocess.run(
        [tool, "-e", str(library), hex(offset)], capture_output=True, text=True, check=False
    )
    match = _PLACE.match(done.stdout.strip())
    return (match[1], int(match[2])) if match and match[1] != "??" else ("", 0)


def _kill(child: int, number: int) -> None:
    try:
        os.kill(child, number)
    except ProcessLookupError:
        return
