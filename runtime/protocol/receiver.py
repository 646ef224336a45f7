"""The receiving side of P: a machine that is stepped, one access to shared memory or one local step a
call."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from operator import attrgetter

from ldc.records import record
from runtime.protocol.check import Code, Situation, check
from runtime.protocol.envelope import Command, Envelope
from runtime.protocol.memory import Watched, Words
from runtime.protocol.profile import CLEAR, Link, Steps
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


@record
class Delivered:
    """An envelope that was checked and is given for the first time: data for an algorithm, or a RESET.
    ``values``: of the parameters, in their order; of a STOP or a RESET none."""

    envelope: Envelope
    values: tuple[float, ...] = ()


@record
class Refused:
    """An envelope was refused."""

    code: Code


Event = Delivered | Refused


@dataclass(slots=True)
class Receiver:
    """``previous``: the last envelope that was taken; ``last``: of the transfers before the last RESET;
    ``code`` and ``token``: of the envelope that is being answered; ``frame``: what is read of the slot."""

    phase: Phase = Phase.WATCH
    at: int = 0
    waited: int = 0
    previous: Envelope | None = None
    last: int = 0
    code: Code = Code.OK
    token: int = 0
    frame: bytes = b""

    def state(self) -> tuple:
        """All members: ``Receiver(*state)`` is the same machine."""
        return _STATE(self)


_STATE = attrgetter(*Receiver.__dataclass_fields__)
_WATCH, _STATUS, _RELEASED, _SCRUB, _OK, _RESET = (
    Phase.WATCH, Phase.STATUS, Phase.RELEASED, Phase.SCRUB, Code.OK, Command.RESET)

Outcome = Event | bool
"""Of a step: what the owner is told; or True: it has gone on, False: it waits."""


def tick(r: Receiver, link: Link) -> None:
    """A period has passed: a receiver without work makes its flags 0 once in ``clear_periods``, so that one
    that was set by a disturbance does not stay."""
    if r.phase is _WATCH and not r.at:
        r.waited += 1
        if r.waited >= link.clear_periods:
            r.phase, r.waited = Phase.SCRUB, 0


def restart() -> Receiver:
    """A receiver that begins on memory that was in use: first its flags become 0. It knows no transfer, so
    the sender has to reset the link."""
    return Receiver(phase=Phase.SCRUB)


def step(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> Outcome:
    """The next step; ``situation`` is asked in the one that checks."""
    return _STEPS[r.phase](r, link, memory, situation)


def run(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> Event | None:
    """Steps until one waits, or a transfer is over: what its owner is told of it may change the situation
    of the next. Flags that are made 0 are no transfer: who was woken for one must not stop before it. As in
    the sender, the most frequent stretch is written out."""
    c = link.channel
    if r.phase is _SCRUB and not r.at:
        _acts(link.scrub, c.mask, memory)
        r.phase = _WATCH
    told, scrubs = None, r.phase is _SCRUB
    if r.phase is _WATCH and not r.at and link.chunk >= c.size:
        if not memory.test(c.running, c.mask) or memory.test(c.begin, c.mask) != link.profile.ready:
            return None
        told = _taken(r, link, memory, situation)
    if r.phase is _RELEASED and not r.at:
        r.at = memory.search(link.released, c.mask)
        if r.at == len(link.released):
            _acts(link.rest, c.mask, memory)
            r.phase, r.at = _WATCH, 0
        return None if told is True else told
    while (outcome := _STEPS[r.phase](r, link, memory, situation)) is not False:
        if outcome is not True:
            told = outcome
        elif r.phase is _WATCH and not r.at:
            if not scrubs:
                break
            scrubs = False
    return None if told is True else told


def _taken(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> Outcome:
    """S2 to S4 at once, of a RESET S2."""
    c = link.channel
    r.waited = 0
    memory.set(c.busy, c.mask)
    r.frame = memory.read(c.slot, c.size)
    told = _check(r, link, memory, situation)
    if r.phase is _STATUS:
        memory.store(c.status, r.token << 8 | r.code)
        memory.set(c.nack if r.code else c.ack, c.mask)
        _acts(link.answered, c.mask, memory)
        r.phase = _RELEASED
    return told


def _acts(script: Steps, mask: int, memory: Words | Watched) -> None:
    """``act`` of all lines of a script."""
    for kind, at in script:
        (memory.clear if kind == CLEAR else memory.set)(at, mask)


def _watch(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> bool:
    """S1: running, and the data complete."""
    c = link.channel
    if r.at == 0:
        if memory.test(c.running, c.mask):
            r.at = 1
            return True
        return False
    r.at = 0
    if memory.test(c.begin, c.mask) != link.profile.ready:
        return False
    r.phase, r.waited = Phase.BUSY, 0
    return True


def _busy(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> bool:
    memory.set(link.channel.busy, link.channel.mask)
    r.phase, r.frame = Phase.READ, b""
    return True


def _read(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> bool:
    have, c = len(r.frame), link.channel
    r.frame += memory.read(c.slot + have, min(link.chunk, c.size - have))
    if len(r.frame) == c.size:
        r.phase = Phase.CHECK
    return True


def _check(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> Outcome:
    """S2. What is taken is taken here: whatever happens to the answer, it is not given again."""
    verdict = check(r.frame, r.previous, situation)
    r.phase, r.code, r.token, r.frame = _STATUS, verdict.code, verdict.token, b""
    if verdict.code is not _OK:
        return Refused(verdict.code)
    if verdict.again:
        return True
    envelope = verdict.envelope
    if envelope.cmd == _RESET:
        r.last = r.previous.seq if r.previous is not None else 0
        r.phase = Phase.LAST
    r.previous = envelope
    return Delivered(envelope, verdict.values)


def _last(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> bool:
    memory.store(link.channel.last, r.last)
    r.phase = Phase.STATUS
    return True


def _status(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> bool:
    memory.store(link.channel.status, r.token << 8 | r.code)
    r.phase = Phase.ANSWER
    return True


def _answer(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> bool:
    """S3."""
    c = link.channel
    memory.set(c.nack if r.code else c.ack, c.mask)
    r.phase = Phase.ANSWERED if link.answered else Phase.RELEASED
    return True


def _script(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> bool:
    """S4, and the second half of S5."""
    if r.phase is Phase.ANSWERED:
        script, follows = link.answered, Phase.RELEASED
    else:
        script, follows = link.rest if r.phase is Phase.REST else link.scrub, _WATCH
    act(script[r.at], link, memory)
    r.at += 1
    if r.at == len(script):
        r.phase, r.at = follows, 0
    return True


def _released(r: Receiver, link: Link, memory: Words | Watched, situation: Situation) -> bool:
    """S5: the sender has seen the answer, or has given up."""
    if memory.test(link.released[r.at], link.channel.mask):
        return False
    r.at += 1
    if r.at == len(link.released):
        r.phase, r.at = Phase.REST, 0
    return True


_STEPS = (_watch, _busy, _read, _check, _last, _status, _answer, _script, _released, _script, _script)
"""By the number of the phase."""
