"""The memory that the processes of a run share: words of P, the field, orders of the master, what each tells,
what algorithms retain.

It has no name: processes have it because they were forked, and it is gone when the last of them ends, however
it ends. Every word has one writer.
"""

from __future__ import annotations

import mmap
from collections.abc import Sequence

import msgspec

from runtime.protocol.memory import shared_size
from runtime.realtime.lateness import WORDS, Lateness
from runtime.retain_file import Entry

_STOP, _EMERGENCIES, _SAVES, _START, _ORDERS = 0, 1, 2, 3, 8
_ALIVE, _SAVED, _HERE, _RECORD = 0, 1, 2, 8 + WORDS


class Board:
    """``field_bytes``: of the field; ``processes``: how many there are, the master is number 0; ``kept``:
    bytes that what each retains takes at most, 0 for nothing."""

    def __init__(self, field_bytes: int, processes: int, kept: Sequence[int] = ()) -> None:
        field_at = shared_size()
        words_at = field_at + -(-field_bytes // 8) * 8
        kept_at = words_at + 8 * (_ORDERS + processes * _RECORD)
        # Of what is retained there are two copies, one of which is whole at every moment.
        self._memory = mmap.mmap(-1, kept_at + 2 * sum(kept))
        view = memoryview(self._memory)
        self.shared, self.field = view[:field_at], view[field_at:words_at]
        self._words = view[words_at:kept_at].cast("Q")
        self._kept: list[tuple[memoryview, memoryview]] = []
        for size in (*kept, *[0] * (processes - len(kept))):
            self._kept.append((view[kept_at : kept_at + size], view[kept_at + size : kept_at + 2 * size]))
            kept_at += 2 * size

    # ---- written by the master -------------------------------------------------------------------

    @property
    def start_ns(self) -> int:
        """When the first period of all begins, on ``time.monotonic_ns``; 0 while that is not known."""
        return self._words[_START]

    def begin(self, start_ns: int) -> None:
        self._words[_START] = start_ns

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

    @property
    def saves(self) -> int:
        """How many saves have begun: another number than before asks for what algorithms retain."""
        return self._words[_SAVES]

    def save(self) -> int:
        """Begins one; its number."""
        self._words[_SAVES] += 1
        return self._words[_SAVES]

    # ---- written by each process -----------------------------------------------------------------

    def arrive(self, number: int) -> None:
        """A process is ready for its first period."""
        self._words[_ORDERS + number * _RECORD + _HERE] = 1

    def arrived(self, number: int) -> bool:
        return self._words[_ORDERS + number * _RECORD + _HERE] != 0

    def keeps(self, number: int) -> bool:
        """A process retains something."""
        return len(self._kept[number][0]) > 0

    def keep(self, number: int, save: int, entries: Sequence[Entry]) -> None:
        """A process that retains something answers a save. Whoever reads it has the one before until all is
        there."""
        at = _ORDERS + number * _RECORD + _SAVED
        copy = 1 - (self._words[at] & 1)
        data = msgspec.msgpack.encode(entries)
        place = self._kept[number][copy]
        place[:4], place[4 : 4 + len(data)] = len(data).to_bytes(4, "little"), data
        self._words[at] = save << 1 | copy

    def saved(self, number: int) -> int:
        """The save that a process answered last."""
        return self._words[_ORDERS + number * _RECORD + _SAVED] >> 1

    def kept(self, number: int) -> list[Entry]:
        """What it answered, or was given at the start."""
        place = self._kept[number][self._words[_ORDERS + number * _RECORD + _SAVED] & 1]
        if not place:
            return []
        size = int.from_bytes(place[:4], "little")
        return msgspec.msgpack.decode(place[4 : 4 + size], type=list[Entry])

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
