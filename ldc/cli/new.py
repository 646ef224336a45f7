"""`ldc new DIR`: a project that compiles, runs, and has a trace to compare with."""

from __future__ import annotations

import argparse
import re
import shlex
import sys
import unicodedata
from importlib import resources
from pathlib import Path

from ldc.cli.console import OK, Failure, UsageError, say
from ldc.cli.output import write_file


def run(options: argparse.Namespace) -> int:
    folder = Path(options.folder)
    if not options.folder:
        raise UsageError("DIR is empty: name a folder")
    try:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise UsageError(f"`{options.folder}` is there and not an empty folder; nothing was written")
        known = folder.exists()
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Failure(f"cannot make `{options.folder}`: {error.strerror}") from error
    name = _name(folder.resolve().name)
    written: list[Path] = []
    try:
        for entry in sorted((resources.files("ldc.cli") / "project").iterdir(), key=lambda e: e.name):
            text = entry.read_text(encoding="utf-8").replace("{name}", name)
            write_file(folder / entry.name, text.encode("utf-8"))
            written.append(folder / entry.name)
    except BaseException:  # all or nothing: the folder can be tried again
        for path in written:
            path.unlink()
        if not known:
            folder.rmdir()
        raise
    say(f"made the project `{name}` in {options.folder}")
    if sys.stdout.isatty():
        shown = shlex.quote(options.folder)
        say(f"try: ldc draw {shown}    ldc run {shown}    ldc check {shown}")
    return OK


def _name(folder: str) -> str:
    """The name of a project: that of its folder, letters without their accents."""
    plain = "".join(char for char in unicodedata.normalize("NFKD", folder) if not unicodedata.combining(char))
    return re.sub(r"[^A-Za-z0-9_-]+", "_", plain).strip("_") or "project"
