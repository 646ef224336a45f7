"""The memory that the processes of a run share: words of P, the field, orders of the master, what each tells.

It has no name: processes have it because they were forked, and it is gone when the last of them ends, however
it ends. Every word has one writer.
"""

from __future__ import annotations

import mmap

from runtime.protocol.memory import shared_size
from runtime.realtime.lateness import WORDS, Lateness

_STOP, _EMERGENCIES, _ORDERS = 0, 1, 8
_ALIVE, _RECORD = 0, 8 + WORDS


class Board:
    """``field_bytes``: of the field; ``processes``: how many there are, the master is number 0."""

    def __init__(self, field_bytes: int, processes: int) -> None:
        field_at = shared_size()
        words_at = field_at + -(-field_bytes // 8) * 8
        size = words_at + 8 * (_ORDERS + processes * _RECORD)
        self._memory = mmap.mmap(-1, size)
        view = memoryview(self._memory)
        self.shared, self.field = view[:field_at], view[field_at:words_at]
        self._words = view[words_at:size].cast("Q")

    # ---- written by the master -------------------------------------------------------------------

    @property
    def stopping(self) -> bool:
        """Every process is to end."""
        return self._words[_STOP] != 0

    def stop(self) -> None:
        self._words[_STOP] = 1

    @property
    def emergencies(self) -> int:
        """How many emergencies have begun: another number than before tells a slave of one, without P."""
        return self._words[_EMERGENCIES]

    def emergency(self) -> None:
        self._words[_EMERGENCIES] += 1

    # ---- written by each process -----------------------------------------------------------------

    def beat(self, number: int) -> None:
        """A process tells that it goes on."""
        self._words[_ORDERS + number * _RECORD + _ALIVE] += 1

    def beats(self, number: int) -> int:
        """How often it has told so."""
        return self._words[_ORDERS + number * _RECORD + _ALIVE]

    def lateness(self, number: int) -> Lateness:
        """Its histogram."""
        first = _ORDERS + number * _RECORD + 8
        return Lateness(self._words[first : first + WORDS])
