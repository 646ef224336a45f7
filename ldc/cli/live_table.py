"""What a program does while it runs, in a terminal: a live table of watched variables and the power of
rungs."""

from __future__ import annotations

import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence

from rich.box import SIMPLE_HEAD
from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ldc.cli.console import wants_color
from ldc.cli.powers import Powers
from ldc.cli.watching import shown, time_of
from ldc.render import plural
from ldc.types import BOOL, Elementary, Type
from runtime.machine import Machine
from runtime.values import show

_REFRESH = 0.05
"""Seconds between two pictures."""

_LEAST_RUNGS = 8
"""Rungs that are shown even on a low screen."""

_HISTORY, _LEAST_HISTORY = 60, 13
"""Scans that the wave of a BOOL shows, and for how many it is shown at all: as wide as its title."""

_EDGES, _BETWEEN = 4, 3
"""Columns of the screen beside a table, and between two of its own."""


class LiveTable:
    """A table that follows the run: each variable's value, for a BOOL how it went in the last scans, and the
    power that reaches the right end of each rung (without ``powers``: not). ``scan`` runs one scan (as
    ``execute`` does it, when not the machine) and ``sample`` takes note of it."""

    def __init__(self, machine: Machine, names: Sequence[str], scans: int, powers: Powers | None,
                 execute: Callable[[], None] | None = None) -> None:
        self._execute = execute or machine.scan
        self._machine, self._names, self._scans, self._powers = machine, names, scans, powers
        self._symbols = machine.find(names)
        self._waves = [deque(maxlen=_HISTORY) if s.type == BOOL else None for s in self._symbols]
        self._next = 0.0
        self._pictured = False
        self._console = Console(no_color=not wants_color(sys.stdout), highlight=False)
        self._live = Live(console=self._console, auto_refresh=False, transient=False)

    def __enter__(self) -> LiveTable:
        self._live.__enter__()
        return self

    def __exit__(self, *error) -> None:
        if self._machine.scans:
            self._live.update(self._picture(), refresh=True)
        self._live.__exit__(*error)

    def scan(self) -> None:
        """One scan: stepped when there will be a picture of it, for the power of the rungs, else as fast
        as it goes. Pictures take a tenth of the time at most."""
        start = time.monotonic()
        self._pictured = start >= self._next or self._machine.scans == self._scans - 1
        if not self._pictured:
            self._execute()
            return
        (self._powers.scan if self._powers else self._execute)()
        end = time.monotonic()
        self._next = end + max(_REFRESH, 9 * (end - start))

    def sample(self) -> None:
        for wave, value in zip(self._waves, self._machine.sample(self._symbols), strict=True):
            if wave is not None:
                wave.append(value)
        if self._pictured:
            self._live.update(self._picture(), refresh=True)

    def _picture(self) -> Group:
        return Group(self._table(), *(self._rungs(self._powers) if self._powers else ()))

    def _rungs(self, powers: Powers) -> Iterator[Table | Text]:
        """The rungs with their power, as many as the screen has room for."""
        rows = powers.rows
        room = max(_LEAST_RUNGS, self._console.size.height - len(self._names) - 12)
        if not rows:
            return
        table = Table(header_style="dim", box=SIMPLE_HEAD)
        table.add_column("rung")
        table.add_column("power", justify="right")
        for row in rows[:room]:
            power = powers.at(row)
            text = "-" if power is None else show(power, BOOL)
            table.add_row(Text(row.name), Text(text, "bold green" if power else ""))
        yield table
        if len(rows) > room:
            yield Text(f"  and {plural(len(rows) - room, 'more rung')}", "dim")

    def _table(self) -> Table:
        machine = self._machine
        title = f"scan {machine.scans - 1} of {self._scans - 1}, {time_of(machine)} ms"
        table = Table(
            title=title, title_justify="left", title_style="bold", header_style="dim", box=SIMPLE_HEAD
        )
        values = machine.sample(self._symbols)
        rows = [
            (name, str(symbol.type), _with_unit(value, symbol.type))
            for name, symbol, value in zip(self._names, self._symbols, values, strict=True)
        ]
        columns = [("variable", {}), ("type", {"style": "dim"}), ("value", {"justify": "right"})]
        widths = [max(map(len, (title, *column))) for (title, _), column in
                  zip(columns, zip(*rows, strict=True) if rows else ((), (), ()), strict=True)]
        left = self._console.size.width - _EDGES - sum(width + _BETWEEN for width in widths)
        # A narrow terminal shows what a variable is before what it was.
        typed = left + _BETWEEN >= 0
        history = min(_HISTORY, left) if left >= _LEAST_HISTORY else 0
        for title, style in columns if typed else columns[::2]:
            table.add_column(title, no_wrap=True, **style)
        if history:
            table.add_column(f"last {history} scans", no_wrap=True)
        for (name, kind, text), value, wave in zip(rows, values, self._waves, strict=True):
            style = "bold green" if value is True else ""
            cells = [Text(name), *([Text(kind)] if typed else []), Text(text, style)]
            if history:
                line = "".join("▇" if on else "▁" for on in list(wave or ())[-history:])
                cells.append(Text(line, "green"))
            table.add_row(*cells)
        return table


def _with_unit(value: object, type_: Type) -> str:
    return shown(value, type_) + (" ms" if isinstance(type_, Elementary) and type_.kind == "time" else "")
