"""Work that does not come back is ended, other work is left alone (`ldc/cli/patience.py`)."""

from __future__ import annotations

import signal
import time

import pytest

from ldc.cli import patience
from ldc.cli.patience import Endless, Patience


def test_short_work_goes_on_for_ever_and_the_timer_ends_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(patience, "LOOK", 0.1)
    before = signal.getsignal(signal.SIGALRM)
    watch, end = Patience(), time.monotonic() + 0.5
    while time.monotonic() < end:
        watch.begin()
        watch.end()
    time.sleep(0.4)
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
    assert signal.getsignal(signal.SIGALRM) == before


def test_what_catches_all_exceptions_is_ended_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(patience, "LOOK", 0.1)
    watch = Patience()
    with pytest.raises(Endless):
        watch.begin()
        try:
            while True:
                try:
                    time.sleep(10)
                except Exception:
                    continue
        finally:
            watch.end()
    time.sleep(0.4)
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
