"""Files that are not finished, and what to do about those of somebody who was killed.

An unfinished file or folder lies where it will be needed, is called ``.ldc-<16 digits>.tmp``, and is locked
(flock) by who makes it. The kernel lets go of the lock when the last process that has it ends, however it
ends: so one that can be locked belongs to nobody that lives, and the next to make one in that folder takes it
away.
"""

from __future__ import annotations

import fcntl
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from stat import S_ISDIR
from typing import BinaryIO

_BEGIN, _END = ".ldc-", ".tmp"


@contextmanager
def file_in(folder: Path, mode: int = 0o666) -> Iterator[BinaryIO]:
    """A new file, empty. When the block ends it is gone, unless it has got its name by then (``named``).
    Raises OSError."""
    sweep(folder)
    while True:
        # The name is known before the file exists: an interrupt at any moment leaves nothing behind.
        path = _new(folder)
        try:
            with open(path, "xb", opener=lambda name, flags: os.open(name, flags, mode)) as file:
                if held(file.fileno()):
                    yield file
                    return
        finally:
            path.unlink(missing_ok=True)


@contextmanager
def folder_in(folder: Path) -> Iterator[Path]:
    """A new folder, which is gone with all that is in it when the block ends, unless it has another name by
    then. Raises OSError."""
    sweep(folder)
    while True:
        path = _new(folder)
        try:
            path.mkdir(parents=True)
            opened = os.open(path, os.O_RDONLY | os.O_DIRECTORY)
            try:
                if held(opened):
                    yield path
                    return
            finally:
                os.close(opened)
        finally:
            _remove_tree(path)


def named(file: BinaryIO, path: Path) -> None:
    """An unfinished file is finished: it takes its name, whatever had it. Raises OSError."""
    file.flush()
    os.replace(file.name, path)


@contextmanager
def alone(path: Path, patience: float = 1.0) -> Iterator[bool]:
    """While the block runs, nobody else gets True for the file ``path``, which is there as long.
    ``patience``: seconds that somebody is given who ends just now. Raises OSError when it cannot be made."""
    opened = _locked(path, time.monotonic() + patience)
    try:
        yield opened is not None
    finally:
        if opened is not None:
            path.unlink(missing_ok=True)
            os.close(opened)


def _locked(path: Path, end: float) -> int | None:
    while True:
        opened = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        if held(opened):
            return opened
        os.close(opened)
        if time.monotonic() > end:
            return None
        time.sleep(0.01)


def held(opened: int) -> bool:
    """Locks what is open. False when somebody else has the lock, or took the file away meanwhile: it may be
    that of a sweep, which could not know whose it is. A file system without locks is never swept."""
    try:
        fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:
        return True
    return os.fstat(opened).st_nlink > 0


def sweep(folder: Path) -> None:
    """Takes away what others left unfinished. Once in a process for each folder: it lists all that is
    there."""
    _sweep(os.path.abspath(folder))


@cache
def _sweep(folder: str) -> None:
    with suppress(OSError):  # a folder that is not there, or not ours to read, has nothing for us
        with os.scandir(folder) as entries:
            found = [entry.path for entry in entries
                     if entry.name.startswith(_BEGIN) and entry.name.endswith(_END)]
        for path in found:
            _take_away(path)


def _take_away(path: str) -> None:
    """Nothing happens to what somebody has still, or who may not remove it."""
    with suppress(OSError):
        opened = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if S_ISDIR(os.fstat(opened).st_mode):
                _remove_tree(Path(path))
            else:
                os.unlink(path)
        finally:
            os.close(opened)


def _remove_tree(path: Path) -> None:
    import shutil  # slow to load, and files are written more often than folders

    shutil.rmtree(path, ignore_errors=True)


def _new(folder: Path) -> Path:
    return folder / f"{_BEGIN}{os.urandom(8).hex()}{_END}"
