"""Results: to standard output, or to a file that is complete or not there at all."""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

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
        handle, temporary = tempfile.mkstemp(prefix=f".{path.name[:40]}.", dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                yield file
            os.chmod(temporary, stat.S_IMODE(mode) if mode is not None else 0o666 & ~_umask())
            os.replace(temporary, path)
        except BaseException:
            os.unlink(temporary)
            raise
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise Failure(f"cannot write `{path}`: {reason}") from error


def _umask() -> int:
    """The process's mask of permissions, which can only be read by setting it."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask
