"""What Ctrl-C does while modules are loaded."""

from __future__ import annotations

import signal


class Unheeded:
    """Inside, Ctrl-C ends the process as it ends one that knows nothing of it. Python would raise in the
    midst of a module: a traceback of imports, or of a class that is half made. Where somebody has other plans
    with Ctrl-C, or a shell lets what it starts in the background ignore it, those stay."""

    def begin(self) -> None:
        self._before = signal.getsignal(signal.SIGINT)
        self._ours = self._before is signal.default_int_handler
        try:
            if self._ours:
                signal.signal(signal.SIGINT, signal.SIG_DFL)
        except ValueError:  # this is not the main thread: signals are no business of it
            self._ours = False

    __enter__ = begin

    def __exit__(self, *error: object) -> None:
        if self._ours:
            signal.signal(signal.SIGINT, self._before)
