"""How commands speak: diagnostics and progress to standard error, colour only on a terminal."""

from __future__ import annotations

import codecs
import errno
import os
import sys
from collections.abc import Callable, Iterable
from typing import IO

from ldc.diagnostics import Diagnostic, Invalid, Locate, Severity
from ldc.render import render, visible

OK, WRONG, USAGE, INTERNAL = 0, 1, 2, 3
"""The exit statuses (DESIGN section 8): fine, the input is wrong, the command line is wrong, a bug."""


FULL = frozenset((errno.ENOSPC, errno.EDQUOT, errno.EFBIG))
"""Errors of a write that had no room: not of ldc, whatever wrote."""


SHOWABLE = "ldc.showable"
"""What becomes of characters that an encoding lacks: lines of drawings are shown by those of ASCII, others,
and the bytes of names of files that are no text, as escapes."""

_LIKE = dict(zip("─│┃┌┐└┘├┠┤┬┴┼╞→►●▁▇…µ", "-||++++|||+++|>>*_#~u", strict=True))


def _showable(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    lacking = error.object[error.start : error.end]
    shown = (_LIKE.get(char) or char.encode("ascii", "backslashreplace").decode() for char in lacking)
    return "".join(shown), error.end


codecs.register_error(SHOWABLE, _showable)


class UsageError(Exception):
    """The command line is wrong in a way that only the command itself can see; ends with status 2."""


class Failure(Exception):
    """Something outside ldc is in the way (a folder that cannot be written); ends with status 1."""


def reason(error: OSError) -> str:
    """What the system says, and of which file."""
    return f"`{error.filename}`: {error.strerror}" if error.filename else error.strerror or str(error)


class InternalFault(Exception):
    """ldc contradicts itself: a bug, for the report of which `details` is the material; status 3."""

    def __init__(self, message: str, details: str) -> None:
        super().__init__(message)
        self.details = details


def is_terminal(stream: IO[str]) -> bool:
    try:
        return stream.isatty()
    except ValueError:
        return False


def wants_color(stream: IO[str]) -> bool:
    """Colour is for a terminal that can show it, and for people who did not say NO_COLOR."""
    return is_terminal(stream) and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def silence_stdout() -> None:
    """What is still to be written goes nowhere: the interpreter would complain when it flushes at the end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def say(text: str) -> None:
    """One line to standard error."""
    print(text, file=sys.stderr)


def answered(command: str, work: Callable[[], int]) -> int:
    """The status of a command; what it gives up with is told."""
    try:
        return work()
    except UsageError as error:
        say(f"ldc {command}: {visible(str(error))}")
        return USAGE
    except Failure as error:
        say(f"ldc {command}: {visible(str(error))}")
        return WRONG
    except Invalid as error:
        return report(error.diagnostics, error.locate) or WRONG


def report(diagnostics: Iterable[Diagnostic], locate: Locate | None = None) -> int:
    """Show findings on standard error; the status that they mean. `locate` finds them in drawings.

    Findings of the LD09xx group say that ldc's own result is wrong: they end as an internal fault.
    """
    found = list(diagnostics)
    if found:
        import shutil  # slow to load, and most compiles have nothing to show

        width = shutil.get_terminal_size((100, 24)).columns if is_terminal(sys.stderr) else 100
        sys.stdout.flush()
        sys.stderr.write(render(found, color=wants_color(sys.stderr), width=width, locate=locate))
    internal = [d for d in found if d.code.startswith("LD09") and d.severity is Severity.ERROR]
    if internal:
        raise InternalFault(f"{internal[0].code} {internal[0].message}", render(found, limit=1000))
    return WRONG if any(d.severity is Severity.ERROR for d in found) else OK
