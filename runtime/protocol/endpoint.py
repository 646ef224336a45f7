"""One processor's end of a slot: what it sends and what it receives, both at once.

The owner polls it as often as it likes and tells it when a period has passed; the thread level that does so
is one (communication, SPEC 6.1), for a word of flags has one writer.
"""

from __future__ import annotations

from collections.abc import Sequence

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

    def send(self, aid: int, cmd: int, adata: bytes = b"") -> None:
        """Begins a transfer. Raises Busy; ValueError when the data do not fit the slot."""
        self.sender = sending.submit(self.sender, self.out, aid, cmd, adata)

    def reset(self) -> None:
        """Makes the direction that it sends in new, after a fault or at a start."""
        self.sender = sending.reset(self.sender)

    def poll(self) -> Sequence[Event]:
        """A step of each machine, and what has come of it."""
        self.sender, first = sending.step(self.sender, self.out, self.memory)
        self.receiver, second = receiving.step(self.receiver, self.into, self.memory, self.situation)
        if first is None and second is None:
            return ()
        return [event for event in (first, second) if event is not None]

    def tick(self) -> Sequence[Event]:
        """A period has passed."""
        self.sender, event = sending.tick(self.sender, self.out)
        self.receiver = receiving.tick(self.receiver, self.into)
        return () if event is None else (event,)
