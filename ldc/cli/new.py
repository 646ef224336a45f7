"""`ldc new DIR`: a project that compiles, runs, and has a trace to compare with."""

from __future__ import annotations

import argparse
import re
import sys
from importlib import resources
from pathlib import Path

from ldc.cli.console import OK, Failure, UsageError, say
from ldc.cli.output import write_file


def run(options: argparse.Namespace) -> int:
    folder = Path(options.folder)
    try:
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise UsageError(f"`{options.folder}` is there and not an empty folder; nothing was written")
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Failure(f"cannot make `{options.folder}`: {error.strerror}") from error
    name = re.sub(r"[^A-Za-z0-9_-]+", "_", folder.resolve().name).strip("_") or "project"
    for entry in sorted((resources.files("ldc.cli") / "project").iterdir(), key=lambda e: e.name):
        text = entry.read_text(encoding="utf-8").replace("{name}", name)
        write_file(folder / entry.name, text.encode("utf-8"))
    shown = options.folder
    say(f"made the project `{name}` in {shown}")
    if sys.stdout.isatty():
        say(f"try: ldc draw {shown}    ldc run {shown}    ldc check {shown}")
    return OK
