"""One end of a slot in a process of its own: sends numbered data, checks those that it is given."""

from __future__ import annotations

import os
import random
import struct
import sys
import time
from collections.abc import Sequence
from multiprocessing.shared_memory import SharedMemory

from runtime.protocol.check import Algorithm, Parameter, Situation
from runtime.protocol.endpoint import Endpoint, Event
from runtime.protocol.envelope import Command
from runtime.protocol.memory import Watched, Words, shared_words
from runtime.protocol.profile import Link, Profile, channel
from runtime.protocol.receiver import Delivered, Phase
from runtime.protocol.sender import Done

AID = 0x02000001
_PIDS = range(1, 10)
_ADATA = struct.Struct("<18I")
SITUATION = Situation({AID: Algorithm(AID, tuple(Parameter(n, "u32") for n in _PIDS))},
                      frozenset((AID,)))


def payload(number: int, salt: int) -> bytes:
    """72 bytes that tell every transfer and direction from the others."""
    first = (number * 2654435761 + salt * 40503) & 0xFFFFFFFF
    values = [(first ^ pid * 0x9E3779B1) & 0xFFFFFFFF for pid in _PIDS]
    return _ADATA.pack(*(x for pair in zip(_PIDS, values) for x in pair))


def links(slave: int, master: bool, profile: Profile, slot: int = 0, **limits: int) -> tuple[Link, Link]:
    """Out and into, as one of the two sides has them."""
    there, back = (Link(channel(slave, to_slave, slot), profile, **limits) for to_slave in (True, False))
    return (there, back) if master else (back, there)


class Side:
    """Sends ``transfers`` payloads and counts what it is given: good, or other than expected."""

    def __init__(self, memory: Words | Watched, slave: int, master: bool, profile: Profile, transfers: int,
                 slot: int = 0) -> None:
        self.end = Endpoint(memory, *links(slave, master, profile, slot), SITUATION)
        self.salt, self.transfers = int(master), transfers
        self.done = self.good = self.bad = 0
        self._send()

    def _send(self) -> None:
        self.end.send(AID, Command.UPDATE, payload(self.done, self.salt))

    def poll(self) -> None:
        self._take(self.end.poll())

    def step_or_poll(self, dice: random.Random) -> None:
        """One step, or as many as go."""
        self._take(self.end.step() if dice.random() < 0.7 else self.end.poll())

    def _take(self, events: Sequence[Event]) -> None:
        for event in events:
            match event:
                case Delivered(envelope) if envelope.adata == payload(self.good, 1 - self.salt):
                    self.good += 1
                case Done():
                    self.done += 1
                    if self.done < self.transfers:
                        self._send()
                case _:
                    self.bad += 1

    def finished(self) -> bool:
        """All is sent and received and the flags of this side are 0; or something was wrong."""
        at_rest = self.end.ready and self.end.receiver.phase is Phase.WATCH
        return self.bad > 0 or self.done == self.good == self.transfers and at_rest


def serve(name: str, transfers: int, profile: Profile) -> None:
    """The slave's process. Exit status 1 when anything was wrong."""
    shared = SharedMemory(name=name)
    words = shared_words(shared.buf)
    side = Side(words, 1, False, profile, transfers)
    drive(side)
    words.close()
    shared.close()
    sys.exit(side.bad > 0)


def drive(side: Side, seconds: float = 300) -> None:
    """Polls until it is finished, and lets others run meanwhile. Raises TimeoutError."""
    end = time.monotonic() + seconds
    while not side.finished():
        for _ in range(20):
            side.poll()
        os.sched_yield()
        if time.monotonic() > end:
            raise TimeoutError(f"{side.done} of {side.transfers} sent, {side.good} received")
