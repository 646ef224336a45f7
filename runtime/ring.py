"""A trace ring: the scans around an event, in bounded memory (docs/commissioning.md).

Rows are kept in a ring until the trigger comes, then a number of further ones; that is all, once. The trigger
is tested after a scan, on the values that it left.
"""

from __future__ import annotations

import csv
import io
import operator
import re
from collections import deque
from collections.abc import Callable, Sequence
from itertools import islice

from ldc.diagnostics import Invalid
from ldc.patterns import Pattern
from ldc.records import record
from ldc.types import BOOL, String, storage
from runtime import value_findings as findings
from runtime.machine import Machine
from runtime.symbols import Symbol, UnknownSymbol
from runtime.values import milliseconds, parse, show

MOST_CELLS = 1_000_000
_EDGE = Pattern(r"\s*(.+?)\s+(rises|falls)\s*\Z", re.IGNORECASE)
_COMPARED = Pattern(r"\s*(.+?)\s*(>=|<=|<>|=|>|<)\s*(.+?)\s*\Z")
_TESTS: dict[str, Callable] = {">": operator.gt, ">=": operator.ge, "<": operator.lt, "<=": operator.le,
                               "=": operator.eq, "<>": operator.ne}
Test = Callable[[object, object], bool]
_Shape = tuple[list[int], tuple[Symbol, ...]]
_Row = tuple[int, int, _Shape, tuple]


@record
class Trigger:
    """``test``: whether the values before (None: there is none) and now are the event."""

    symbol: Symbol
    test: Test


def trigger(text: str, machine: Machine) -> Trigger:
    """``PATH rises``, ``PATH falls``, or ``PATH`` compared with a value. Raises Invalid: LD0857 for the
    text, LD0855 for the path or the value."""
    edge, compared = _EDGE.match(text), _COMPARED.match(text)
    if edge is None and compared is None:
        raise Invalid([findings.bad_trigger(text, "it says neither `rises`, `falls` nor a comparison")])
    path = (edge or compared)[1]
    symbol = found(machine, "trace", (path,))[0]
    if edge:
        if storage(symbol.type) != BOOL:
            raise Invalid([findings.bad_trigger(text, f"a {symbol.type} does not rise or fall")])
        now = edge[2].lower() == "rises"
        return Trigger(symbol, lambda before, value: before is (not now) and value is now)
    sign, operand = compared[2], compared[3]
    plain = isinstance(symbol.type, String) or storage(symbol.type) == BOOL
    if plain and sign not in ("=", "<>"):
        raise Invalid([findings.bad_trigger(text, f"values of {symbol.type} have no order")])
    try:
        wanted = parse(operand, symbol.type)
    except ValueError as error:
        raise Invalid([findings.no_value("trace", path, error)]) from error
    test = _TESTS[sign]
    return Trigger(symbol, lambda before, value: test(value, wanted))


def found(machine: Machine, action: str, paths: Sequence[str]) -> tuple[Symbol, ...]:
    """The symbols of some paths. Raises Invalid (LD0855) with what is unknown."""
    symbols, against = [], []
    for path in paths:
        try:
            symbols.append(machine.symbols.find(path))
        except UnknownSymbol as error:
            against.append(findings.no_value(action, path, error))
    if against:
        raise Invalid(against)
    return tuple(symbols)


class Ring:
    """``before`` rows, the one of the event, ``after`` rows. Raises Invalid: LD0855, LD0857, LD0859."""

    def __init__(self, machine: Machine, names: Sequence[str], text: str, before: int, after: int) -> None:
        cells = (before + 1 + after) * max(len(names), 1)
        if before < 0 or after < 0 or cells > MOST_CELLS:
            raise Invalid([findings.too_much(
                f"a trace of {before} rows before and {after} after, of {len(names)} variables",
                f"it may have {MOST_CELLS:,} cells: watch less, or take fewer rows")])
        self.names, self._text, self._after = tuple(names), text, after
        symbols = found(machine, "trace", names)
        self._trigger: Trigger | None = trigger(text, machine)
        self._paths = [machine.symbols.full(s) for s in (*symbols, self._trigger.symbol)]
        self._previous: object = None
        self.rows: deque[_Row] = deque(maxlen=before)
        self.event: int | None = None
        self._left = after
        self._use(machine, list(range(len(names))), symbols)

    @property
    def done(self) -> bool:
        """All rows are there."""
        return self.event is not None and self._left == 0

    @property
    def lost(self) -> bool:
        """The variable of the trigger is not in the program that runs now."""
        return self._trigger is None

    def follow(self, machine: Machine) -> None:
        """Goes on with another program; the cells of what it does not have are empty."""
        *known, watched = machine.known(self._paths)
        columns = [at for at, symbol in enumerate(known) if symbol is not None]
        if watched is None or self._trigger is None or watched.type != self._trigger.symbol.type:
            self._trigger = None
        else:
            self._trigger = Trigger(watched, self._trigger.test)
        self._use(machine, columns, tuple(known[at] for at in columns))

    def _use(self, machine: Machine, columns: list[int], symbols: tuple[Symbol, ...]) -> None:
        self._machine, self._shape = machine, (columns, symbols)
        self._read = machine.reader((*symbols, self._trigger.symbol) if self._trigger else symbols)

    def sample(self) -> None:
        """Takes the row of the scan that has just ended."""
        if self.done:
            return
        machine, values = self._machine, self._read()
        row = machine.scans - 1, machine.now_ns - machine.period_ns, self._shape, values
        if self.event is not None:
            self._left -= 1
            self.rows.append(row)
        elif self._trigger is None:
            self.rows.append(row)
        else:
            value = values[-1]
            if self._trigger.test(self._previous, value):
                self.event = row[0]
                self.rows = deque((*self.rows, row))
            else:
                self.rows.append(row)
            self._previous = value

    def csv(self, first: int = 0, count: int | None = None) -> str:
        """Rows as traces have them, the header before row 0. The ring is done, or stands still."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        if first == 0:
            writer.writerow(("scan", "t_ms", *self.names))
        end = None if count is None else first + count
        for scan, now, (columns, symbols), values in islice(self.rows, first, end):
            cells = [""] * len(self.names)
            for at, symbol, value in zip(columns, symbols, values, strict=False):
                cells[at] = show(value, symbol.type)
            writer.writerow((scan, milliseconds(now), *cells))
        return text.getvalue()
