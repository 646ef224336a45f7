"""SIGTERM as Ctrl-C is: an exception that ends what is being done in order, files and all."""

from __future__ import annotations

import signal
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)
"""What ends a command in order."""
INTERRUPTED, TERMINATED = 130, 143
"""As a shell reports a command that SIGINT or SIGTERM ended."""


class Terminated(KeyboardInterrupt):
    """SIGTERM came."""


def status_of(interrupt: KeyboardInterrupt) -> int:
    """That of a command which it ended."""
    return TERMINATED if isinstance(interrupt, Terminated) else INTERRUPTED


class Heeded:
    """Inside, SIGTERM raises. Who has other plans with it keeps them."""

    def __enter__(self) -> None:
        self._ours = signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
        try:
            if self._ours:
                signal.signal(signal.SIGTERM, _raise)
        except ValueError:  # this is not the main thread: signals are no business of it
            self._ours = False

    def __exit__(self, *error: object) -> None:
        if self._ours:
            signal.signal(signal.SIGTERM, signal.SIG_DFL)


def heed_once() -> None:
    """From now on the first SIGINT or SIGTERM raises in this process, and further ones do nothing: it
    ends."""
    for number in SIGNALS:
        signal.signal(number, _raise_once)


def _raise(number: int, frame: FrameType | None) -> None:
    raise Terminated


def _nothing(number: int, frame: FrameType | None) -> None:
    """Not SIG_IGN: of a signal that has come already Python would say that it is ignored."""


def _raise_once(number: int, frame: FrameType | None) -> None:
    for each in SIGNALS:
        signal.signal(each, _nothing)
    raise Terminated if number == signal.SIGTERM else KeyboardInterrupt
