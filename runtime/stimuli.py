"""Input files of a run: CSV with the header ``scan,a,b`` (DESIGN section 8).

A row sets the variables of its columns before that scan, an empty cell leaves one as it is.
"""

from __future__ import annotations


from ldc.diagnostics import Diagnostics, Label
from ldc.records import record
from ldc.source import SourceFile, Span
from runtime.machine import Machine
from runtime.symbols import Symbol, Symbols, UnknownSymbol
from runtime.values import parse


@record
class Stimuli:
    """``rows``: per scan number what is set before it, in the order of the columns; ``last``: the highest."""

    rows: dict[int, tuple[tuple[Symbol, object], ...]]
    last: int = -1

    def apply(self, machine: Machine) -> None:
        """Sets what the row of the coming scan says."""
        for symbol, value in self.rows.get(machine.scans, ()):
            machine.put(symbol, value)

    def follow(self, old: Machine, new: Machine) -> Stimuli:
        """The same for another program; what it does not have, or has of another type, is left out."""
        symbols = list({symbol: None for row in self.rows.values() for symbol, _ in row})
        known = dict(zip(symbols, new.known(old.symbols.full(s) for s in symbols), strict=True))
        kept = {s: now for s, now in known.items() if now is not None and now.type == s.type}
        rows = {scan: tuple((kept[s], value) for s, value in row if s in kept)
                for scan, row in self.rows.items()}
        return Stimuli(rows, self.last)


@record
class _Cell:
    text: str
    span: Span


def read(source: SourceFile, symbols: Symbols, diagnostics: Diagnostics) -> Stimuli | None:
    """The stimuli of a CSV text; None (and diagnostics LD0650 to LD0655) when it is wrong."""
    before = len(diagnostics)
    lines = _lines(source)
    columns = _header(source, lines, symbols, diagnostics)
    if columns is None:
        return None
    rows: dict[int, tuple[tuple[Symbol, object], ...]] = {}
    previous: tuple[int, Span] | None = None
    for cells in lines[1:]:
        if len(cells) > len(columns):
            diagnostics.error(
                "LD0654", f"this row has {len(cells)} cells, the header has {len(columns)}",
                cells[len(columns)].span, "no column for this cell",
                secondary=(Label(lines[0][-1].span, "the last column"),),
                help='give the column a name, or put a value that holds a comma in quotes: "a,b"')
            continue
        scan = _scan_number(cells[0], previous, diagnostics)
        if scan is None:
            continue
        previous = scan, cells[0].span
        pairs = zip(cells[1:], columns[1:], strict=False)
        values = (_value(cell, symbol, diagnostics) for cell, symbol in pairs)
        rows[scan] = tuple(value for value in values if value is not None)
    return Stimuli(rows, max(rows, default=-1)) if len(diagnostics) == before else None


def _header(source: SourceFile, lines: list[list[_Cell]], symbols: Symbols,
            diagnostics: Diagnostics) -> list[Symbol | None] | None:
    """The symbols of the columns (None for ``scan`` and for what is unknown); None without a header."""
    if not lines or lines[0][0].text.lower() != "scan":
        at = lines[0][0].span if lines else Span(source, 0, 0)
        diagnostics.error(
            "LD0650", "an input file begins with the header `scan,` and the names of variables", at,
            "the first column is not `scan`" if lines else "the file is empty",
            help="begin with a line like `scan,start,stop`; columns are separated by commas")
        return None
    columns: list[Symbol | None] = [None]
    seen: dict[str, Span] = {}
    for cell in lines[0][1:]:
        first = seen.setdefault(cell.text.upper(), cell.span)
        symbol = None
        if first is not cell.span:
            diagnostics.error("LD0655", f"the column `{cell.text}` is there twice", cell.span, "again",
                              secondary=(Label(first, "first here"),), help="keep one of them")
        else:
            try:
                symbol = symbols.find(cell.text)
            except UnknownSymbol as error:
                diagnostics.error("LD0651", f"unknown column: {error}", cell.span, "no such variable",
                                  help="name a variable as in `conveyor.warm.PT`, `start` or `%IX0.0`")
        columns.append(symbol)
    return columns


def _scan_number(cell: _Cell, previous: tuple[int, Span] | None, diagnostics: Diagnostics) -> int | None:
    number = int(cell.text) if cell.text.isascii() and cell.text.isdigit() and len(cell.text) < 16 else None
    if number is not None and (previous is None or number > previous[0]):
        return number
    if number is None:
        label, secondary = "not a whole number from 0", ()
    else:
        label, secondary = "not after the row before", (Label(previous[1], "the row before"),)
    diagnostics.error("LD0653", f"`{cell.text}` is no scan number here", cell.span, label,
                      secondary=secondary,
                      help="scans count 0, 1, 2 ...; rows stand in rising order, one for a scan")
    return None


def _value(cell: _Cell, symbol: Symbol | None, diagnostics: Diagnostics) -> tuple[Symbol, object] | None:
    if symbol is None or not cell.text:
        return None
    try:
        return symbol, parse(cell.text, symbol.type)
    except ValueError as error:
        diagnostics.error("LD0652", f"bad value for `{symbol.path}`: {error}", cell.span,
                          f"not a value of {symbol.type}",
                          help="values are written `0 1 TRUE FALSE 12 -3 16#FF 1.5 T#20ms`, an empty cell "
                               "changes nothing")
    return None


def _lines(source: SourceFile) -> list[list[_Cell]]:
    """The cells of every line that is not empty, with their spans; commas in quotes divide nothing."""
    found = []
    text = source.text
    for number, start in enumerate(source.line_starts, 1):
        line = source.line(number)
        if number == 1 and line.startswith("\ufeff"):
            line, start = line[1:], start + 1
        if not line.strip():
            continue
        cells, at = [], 0
        while at <= len(line):
            end = _cell_end(line, at)
            raw = line[at:end]
            bare = raw.strip()
            left = start + at + len(raw) - len(raw.lstrip())
            quoted = len(bare) > 1 and bare[0] == bare[-1] == '"'
            value = bare[1:-1].replace('""', '"').strip() if quoted else bare
            cells.append(_Cell(value, Span(source, min(left, len(text)), left + len(bare))))
            at = end + 1
        found.append(cells)
    return found


def _cell_end(line: str, at: int) -> int:
    """Where the cell that begins at ``at`` ends: at a comma outside quotes or at the end of the line."""
    first = at
    while first < len(line) and line[first] in " \t":
        first += 1
    if first < len(line) and line[first] == '"':
        close = line.find('"', first + 1)
        while close >= 0 and line[close + 1 : close + 2] == '"':
            close = line.find('"', close + 2)
        at = close + 1 if close >= 0 else len(line)
    comma = line.find(",", at)
    return comma if comma >= 0 else len(line)
