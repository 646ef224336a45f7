"""What transfers cost in virtual time: the work of a processor on its frames (docs/scheduling.md)."""

from __future__ import annotations

from runtime.protocol.endpoint import Endpoint
from runtime.protocol.envelope import HEAD, Envelope
from runtime.protocol.sender import Phase

_WRITTEN = (Phase.ANSWER, Phase.IDLE)
"""Where a sender stands when what it sent last is in the slot."""


class Meter:
    """Of one processor. ``frame_ns``: for each frame that it has written or taken; ``word_ns``: for each of
    the words of 32 bits in it. A frame that is refused costs its sender alone."""

    def __init__(self, frame_ns: int, word_ns: int) -> None:
        self._frame, self._word = frame_ns, word_ns
        self._known: dict[object, tuple[Envelope | None, Envelope | None]] = {}

    def cost(self, end: Endpoint) -> int:
        """What an endpoint has done since the call before, in ns."""
        channel, sender = end.out.channel, end.sender
        written, taken = self._known.get(channel, (None, None))
        spent = 0
        if sender.phase in _WRITTEN and sender.message is not written and sender.message.cmd:
            written = sender.message
            spent += self._of(written)
        previous = end.receiver.previous
        if previous is not None and previous is not taken:
            taken = previous
            spent += self._of(taken)
        self._known[channel] = written, taken
        return spent

    def _of(self, envelope: Envelope) -> int:
        return self._frame + (HEAD + len(envelope.adata)) // 4 * self._word
