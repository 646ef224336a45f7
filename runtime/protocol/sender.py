"""The sending side of P: a machine that is stepped, one access to shared memory or one local step a call.

States are values and steps give new ones, so that tests can try every interleaving with the receiver. Time
comes from outside too: the owner calls ``tick`` once a period.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import IntEnum
from typing import NamedTuple

from runtime.protocol.check import TRANSIENT, Code
from runtime.protocol.envelope import HEAD, Command, Envelope, encode, successor, token
from runtime.protocol.memory import Watched, Words
from runtime.protocol.profile import CLEAR, COPY, WITHDRAW, Link, Script


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


@dataclass(frozen=True, slots=True)
class Done:
    """The receiver has taken transfer ``seq``."""

    seq: int


@dataclass(frozen=True, slots=True)
class Fault:
    """The link stands until a reset. Whether the receiver has taken transfer ``seq`` is not known."""

    seq: int
    code: Code


@dataclass(frozen=True, slots=True)
class Linked:
    """A reset is done. ``last``: the transfer that the receiver took last before, 0 for none. ``delivered``:
    the transfer that the fault left open is that one."""

    last: int
    delivered: bool


Event = Done | Fault | Linked


class Sender(NamedTuple):
    """A tuple, because a step is little more than making one.

    ``at``: where in the phase; ``waited``: periods in it; ``copied``: bytes of the frame
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
    message: Envelope = Envelope(0, 0, 0, 0)
    frame: bytes = b""

    @property
    def ready(self) -> bool:
        """A transfer can be submitted."""
        return self.phase is Phase.IDLE


class Busy(Exception):
    """A transfer is still open, or the link stands."""


def submit(s: Sender, link: Link, aid: int, cmd: int, adata: bytes = b"") -> Sender:
    """Begins a transfer. Raises Busy; ValueError when the data do not fit the slot."""
    if s.phase is not Phase.IDLE:
        raise Busy(f"transfer {s.seq} is in phase {s.phase.name}")
    if len(adata) > link.channel.size - HEAD or len(adata) % 4:
        raise ValueError(f"{len(adata)} bytes of data for a slot of {link.channel.size}")
    seq = successor(s.seq)
    return _attempt(s, Envelope(seq, aid, cmd, 0, adata))._replace(seq=seq, open=seq)


def reset(s: Sender) -> Sender:
    """Gives up what is open and makes the link new, from any phase; ``Linked`` tells the end.

    A reset that has failed is the same again, so that a receiver that knows it still tells what it had
    before.
    """
    failed = s.message.cmd == Command.RESET and not s.ready
    ordinal = s.resets if failed else s.resets + 1 & 0xFFFFFFFF
    message = Envelope(0, ordinal, Command.RESET, 0)
    return s._replace(phase=Phase.WITHDRAW, at=0, waited=0, resets=ordinal, message=message, frame=b"",
                      code=Code.OK)


def tick(s: Sender, link: Link) -> tuple[Sender, Event | None]:
    """A period has passed."""
    if s.phase is Phase.ANSWER:
        if s.waited + 1 < link.ack_periods:
            return s._replace(waited=s.waited + 1), None
        return s._replace(phase=Phase.WITHDRAW, at=0, waited=0, code=Code.SILENT), None
    if s.phase is Phase.REST:
        if s.waited + 1 < link.clear_periods:
            return s._replace(waited=s.waited + 1), None
        return _failed(s, Code.STUCK)
    return s, None


def step(s: Sender, link: Link, memory: Words | Watched) -> tuple[Sender, Event | None]:
    """The next step. A wait that goes on gives the same state."""
    return _STEPS[s.phase](s, link, memory)


def _attempt(s: Sender, message: Envelope) -> Sender:
    return s._replace(phase=Phase.REST, at=0, waited=0, copied=4, code=Code.OK, message=message,
                      frame=encode(message))


def _failed(s: Sender, code: Code) -> tuple[Sender, Event]:
    return s._replace(phase=Phase.FAULT, at=0, waited=0, code=code, frame=b""), Fault(s.open, code)


def _stand(s: Sender, link: Link, memory: Words | Watched) -> tuple[Sender, None]:
    return s, None


_QUIET = ("ack", "nack", "busy")


def _rest(s: Sender, link: Link, memory: Words | Watched) -> tuple[Sender, None]:
    """M0: each flag of the receiver is 0."""
    c = link.channel
    if memory.test(getattr(c, _QUIET[s.at]), c.mask):
        return s if s.at == 0 else s._replace(at=0), None
    if s.at < len(_QUIET) - 1:
        return s._replace(at=s.at + 1), None
    return s._replace(phase=Phase.OPEN, at=0, waited=0), None


def act(script: Script, at: int, link: Link, memory: Words | Watched) -> None:
    """Sets or clears the flag of one line of a script."""
    action, flag = script[at]
    change = memory.clear if action == CLEAR else memory.set
    change(getattr(link.channel, flag), link.channel.mask)


def _open(s: Sender, link: Link, memory: Words | Watched) -> tuple[Sender, None]:
    """M1 to M4."""
    script = link.profile.opening
    if script[s.at][0] == COPY:
        # The first word, the number of the transfer, comes last.
        if s.copied < len(s.frame):
            part = s.frame[s.copied : s.copied + link.chunk]
            memory.write(link.channel.slot + s.copied, part)
            return s._replace(copied=s.copied + len(part)), None
        memory.write(link.channel.slot, s.frame[:4])
    else:
        act(script, s.at, link, memory)
    if s.at + 1 < len(script):
        return s._replace(at=s.at + 1), None
    return s._replace(phase=Phase.ANSWER, at=0), None


def _answer(s: Sender, link: Link, memory: Words | Watched) -> tuple[Sender, None]:
    """M5: ack or nack, and with it the receiver settled."""
    c = link.channel
    if s.at == 2:
        return (s, None) if memory.test(c.busy, c.mask) else (s._replace(phase=Phase.STATUS, at=0), None)
    if not memory.test(c.nack if s.at else c.ack, c.mask):
        return s._replace(at=1 - s.at), None
    if link.profile.settled:
        return s._replace(at=2), None
    return s._replace(phase=Phase.STATUS, at=0), None


def _status(s: Sender, link: Link, memory: Words | Watched) -> tuple[Sender, None]:
    """Reads what the answer says. An answer to another transfer is none to this one."""
    word = memory.load(link.channel.status)
    code = Code(word & 0xFF) if word & 0xFF <= Code.STALE else Code.SILENT
    message = s.message
    if code not in TRANSIENT and word >> 8 != token(message.seq, message.aid, message.cmd):
        code = Code.SILENT
    follows = Phase.LAST if code is Code.OK and message.cmd == Command.RESET else Phase.CLOSE
    return s._replace(phase=follows, at=0, waited=0, code=code), None


def _last(s: Sender, link: Link, memory: Words | Watched) -> tuple[Sender, None]:
    """Reads back what the receiver had taken before it was reset."""
    return s._replace(phase=Phase.CLOSE, last=memory.load(link.channel.last)), None


def _close(s: Sender, link: Link, memory: Words | Watched) -> tuple[Sender, Event | None]:
    script = link.profile.closing if s.phase is Phase.CLOSE else WITHDRAW
    act(script, s.at, link, memory)
    if s.at + 1 < len(script):
        return s._replace(at=s.at + 1), None
    return _judged(s, link)


def _judged(s: Sender, link: Link) -> tuple[Sender, Event | None]:
    """The flags of this side are 0: taken, once more, or given up."""
    resets = s.message.cmd == Command.RESET
    if s.phase is Phase.WITHDRAW and s.code is Code.OK:
        return _attempt(s, s.message), None
    if s.code is Code.OK:
        rest = s._replace(phase=Phase.IDLE, at=0, open=0, frame=b"")
        if resets:
            return rest._replace(seq=0), Linked(s.last, s.open != 0 and s.last == s.open)
        return rest, Done(s.seq)
    if (resets or s.code in TRANSIENT) and s.message.attempt < link.retries:
        return _attempt(s, replace(s.message, attempt=s.message.attempt + 1)), None
    return _failed(s, s.code)


_STEPS = {
    Phase.IDLE: _stand,
    Phase.REST: _rest,
    Phase.OPEN: _open,
    Phase.ANSWER: _answer,
    Phase.STATUS: _status,
    Phase.LAST: _last,
    Phase.CLOSE: _close,
    Phase.WITHDRAW: _close,
    Phase.FAULT: _stand,
}
