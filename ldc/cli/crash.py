"""What is kept of a bug in ldc: a file that holds all that a report needs."""

from __future__ import annotations

import os
import platform
import shlex
import sys
import tempfile
import time
import traceback
from collections.abc import Sequence
from pathlib import Path

from ldc import __version__
from ldc.cli.console import INTERNAL, say
from ldc.render import visible


def reported(error: Exception, arguments: Sequence[str]) -> int:
    """One line for the user, everything else into a file for those who mend it. The exit status."""
    what = " ".join(f"{type(error).__name__}: {error}".split())[:120]
    path = write_dump(error, arguments)
    if path is None:
        say(dump_text(error, arguments))
    say(
        f"ldc: internal fault ({visible(what)}); this is a bug in ldc, "
        f"please report it with {path or 'the text above'}"
    )
    return INTERNAL


def write_dump(error: BaseException, arguments: Sequence[str]) -> Path | None:
    """Write the report to the current folder, or else to that for temporary files; None if neither works."""
    text = dump_text(error, arguments)
    name = f"ldc-bug-{time.strftime('%Y%m%d-%H%M%S')}-{os.getpid()}.txt"
    for folder in (Path("."), Path(tempfile.gettempdir())):
        try:
            (folder / name).write_text(text, encoding="utf-8", errors="backslashreplace")
        except OSError:
            continue
        return folder / name
    return None


def dump_text(error: BaseException, arguments: Sequence[str]) -> str:
    """Version, machine, command and traceback. A traceback of endless recursion is cut in the middle."""
    trace = "".join(traceback.format_exception(error, limit=-60))
    details = getattr(error, "details", "")
    return (
        f"ldc {__version__}\n"
        f"python {sys.version.split()[0]} on {platform.platform()}\n"
        f"command: ldc {shlex.join(arguments)}\n"
        f"folder: {_folder()}\n\n"
        f"{trace}\n{details}"
    )


def _folder() -> str:
    try:
        return os.getcwd()
    except OSError as error:  # it was deleted
        return str(error.strerror)
