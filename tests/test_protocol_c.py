"""P with one end in C and the other in Python, over one memory and between processes (docs/protocol.md)."""

from __future__ import annotations

import math
import mmap
import random
import struct
import subprocess
import sys
from pathlib import Path

import cffi
import native
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from protocol_in_c import ROOM, compiled, declarations
from protocol_pair import AID, SITUATION, Side, drive, links, payload

from runtime.protocol.check import Algorithm, Code, Parameter, Situation, adata_of, check
from runtime.protocol.endpoint import Endpoint
from runtime.protocol.envelope import Command, Envelope, encode
from runtime.protocol.memory import shared_size, shared_words
from runtime.protocol.profile import U_STAR
from runtime.protocol.receiver import Delivered, restart
from runtime.protocol.sender import Done, Fault, Linked

pytestmark = native.needs_gcc
ROOT = Path(__file__).resolve().parents[1]
TYPES = ("f32", "i32", "u32", "bool32")


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    sources = (ROOM / "p_handshake.c", ROOM / "p_parameters.c", ROOT / "bench" / "p_pair.c")
    return compiled(tmp_path_factory.mktemp("p"), *sources)


@pytest.fixture(scope="module")
def c(library: Path):
    """The library with its ``ffi``."""
    ffi = cffi.FFI()
    ffi.cdef(declarations())
    return ffi, ffi.dlopen(str(library))


class InC:
    """The slave's or the master's end in C: one direction out, one in, over the same bytes as Python's."""

    def __init__(self, c, shared: bytearray, master: bool, slot: int = 0, patience: int = 0) -> None:
        self.ffi, self.lib = ffi, lib = c
        at = {"smd": 0, "msd": 0x1000, "mpf": 0x8000, "spf": 0x9000, "mpa": 0x8400, "spa": 0x9400}
        self.buffer = ffi.from_buffer("uint8_t[]", shared, require_writable=True)
        self.areas = ffi.new("p_areas *", {
            n: ffi.cast("volatile uint32_t *", self.buffer + offset) for n, offset in at.items()})
        self.out, self.into = ffi.new("p_channel *"), ffi.new("p_channel *")
        (lib.p_to_slave if master else lib.p_to_master)(self.out, self.areas, slot, 128)
        (lib.p_to_master if master else lib.p_to_slave)(self.into, self.areas, slot, 128)
        self.frame, self.taken = ffi.new("uint8_t[128]"), ffi.new("uint8_t[128]")
        self.parameters = ffi.new("p_parameter[]", [
            {"pid": n, "type": TYPES.index("u32"), "min": -math.inf, "max": math.inf, "rate": math.inf}
            for n in range(1, 10)])
        self.algorithm = ffi.new("p_algorithm *", {
            "aid": AID, "count": 9, "parameters": self.parameters, "running": 1})
        self.receiver = ffi.new("p_receiver *", {
            "channel": self.into, "algorithms": self.algorithm, "count": 1, "judge": lib.p_judge,
            "frame": self.frame, "data": self.taken})
        self.sender = ffi.new("p_sender *", {"channel": self.out, "patience": patience})

    def send(self, adata: bytes, elapsed: int = 0) -> int:
        return self.lib.p_send(self.sender, AID, Command.UPDATE, adata, len(adata), elapsed)

    def receive(self) -> bytes | None:
        """The data of an envelope that was not there before."""
        if self.lib.p_receive(self.receiver) != self.lib.P_DONE:
            return None
        return bytes(self.ffi.buffer(self.taken, self.receiver.envelope.len))


@pytest.mark.parametrize("damage", [0, 0.02], ids=["", "damaged"])
@pytest.mark.parametrize("master", [True, False], ids=["C is the master", "C is the slave"])
def test_c_and_python_over_one_memory_in_any_order(c, master: bool, damage: float) -> None:
    """Both directions at once, slot 31; a word of a slot is changed now and then."""
    dice, count, shared = random.Random(11), 300, bytearray(shared_size())
    words = shared_words(shared)
    other = InC(c, shared, master, 31)
    side = Side(words, 1, not master, U_STAR, count, 31)
    sent = good = bad = 0
    while min(side.done, side.good, sent) < count or side.end.receiver.phase:
        move = dice.randrange(3)
        if move == 0 and sent < count:
            before = other.sender.step
            result = other.send(payload(sent, int(master)))
            assert result in (other.lib.P_BUSY, other.lib.P_DONE)
            sent += result == other.lib.P_DONE
            if before == 4 and dice.random() < damage:
                address = side.end.into.channel.slot + 4 * dice.choice((1, 2, 4, 7, 20))
                words.store(address, words.load(address) ^ 1 << dice.randrange(32))
        elif move == 1:
            data = other.receive()
            bad += data not in (None, payload(good, 1 - int(master)))
            good += data is not None
        else:
            side.step_or_poll(dice)
    for _ in range(8):
        good += other.receive() is not None
    assert (side.done, side.good, good, bad) == (count, count, count, 0)
    assert not any(words.load(base + at) for base in (0x1FC000, 0x1FD000) for at in range(0, 32, 4))


def test_a_fault_is_told_and_a_reset_reads_back_what_was_taken(c) -> None:
    """C sends, Python is the slave and goes silent in the middle."""
    shared = bytearray(shared_size())
    master, words = InC(c, shared, True, patience=20), shared_words(shared)
    slave = Endpoint(words, *links(1, False, U_STAR), SITUATION)
    lib, taken = master.lib, []

    def sends(number: int) -> int:
        while (result := master.send(payload(number, 1), 1)) == lib.P_BUSY:
            taken.extend(e.envelope.seq for e in slave.step() if isinstance(e, Delivered))
            if number == 3 and 4 in taken:
                break
        return result

    def resets() -> int:
        while (result := lib.p_reset(master.sender, 1)) == lib.P_BUSY:
            slave.step()
        return result

    assert [sends(n) for n in range(4)] == [lib.P_DONE] * 3 + [lib.P_BUSY]
    while (result := master.send(payload(3, 1), 1)) == lib.P_BUSY:
        pass
    assert result == lib.P_STUCK == master.send(payload(3, 1), 1)
    assert resets() == lib.P_DONE and (master.sender.last, master.sender.delivered) == (4, 1)
    slave.poll()
    slave.receiver = restart()
    assert sends(4) == lib.P_DONE, "after a reset numbers begin anew"
    slave.receiver = restart()
    assert sends(5) == lib.P_SEQ
    assert resets() == lib.P_DONE and (master.sender.last, master.sender.delivered) == (0, 0)
    assert sends(5) == lib.P_DONE


def test_python_resets_a_slave_in_c(c) -> None:
    shared = bytearray(shared_size())
    slave, master = InC(c, shared, False), Endpoint(shared_words(shared), *links(1, True, U_STAR), SITUATION)

    def run(polled: bool = True) -> list:
        found = []
        for n in range(400):
            found += master.poll()
            if polled:
                slave.receive()
            found += master.tick() if n % 20 == 19 else ()
        return found

    master.send(AID, Command.UPDATE, payload(0, 1))
    assert run() == [Done(1)]
    master.send(AID, Command.UPDATE, payload(1, 1))
    assert run(False) == [Fault(2, Code.SILENT)]
    master.reset()
    assert run() == [Linked(1, False)]
    assert slave.receiver.envelope.cmd == Command.RESET
    master.send(AID, Command.UPDATE, payload(1, 1))
    assert run() == [Done(1)]


limits = st.sampled_from([-math.inf, -5.0, 0.0, 3.5, 100.0, math.inf])
parameter = st.builds(lambda t, low, high, rate: (t, min(low, high), max(low, high), rate),
                      st.sampled_from(TYPES), limits, limits, st.sampled_from([math.inf, 1.0, 20.0]))
raw = st.one_of(st.sampled_from([0, 1, 2, 0x7F800000, 0x7FC00000, 0x41200000, 0xC0A00000, 0x80000000]),
                st.integers(0, 2**32 - 1))


@settings(max_examples=400, deadline=None)
@given(st.lists(parameter, min_size=1, max_size=4), st.lists(raw, min_size=4, max_size=4),
       st.permutations(range(4)), st.integers(0, 5), st.integers(0, 3), st.sampled_from([1, 1, 1, 2]),
       st.sampled_from([0, 4, 1]), st.booleans(), st.booleans(), st.data())
def test_c_and_python_find_the_same_code(c, described, values, order, cmd, state, seq, extra, known, stamped,
                                         data) -> None:
    """Any envelope, most of them nearly right, judged by both."""
    ffi, lib = c
    parameters = tuple(Parameter(7 + n, *p) for n, p in enumerate(described))
    stamp = next((p.pid for p in parameters if p.type == "u32"), None) if stamped else None
    algorithm = Algorithm(AID, parameters, stamp, 50)
    pids = [p.pid for p in parameters]
    order = [n for n in order if n < len(pids)]
    if data.draw(st.integers(0, 9)) == 0:
        pids[0] = data.draw(st.sampled_from([8, 9, 99]))
    pairs = b"".join(struct.pack("<II", pids[n], values[n]) for n in order)
    adata = pairs + bytes(extra if extra == 4 else 0)
    adata = b"" if cmd in (3, 4) and data.draw(st.booleans()) else adata
    aid = AID + (not data.draw(st.integers(0, 9)))
    slot = bytearray(encode(Envelope(seq, aid, cmd, 0, adata)).ljust(128, b"\0"))
    if extra == 1:
        slot[data.draw(st.integers(0, len(adata) + 19))] ^= 1 << data.draw(st.integers(0, 7))
    before = {(AID, p.pid): 10.0 for p in parameters} if known else {}
    running, ended = frozenset((AID,) * (state & 1)), frozenset((AID,) * (state >> 1))
    found = check(bytes(slot), None, Situation({AID: algorithm}, running, before, 1000, ended))

    shared = bytearray(shared_size())
    shared[:128] = slot
    side = InC(c, shared, False)
    table = ffi.new("p_parameter[]", [
        {"pid": p.pid, "type": TYPES.index(p.type), "min": p.min, "max": p.max, "rate": p.rate}
        for p in parameters])
    last = ffi.new("double[]", [10.0] * len(parameters))
    side.algorithm[0] = {
        "aid": AID, "count": len(parameters), "parameters": table, "values": last if known else ffi.NULL,
        "running": state & 1, "ended": state >> 1, "stamp": stamp or 0, "max_age_ms": 50}
    side.receiver.now_ms = 1000
    shared_words(shared).set(0x1FC004, 1)
    lib.p_receive(side.receiver)
    lib.p_receive(side.receiver)
    assert (side.receiver.code, side.receiver.token) == (found.code, found.token)


PROCESS = """
import cffi, mmap, sys
with open(sys.argv[2], "r+b") as file:
    shared = mmap.mmap(file.fileno(), 0)
ffi = cffi.FFI()
ffi.cdef("uint32_t p_sends(uint8_t *, uint32_t, uint32_t, uint32_t *);"
         "uint32_t p_receives(uint8_t *, uint32_t, uint32_t);")
lib = ffi.dlopen(sys.argv[1])
buffer = ffi.from_buffer(shared)
count = int(sys.argv[3])
bad = lib.p_receives(buffer, 1, count) + lib.p_sends(buffer, 0, count, ffi.NULL)
sys.exit(bad > 0)
"""


def test_c_in_another_process(library: Path, tmp_path: Path) -> None:
    """2,000 transfers there, then 2,000 back, every one compared."""
    count, file = 2000, tmp_path / "shared"
    file.write_bytes(bytes(shared_size()))
    with file.open("r+b") as opened, mmap.mmap(opened.fileno(), 0) as shared:
        slave = subprocess.Popen([sys.executable, "-c", PROCESS, str(library), str(file), str(count)])
        try:
            words = shared_words(shared)
            side = Side(words, 1, True, U_STAR, count)
            drive(side, 60)
            words.close()
            assert (side.done, side.good, side.bad, slave.wait(30)) == (count, count, 0, 0)
        finally:
            slave.kill()
            slave.wait()


def test_adata_is_what_c_reads(c) -> None:
    ffi, lib = c
    parameters = tuple(Parameter(n, t) for n, t in enumerate(TYPES, 1))
    values = {1: -2.5, 2: -7, 3: 4_000_000_000, 4: 1}
    adata = adata_of(values, Algorithm(1, parameters))
    assert [lib.p_value(adata[8 * n + 4 : 8 * n + 8], n) for n in range(4)] == list(values.values())
