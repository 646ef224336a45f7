"""Forces: variables that hold a value whatever inputs and code say (docs/commissioning.md).

The order in a scan: inputs are latched, forces, code, forces, outputs. So a forced input is what the code
reads, a forced output is what leaves, also after a fault, and a forced variable in between begins and ends
every scan with its value; code that writes it may read its own value until the scan ends.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ldc.types import Type
from runtime.symbols import Symbol
from runtime.values import parse, show

if TYPE_CHECKING:
    from runtime.machine import Machine


@dataclass(slots=True)
class Force:
    """One of them. ``path``: with the name of its program; ``free``: what the variable had without it."""

    path: str
    symbol: Symbol
    value: object
    free: object

    @property
    def shown(self) -> str:
        """The value as traces print it."""
        return show(self.value, self.symbol.type)


class Forces:
    """The forces of one machine, in the order in which they were set; ``rows`` is empty without any."""

    def __init__(self, machine: Machine) -> None:
        self._machine: Machine | None = machine
        self.rows: list[Force] = []

    def close(self) -> None:
        """The machine is given up: it and its forces hold each other no more."""
        self._machine = None

    def add(self, path: str, text: str) -> Force:
        """Holds a variable from now on; a force that it has already gets the new value. Between two scans.

        ``text``: the value as people write it. Raises UnknownSymbol for the path, ValueError for the value.
        """
        machine = self._machine
        symbol = machine.symbols.find(path)
        value = parse(text, symbol.type)
        row = self.of(symbol)
        if row is None:
            row = Force(machine.symbols.full(symbol), symbol, value, machine.value(symbol))
            self.rows.append(row)
        row.value = value
        machine.assign(symbol, value)
        return row

    def remove(self, path: str) -> Force | None:
        """Lets a variable go: an input gets what came in meanwhile, others keep the value until code writes
        them. None when it is not forced. Raises UnknownSymbol."""
        row = self.of(self._machine.symbols.find(path))
        if row is not None:
            self.rows.remove(row)
            if row.symbol.area == "I":
                self._machine.assign(row.symbol, row.free)
        return row

    def of(self, symbol: Symbol) -> Force | None:
        """The force of a variable, by whatever path it was named."""
        return next((row for row in self.rows if row.symbol.place == symbol.place), None)

    def latch(self, latch: Callable[[], None]) -> None:
        """Latches inputs, keeps what came in for those that are forced, and holds all."""
        machine = self._machine
        inputs = [row for row in self.rows if row.symbol.area == "I"]
        for row in inputs:
            machine.assign(row.symbol, row.free)
        latch()
        for row in inputs:
            row.free = machine.value(row.symbol)
        self.hold()

    def hold(self) -> None:
        """Writes all forced values."""
        assign = self._machine.assign
        for row in self.rows:
            assign(row.symbol, row.value)

    def follow(self, machine: Machine) -> Forces:
        """Those of another machine that goes on with the state; see ``lost`` for what it cannot hold."""
        found = Forces(machine)
        for row, symbol in zip(self.rows, machine.known(row.path for row in self.rows), strict=True):
            if symbol is not None and symbol.type == row.symbol.type:
                found.rows.append(Force(row.path, symbol, row.value, row.free))
        return found

    def lost(self, machine: Machine) -> list[tuple[str, Type, Type | None]]:
        """Path, type and new type (None: not there) of what another machine could not hold."""
        symbols = machine.known(row.path for row in self.rows)
        return [(row.path, row.symbol.type, symbol.type if symbol else None)
                for row, symbol in zip(self.rows, symbols, strict=True)
                if symbol is None or symbol.type != row.symbol.type]
