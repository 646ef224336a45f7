"""A sender and a receiver over a memory that is a value: every interleaving, with disturbances.

What they are is given: here are those of the runtime, in ``protocol_in_c`` those of firmware. Each is a few
functions of its state, which is a value too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from explore import ends, explore

from runtime.protocol import receiver as receiving
from runtime.protocol import sender as sending
from runtime.protocol.check import Algorithm, Parameter, Situation, adata_of
from runtime.protocol.envelope import Command
from runtime.protocol.profile import Channel, Link, Profile

FLAGS = ("begin", "running", "order", "busy", "ack", "nack")
AID = 0x02000001
ALGORITHM = Algorithm(AID, (Parameter(1, "i32"),))
SITUATION = Situation({AID: ALGORITHM}, frozenset((AID,)))
SIZE = 28


class Memory:
    """The words of one channel, made of and given as a tuple."""

    def __init__(self, words: tuple) -> None:
        self.words, self.slot = list(words[:-1]), bytearray(words[-1])

    def value(self) -> tuple:
        return (*self.words, bytes(self.slot))

    def load(self, at: int) -> int:
        return self.words[at]

    def store(self, at: int, value: int) -> None:
        self.words[at] = value

    def test(self, at: int, mask: int) -> bool:
        return self.words[at] & mask != 0

    def search(self, places: tuple[int, ...], mask: int) -> int:
        return next((n for n, at in enumerate(places) if self.test(at, mask)), len(places))

    def set(self, at: int, mask: int) -> None:
        self.words[at] |= mask

    def clear(self, at: int, mask: int) -> None:
        self.words[at] &= ~mask

    def read(self, at: int, size: int) -> bytes:
        return bytes(self.slot[at - SLOT : at - SLOT + size])

    def write(self, at: int, data: bytes) -> None:
        self.slot[at - SLOT : at - SLOT + len(data)] = data


SLOT = 100
CHANNEL = Channel(*range(8), slot=SLOT, size=SIZE, mask=1)
EMPTY = (*(0,) * 8, bytes(SIZE))


class Limits(NamedTuple):
    """How often each disturbance may come in one history. ``late``: any wait may be taken for too long;
    ``corrupt``: a word of the slot; ``lose``: an answer that is there; ``flip``: any flag; ``reset``: by the
    owner."""

    late: bool = False
    corrupt: int = 0
    lose: int = 0
    flip: int = 0
    reset: int = 0


class State(NamedTuple):
    """``sender`` and ``receiver``: all that these machines know, from which they are made again."""

    sender: tuple
    receiver: tuple
    words: tuple
    limits: Limits
    item: int = 0
    taken: tuple[int, ...] = ()
    wrong: str = ""


DONE = "done"
"""What an owner of a sender is told of a transfer; of a reset it is told whether the open one was taken."""


class Sends(Protocol):
    """A sender. Where it has something to tell its owner, a step gives DONE, or of a reset a bool."""

    start: tuple

    def ready(self, state: tuple) -> bool: ...

    def failed(self, state: tuple) -> bool: ...

    def submit(self, state: tuple, value: int) -> tuple: ...

    def reset(self, state: tuple) -> tuple: ...

    def step(self, state: tuple, words: tuple) -> tuple[tuple, tuple, str | bool | None]: ...

    def late(self, state: tuple, words: tuple) -> tuple[tuple, tuple, str | bool | None] | None:
        """A wait is taken for too long; None: it does not wait."""


class Receives(Protocol):
    """A receiver. A step gives the value of a transfer to its owner."""

    start: tuple

    def step(self, state: tuple, words: tuple) -> tuple[tuple, tuple, int | None]: ...

    def holds(self, state: tuple) -> int | None:
        """The value of a transfer that is taken, and will be given to the owner."""

    def scrub(self, state: tuple) -> tuple:
        """A receiver without work is to make its flags 0."""


def linked(profile: Profile, chunk: int = SIZE, retries: int = 2) -> Link:
    return Link(CHANNEL, profile, retries=retries, ack_periods=1, clear_periods=1, chunk=chunk)


class PythonSends:
    start = sending.Sender().state()

    def __init__(self, link: Link) -> None:
        self.link = link

    def ready(self, state: tuple) -> bool:
        return sending.Sender(*state).ready

    def failed(self, state: tuple) -> bool:
        return sending.Sender(*state).phase is sending.Phase.FAULT

    def submit(self, state: tuple, value: int) -> tuple:
        sender = sending.Sender(*state)
        sending.submit(sender, self.link, AID, Command.UPDATE, adata_of({1: value}, ALGORITHM))
        return sender.state()

    def reset(self, state: tuple) -> tuple:
        sender = sending.Sender(*state)
        sending.reset(sender)
        return sender.state()

    def step(self, state: tuple, words: tuple) -> tuple[tuple, tuple, str | bool | None]:
        sender, memory = sending.Sender(*state), Memory(words)
        event = sending.step(sender, self.link, memory)
        return sender.state(), memory.value(), _told(event)

    def late(self, state: tuple, words: tuple) -> tuple[tuple, tuple, str | bool | None]:
        sender = sending.Sender(*state)
        event = sending.tick(sender, self.link)
        return sender.state(), words, _told(event)


def _told(event: object) -> str | bool | None:
    match event:
        case sending.Done():
            return DONE
        case sending.Linked(delivered=delivered):
            return delivered
    return None


class PythonReceives:
    start = receiving.Receiver().state()

    def __init__(self, link: Link) -> None:
        self.link = link

    def step(self, state: tuple, words: tuple) -> tuple[tuple, tuple, int | None]:
        receiver, memory = receiving.Receiver(*state), Memory(words)
        event = receiving.step(receiver, self.link, memory, SITUATION)
        taken = isinstance(event, receiving.Delivered) and event.envelope.cmd != Command.RESET
        return receiver.state(), memory.value(), event.values[0] if taken else None

    def holds(self, state: tuple) -> None:
        """It is given in the step that takes it."""

    def scrub(self, state: tuple) -> tuple:
        receiver = receiving.Receiver(*state)
        receiving.tick(receiver, self.link)
        return receiver.state()


@dataclass(frozen=True, slots=True)
class Result:
    """``wrong``: what a receiver or the owner of a sender was told falsely; ``stuck``: ends without a result;
    ``ends``: what the receiver had been given at the others, and whether the sender stands in a fault;
    ``raised``: ends at which a flag is not 0; ``halves``: each machine with each memory that it met."""

    states: int
    wrong: frozenset[str]
    stuck: int
    ends: frozenset[tuple[tuple[int, ...], bool]]
    raised: int
    halves: tuple[tuple[tuple, tuple], ...]


def check(profile: Profile, start: Limits, transfers: int = 3, chunk: int = SIZE, retries: int = 2) -> Result:
    """Explores the machines of the runtime."""
    link = linked(profile, chunk, retries)
    return explored(PythonSends(link), PythonReceives(link), start, transfers)


def explored(sends: Sends, receives: Receives, start: Limits, transfers: int) -> Result:
    """Explores everything: the owner of the sender submits item after item, and after a fault resets the link
    and submits the open one again if it was not delivered."""

    def heard(state: State, sender: tuple, words: tuple, told: str | bool | None) -> State:
        """What the owner of the sender does with what it is told."""
        state = state._replace(sender=sender, words=words)
        if told is None:
            return state
        taken = state.item in (*state.taken, receives.holds(state.receiver))
        if told == DONE:
            return state if taken else state._replace(wrong="done, and not taken")
        if told != taken:
            return state._replace(wrong="read back falsely")
        return state if told else state._replace(item=state.item - 1)

    def given(state: State, receiver: tuple, words: tuple, value: int | None) -> State:
        state = state._replace(receiver=receiver, words=words)
        if value is None:
            return state
        taken = (*state.taken, value)
        wrong = "" if taken == tuple(range(1, value + 1)) else f"took {taken}"
        return state._replace(taken=taken, wrong=wrong)

    def moves(state: State) -> Iterator[State]:
        if state.wrong:
            return
        limits = state.limits
        if not sends.ready(state.sender):
            yield heard(state, *sends.step(state.sender, state.words))
        elif state.item < transfers:
            yield state._replace(sender=sends.submit(state.sender, state.item + 1), item=state.item + 1)
        yield given(state, *receives.step(state.receiver, state.words))
        if limits.late and (late := sends.late(state.sender, state.words)) is not None:
            yield heard(state, *late)
        if limits.flip < start.flip and any(state.words[3:6]):
            yield state._replace(receiver=receives.scrub(state.receiver))
        if limits.corrupt:
            less = limits._replace(corrupt=limits.corrupt - 1)
            for at in range(0, SIZE, 4):
                slot = bytearray(state.words[-1])
                slot[at] ^= 1
                yield state._replace(words=(*state.words[:-1], bytes(slot)), limits=less)
        if limits.lose and (state.words[4] or state.words[5]):
            words = (*state.words[:4], 0, 0, *state.words[6:])
            yield state._replace(words=words, limits=limits._replace(lose=limits.lose - 1))
        if limits.flip:
            for at in range(len(FLAGS)):
                words = (*state.words[:at], 1 - state.words[at], *state.words[at + 1 :])
                yield state._replace(words=words, limits=limits._replace(flip=limits.flip - 1))
        if limits.reset and sends.failed(state.sender):
            less = limits._replace(reset=limits.reset - 1)
            yield state._replace(sender=sends.reset(state.sender), limits=less)

    graph = explore(State(sends.start, receives.start, EMPTY, start), moves)
    finished = [s for s in ends(graph) if not s.wrong]
    faulted = {s: sends.failed(s.sender) for s in finished}
    return Result(
        states=len(graph),
        stuck=sum(not fault and (not sends.ready(s.sender) or s.item < transfers)
                  for s, fault in faulted.items()),
        wrong=frozenset(s.wrong for s in graph.states if s.wrong),
        ends=frozenset((s.taken, fault) for s, fault in faulted.items()),
        raised=sum(any(s.words[:6]) for s in finished),
        halves=tuple(dict.fromkeys(
            (machine, s.words) for s in graph.states for machine in (s.sender, s.receiver))),
    )
