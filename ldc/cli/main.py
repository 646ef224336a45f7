"""How `ldc` ends: the command is run, and whatever happens becomes an exit status."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence

from ldc.cli.arguments import make_parser
from ldc.cli.console import (
    FULL, SHOWABLE, USAGE, WRONG, answered, is_terminal, say, silence_stdout
)
from ldc.cli.interrupt import Unheeded
from ldc.collector import resting
from runtime.ending import Heeded, status_of

BROKEN_PIPE = 141
"""As a shell reports a command that SIGPIPE ended."""


def main(arguments: Sequence[str]) -> int:
    """Run one command; its exit status. Nothing that a command raises gets past here."""
    _open_streams()
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            # Results are the same bytes on every machine; people see what their terminal can show.
            encoding = None if is_terminal(stream) else "utf-8"
            stream.reconfigure(encoding=encoding, errors=SHOWABLE)
    try:
        status = _run(arguments)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        silence_stdout()
        return BROKEN_PIPE
    except KeyboardInterrupt as interrupt:
        return status_of(interrupt)
    except Exception as error:
        if isinstance(error.__cause__, KeyboardInterrupt):  # Python wraps what comes while a class is made
            return status_of(error.__cause__)
        if isinstance(error, OSError) and error.errno in FULL:
            silence_stdout()
            say(f"ldc: cannot write: {error.strerror}")
            return WRONG
        from ldc.cli.crash import reported  # loads what nobody hopes to need

        return reported(error, arguments)


def _open_streams() -> None:
    """A stream that was closed before the command began (`>&-`) goes nowhere; its number is taken, or the
    next file that is opened would get it, and what others write there."""
    for name, number in (("stdout", 1), ("stderr", 2)):
        if getattr(sys, name) is None:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            if nowhere != number:
                os.dup2(nowhere, number)
                os.close(nowhere)
            setattr(sys, name, open(number, "w", encoding="utf-8", closefd=False))


def _run(arguments: Sequence[str]) -> int:
    parser = make_parser(*arguments[:1])
    try:
        options = parser.parse_args(arguments)
    except SystemExit as exit:
        return exit.code if isinstance(exit.code, int) else USAGE
    if options.command is None:
        parser.print_help(sys.stderr)
        return USAGE
    options.arguments = list(arguments)
    with resting(), Unheeded():
        command = importlib.import_module(f"ldc.cli.{options.command}")
    with Heeded():
        return answered(options.command, lambda: command.run(options))
