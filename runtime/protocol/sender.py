"""The sending side of P: a machine that is stepped, one access to shared memory or one local step a call.

``run`` goes on with the same steps until one has to wait. All of a machine's state is in its ``state``, so
that tests can try every interleaving with the receiver. Time comes from outside too: the owner calls ``tick``
once a period.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from operator import attrgetter

from ldc.records import record, replace
from runtime.protocol.check import CODES, TRANSIENT, Code
from runtime.protocol.envelope import HEAD, Command, Envelope, encode, successor, token
from runtime.protocol.memory import Watched, Words
from runtime.protocol.profile import CLEAR, COPY, SET, Link, Steps


class Phase(IntEnum):
    """IDLE and FAULT wait for the owner, REST for the receiver's flags to be 0 (M0), ANSWER for its answer
    (M5)."""

    IDLE = 0
    REST = 1
    OPEN = 2
    ANSWER = 3
    STATUS = 4
    LAST = 5
    CLOSE = 6
    WITHDRAW = 7
    FAULT = 8


@record
class Done:
    """The receiver has taken transfer ``seq``."""

    seq: int


@record
class Fault:
    """The link stands until a reset. Whether the receiver has taken transfer ``seq`` is not known."""

    seq: int
    code: Code


@record
class Linked:
    """A reset is done. ``last``: the transfer that the receiver took last before, 0 for none. ``delivered``:
    the transfer that the fault left open is that one."""

    last: int
    delivered: bool


Event = Done | Fault | Linked


_NO_MESSAGE = Envelope(0, 0, 0, 0)


@dataclass(slots=True)
class Sender:
    """``at``: where in the phase; ``waited``: periods in it; ``copied``: bytes of the frame
    that are in the slot, from its second word; ``seq``: of the last transfer; ``open``: the one
    whose fate is unknown, 0 for none; ``resets``: the ordinal of the last reset."""

    phase: Phase = Phase.IDLE
    at: int = 0
    waited: int = 0
    copied: int = 4
    seq: int = 0
    open: int = 0
    resets: int = 0
    last: int = 0
    code: Code = Code.OK
    message: Envelope = _NO_MESSAGE
    frame: bytes = b""

    @property
    def ready(self) -> bool:
        """A transfer can be submitted."""
        return self.phase is _IDLE

    def state(self) -> tuple:
        """All members: ``Sender(*state)`` is the same machine."""
        return _STATE(self)


_STATE = attrgetter(*Sender.__dataclass_fields__)
_IDLE, _REST, _ANSWER, _STATUS, _LAST, _CLOSE, _WITHDRAW = (
    Phase.IDLE, Phase.REST, Phase.ANSWER, Phase.STATUS, Phase.LAST, Phase.CLOSE, Phase.WITHDRAW)
_OK, _RESET = Code.OK, Command.RESET

Outcome = Event | bool
"""Of a step: what the owner is told; or True: it has gone on, False: it waits."""


class Busy(Exception):
    """A transfer is still open, or the link stands."""


def submit(s: Sender, link: Link, aid: int, cmd: int, adata: bytes = b"") -> None:
    """Begins a transfer. Raises Busy; ValueError when the data do not fit the slot."""
    if s.phase is not _IDLE:
        raise Busy(f"transfer {s.seq} is in phase {s.phase.name}")
    if len(adata) > link.channel.size - HEAD or len(adata) % 4:
        raise ValueError(f"{len(adata)} bytes of data for a slot of {link.channel.size}")
    s.seq = s.open = successor(s.seq)
    _attempt(s, Envelope(s.seq, aid, cmd, 0, adata))


def reset(s: Sender) -> None:
    """Gives up what is open and makes the link new, from any phase; ``Linked`` tells the end.

    A reset that has failed is the same again, so that a receiver that knows it still tells what it had
    before.
    """
    if s.message.cmd != _RESET or s.ready:
        s.resets = s.resets + 1 & 0xFFFFFFFF
    _go(s, _WITHDRAW)
    s.message, s.frame, s.code = Envelope(0, s.resets, _RESET, 0), b"", _OK


def tick(s: Sender, link: Link) -> Event | None:
    """A period has passed."""
    if s.phase is _ANSWER:
        s.waited += 1
        if s.waited >= link.ack_periods:
            _go(s, _WITHDRAW)
            s.code = Code.SILENT
    elif s.phase is _REST:
        s.waited += 1
        if s.waited >= link.clear_periods:
            return _failed(s, Code.STUCK)
    return None


def step(s: Sender, link: Link, memory: Words | Watched) -> Outcome:
    """The next step."""
    return _STEPS[s.phase](s, link, memory)


def run(s: Sender, link: Link, memory: Words | Watched) -> Event | None:
    """Steps until one waits or has something to tell: the same accesses as those of ``step`` again and again
    (tests/test_protocol_model.py compares them in every state). The stretches of which nearly every transfer
    consists are written out, because steps cost more than what they do."""
    if (s.phase is _REST and not s.at and s.copied == 4 and link.chunk >= len(s.frame)
            and not _sent(s, link, memory)):
        return None
    if s.phase is _ANSWER and not s.at:
        c = link.channel
        if memory.search(link.answer, c.mask) == 2:
            return None
        if link.profile.settled and memory.test(c.busy, c.mask):
            s.at = 2
            return None
        s.phase = _STATUS
    while (outcome := _STEPS[s.phase](s, link, memory)) is True:
        pass
    return outcome or None


def _sent(s: Sender, link: Link, memory: Words | Watched) -> bool:
    """M0 to M4 at once."""
    mask = link.channel.mask
    if memory.search(link.quiet, mask) < 3:
        return False
    for kind, at in link.opening:
        if kind == SET:
            memory.set(at, mask)
        elif kind == CLEAR:
            memory.clear(at, mask)
        else:
            memory.write(at + 4, s.frame[4:])
            memory.write(at, s.frame[:4])
    s.phase, s.waited, s.copied = _ANSWER, 0, len(s.frame)
    return True


def _go(s: Sender, phase: Phase) -> None:
    s.phase, s.at, s.waited = phase, 0, 0


def _attempt(s: Sender, message: Envelope) -> None:
    s.phase, s.at, s.waited, s.copied, s.code = _REST, 0, 0, 4, _OK
    s.message, s.frame = message, encode(message)


def _failed(s: Sender, code: Code) -> Fault:
    _go(s, Phase.FAULT)
    s.code, s.frame = code, b""
    return Fault(s.open, code)


def _stand(s: Sender, link: Link, memory: Words | Watched) -> bool:
    return False


def _rest(s: Sender, link: Link, memory: Words | Watched) -> bool:
    """M0: each flag of the receiver is 0."""
    if memory.test(link.quiet[s.at], link.channel.mask):
        s.at = 0
        return False
    s.at += 1
    if s.at == len(link.quiet):
        _go(s, Phase.OPEN)
    return True


def act(line: tuple[str, int], link: Link, memory: Words | Watched) -> None:
    """Sets or clears the flag of one line of a script."""
    if line[0] == CLEAR:
        memory.clear(line[1], link.channel.mask)
    else:
        memory.set(line[1], link.channel.mask)


def _open(s: Sender, link: Link, memory: Words | Watched) -> bool:
    """M1 to M4."""
    line = link.opening[s.at]
    if line[0] == COPY:
        # The first word, the number of the transfer, comes last.
        if s.copied < len(s.frame):
            part = s.frame[s.copied : s.copied + link.chunk]
            memory.write(line[1] + s.copied, part)
            s.copied += len(part)
            return True
        memory.write(line[1], s.frame[:4])
    else:
        act(line, link, memory)
    s.at += 1
    if s.at == len(link.opening):
        s.phase, s.at = _ANSWER, 0
    return True


def _answer(s: Sender, link: Link, memory: Words | Watched) -> bool:
    """M5: ack or nack, and with it the receiver settled."""
    c = link.channel
    if s.at == 2:
        if memory.test(c.busy, c.mask):
            return False
    elif not memory.test(c.nack if s.at else c.ack, c.mask):
        s.at = 1 - s.at
        return s.at == 1
    elif link.profile.settled:
        s.at = 2
        return True
    s.phase, s.at = _STATUS, 0
    return True


def _status(s: Sender, link: Link, memory: Words | Watched) -> bool:
    """Reads what the answer says. An answer to another transfer is none to this one."""
    word, m = memory.load(link.channel.status), s.message
    code = CODES[word & 0xFF] if word & 0xFF < len(CODES) else Code.SILENT
    if code not in TRANSIENT and word >> 8 != token(m.seq, m.aid, m.cmd):
        code = Code.SILENT
    _go(s, _LAST if code is _OK and m.cmd == _RESET else _CLOSE)
    s.code = code
    return True


def _last(s: Sender, link: Link, memory: Words | Watched) -> bool:
    """Reads back what the receiver had taken before it was reset."""
    s.phase, s.last = _CLOSE, memory.load(link.channel.last)
    return True


def _close(s: Sender, link: Link, memory: Words | Watched) -> Outcome:
    script: Steps = link.closing if s.phase is _CLOSE else link.withdraw
    act(script[s.at], link, memory)
    s.at += 1
    return s.at < len(script) or _judged(s, link)


def _judged(s: Sender, link: Link) -> Outcome:
    """The flags of this side are 0: taken, once more, or given up."""
    resets, at = s.message.cmd == _RESET, s.phase
    s.at = 0
    if s.code is _OK:
        if at is _WITHDRAW:
            _attempt(s, s.message)
            return True
        opened, s.phase, s.open, s.frame = s.open, _IDLE, 0, b""
        if not resets:
            return Done(s.seq)
        s.seq = 0
        return Linked(s.last, opened != 0 and s.last == opened)
    if (resets or s.code in TRANSIENT) and s.message.attempt < link.retries:
        _attempt(s, replace(s.message, attempt=s.message.attempt + 1))
        return True
    return _failed(s, s.code)


_STEPS = (_stand, _rest, _open, _answer, _status, _last, _close, _close, _stand)
"""By the number of the phase."""
