"""P as its owners see it: envelopes, the nine codes, faults and resets, schedules, processes, the single
writer."""

from __future__ import annotations

import math
import multiprocessing
import random
import struct
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.shared_memory import SharedMemory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from protocol_pair import AID, SITUATION, Side, drive, links, payload, serve

from ldc.il.areas import PROCESSORS
from runtime.processors.invariants import i7
from runtime.protocol.check import Algorithm, Code, Parameter, Situation, adata_of, check
from runtime.protocol.endpoint import Endpoint
from runtime.protocol.envelope import HEAD, LAST_SEQ, Command, Envelope, crc16, decode, encode, head, intact
from runtime.protocol.literal import (
    CANONICAL, LITERAL_I, LITERAL_U, LITERAL_U_FIRST, NAMES_OF_I, atomic, left_over)
from runtime.protocol.memory import Access, ForeignAccess, allocate, bit, shared_size, shared_words, watch
from runtime.protocol.profile import I_STAR, U_STAR, Profile, channel
from runtime.protocol.receiver import Delivered, Refused, restart
from runtime.protocol.receiver import Phase as ReceiverPhase
from runtime.protocol.sender import Busy, Done, Fault, Linked, Phase, Sender

PROFILES = pytest.mark.parametrize("profile", [U_STAR, I_STAR], ids=lambda p: p.name)


def test_crc_of_the_published_vectors() -> None:
    assert crc16(b"123456789") == 0x4B37
    frame = bytes.fromhex("01000002180000000100000210000000010000002a000000e9a3")
    assert crc16(frame[:-2]) == 0xA3E9 and crc16(frame) == 0


@given(st.binary(max_size=40), st.integers(0, 40))
def test_crc_in_parts_is_that_of_the_whole_bit_by_bit(data: bytes, cut: int) -> None:
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ (0xA001 if crc & 1 else 0)
    assert crc16(data) == crc16(data[cut:], crc16(data[:cut])) == crc


def test_layout_of_an_envelope() -> None:
    frame = encode(Envelope(7, 0x02000001, Command.UPDATE, 3, b"abcdefgh"))
    assert frame[:16].hex() == "07000000" "01000002" "0200" "0300" "08000000"
    assert struct.unpack_from("<I", frame, 16)[0] == crc16(frame[:16] + b"abcdefgh")
    assert frame[HEAD:] == b"abcdefgh"


words = st.binary(max_size=18).map(lambda b: (b * 4)[: len(b) * 4])
u16, u32 = st.integers(0, 2**16 - 1), st.integers(0, 2**32 - 1)
envelopes = st.builds(Envelope, u32, u32, u16, u16, words)


@given(envelopes, st.integers(0, 100))
def test_envelopes_come_back(envelope: Envelope, rest: int) -> None:
    slot = encode(envelope) + bytes(rest)
    assert intact(head(slot), slot) and decode(head(slot), slot) == envelope


@settings(max_examples=300)
@given(envelopes, st.data())
def test_up_to_three_wrong_bits_are_found(envelope: Envelope, data) -> None:
    slot = bytearray(encode(envelope))
    for n in data.draw(st.sets(st.integers(0, len(slot) * 8 - 1), min_size=1, max_size=3)):
        slot[n // 8] ^= 1 << n % 8
    assert check(bytes(slot), None, Situation()).code in (Code.LEN, Code.CRC)


@settings(max_examples=300)
@given(st.binary(min_size=HEAD, max_size=128))
def test_a_slot_with_anything_in_it_is_judged(slot: bytes) -> None:
    assert check(slot, None, SITUATION).code != Code.OK


VALVE = Algorithm(5, (
    Parameter(1, "f32", 0.0, 100.0, rate=10.0), Parameter(2, "bool32"), Parameter(3, "u32")),
    stamp=3, max_age_ms=40)
HALL = Situation({5: VALVE}, frozenset((5,)), {(5, 1): 50.0}, now_ms=1030)
GOOD = adata_of({1: 55.0, 2: 1, 3: 1000}, VALVE)
LAST = Envelope(6, 5, Command.UPDATE, 0, adata_of({1: 50.0, 2: 1, 3: 990}, VALVE))


def slot(seq: int = 7, aid: int = 5, cmd: int = Command.UPDATE, adata: bytes = GOOD, size: int = 64) -> bytes:
    return encode(Envelope(seq, aid, cmd, 0, adata)).ljust(size, b"\0")


def with_word(at: int, value: int) -> bytes:
    found = bytearray(slot())
    found[4 * at : 4 * at + 4] = value.to_bytes(4, "little")
    return bytes(found)


def valve(values: dict) -> bytes:
    return slot(adata=adata_of({1: 55.0, 2: 1, 3: 1000} | values, VALVE))


@pytest.mark.parametrize(("code", "found"), [
    (Code.LEN, with_word(3, 48)), (Code.LEN, with_word(3, 22)), (Code.LEN, slot(adata=GOOD[:16])),
    (Code.LEN, slot(cmd=Command.STOP)),
    (Code.CRC, with_word(6, 1)), (Code.CRC, with_word(4, struct.unpack_from("<I", slot(), 16)[0] | 0x10000)),
    (Code.SEQ, slot(seq=8)), (Code.SEQ, slot(seq=5)), (Code.SEQ, slot(seq=6)),
    (Code.SEQ, slot(seq=7, cmd=Command.RESET, adata=b"")), (Code.SEQ, slot(seq=0)),
    (Code.AID, slot(aid=6)),
    (Code.PID, slot(adata=GOOD[:8] + GOOD[:8] + GOOD[16:])), (Code.PID, slot(adata=b"\t" + GOOD[1:])),
    (Code.TYPE, valve({1: math.nan})), (Code.TYPE, valve({1: math.inf})), (Code.TYPE, valve({2: 2})),
    (Code.RANGE, valve({1: -0.5})), (Code.RANGE, valve({1: 60.5})),
    (Code.STATE, slot(cmd=Command.START)), (Code.STATE, slot(cmd=9)),
    (Code.STALE, valve({3: 989})), (Code.STALE, valve({3: 1031})),
    (Code.OK, slot()), (Code.OK, valve({3: 990})), (Code.OK, slot(cmd=Command.STOP, adata=b"")),
    (Code.OK, slot(seq=0, cmd=Command.RESET, adata=b"")),
])
def test_the_nine_codes(code: Code, found: bytes) -> None:
    assert check(found, LAST, HALL).code == code


def test_the_first_failure_is_told() -> None:
    """A sound slot is damaged in the reverse order of the codes: each new damage hides those before it."""
    bad = {1: 200.0, 2: 1, 3: 0}
    told = [check(slot(adata=adata_of(bad | {1: 50.0}, VALVE)), LAST, HALL).code,
            check(slot(cmd=Command.START, adata=adata_of(bad | {1: 50.0}, VALVE)), LAST, HALL).code,
            check(slot(cmd=Command.START, adata=adata_of(bad, VALVE)), LAST, HALL).code]
    adata = adata_of(bad | {2: 2}, VALVE)
    told.append(check(slot(cmd=Command.START, adata=adata), LAST, HALL).code)
    told.append(check(slot(cmd=Command.START, adata=b"\t" + adata[1:]), LAST, HALL).code)
    told.append(check(slot(cmd=Command.START, aid=9, adata=b"\t" + adata[1:]), LAST, HALL).code)
    told.append(check(slot(seq=9, cmd=Command.START, aid=9, adata=b"\t" + adata[1:]), LAST, HALL).code)
    damaged = bytearray(slot(seq=9, cmd=Command.START, aid=9, adata=b"\t" + adata[1:]))
    damaged[-1 - 64 + HEAD + len(adata)] ^= 1
    told.append(check(bytes(damaged), LAST, HALL).code)
    damaged[12] = 255
    told.append(check(bytes(damaged), LAST, HALL).code)
    assert told == list(reversed(range(Code.LEN, Code.STALE + 1)))


def test_a_repetition_is_ok_whatever_has_changed_since() -> None:
    stopped = replace(HALL, running=frozenset(), now_ms=9999)
    verdict = check(encode(replace(LAST, attempt=2)).ljust(64, b"\0"), LAST, stopped)
    assert (verdict.code, verdict.again) == (Code.OK, True)


def test_numbers_of_transfers_begin_again_from_1() -> None:
    last = replace(LAST, seq=LAST_SEQ)
    assert check(slot(seq=1), last, HALL).code == Code.OK
    assert check(slot(seq=LAST_SEQ + 1), last, HALL).code == Code.SEQ


def test_values_of_an_envelope_come_in_the_order_of_the_parameters() -> None:
    mixed = b"".join(GOOD[at : at + 8] for at in (16, 0, 8))
    for adata in (GOOD, mixed):
        assert check(slot(adata=adata), LAST, HALL).values == (55.0, 1, 1000)


@pytest.mark.parametrize("made", [
    lambda: Algorithm(1, (Parameter(1), Parameter(1))), lambda: Algorithm(1, (Parameter(1),), stamp=1),
    lambda: channel(5, True), lambda: channel(1, True, 32), lambda: channel(1, True, 0, 18),
])
def test_what_cannot_be_is_refused(made: Callable) -> None:
    with pytest.raises(ValueError):
        made()


class Pair:
    """Master and slave 1 over watched memory; the test drives them."""

    def __init__(self, profile: Profile, situation: Situation = SITUATION) -> None:
        shared = bytearray(shared_size())
        self.seen: list[Access] = []
        self.words = shared_words(shared)
        master, slave = (watch(allocate(n, shared), self.seen.append).shared for n in ("master", "slave1"))
        self.master = Endpoint(master, *links(1, True, profile), situation)
        self.slave = Endpoint(slave, *links(1, False, profile), situation)
        self.events: list = []

    def run(self, steps: int = 200, ticks: int = 0, slave: bool = True) -> list:
        """What has happened meanwhile, in its order."""
        before = len(self.events)
        for n in range(steps):
            self.events += self.master.step()
            self.events += self.slave.step() if slave else ()
            if ticks and n % 20 == 19:
                self.events += [*self.master.tick(), *(self.slave.tick() if slave else ())]
        return self.events[before:]

    def quiet(self) -> bool:
        """All flags are 0."""
        return not any(self.words.read(base, 0x80).strip(b"\0") for base in (0x1FC000, 0x1FD000))


@PROFILES
def test_a_transfer_leaves_the_canonical_trace(profile: Profile) -> None:
    pair, actions = Pair(profile), []
    pair.master.send(AID, Command.UPDATE, payload(0, 1))
    assert [type(e) for e in pair.run()] == [Delivered, Done] and pair.quiet()
    names = {0: "b", 4: "f", 8: "a", 12: "s", 16: "na", 24: "c"}
    for access in pair.seen:
        data = {"store": "send", "load": "check"}.get(access.kind)
        if access.area == "SMD" and (not actions or actions[-1] != f"{data} smd"):
            actions.append(f"{data} smd")
        elif access.area in ("MPF", "SPF") and access.kind in ("set", "clear"):
            letters = "ms" if access.area == "MPF" else "sm"
            actions.append(f"{access.kind} {letters}{names[access.address & 31]}")
    actions = [a for a in actions if a != "clear smna"]
    assert actions == [f"{a.kind} {a.name}" for a in CANONICAL[profile.name]]
    assert {a.processor for a in pair.seen if a.area == "SPF" and a.kind != "load"} == {"slave1"}


def test_sequences_as_printed() -> None:
    assert left_over(LITERAL_U) == left_over(LITERAL_I) == frozenset()
    assert left_over(LITERAL_U_FIRST) == {"sma", "msf"}
    assert [str(a) for a in LITERAL_U][-3:] == ["S clear sms", "S clear sma", "M clear msf"]
    assert sorted(map(str, LITERAL_U)) == sorted(map(str, CANONICAL["U*"]))
    renamed = sorted(f"{a.by} {a.kind} {NAMES_OF_I[a.name]}" for a in LITERAL_I)
    assert renamed == sorted(map(str, CANONICAL["I*"]))
    checked = next(flags for action, flags in atomic(LITERAL_U) if action.kind == "check")
    assert checked == {"msf", "sms"}


@PROFILES
def test_busy_and_too_large(profile: Profile) -> None:
    pair = Pair(profile)
    with pytest.raises(ValueError, match="slot of 128"):
        pair.master.send(AID, Command.UPDATE, bytes(112))
    pair.master.send(AID, Command.UPDATE, payload(0, 1))
    with pytest.raises(Busy):
        pair.master.send(AID, Command.UPDATE, payload(1, 1))


@PROFILES
def test_a_slave_that_does_not_answer(profile: Profile) -> None:
    pair = Pair(profile)
    pair.master.send(AID, Command.UPDATE, payload(0, 1))
    assert pair.run(1000, ticks=1, slave=False) == [Fault(1, Code.SILENT)] and pair.quiet()
    attempts = {struct.unpack_from("<H", a.value, 6)[0] for a in pair.seen
                if a.area == "SMD" and a.kind == "store" and len(a.value) > 4}
    assert len(attempts) == 3
    with pytest.raises(Busy):
        pair.master.send(AID, Command.UPDATE, payload(0, 1))
    pair.master.reset()
    assert pair.run(1000, ticks=1, slave=False) == [Fault(1, Code.SILENT)]
    pair.master.reset()
    linked = [e for e in pair.run(400, ticks=1) if isinstance(e, Linked)]
    assert linked == [Linked(0, False)] and pair.quiet()
    pair.master.send(AID, Command.UPDATE, payload(0, 1))
    assert [type(e) for e in pair.run()] == [Delivered, Done]


@PROFILES
def test_a_reset_reads_back_what_the_slave_had_taken(profile: Profile) -> None:
    pair = Pair(profile)
    for n in range(3):
        pair.master.send(AID, Command.UPDATE, payload(n, 1))
        pair.run()
    pair.master.send(AID, Command.UPDATE, payload(3, 1))
    while not any(isinstance(e, Delivered) and e.envelope.seq == 4 for e in pair.events):
        pair.run(1)
    assert pair.run(2000, ticks=1, slave=False) == [Fault(4, Code.STUCK)]
    pair.master.reset()
    events = pair.run()
    assert events[-1] == Linked(4, True) and [e.envelope.cmd for e in events[:-1]] == [Command.RESET]
    assert pair.master.sender.seq == 0 and pair.quiet()


@PROFILES
def test_bad_data_are_not_sent_again(profile: Profile) -> None:
    pair = Pair(profile, HALL)
    pair.master.send(5, Command.UPDATE, adata_of({1: 101.0, 2: 0, 3: 1000}, VALVE))
    assert pair.run() == [Refused(Code.RANGE), Fault(1, Code.RANGE)] and pair.quiet()


@PROFILES
def test_damage_on_the_way_is_repaired(profile: Profile) -> None:
    pair = Pair(profile)
    pair.master.send(AID, Command.UPDATE, payload(0, 1))
    while pair.master.sender.phase is not Phase.ANSWER:
        pair.events += pair.master.step()
    pair.words.store(pair.master.out.channel.slot + 24, 0xDEAD)
    assert [type(e) for e in pair.run(400)] == [Refused, Delivered, Done] and pair.quiet()


@PROFILES
def test_a_slave_that_starts_anew_is_linked_anew(profile: Profile) -> None:
    pair = Pair(profile)
    for n in range(2):
        pair.master.send(AID, Command.UPDATE, payload(n, 1))
        pair.run()
    pair.slave.receiver = restart()
    pair.master.send(AID, Command.UPDATE, payload(2, 1))
    assert pair.run(600) == [Refused(Code.SEQ)] * 3 + [Fault(3, Code.SEQ)]
    pair.master.reset()
    assert pair.run()[-1] == Linked(0, False)
    pair.master.send(AID, Command.UPDATE, payload(2, 1))
    assert pair.run()[-1] == Done(1)


@PROFILES
def test_a_master_that_starts_anew_resets_the_link(profile: Profile) -> None:
    """In the midst of a transfer: what the old one had raised is cleared, the new one is heard."""
    for steps in range(60):
        pair = Pair(profile)
        pair.master.send(AID, Command.UPDATE, payload(0, 1))
        pair.run(steps)
        pair.master.sender = Sender()
        pair.master.reset()
        pair.run(400, ticks=1)
        pair.master.send(AID, Command.UPDATE, payload(1, 1))
        assert pair.run(400, ticks=1)[-1] == Done(1) and pair.quiet(), steps


@PROFILES
@settings(max_examples=40, deadline=None)
@given(n=st.integers(1, 4), slots=st.sets(st.integers(0, 31), min_size=1, max_size=3),
       begin=st.lists(st.integers(0, 23), max_size=300), seed=st.integers(0, 2**32))
def test_any_schedule_of_master_and_slaves(profile: Profile, n: int, slots: set[int], begin: list[int],
                                           seed: int) -> None:
    """Both directions at once, several slots, 1 to 4 slaves: all is delivered, each word has one writer (I7),
    and all flags are 0 at the end (I6)."""
    shared, seen = bytearray(shared_size()), []
    memory = {p: watch(allocate(p, shared), seen.append).shared for p in PROCESSORS}
    sides = [Side(memory[name], k, name == "master", profile, 3, slot)
             for k in range(1, n + 1) for slot in sorted(slots) for name in ("master", f"slave{k}")]
    for at in begin:
        sides[at % len(sides)].poll()
    chance = random.Random(seed)
    while not all(side.finished() for side in sides):
        side = chance.choice(sides)
        for _ in range(chance.choice((1, 1, 1, 7))):
            side.step_or_poll(chance)
    assert [(s.done, s.good, s.bad) for s in sides] == [(3, 3, 0)] * len(sides)
    assert not any(shared[at] for base in (0x8000, 0x9000) for at in range(base, base + 0x80))
    assert i7(seen, 1) == []


def test_two_processes_over_shared_memory() -> None:
    """10^4 transfers of 72 bytes, half of them each way and at the same time, every one compared."""
    each = 5_000
    shared = SharedMemory(create=True, size=shared_size())
    try:
        spawn = multiprocessing.get_context("spawn")
        slave = spawn.Process(target=serve, args=(shared.name, each, U_STAR), daemon=True)
        slave.start()
        words = shared_words(shared.buf)
        side = Side(words, 1, True, U_STAR, each)
        drive(side)
        slave.join(60)
        flags = [words.load(base + at) for base in (0x1FC000, 0x1FD000) for at in range(0, 0x20, 4)]
        words.close()
        assert (side.done, side.good, side.bad, slave.exitcode) == (each, each, 0, 0) and not any(flags)
    finally:
        slave.kill()
        shared.close()
        shared.unlink()


def test_a_processor_writes_only_what_is_its_own() -> None:
    shared = bytearray(shared_size())
    master, slave = (watch(allocate(name, shared)) for name in ("master", "slave2"))
    master.bits.set(*bit(0x400))
    master.bits.set(*bit(0x14A))
    master.data.store(0x600, 1)
    master.shared.store(0x1F6000, 1)
    assert slave.shared.load(0x1F6000) == 1
    slave.data.store(4 * 9, 1)
    for touch in (
        lambda: slave.shared.store(0x1F6000, 2),
        lambda: slave.shared.set(0x1FC020, 1),
        lambda: slave.shared.clear(0x1FD000, 1),  # of slave 1
        lambda: slave.shared.load(0x1F4000),
        lambda: slave.shared.write(0x1F7FFC, bytes(8)),  # over the end of its window
        lambda: master.shared.set(0x1FD020, 1),
        lambda: master.shared.store(0x1FC100, 1),
        lambda: master.data.store(0x1D000, 1),
        lambda: slave.bits.test(*bit(0x400)),
    ):
        with pytest.raises(ForeignAccess):
            touch()
    assert master.bits.test(*bit(0x400)) and not master.bits.test(*bit(0x401))


def test_a_word_outside_of_the_memory_is_no_word() -> None:
    words = shared_words(bytearray(shared_size()))
    for address in (0, 0x1F3FFC, 0x1F4002, 0x1FE000):
        with pytest.raises(IndexError):
            words.load(address)


def test_two_writers_of_a_word_are_found() -> None:
    accesses = [Access("master", "set", "SPF", 0x1FD000, 1), Access("slave1", "clear", "SPF", 0x1FD000, 1)]
    assert len(i7(accesses, 1)) == 1


@PROFILES
def test_a_transfer_that_begins_while_flags_are_made_zero_is_served_by_the_same_poll(profile: Profile) -> None:
    memory = shared_words(bytearray(shared_size()))
    master, slave = (Endpoint(memory, *links(1, end, profile), SITUATION) for end in (True, False))
    for _ in range(slave.into.clear_periods):
        slave.tick()
    assert slave.receiver.phase is ReceiverPhase.SCRUB
    master.send(AID, Command.UPDATE, payload(1, 1))
    master.poll()
    assert any(isinstance(event, Delivered) for event in slave.poll())
