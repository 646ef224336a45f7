"""M, messages between modules inside the master (SPEC 3, docs/messages.md).

What happens and what waits lies in words of the master: a flag in MSGF while a broadcast waits or is handled,
and in MSGD a word of state a message (how many wait, which is the oldest, what ``from`` was before) with the
data that wait behind it. Nothing else is remembered, so a program may be changed between two scans.

A broadcast (C.BCAST) writes data, then state, then the flag. Handling (C.MSG), once a scan after the logic,
takes the oldest broadcast of every message that waits when it begins: what a subscriber broadcasts meanwhile
is handled in the next scan. One of each message, since a flag that a subscriber sees is TRUE for one
execution.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress
from enum import Enum
from struct import Struct

from ldc.il.areas import areas
from ldc.il.coordination import Message, Subscriber, Value
from runtime.protocol.memory import Memory, bit

OVERFLOW = 0x1_0000
"""ALARM with this and the offset of a message in MSGF: a broadcast of it was refused, nobody gets it."""

_COUNT, _FIRST, _BEFORE = 0xFF, 0xFF00, 0x1_0000
_FIRST_AT = 8

Call = Callable[[Message, Subscriber, Value | None], None]


class Outcome(Enum):
    """What became of a broadcast: it ``waits`` to be handled, it took the place of one that waited, or it was
    ``refused`` (and ALARM was broadcast)."""

    WAITS = "waits"
    REPLACED = "replaced"
    REFUSED = "refused"


class Messages:
    """The messages of a program over the memory of its master. ``messages``: those of the system first, each
    class in ascending order."""

    __slots__ = ("_memory", "_flags", "_none", "_rows", "_alarm")

    def __init__(self, memory: Memory, messages: Iterable[Message]) -> None:
        self._memory = memory
        area = areas()["MSGF"]
        self._flags, self._none = area.base // 8, bytes(area.size // 8)
        self._rows = tuple((m, *bit(m.flag), Struct(m.form) if m.form else None) for m in messages)
        self._alarm = next((m for m, *_ in self._rows if m.system and m.name == "ALARM"), None)

    def rises(self, message: Message, now: bool) -> bool:
        """Whether what the message is broadcast from has become TRUE since the call before."""
        data = self._memory.data
        state = data.load(message.slot)
        if bool(state & _BEFORE) == now:
            return False
        data.store(message.slot, state ^ _BEFORE)
        return now

    def broadcast(self, message: Message, value: Value | None = None) -> Outcome:
        """C.BCAST: the value is copied, the message is handled in the next ``handle`` that has its turn."""
        memory = self._memory
        state = memory.data.load(message.slot)
        waiting, first = state & _COUNT, (state & _FIRST) >> _FIRST_AT
        outcome, depth = Outcome.WAITS, message.depth if message.policy == "queue" else 1
        if waiting == depth:
            if message.policy != "overwrite":
                if self._alarm is not None and message is not self._alarm:
                    offset = message.flag - areas()["MSGF"].base
                    self.broadcast(self._alarm, OVERFLOW | offset)
                return Outcome.REFUSED
            outcome, waiting = Outcome.REPLACED, waiting - 1
        if message.form:
            place = (first + waiting) % depth
            memory.data.write(message.slot + 4 + place * message.size, Struct(message.form).pack(value))
        memory.data.store(message.slot, state & ~_COUNT | waiting + 1)
        memory.bits.set(*bit(message.flag))
        return outcome

    def handle(self, call: Call) -> int:
        """C.MSG: calls every subscriber of every message that waits, in order; how many messages those
        were."""
        memory = self._memory
        if memory.bits.read(self._flags, len(self._none)) == self._none:
            return 0
        taken = [(message, word, mask, self._take(message, form))
                 for message, word, mask, form in self._rows if memory.bits.test(word, mask)]
        for message, word, mask, value in taken:
            for subscriber in message.subscribers:
                call(message, subscriber, value)
            if not memory.data.load(message.slot) & _COUNT:
                memory.bits.clear(word, mask)
        return len(taken)

    def _take(self, message: Message, form: Struct | None) -> Value | None:
        """The data of the oldest broadcast, which waits no longer."""
        data = self._memory.data
        state = data.load(message.slot)
        first = (state & _FIRST) >> _FIRST_AT
        value = None
        if form is not None:
            (value,) = form.unpack(data.read(message.slot + 4 + first * message.size, message.size))
        depth = message.depth if message.policy == "queue" else 1
        data.store(message.slot, state & ~(_FIRST | _COUNT) | (first + 1) % depth << _FIRST_AT
                   | (state & _COUNT) - 1)
        return value

    def take_over(self, other: Messages, now: Callable[[Message, Value | None], Value | None]
                  = lambda message, value: value) -> None:
        """Between two scans, from the messages of the program before, over the same memory: those of the same
        name and the same form of data keep what waits, in its order, and what ``from`` was. What has no room
        any more is refused as any broadcast. ``now``: the data of a message in this program; raises
        LookupError when what it tells of is gone, and the message with it."""
        data = self._memory.data
        kept = {}
        for message, word, mask, form in other._rows:
            state = data.load(message.slot)
            values = [other._take(message, form) for _ in range(state & _COUNT)]
            kept[message.name.upper(), message.form] = (state & _BEFORE, values)
            self._memory.bits.clear(word, mask)
        rows = [(m, *kept.get((m.name.upper(), m.form), (0, ()))) for m, *_ in self._rows]
        for message, before, _ in rows:
            data.store(message.slot, before)
        for message, _, values in rows:
            for value in values:
                with suppress(LookupError):
                    self.broadcast(message, now(message, value))

    def clear(self) -> None:
        """Nothing waits any longer: after an emergency."""
        for message, word, mask, _ in self._rows:
            state = self._memory.data.load(message.slot)
            self._memory.data.store(message.slot, state & _BEFORE)
            self._memory.bits.clear(word, mask)
