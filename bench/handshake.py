"""Transfers between two processes over shared memory, against bare copies to and fro over the same memory.

A transfer is 72 bytes of data with envelope, CRC, check of nine parameters and the flags of U*; the yardstick
is a ping-pong of as many bytes with one word as flag, written in the same language. Both wait by looking
again and again, and let others run in between. Batches alternate, so that the ratio does not depend on how
busy the machine is.
"""

from __future__ import annotations

import multiprocessing
import os
import statistics
import struct
import time
from collections.abc import Callable
from multiprocessing.shared_memory import SharedMemory

import _tables

from runtime.protocol.check import Algorithm, Parameter, Situation
from runtime.protocol.endpoint import Endpoint
from runtime.protocol.envelope import Command
from runtime.protocol.memory import Words, shared_size, shared_words
from runtime.protocol.profile import I_STAR, U_STAR, Link, Profile, channel
from runtime.protocol.receiver import Delivered
from runtime.protocol.sender import Done

TRANSFERS, BATCHES, LOOKS = 2000, 7, 20
AID = 1
SITUATION = Situation({AID: Algorithm(AID, tuple(Parameter(n) for n in range(1, 10)))}, frozenset((AID,)))
DATA = b"".join(struct.pack("<If", n, n / 2) for n in range(1, 10))


def endpoint(words: Words, master: bool, profile: Profile) -> Endpoint:
    there, back = (Link(channel(1, to_slave), profile) for to_slave in (True, False))
    return Endpoint(words, *((there, back) if master else (back, there)), SITUATION)


def transfers(words: Words, master: bool, profile: Profile, both: bool) -> int:
    """Until the last one has come and the flags are 0; the number that this side has sent."""
    end = endpoint(words, master, profile)
    sends = master or both
    todo, due = TRANSFERS if sends else 0, TRANSFERS if both or not master else 0
    if sends:
        end.send(AID, Command.UPDATE, DATA)
    while todo or due or not end.ready or end.receiver.phase:
        for _ in range(LOOKS):
            for event in end.poll():
                match event:
                    case Done():
                        todo -= 1
                        if todo:
                            end.send(AID, Command.UPDATE, DATA)
                    case Delivered():
                        due -= 1
                    case _:
                        raise SystemExit(f"a transfer failed: {event}")
        os.sched_yield()
    return TRANSFERS * (1 + both)


def copies(words: Words, master: bool) -> int:
    """The bytes of an envelope there, and a word back: what any transfer costs at least."""
    there, back, slot = words.first + 0x8000, words.first + 0x9000, words.first
    frame = bytes(20) + DATA
    for n in range(1, TRANSFERS + 1):
        if master:
            words.write(slot, frame)
            words.store(there, n)
        wait(words, back if master else there, n)
        if not master:
            words.read(slot, len(frame))
            words.store(back, n)
    return TRANSFERS


def wait(words: Words, address: int, value: int) -> None:
    while True:
        for _ in range(LOOKS):
            if words.load(address) == value:
                return
        os.sched_yield()


WORK: dict[str, Callable[[Words, bool], int]] = {
    "copies": copies,
    "U*, one way": lambda words, master: transfers(words, master, U_STAR, False),
    "I*, one way": lambda words, master: transfers(words, master, I_STAR, False),
    "U*, both ways": lambda words, master: transfers(words, master, U_STAR, True),
}


def slave(name: str, turns: multiprocessing.Queue) -> None:
    """Takes part in what it is told until it is told nothing."""
    shared = SharedMemory(name=name)
    words = shared_words(shared.buf)
    while (work := turns.get()) is not None:
        WORK[work](words, False)
    words.close()
    shared.close()


def main() -> None:
    context = multiprocessing.get_context("spawn")
    turns = context.Queue()
    shared = SharedMemory(create=True, size=shared_size())
    partner = context.Process(target=slave, args=(shared.name, turns), daemon=True)
    partner.start()
    words = shared_words(shared.buf)
    rates: dict[str, list[float]] = {name: [] for name in WORK}
    for batch in range(BATCHES + 1):
        for name, work in WORK.items():
            shared.buf[:] = bytes(len(shared.buf))
            turns.put(name)
            start = time.perf_counter()
            count = work(words, True)
            if batch:  # the first batch warms up
                rates[name].append(count / (time.perf_counter() - start))
    turns.put(None)
    partner.join()
    words.close()
    shared.close()
    shared.unlink()
    rows = []
    for name, values in rates.items():
        ratio = statistics.median(c / v for c, v in zip(rates["copies"], values, strict=True))
        rows.append([name, _tables.spread([v / 1000 for v in values], 2), f"{ratio:.1f}"])
    _tables.show(f"{len(DATA)} bytes of data between two processes over shared memory",
                 ["", "1000 transfers a second, median (min .. max)", "copies / this"], rows,
                 f"ratio of paired batches, median of {BATCHES}; {TRANSFERS} transfers a batch")


if __name__ == "__main__":
    main()
