"""One processor's end of a slot: what it sends and what it receives, both at once.

The owner polls it as often as it likes and tells it when a period has passed; the thread level that does so
is one (communication, SPEC 6.1), for a word of flags has one writer.
"""

from __future__ import annotations

from runtime.protocol import receiver as receiving
from runtime.protocol import sender as sending
from runtime.protocol.check import Situation
from runtime.protocol.memory import Watched, Words
from runtime.protocol.profile import Link

Event = sending.Event | receiving.Event


class Endpoint:
    """``out``: the direction that this processor sends in; ``into``: the one that it receives in.
    ``situation`` may be replaced at any moment."""

    __slots__ = ("memory", "out", "into", "situation", "sender", "receiver")

    def __init__(self, memory: Words | Watched, out: Link, into: Link, situation: Situation) -> None:
        self.memory, self.out, self.into, self.situation = memory, out, into, situation
        self.sender, self.receiver = sending.Sender(), receiving.Receiver()

    @property
    def ready(self) -> bool:
        """``send`` is possible."""
        return self.sender.ready

    @property
    def rests(self) -> bool:
        """Nothing is sent or received, though somebody may have begun to send."""
        return self.receiver.phase is _WATCH and self.sender.phase in _AT_REST

    @property
    def idle(self) -> bool:
        """Nothing to do: nothing is sent or received, and nobody has begun to send."""
        into = self.into.channel
        return (self.sender.phase in _AT_REST and self.receiver.phase is _WATCH
                and not self.memory.test(into.running, into.mask))

    def send(self, aid: int, cmd: int, adata: bytes = b"") -> None:
        """Begins a transfer. Raises Busy; ValueError when the data do not fit the slot."""
        sending.submit(self.sender, self.out, aid, cmd, adata)

    def reset(self) -> None:
        """Makes the direction that it sends in new, after a fault or at a start."""
        sending.reset(self.sender)

    def poll(self) -> tuple[Event, ...]:
        """As many steps of each machine as are possible now, and what has come of them: at most one event of
        each. Both machines stand at a wait then, or at the end of a transfer."""
        sender = self.sender
        first = None if sender.phase in _AT_REST else sending.run(sender, self.out, self.memory)
        second = receiving.run(self.receiver, self.into, self.memory, self.situation)
        if second is None:
            return () if first is None else (first,)
        return (second,) if first is None else (first, second)

    def step(self) -> tuple[Event, ...]:
        """One step of each machine, and what has come of it."""
        first = sending.step(self.sender, self.out, self.memory)
        second = receiving.step(self.receiver, self.into, self.memory, self.situation)
        return tuple(event for event in (first, second) if not isinstance(event, bool))

    def tick(self) -> tuple[Event, ...]:
        """A period has passed."""
        receiving.tick(self.receiver, self.into)
        told = None if self.sender.phase in _AT_REST else sending.tick(self.sender, self.out)
        return () if told is None else (told,)


_AT_REST = (sending.Phase.IDLE, sending.Phase.FAULT)
_WATCH = receiving.Phase.WATCH

