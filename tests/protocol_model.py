"""A sender and a receiver of the runtime over a memory that is a value: every interleaving, with
disturbances."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

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
    link: Link


def check(profile: Profile, start: Limits, transfers: int = 3, chunk: int = SIZE, retries: int = 2) -> Result:
    """Explores everything: the owner of the sender submits item after item, and after a fault resets the link
    and submits the open one again if it was not delivered."""
    link = Link(CHANNEL, profile, retries=retries, ack_periods=1, clear_periods=1, chunk=chunk)

    def heard(state: State, event: object) -> State:
        """What the owner of the sender does with what it is told."""
        match event:
            case sending.Done() if state.item not in state.taken:
                return state._replace(wrong="done, and not taken")
            case sending.Linked(delivered=delivered):
                if delivered != (state.item in state.taken):
                    return state._replace(wrong="read back falsely")
                return state if delivered else state._replace(item=state.item - 1)
        return state

    def given(state: State, event: object) -> State:
        if not isinstance(event, receiving.Delivered) or event.envelope.cmd == Command.RESET:
            return state
        (value,) = event.values
        taken = (*state.taken, value)
        wrong = "" if taken == tuple(range(1, value + 1)) else f"took {taken}"
        return state._replace(taken=taken, wrong=wrong)

    def moves(state: State) -> Iterator[State]:
        if state.wrong:
            return
        limits, sender, memory = state.limits, sending.Sender(*state.sender), Memory(state.words)
        if not sender.ready:
            event = sending.step(sender, link, memory)
            yield heard(state._replace(sender=sender.state(), words=memory.value()), event)
        elif state.item < transfers:
            sending.submit(sender, link, AID, Command.UPDATE, adata_of({1: state.item + 1}, ALGORITHM))
            yield state._replace(sender=sender.state(), item=state.item + 1)
        receiver, memory = receiving.Receiver(*state.receiver), Memory(state.words)
        event = receiving.step(receiver, link, memory, SITUATION)
        yield given(state._replace(receiver=receiver.state(), words=memory.value()), event)
        if limits.late:
            sender = sending.Sender(*state.sender)
            event = sending.tick(sender, link)
            yield heard(state._replace(sender=sender.state()), event)
        if limits.flip < start.flip and any(state.words[3:6]):
            receiver = receiving.Receiver(*state.receiver)
            receiving.tick(receiver, link)
            yield state._replace(receiver=receiver.state())
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
        if limits.reset and sending.Sender(*state.sender).phase is sending.Phase.FAULT:
            sender = sending.Sender(*state.sender)
            sending.reset(sender)
            less = limits._replace(reset=limits.reset - 1)
            yield state._replace(sender=sender.state(), limits=less)

    begin = State(sending.Sender().state(), receiving.Receiver().state(), EMPTY, start)
    graph = explore(begin, moves)
    finished = [s for s in ends(graph) if not s.wrong]
    faulted = {s: sending.Sender(*s.sender).phase is sending.Phase.FAULT for s in finished}
    return Result(
        states=len(graph),
        stuck=sum(not fault and (not sending.Sender(*s.sender).ready or s.item < transfers)
                  for s, fault in faulted.items()),
        wrong=frozenset(s.wrong for s in graph.states if s.wrong),
        ends=frozenset((s.taken, fault) for s, fault in faulted.items()),
        raised=sum(any(s.words[:6]) for s in finished),
        halves=tuple(dict.fromkeys(
            (machine, s.words) for s in graph.states for machine in (s.sender, s.receiver))),
        link=link,
    )
