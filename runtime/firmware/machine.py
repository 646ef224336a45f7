"""A machine whose scans a microcontroller has executed: a job tells it what to do, the trace what happened.

A job, words of 32 bits: ``LDCJ``, scans, the scan before which the processor starts anew (``END``: none), how
many ranges are watched, offset and size of each; then of every scan with changes its number, how many
changes, and these (``ldc.il.changes``); at the end ``END``. The trace: ``F``, a task (8 bits) and the begin
of the block when that task stops; ``S`` and the bytes of the watched ranges after each scan; ``E`` and the
whole block at the end. """

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from struct import calcsize, pack

from ldc.il import changes
from ldc.il.block import Block, Spot
from ldc.types import Value
from runtime import fault_record
from runtime.in_block import FIRST_SCAN, InBlock
from runtime.layout import Layout
from runtime.machine import Schedule
from runtime.outputs import safe_states
from runtime.stimuli import Stimuli
from runtime.symbols import Symbol

MAGIC, END = 0x4A43444C, 0xFFFF_FFFF
_RECORD = calcsize("<qQ4BIqqqII") + 121 * 8


class BrokenTrace(Exception):
    """The trace of a run is not what the job asked for."""


@dataclass(slots=True, eq=False)
class Machine(InBlock):
    """Goes through a run again, scan by scan; only what was watched has values in between. ``block``: where
    variables lie in the firmware; ``parts``: the map of its code, for faults."""

    block: Block = field(kw_only=True)
    parts: fault_record.Parts = field(kw_only=True)
    _trace: memoryview = field(init=False, repr=False)
    _at: int = field(init=False, repr=False)
    _ranges: list[tuple[int, int]] = field(init=False, repr=False)

    def _load(self) -> Layout:
        layout = self._find_places(self.block)
        self.memory = memoryview(self.block.initial())
        self.memory[FIRST_SCAN] = 1
        self._trace, self._at, self._ranges = memoryview(b""), 0, []
        return layout

    def single_spot(self, schedule: Schedule) -> Spot | None:
        """The place of the variable of SINGLE."""
        single = schedule.task.single
        return None if single is None else self.spot(self.symbols.find(str(single)))

    def safe_values(self, schedule: Schedule) -> tuple[tuple[Spot, Value], ...]:
        """What outputs become when the task is stopped."""
        found = safe_states(self._declared, self.layout, self.symbols, schedule.runs)
        # In the order of their places: the sets that they come from have none.
        places = [(self.spot(symbol), value) for symbol, value in found]
        return tuple(sorted(places, key=lambda p: (p[0].offset, p[0].bit or 0)))

    # ---- before the run

    def job(self, scans: int, watched: Iterable[Symbol], stimuli: Stimuli, restart: int = END) -> bytes:
        """The job of some scans; the trace of it is to be given to ``replay``. ``restart``: the scan before
        which the processor starts anew."""
        self._ranges = _merged(self._extent(symbol) for symbol in watched)
        words = [MAGIC, scans, restart, len(self._ranges)]
        for pair in self._ranges:
            words += pair
        for scan, row in sorted(stimuli.rows.items()):
            if scan < scans:
                found = list(changes.words((self.spot(symbol), value) for symbol, value in row))
                words += (scan, changes.count(found), *found)
        words.append(END)
        return pack(f"<{len(words)}I", *words)

    def _extent(self, symbol: Symbol) -> tuple[int, int]:
        spot = self.spot(symbol)
        return spot.offset, 1 if spot.bit is not None else self.block.measure(spot.type)

    # ---- after it

    def replay(self, trace: bytes) -> None:
        """What ``scan`` goes through from now on. Raises BrokenTrace at the scan where something is amiss."""
        self._trace, self._at = memoryview(trace), 0

    def put(self, symbol: Symbol, value: object) -> None:
        """Changes were in the job."""

    def scan(self) -> None:
        while (mark := self._take(1)) == b"F":
            schedule = self.schedules[self._take(1)[0]]
            record, limit = self._take(_RECORD), schedule.task.watchdog
            self.stop(schedule, *fault_record.read(self.block, self.parts, record, limit))
        if mark != b"S":
            raise BrokenTrace("a scan is missing")
        for offset, size in self._ranges:
            self.memory[offset:offset + size] = self._take(size)
        self.scans += 1
        self.now_ns += self.period_ns
        if self._at + 1 + len(self.memory) == len(self._trace):
            # After the last scan all variables are known.
            if self._take(1) != b"E":
                raise BrokenTrace("the end is missing")
            self.memory[:] = self._take(len(self.memory))

    def _take(self, size: int) -> memoryview:
        found = self._trace[self._at:self._at + size]
        if len(found) < size:
            raise BrokenTrace("it ends too early")
        self._at += size
        return found


def _merged(extents: Iterable[tuple[int, int]]) -> list[tuple[int, int]]:
    """Ranges without overlap, in order, that cover all of some."""
    found: list[tuple[int, int]] = []
    for offset, size in sorted(extents):
        if found and offset <= found[-1][0] + found[-1][1]:
            begin = found[-1][0]
            found[-1] = begin, max(found[-1][1], offset + size - begin)
        else:
            found.append((offset, size))
    return found
