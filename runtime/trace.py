"""Traces: CSV with the header ``scan,t_ms,`` and the watched variables, a row per scan (DESIGN section 8)."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import TextIO

from runtime.values import milliseconds, show
from runtime.machine import Machine


class Trace:
    """Writes to ``stream``: the header at once, a row at each ``sample`` (after a scan).

    ``names`` are the columns as they were asked for. Raises UnknownSymbol for one that is none.
    """

    def __init__(self, machine: Machine, names: Sequence[str], stream: TextIO) -> None:
        self._machine = machine
        self._symbols = machine.find(names)
        self._paths = [machine.symbols.full(symbol) for symbol in self._symbols]
        self._columns = range(len(names))
        self._writer = csv.writer(stream, lineterminator="\n")
        self._writer.writerow(("scan", "t_ms", *names))

    def follow(self, machine: Machine) -> None:
        """Goes on with another program; the cells of what it does not have are empty."""
        self._machine = machine
        known = machine.known(self._paths)
        self._columns = [at for at, symbol in enumerate(known) if symbol is not None]
        self._symbols = tuple(known[at] for at in self._columns)

    def sample(self) -> None:
        """The row of the scan that has just ended."""
        machine = self._machine
        values = machine.sample(self._symbols)
        cells = [""] * len(self._paths)
        for at, value, symbol in zip(self._columns, values, self._symbols, strict=True):
            cells[at] = show(value, symbol.type)
        self._writer.writerow((machine.scans - 1, milliseconds(machine.now_ns - machine.period_ns), *cells))


def record(machine: Machine, names: Sequence[str], scans: int, stimuli=None) -> str:
    """Runs some scans and gives their trace as text. ``stimuli``: a ``runtime.stimuli.Stimuli``."""
    text = io.StringIO()
    trace = Trace(machine, names, text)
    for _ in range(scans):
        if stimuli is not None:
            stimuli.apply(machine)
        machine.scan()
        trace.sample()
    return text.getvalue()
