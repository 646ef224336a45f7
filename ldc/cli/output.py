"""Results: to standard output, or to a file that is complete or not there at all."""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from ldc import unfinished
from ldc.cli.console import Failure, UsageError, is_terminal


def write_result(data: str | bytes, target: str | None) -> None:
    """Write to the file `target`, or to standard output when it is None or `-`."""
    if target not in (None, "-"):
        write_file(Path(target), data if isinstance(data, bytes) else data.encode("utf-8"))
    elif isinstance(data, str):
        sys.stdout.write(data if data.endswith("\n") or not data else data + "\n")
    elif is_terminal(sys.stdout):
        raise UsageError("the result is binary: name a file with -o, or send it into a pipe")
    else:
        sys.stdout.flush()
        sys.stdout.buffer.write(data)


def writable(path: Path) -> None:
    """Raises Failure when `write_file` would, as far as the folder tells it: before work that ends with a
    result."""
    folder = path.parent
    number = 0
    if not folder.exists():
        number = errno.ENOENT
    elif path.is_dir():
        number = errno.EISDIR
    elif not folder.is_dir():
        number = errno.ENOTDIR
    elif not os.access(path if path.exists() and not path.is_file() else folder, os.W_OK):
        number = errno.EROFS if os.statvfs(folder).f_flag & os.ST_RDONLY else errno.EACCES
    if number:
        raise Failure(f"cannot write `{path}`: {os.strerror(number)}")


def write_file(path: Path, data: bytes) -> None:
    """Replace the file in one step, so that no reader sees half of it; its permissions stay.

    Raises Failure when the folder or the file cannot be written.
    """
    with replacing(path) as file:
        file.write(data)


@contextmanager
def replacing(path: Path) -> Iterator[BinaryIO]:
    """A file to write to, which takes the name `path` when the block ends well; see `write_file`.

    What is no plain file (a device, a pipe) is written to as it is: it must not be replaced.
    """
    try:
        path = path.resolve()
        mode = path.stat().st_mode if path.exists() else None
        if mode is not None and not stat.S_ISREG(mode):
            with open(path, "wb") as file:
                yield file
            return
        with unfinished.file_in(path.parent) as file:
            yield file
            if mode is not None:
                os.fchmod(file.fileno(), stat.S_IMODE(mode))
            unfinished.named(file, path)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise Failure(f"cannot write `{path}`: {reason}") from error
