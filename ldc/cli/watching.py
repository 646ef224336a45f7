"""Watched variables while a program runs: a live table for a terminal, lines of changes for a pipe."""

from __future__ import annotations

import sys
import time
from collections import deque
from collections.abc import Sequence
from typing import TextIO

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ldc.cli.console import wants_color
from ldc.types import BOOL, String
from runtime.values import milliseconds, show
from runtime.vm.machine import Machine

_REFRESH = 0.05
"""Seconds between two pictures."""

_HISTORY = 60
"""Scans that the wave of a BOOL shows."""


class ChangeLines:
    """One line for the first scan, and one for every scan that changed a watched variable."""

    def __init__(self, machine: Machine, names: Sequence[str], stream: TextIO) -> None:
        self._machine, self._names, self._stream = machine, names, stream
        self._symbols = machine.find(names)
        self._before: list[object] = [None] * len(names)

    def sample(self) -> None:
        now = self._machine.sample(self._symbols)
        if now == self._before:
            return
        changed = [
            f"{name}={_shown(value, symbol.type)}"
            for name, symbol, value, before in zip(self._names, self._symbols, now, self._before, strict=True)
            if value != before
        ]
        self._before = now
        self._stream.write(
            f"scan {self._machine.scans - 1:>5}  {_time(self._machine):>8} ms  {'  '.join(changed)}\n"
        )


class LiveTable:
    """A table that follows the run: each variable's value, and for a BOOL how it went in the last scans."""

    def __init__(self, machine: Machine, names: Sequence[str], scans: int) -> None:
        self._machine, self._names, self._scans = machine, names, scans
        self._symbols = machine.find(names)
        self._waves = [deque(maxlen=_HISTORY) if s.type == BOOL else None for s in self._symbols]
        self._next = 0.0
        console = Console(no_color=not wants_color(sys.stdout), highlight=False)
        self._live = Live(console=console, auto_refresh=False, transient=False)

    def __enter__(self) -> LiveTable:
        self._live.__enter__()
        return self

    def __exit__(self, *error) -> None:
        if self._machine.scans:
            self._live.update(self._table(), refresh=True)
        self._live.__exit__(*error)

    def sample(self) -> None:
        for wave, value in zip(self._waves, self._machine.sample(self._symbols), strict=True):
            if wave is not None:
                wave.append(value)
        if time.monotonic() >= self._next:
            self._live.update(self._table(), refresh=True)
            self._next = time.monotonic() + _REFRESH

    def _table(self) -> Table:
        machine = self._machine
        title = f"scan {machine.scans - 1} of {self._scans - 1}, {_time(machine)} ms"
        table = Table(
            title=title, title_justify="left", title_style="bold", header_style="dim", box=SIMPLE_HEAD
        )
        table.add_column("variable")
        table.add_column("type", style="dim")
        table.add_column("value", justify="right")
        table.add_column(f"last {_HISTORY} scans", no_wrap=True, overflow="crop")
        values = machine.sample(self._symbols)
        for name, symbol, value, wave in zip(self._names, self._symbols, values, self._waves, strict=True):
            style = "bold green" if value is True else ""
            line = "".join("▇" if on else "▁" for on in wave) if wave is not None else ""
            table.add_row(
                name, str(symbol.type), Text(_shown(value, symbol.type), style), Text(line, "green")
            )
        return table


def _shown(value: object, type_) -> str:
    text = show(value, type_)
    return repr(text) if isinstance(type_, String) else text


def _time(machine: Machine) -> str:
    """When the last scan began, in milliseconds."""
    return milliseconds(machine.now_ns - machine.period_ns)
