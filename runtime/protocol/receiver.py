"""The receiving side of P: a machine that is stepped, one access to shared memory or one local step a
call."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from runtime.protocol.check import Code, Situation, check
from runtime.protocol.envelope import Command, Envelope
from runtime.protocol.memory import Watched, Words
from runtime.protocol.profile import SCRUB, Link
from runtime.protocol.sender import act


class Phase(IntEnum):
    """WATCH waits for a transfer (S1), RELEASED for its end (S5)."""

    WATCH = 0
    BUSY = 1
    READ = 2
    CHECK = 3
    LAST = 4
    STATUS = 5
    ANSWER = 6
    ANSWERED = 7
    RELEASED = 8
    REST = 9
    SCRUB = 10


@dataclass(frozen=True, slots=True)
class Delivered:
    """An envelope that was checked and is given for the first time: data for an algorithm, or a RESET."""

    envelope: Envelope


@dataclass(frozen=True, slots=True)
class Refused:
    """An envelope was refused."""

    code: Code


Event = Delivered | Refused


class Receiver(NamedTuple):
    """A tuple, because a step is little more than making one.

    ``previous``: the last envelope that was taken; ``last``: of the transfers before the last RESET;
    ``code`` and ``token``: of the envelope that is being answered; ``frame``: what is read of the slot."""

    phase: Phase = Phase.WATCH
    at: int = 0
    waited: int = 0
    previous: Envelope | None = None
    last: int = 0
    code: Code = Code.OK
    token: int = 0
    frame: bytes = b""


def tick(r: Receiver, link: Link) -> Receiver:
    """A period has passed: a receiver without work makes its flags 0 once in ``clear_periods``, so that one
    that was set by a disturbance does not stay."""
    if r.phase is not Phase.WATCH or r.at:
        return r
    if r.waited + 1 < link.clear_periods:
        return r._replace(waited=r.waited + 1)
    return r._replace(phase=Phase.SCRUB, waited=0)


def restart() -> Receiver:
    """A receiver that begins on memory that was in use: first its flags become 0. It knows no transfer, so
    the sender has to reset the link."""
    return Receiver(phase=Phase.SCRUB)


def step(r: Receiver, link: Link, memory: Words | Watched, situation: Situation
         ) -> tuple[Receiver, Event | None]:
    """The next step. A wait that goes on gives the same state; ``situation`` is asked in the step that
    checks."""
    if r.phase is Phase.CHECK:
        return _check(r, situation)
    return _STEPS[r.phase](r, link, memory), None


def _watch(r: Receiver, link: Link, memory: Words | Watched) -> Receiver:
    """S1: running, and the data complete."""
    c = link.channel
    if r.at == 0:
        return r._replace(at=1) if memory.test(c.running, c.mask) else r
    if memory.test(c.begin, c.mask) != link.profile.ready:
        return r._replace(at=0)
    return r._replace(phase=Phase.BUSY, at=0, waited=0)


def _busy(r: Receiver, link: Link, memory: Words | Watched) -> Receiver:
    memory.set(link.channel.busy, link.channel.mask)
    return r._replace(phase=Phase.READ, frame=b"")


def _read(r: Receiver, link: Link, memory: Words | Watched) -> Receiver:
    have, c = len(r.frame), link.channel
    frame = r.frame + memory.read(c.slot + have, min(link.chunk, c.size - have))
    return r._replace(phase=Phase.CHECK if len(frame) == c.size else Phase.READ, frame=frame)


def _check(r: Receiver, situation: Situation) -> tuple[Receiver, Event | None]:
    """S2. What is taken is taken here: whatever happens to the answer, it is not given again."""
    verdict = check(r.frame, r.previous, situation)
    r = r._replace(phase=Phase.STATUS, code=verdict.code, token=verdict.token, frame=b"")
    if verdict.code is not Code.OK:
        return r, Refused(verdict.code)
    if verdict.again:
        return r, None
    envelope, last = verdict.envelope, r.last
    if envelope.cmd == Command.RESET:
        last = r.previous.seq if r.previous is not None else 0
        r = r._replace(phase=Phase.LAST)
    return r._replace(previous=envelope, last=last), Delivered(envelope)


def _last(r: Receiver, link: Link, memory: Words | Watched) -> Receiver:
    memory.store(link.channel.last, r.last)
    return r._replace(phase=Phase.STATUS)


def _status(r: Receiver, link: Link, memory: Words | Watched) -> Receiver:
    memory.store(link.channel.status, r.token << 8 | r.code)
    return r._replace(phase=Phase.ANSWER)


def _answer(r: Receiver, link: Link, memory: Words | Watched) -> Receiver:
    """S3."""
    c = link.channel
    memory.set(c.nack if r.code else c.ack, c.mask)
    return r._replace(phase=Phase.ANSWERED if link.profile.answered else Phase.RELEASED)


def _script(r: Receiver, link: Link, memory: Words | Watched) -> Receiver:
    """S4, and the second half of S5."""
    if r.phase is Phase.ANSWERED:
        script, follows = link.profile.answered, Phase.RELEASED
    else:
        script, follows = link.profile.rest if r.phase is Phase.REST else SCRUB, Phase.WATCH
    act(script, r.at, link, memory)
    if r.at + 1 < len(script):
        return r._replace(at=r.at + 1)
    return r._replace(phase=follows, at=0)


def _released(r: Receiver, link: Link, memory: Words | Watched) -> Receiver:
    """S5: the sender has seen the answer, or has given up."""
    flags = link.profile.released
    if memory.test(getattr(link.channel, flags[r.at]), link.channel.mask):
        return r
    if r.at + 1 < len(flags):
        return r._replace(at=r.at + 1)
    return r._replace(phase=Phase.REST, at=0)


_STEPS = {
    Phase.WATCH: _watch,
    Phase.BUSY: _busy,
    Phase.READ: _read,
    Phase.LAST: _last,
    Phase.STATUS: _status,
    Phase.ANSWER: _answer,
    Phase.ANSWERED: _script,
    Phase.RELEASED: _released,
    Phase.REST: _script,
    Phase.SCRUB: _script,
}
