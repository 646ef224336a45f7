"""The garbage collector rests while much is made that stays."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def resting() -> Iterator[None]:
    """What is made inside is not walked, neither again and again as it grows nor when it is done: it counts
    as old at once. Without this the first collection behind a compile takes as long as a stage of it."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.freeze()
            gc.unfreeze()  # everything is in the oldest generation now
            gc.enable()
