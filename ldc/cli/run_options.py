"""Which options of `ldc run` mean something together, and to whom standard output belongs."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ldc.cli.console import UsageError, is_terminal
from ldc.cli.output import writable


def check(options: argparse.Namespace) -> None:
    """Before anything is read. Raises UsageError for options that mean nothing together, Failure for a result
    that could not be written when it is there."""
    if options.online and options.target:
        raise UsageError("--online changes a program on this computer, not on a --target")
    here = {"--retain": options.retain, "--start": options.start, "--force": options.force,
            "--ring": options.ring, "--events": options.events}
    for name, value in here.items():
        if value and options.target:
            raise UsageError(f"{name} is for a run on this computer, not on a --target")
    if options.board and not options.target:
        raise UsageError("--board is for firmware: name its processor with --target, such as cortex-m3")
    given = {"--no-wait": options.no_wait, "--socket": options.socket, "--audit": options.audit}
    alone = [name for name, value in given.items() if value and not options.online]
    if alone:
        raise UsageError(f"{alone[0]} goes with --online")
    if options.timing and (options.online or options.target or options.realtime):
        raise UsageError(
            "--timing tells of virtual time, which neither --online, --realtime nor a --target has")
    if options.realtime and options.target:
        raise UsageError("--realtime runs on this computer, not on a --target")
    if options.realtime and options.no_wait:
        raise UsageError("--no-wait leaves the time out, which --realtime keeps")
    if options.plot and not options.realtime:
        raise UsageError("--plot goes with --realtime")
    _check_files(options)


def _check_files(options: argparse.Namespace) -> None:
    """A file has one use, and those that are written when the run is over can be written."""
    files = {"--inputs": options.inputs, "--trace": options.trace, "--events": options.events,
             "--timing": options.timing, "--ring": options.ring, "--plot": options.plot,
             "--retain": options.retain, "--audit": options.audit}
    used: dict[object, str] = {}
    for name, target in files.items():
        path = Path(target) if target else None
        if path is None or target != "-" and path.exists() and not path.is_file():
            continue  # a device takes what several write
        other = used.setdefault(target if target == "-" else path.resolve(), name)
        if other != name:
            where = "standard output" if target == "-" else f"the file `{target}`"
            raise UsageError(f"{other} and {name} are both {where}")
    for target in (options.timing, options.ring, options.plot):
        if target not in (None, "-"):
            writable(Path(target))


def shows(options: argparse.Namespace) -> bool:
    """Whether standard output is for people: no result goes there."""
    return options.trace is None and "-" not in (options.events, options.timing, options.ring)


def live(options: argparse.Namespace) -> bool:
    """Whether they see a picture, for which there has to be a terminal."""
    return shows(options) and is_terminal(sys.stdout)
