"""What ``ldc bench`` measures: nanoseconds per scan and per contact, median of batches (DESIGN section 8)."""

from __future__ import annotations

import gc
from collections.abc import Callable
from statistics import median
from time import perf_counter_ns

from ldc.types import BOOL
from runtime.machine import Machine
from runtime.symbols import Symbol

BATCHES, SEED = 7, 0x9E3779B97F4A7C15
STIMULI = ("fixed", "flip", "random")
_WORD = (1 << 64) - 1

Change = list[tuple[Symbol, bool]]


def xorshift64(state: int) -> int:
    """The next number of Marsaglia's generator with shifts 13, 7, 17; never 0 from a state that is not 0."""
    state ^= state << 13 & _WORD
    state ^= state >> 7
    return state ^ (state << 17 & _WORD)


def scans_of(contacts: int) -> int:
    """Scans of one batch: depends on the program only, so that every engine ends in the same state."""
    return max(10, min(2_000, 400_000 // max(contacts, 1)))


def bench(machine: Machine, contacts: int, stimulus: str = "fixed", engine: str = "vm",
          batches: int = BATCHES, scans: int | None = None, seed: int = SEED) -> dict[str, object]:
    """Times ``machine.scan()`` in batches; a first batch warms up and is not timed.

    ``contacts``: how many contacts the program draws (the caller counts them). ``stimulus``: ``fixed``
    leaves the BOOL inputs (%IX) as they are, ``flip`` inverts one of them before each scan, in declared
    order round and round, ``random`` sets all from xorshift64, one bit for each from the lowest, 64 inputs
    to a number. ``scans``: of one batch. Result: ``scans`` counts all executed, the warm-up too;
    ``spread`` is (slowest - fastest) / median of the batches; ``state`` is the checksum at the end.
    """
    size = scans_of(contacts) if scans is None else scans
    changes = _changes(machine, stimulus, seed)
    before, times = machine.scans, []
    collecting = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        for batch in range(batches + 1):
            elapsed = _timed(machine, changes, size)
            if batch:
                times.append(elapsed / size)
    finally:
        if collecting:
            gc.enable()
    middle = median(times)
    return {
        "engine": engine, "scans": machine.scans - before, "contacts": contacts, "ns_per_scan": middle,
        "ns_per_contact": middle / contacts if contacts else None,
        "spread": (max(times) - min(times)) / middle, "state": machine.checksum(),
    }


def _timed(machine: Machine, changes: Callable[[], Change] | None, size: int) -> int:
    """Nanoseconds of ``size`` scans; what the inputs will be is worked out before."""
    scan = machine.scan
    if changes is None:
        begin = perf_counter_ns()
        for _ in range(size):
            scan()
        return perf_counter_ns() - begin
    prepared = [machine.prepare(changes()) for _ in range(size)]
    feed = machine.feed
    begin = perf_counter_ns()
    for one in prepared:
        feed(one)
        scan()
    return perf_counter_ns() - begin


def _changes(machine: Machine, stimulus: str, seed: int) -> Callable[[], Change] | None:
    """What makes the changes of inputs before each scan; only those that change are sent."""
    if stimulus not in STIMULI:
        raise ValueError(f"no stimulus {stimulus}: {', '.join(STIMULI)}")
    found = (s for s in machine.symbols.located("I") if s.type == BOOL)
    inputs = list({(s.home, s.keys): s for s in found}.values())
    if stimulus == "fixed" or not inputs:
        return None
    values = [bool(v) for v in machine.sample(inputs)]
    state = seed

    def flip() -> Change:
        nonlocal state
        at = (state := state + 1) % len(inputs)
        values[at] = not values[at]
        return [(inputs[at], values[at])]

    def random() -> Change:
        nonlocal state
        bits = 0
        for shift in range(0, len(inputs), 64):
            state = xorshift64(state)
            bits |= state << shift
        changed = []
        for at, old in enumerate(values):
            if (new := bool(bits >> at & 1)) is not old:
                values[at] = new
                changed.append((inputs[at], new))
        return changed

    if stimulus == "flip":
        state = -1
        return flip
    return random
