"""What a program does while it runs, as lines of changes for a pipe."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TextIO

from ldc.types import String, Type
from runtime.machine import Machine
from runtime.values import milliseconds, show


class ChangeLines:
    """One line for the first scan, and one for every scan that changed a watched variable."""

    def __init__(self, machine: Machine, names: Sequence[str], stream: TextIO) -> None:
        self._machine, self._names, self._stream = machine, names, stream
        self._symbols = machine.find(names)
        self._before: list[object] = [None] * len(names)
        self._paths = [machine.symbols.full(symbol) for symbol in self._symbols]

    def follow(self, machine: Machine, shown: Sequence[tuple[str, str]] | None = None) -> None:
        """Goes on with another program, and with ``shown`` (what is written, and its full path) when that has
        others to show; what it does not have is shown no more."""
        before = dict(zip(self._paths, self._before, strict=True))
        asked = zip(self._names, self._paths, strict=True) if shown is None else shown
        known = ((name, path, *machine.known([path])) for name, path in asked)
        rows = [row for row in known if row[2] is not None]
        self._machine, self._names = machine, [name for name, *_ in rows]
        self._paths = [path for _, path, _ in rows]
        self._symbols = tuple(symbol for *_, symbol in rows)
        self._before = [before.get(path) for path in self._paths]

    def sample(self) -> None:
        now = self._machine.sample(self._symbols)
        if now == self._before:
            return
        changed = [
            f"{name}={shown(value, symbol.type)}"
            for name, symbol, value, before in zip(self._names, self._symbols, now, self._before, strict=True)
            if value != before
        ]
        self._before = now
        self._stream.write(
            f"scan {self._machine.scans - 1:>5}  {time_of(self._machine):>8} ms  {'  '.join(changed)}\n"
        )


def shown(value: object, type_: Type) -> str:
    """A value of the machine as text."""
    text = show(value, type_)
    return repr(text) if isinstance(type_, String) else text


def time_of(machine: Machine) -> str:
    """When the last scan began, in milliseconds."""
    return milliseconds(machine.now_ns - machine.period_ns)
