"""Processes that do not outlive the one that made them."""

from __future__ import annotations

import ctypes
import os
import signal

_PR_SET_PDEATHSIG = 1


def end_with_parent(parent: int) -> bool:
    """From now on the kernel ends this process (SIGKILL) when its parent dies, whatever that died of. Whether
    ``parent`` is its parent still: one that has died already tells nobody."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    return os.getppid() == parent
