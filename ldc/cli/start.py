"""Where the console script begins: nothing but the handling of Ctrl-C is loaded before the rest of ldc."""

from __future__ import annotations

import gc
import signal
import sys


def entry() -> None:
    """Run the command of `sys.argv`, and end with its status.

    While modules are loaded, and when the command is done, Ctrl-C ends the process as it ends one that knows
    nothing of it: Python would show a traceback of imports. In between it is the `KeyboardInterrupt` that
    commands heed. A shell that starts a command in the background lets it ignore Ctrl-C; then it does.
    """
    heeded = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if heeded:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from ldc.cli.main import main

    if heeded:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    status = main(sys.argv[1:])
    if heeded:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    gc.freeze()  # the process ends: nobody needs to look for what nobody uses
    sys.exit(status)
