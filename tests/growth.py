"""How long something takes, for tests that ask how that grows: of the processor, without the collector, the less
of two times. Even so it varies on a busy computer, so tests leave room."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable


def seconds(work: Callable[[], object]) -> float:
    """Seconds of the processor that ``work`` takes."""
    return min(_once(work), _once(work))


def _once(work: Callable[[], object]) -> float:
    gc.collect()
    gc.disable()
    start = time.process_time()
    try:
        work()
        return time.process_time() - start
    finally:
        gc.enable()
