"""Where the console script begins: nothing but the handling of Ctrl-C is loaded before the rest of ldc."""

from __future__ import annotations

import atexit
import os
import sys

from ldc.cli.interrupt import Unheeded


def entry() -> None:
    """Run the command of `sys.argv`, and end with its status."""
    statuses: list[int] = []
    atexit.register(_leave, statuses)  # before all others, so that it is called last
    with Unheeded():
        from ldc.cli.main import main
    statuses.append(main(sys.argv[1:]))
    Unheeded().begin()  # for all that Python does at the end
    sys.exit(statuses[0])


def _leave(statuses: list[int]) -> None:
    """End the process as it stands: to take down what a compile has made, object by object, would take as
    long as a stage of it."""
    if not statuses:
        return
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except (OSError, ValueError):  # what others wrote at the end, and nobody takes
        os._exit(statuses[0] or 1)
    os._exit(statuses[0])
