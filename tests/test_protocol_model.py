"""P over all interleavings: what is printed fails as SPEC 2.3 says, what is executed does not fail."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from handshake_scripts import DEADLOCK, DUPLICATE, EARLY, LOST, run
from protocol_model import AID, ALGORITHM, FLAGS, SITUATION, Limits, Memory, check, linked

from explore import ends, explore
from ldc.il.areas import shared_range
from runtime.protocol import check as checking
from runtime.protocol import receiver as receiving
from runtime.protocol import sender as sending
from runtime.protocol.check import adata_of
from runtime.protocol.envelope import Command
from runtime.protocol.memory import shared_size, shared_words
from runtime.protocol.profile import I_STAR, U_STAR, Channel, Link, channel

U_MASTER = "set msb\n set msf\n send\n clear msb\n"
U_SLAVE = "set sms if msf=1 msb=0\n check\n set sma\n clear sms\n"
I_SLAVE = "set sf if ms=1 mf=1\n check\n set sa\n clear sf if ms=0 mf=0 mc=0\n clear sa"
I_TAIL = "set mc if sa=1\n clear ms\n clear mf\n clear mc"


@pytest.mark.parametrize(("master", "slave", "failures"), [
    pytest.param(U_MASTER + "clear msf if sma=1", U_SLAVE + "clear sma", {LOST, DUPLICATE}, id="U printed"),
    pytest.param(U_MASTER + "clear sma if sma=1 sms=0\n clear msf", U_SLAVE + "wait if msf=0", {DEADLOCK},
                 id="U, the master clears sma"),
    pytest.param(U_MASTER + "clear sma if sma=1 sms=0\n clear msf", U_SLAVE, {DUPLICATE},
                 id="U, the master clears sma, no wait"),
    pytest.param("set msf if sma=0 sms=0\n set msb\n send\n clear msb\n clear msf if sma=1 sms=0",
                 U_SLAVE + "clear sma if msf=0", {DUPLICATE, EARLY}, id="U*, msf before msb"),
    pytest.param("set ms\n set mf\n send\n" + I_TAIL, I_SLAVE, {EARLY, LOST, DUPLICATE}, id="I printed"),
])
def test_printed_sequences_fail(master: str, slave: str, failures: set[str]) -> None:
    assert run(master, slave).failures == failures


@pytest.mark.parametrize(("master", "slave", "states"), [
    pytest.param("set msb if sma=0 sms=0\n set msf\n send\n clear msb\n clear msf if sma=1 sms=0",
                 U_SLAVE + "clear sma if msf=0", 31, id="U*"),
    pytest.param("set ms if sa=0 sf=0\n send\n set mf\n" + I_TAIL, I_SLAVE, 37, id="I*"),
    pytest.param("set ms if sa=0 sf=0\n send\n set mf\n" + I_TAIL + " if sf=0 sa=0",
                 I_SLAVE.replace("mc=0", "mc=1"), 37, id="I*, mc held"),
])
def test_repaired_sequences_do_not_fail(master: str, slave: str, states: int) -> None:
    outcome = run(master, slave)
    assert (outcome.failures, outcome.states) == (set(), states)


DELIVERED = {((1, 2, 3), False)}
OR_FAULT = DELIVERED | {((1, 2, 3)[:n], True) for n in range(4)}
TWO_OR_FAULT = {((1, 2), False)} | {((1, 2)[:n], True) for n in range(3)}


@pytest.mark.parametrize(("limits", "more", "found", "states"), [
    pytest.param(Limits(), {"chunk": 4}, DELIVERED, (212, 204), id="word by word"),
    pytest.param(Limits(late=True), {"chunk": 4}, OR_FAULT, (17945, 18841), id="late, word by word"),
    pytest.param(Limits(late=True, lose=1), {"retries": 1}, OR_FAULT, None, id="an answer lost"),
    pytest.param(Limits(late=True, corrupt=1), {"retries": 1, "transfers": 2}, TWO_OR_FAULT, None,
                 id="a word corrupted"),
    pytest.param(Limits(late=True, reset=2), {"retries": 0}, OR_FAULT, (14432, 16644), id="two resets"),
    pytest.param(Limits(late=True, corrupt=1, reset=1), {"retries": 0, "transfers": 2}, TWO_OR_FAULT, None,
                 id="a word corrupted, a reset"),
])
@pytest.mark.parametrize("profile", [U_STAR, I_STAR], ids=lambda p: p.name)
def test_every_interleaving_delivers_once_or_ends_in_a_fault(profile, limits, more, found, states) -> None:
    """Nothing is taken twice or out of order, nothing is told to be done that is not taken, what a reset
    reads back is true, no path ends elsewhere, and at every end all flags are 0 (I6)."""
    result = check(profile, limits, **more)
    assert (result.wrong, result.stuck, result.raised) == (frozenset(), 0, 0)
    assert result.ends == found
    print(f"{profile.name}: {result.states} states")
    if states is not None:
        assert result.states == states[profile is I_STAR]


@pytest.mark.parametrize("profile", [U_STAR, I_STAR], ids=lambda p: p.name)
@pytest.mark.parametrize("more", [{"retries": 1}, {"retries": 0, "reset": 1}], ids=["", "a reset"])
def test_a_flag_that_is_disturbed_at_any_moment_loses_and_repeats_nothing(profile, more) -> None:
    """A flag may stay 1 where it was disturbed at rest; it does no harm, and a reset clears it."""
    limits = Limits(late=True, flip=1, reset=more.get("reset", 0))
    result = check(profile, limits, transfers=2, retries=more["retries"])
    assert (result.wrong, result.stuck) == (frozenset(), 0)
    assert result.ends <= TWO_OR_FAULT


def test_the_exploration_finds_what_is_wrong(monkeypatch) -> None:
    """Without the memory of what was taken, a retry is taken twice."""
    monkeypatch.setattr(receiving, "check", lambda slot, previous, situation: checking.check(
        slot, None, situation))
    assert "took (1, 1)" in check(U_STAR, Limits(late=True), transfers=1).wrong


@pytest.mark.parametrize("profile", [U_STAR, I_STAR], ids=lambda p: p.name)
@pytest.mark.parametrize("others", [(1, False, 0), (1, True, 31), (2, True, 0)],
                         ids=["back", "slot 31", "slave 2"])
def test_two_links_at_once_in_every_interleaving(profile, others) -> None:
    """Links do not touch each other: together they come to the product of their states, and to one end. Words
    of flags are shared by the slots of a direction."""
    first, second = (Link(channel(*which), profile) for which in ((1, True, 0), others))
    buffer = bytearray(shared_size())
    words = shared_words(buffer)
    begin = shared_range()[0]
    used = sorted({at for link in (first, second) for at in places(link.channel)})
    slots = first.channel.slot, second.channel.slot
    parts = [(at - begin, at - begin + (28 if at in slots else 4)) for at in used]
    data = adata_of({1: 7}, ALGORITHM)

    def moves(state: tuple) -> Iterator[tuple]:
        *machines, memory, taken = state
        for at in range(4):
            for (low, high), value in zip(parts, memory, strict=True):
                buffer[low:high] = value
            link = (first, second)[at // 2]
            if at % 2 == 0:
                machine = sending.Sender(*machines[at])
                event = sending.step(machine, link, words)
            else:
                machine = receiving.Receiver(*machines[at])
                event = receiving.step(machine, link, words, SITUATION)
            after = taken + isinstance(event, receiving.Delivered)
            new = tuple(bytes(buffer[low:high]) for low, high in parts)
            yield (*machines[:at], machine.state(), *machines[at + 1 :], new, after)

    def begun(both: bool) -> tuple:
        machines = []
        for link in (first, second):
            sender = sending.Sender()
            if both or link is first:
                sending.submit(sender, link, AID, Command.UPDATE, data)
            machines.append(sender.state())
            machines.append(receiving.Receiver().state())
        return (*machines, tuple(bytes(high - low) for low, high in parts), 0)

    both = explore(begun(True), moves)
    assert len(both) == len(explore(begun(False), moves)) ** 2
    (end,) = ends(both)
    assert all(sending.Sender(*end[n]).ready for n in (0, 2)) and end[-1] == 2
    flags = {getattr(link.channel, flag) for link in (first, second) for flag in FLAGS}
    assert not any(value.strip(b"\0") for at, value in zip(used, end[-2], strict=True) if at in flags)


class Seen(Memory):
    """Notes what is done to it, in order."""

    def __init__(self, words: tuple) -> None:
        super().__init__(words)
        self.log: list[tuple] = []

    def __getattribute__(self, name: str):
        found = super().__getattribute__(name)
        if name not in ("load", "store", "test", "set", "clear", "read", "write"):
            return found
        return lambda *given: self.log.append((name, *given)) or found(*given)


@pytest.mark.parametrize("profile", [U_STAR, I_STAR], ids=lambda p: p.name)
@pytest.mark.parametrize(("limits", "chunk"), [
    pytest.param(Limits(late=True, reset=1), 28, id="resets"),
    pytest.param(Limits(late=True), 4, id="word by word"),
    pytest.param(Limits(flip=1), 28, id="a flag disturbed"), pytest.param(Limits(corrupt=1), 28, id="a word"),
])
def test_to_run_is_to_step_until_one_waits(profile, limits, chunk) -> None:
    """In every state that the exploration finds: the same accesses, the same state after, the same event."""
    result, link = check(profile, limits, transfers=2, chunk=chunk, retries=1), linked(profile, chunk, 1)
    for state, words in result.halves:
        sends = len(state) == len(sending.Sender().state())
        made = sending.Sender if sends else receiving.Receiver
        module, more = (sending, ()) if sends else (receiving, (SITUATION,))
        once, again = Seen(words), Seen(words)
        at_once, in_steps = made(*state), made(*state)
        event = module.run(at_once, link, once, *more)
        told, scrubs = None, in_steps.phase == receiving.Phase.SCRUB and not sends
        while (outcome := module.step(in_steps, link, again, *more)) is not False:
            told = outcome if outcome is not True else told
            rests = in_steps.phase == receiving.Phase.WATCH and not in_steps.at
            if told if sends else rests and not scrubs:
                break
            scrubs = scrubs and not rests
        assert (at_once.state(), once.value(), once.log, event) == (
            in_steps.state(), again.value(), again.log, told)


def places(channel: Channel) -> list[int]:
    """The addresses of the words of a channel and of its slot."""
    return [getattr(channel, name) for name in (*FLAGS, "status", "last", "slot")]
