"""Work done by a copy of this process on another processor, while this one goes on."""

from __future__ import annotations

import gc
import marshal
import os
import signal
import sys
from collections.abc import Callable
from typing import Generic, NoReturn, TypeVar

_Found = TypeVar("_Found")
_PIECE = 1 << 16
"""Bytes that a pipe holds."""


class Beside(Generic[_Found]):
    """What ``work`` finds, which is of what `marshal` knows: numbers, texts, tuples and sets of them.

    The copy begins at once, and is gone behind the ``with`` block. It sees all that this process has when it
    is made and changes nothing here: whatever the work does besides is lost. Where there is no copy, because
    it does not ``pay`` or cannot be made, and where it ends without a result, because the work raises or
    something ends it, this process does the work when it asks for the result. So nothing is lost but time,
    and what the work raises is raised here.

    A copy costs a page of memory, some microseconds, for each that either process then writes to, and Python
    writes to all that it looks at: it pays early in a process, and for work of 50 ms and more.
    """

    def __init__(self, work: Callable[[], _Found], pays: bool = True) -> None:
        self._work = work
        self._child = 0
        if not pays or not _is_room():
            return
        self._pipe, theirs = os.pipe()
        try:
            self._child = os.fork()
        except OSError:  # too many processes, or no memory for one more
            os.close(self._pipe)
        else:
            if self._child == 0:
                _give(work, theirs)
        os.close(theirs)

    def result(self) -> _Found:
        """What the work found; waits for it. To be asked for once."""
        if not self._child:
            return self._work()
        pieces = []
        while piece := os.read(self._pipe, _PIECE):
            pieces.append(piece)
        try:
            return marshal.loads(b"".join(pieces))
        except (EOFError, ValueError, TypeError):  # it ended before all was said
            return self._work()

    def __enter__(self) -> Beside[_Found]:
        return self

    def __exit__(self, *_: object) -> None:
        if self._child:
            os.close(self._pipe)
            os.kill(self._child, signal.SIGKILL)  # it has said all, or nobody wants to know
            os.waitpid(self._child, 0)
            self._child = 0


def _is_room() -> bool:
    """Whether a copy has a processor to itself. Of several threads it would have one, and the locks that the
    others hold."""
    if not hasattr(os, "sched_getaffinity") or len(os.sched_getaffinity(0)) < 2:
        return False
    threading = sys.modules.get("threading")
    return threading is None or threading.active_count() == 1


def _give(work: Callable[[], object], pipe: int) -> NoReturn:
    """In the copy: says what the work finds, and ends, without any of what Python does at an end: what this
    process has yet to write is none of its business."""
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever waits for it is told, and ends it
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
        gc.disable()
        left = memoryview(marshal.dumps(work()))
        while left:
            left = left[os.write(pipe, left):]
        os.close(pipe)
    finally:
        os._exit(0)
