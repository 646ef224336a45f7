"""Transfers between two processes over shared memory, in C and in Python, against the least that any transfer
costs: as many bytes copied there and a word back, in C over the same memory.

A transfer is 72 bytes of data with envelope, CRC, check of nine parameters and the flags of U*; every one
that arrives is compared. Both sides wait by looking again and again, and let others run in between. Batches
alternate, so that ratios do not depend on how busy the machine is. In C the latency of a transfer is the time
from its begin until the sender knows that it was taken.
"""

from __future__ import annotations

import multiprocessing
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import cache, partial
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path

import _tables
import cffi

from ldc.components import toolchain

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from protocol_pair import Side, drive  # noqa: E402

from runtime.protocol.memory import shared_size, shared_words  # noqa: E402
from runtime.protocol.profile import I_STAR, U_STAR, Profile  # noqa: E402

BATCHES, IN_C, IN_PYTHON = 5, 200_000, 4000
ROOM = ROOT / "ldc" / "backends" / "firmware" / "runtime"
_DECLARED = """
uint32_t p_sends(uint8_t *shared, uint32_t salt, uint32_t count, uint32_t *ns);
uint32_t p_receives(uint8_t *shared, uint32_t salt, uint32_t count);
void p_copies(uint8_t *shared, uint32_t first, uint32_t count, uint32_t *ns);
"""


def built(target: Path) -> Path:
    """The loops of both sides in C (p_pair.c)."""
    names = ROOM / "p_handshake.c", ROOM / "p_parameters.c", ROOT / "bench" / "p_pair.c"
    flags = "-std=c11 -O2 -fPIC -shared".split()
    subprocess.run([toolchain.find(toolchain.GCC), *flags, "-I", str(ROOM), "-o", str(target),
                    *map(str, names)], check=True)
    return target


@cache
def _library(path: str):
    ffi = cffi.FFI()
    ffi.cdef(_DECLARED)
    return ffi, ffi.dlopen(path)


def copies(path: str, shared: SharedMemory, master: bool) -> list[int]:
    ffi, lib = _library(path)
    times = ffi.new("uint32_t[]", IN_C) if master else ffi.NULL
    with ffi.from_buffer("uint8_t[]", shared.buf, require_writable=True) as buffer:
        lib.p_copies(buffer, master, IN_C, times)
    return list(times) if master else []


def in_c(path: str, shared: SharedMemory, master: bool) -> list[int]:
    ffi, lib = _library(path)
    times = ffi.new("uint32_t[]", IN_C) if master else ffi.NULL
    with ffi.from_buffer("uint8_t[]", shared.buf, require_writable=True) as buffer:
        bad = lib.p_sends(buffer, 1, IN_C, times) if master else lib.p_receives(buffer, 1, IN_C)
    if bad:
        raise SystemExit(f"{bad} of {IN_C} transfers were wrong")
    return list(times) if master else []


def in_python(profile: Profile, path: str, shared: SharedMemory, master: bool) -> list[int]:
    """Half of the transfers each way, at the same time."""
    words = shared_words(shared.buf)
    side = Side(words, 1, master, profile, IN_PYTHON // 2)
    drive(side)
    words.close()
    if side.bad:
        raise SystemExit(f"{side.bad} of {IN_PYTHON} transfers were wrong")
    return []


WORK: dict[str, tuple[Callable[[str, SharedMemory, bool], list[int]], int]] = {
    "copies, C": (copies, IN_C),
    "U*, C": (in_c, IN_C),
    "U*, Python, both ways": (partial(in_python, U_STAR), IN_PYTHON),
    "I*, Python, both ways": (partial(in_python, I_STAR), IN_PYTHON),
}


def slave(name: str, path: str, turns: multiprocessing.Queue, ready: multiprocessing.Queue) -> None:
    """Takes part in what it is told until it is told nothing."""
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    shared = SharedMemory(name=name)
    while (work := turns.get()) is not None:
        ready.put(work)
        WORK[work][0](path, shared, False)
        ready.put(work)
    shared.close()


def main() -> None:
    context = multiprocessing.get_context("spawn")
    turns, ready = context.Queue(), context.Queue()
    shared = SharedMemory(create=True, size=shared_size())
    rates: dict[str, list[float]] = {name: [] for name in WORK}
    latencies: dict[str, list[int]] = {name: [] for name in WORK}
    with tempfile.TemporaryDirectory() as folder:
        path = str(built(Path(folder) / "p.so"))
        partner = context.Process(target=slave, args=(shared.name, path, turns, ready), daemon=True)
        partner.start()
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
        for batch in range(BATCHES + 1):
            for name, (work, count) in WORK.items():
                shared.buf[:] = bytes(len(shared.buf))
                turns.put(name)
                ready.get()
                start = time.perf_counter()
                times = work(path, shared, True)
                rate = count / (time.perf_counter() - start)
                ready.get()
                if batch:  # the first batch warms up
                    rates[name].append(rate)
                    latencies[name] += times
        turns.put(None)
        partner.join()
    shared.close()
    shared.unlink()
    rows = []
    for name, values in rates.items():
        ratio = statistics.median(c / v for c, v in zip(rates["copies, C"], values, strict=True))
        found = sorted(latencies[name])
        at = [f"{found[int(len(found) * share) - 1] / 1000:.1f}" for share in (0.5, 0.99, 0.999, 1)] \
            if found else []
        rows.append([name, _tables.spread([v / 1000 for v in values], 1), f"{ratio:.1f}", " / ".join(at)])
    _tables.show("72 bytes of data between two processes over shared memory",
                 ["", "1000 transfers a second", "copies / this", "us: p50 / p99 / p99.9 / max"], rows,
                 f"median (min .. max) of {BATCHES} batches of {IN_C} transfers in C, {IN_PYTHON} in Python; "
                 "none wrong; ratio of paired batches")


if __name__ == "__main__":
    main()
