"""A rung as Unicode text: box-drawing characters in a grid of cells."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from itertools import groupby

from ldc.draw.arrange import Arrangement, arrange
from ldc.draw.labels import BlockPins, Options, fold, notes_of, shorten, standard_pins, text_width
from ldc.draw.shapes import Arrow, Box, Dot, Label, Rail, Symbol, Wire
from ldc.draw.sheet import heading_of, sheet_of
from ldc.draw.wrap import bands
from ldc.parser import ast
from ldc.source import Span

UP, DOWN, LEFT, RIGHT = 1, 2, 4, 8
LINES = " │││─┘┐┤─└┌├─┴┬┼"
LOCAL = {"│": "┃", "├": "┠"}
SYMBOLS = {"contact": "┤├", "coil": "()"}
WIDE = "\0"
STYLES = {True: "32", False: "2", "error": "1;31", "warning": "1;33", "note": "36"}


def rung_text(
    rung: ast.Rung, *, width: int = 100, number: int | None = None, fill: int = 0, colour: bool = False,
    pins_of: Callable[[ast.Block], BlockPins | None] = standard_pins,
    notes: Mapping[str, tuple[str, ...]] | None = None, mark: Mapping[Span, str] | None = None,
    power: Callable[[ast.Item, str | None], bool | None] | None = None,
) -> str:
    """The rung as text in lines of at most ``width`` (60 or more) columns, without a last line end.

    ``number``: written above it, with its name and title. ``fill``: columns that the picture takes at
    least. ``colour``: ANSI colours for power and marks; without them marks are carets. For the others
    see ``ldc.draw.labels.Options``.
    """
    options = Options(width, pins_of, notes or {}, mark or {}, power, carets=not colour)
    return "\n".join(_rung_lines(rung, options, number, fill, colour))


def pou_text(
    pou: ast.Pou, *, comments: Iterable[ast.Comment] = (), width: int = 100, colour: bool = False,
    pins_of: Callable[[ast.Block], BlockPins | None] = standard_pins, addresses: bool = True,
    power: Callable[[ast.Item, str | None], bool | None] | None = None,
) -> str:
    """All rungs of a ladder POU with numbers, titles and the comments before them."""
    comments = tuple(comments)
    options = Options(width, pins_of, notes_of(pou, comments) if addresses else {}, {}, power)
    sheet = sheet_of(pou, comments, options)
    lines = [shorten("  ".join(sheet.heading), width)]
    for entry in sheet.entries:
        lines.append("")
        lines += [line for comment in entry.comments for line in fold(comment, width, 1000)]
        lines += _rung_lines(entry.rung, options, entry.number, sheet.fill, colour, entry.found)
    return "\n".join(lines)


def _rung_lines(
    rung: ast.Rung, options: Options, number: int | None, fill: int, colour: bool,
    found: Arrangement | None = None,
) -> list[str]:
    heading = "  ".join(heading_of(rung, number).values())
    lines = [shorten(heading, options.width)] if heading else []
    for number, band in enumerate(bands(found or arrange(rung, options), options, fill)):
        if number:
            lines.append("")
        canvas = Canvas(band.width, band.height)
        for shape in band.shapes:
            canvas.draw(shape)
        lines += canvas.rows(colour)
    return lines


class Canvas:
    """Cells that keep the directions of the lines in them, or a character, and a style."""

    def __init__(self, width: int, height: int) -> None:
        self.width, self.height = width, height
        self.lines = [bytearray(width) for _ in range(height)]
        self.chars: dict[tuple[int, int], str] = {}
        self.styles: dict[tuple[int, int], object] = {}
        self.heavy: set[tuple[int, int]] = set()

    def draw(self, shape) -> None:
        match shape:
            case Wire(x1, y1, x2, y2, on):
                self.line(x1, y1, x2, y2, on)
            case Rail(x, y1, y2, local):
                for y in range(y1, y2 + 1):
                    self.lines[y][x] |= UP | DOWN
                    if local:
                        self.heavy.add((x, y))
            case Symbol(kind, modifier, x, y, on, mark):
                left, right = SYMBOLS[kind]
                for at, char in ((x - 1, left), (x, modifier or " "), (x + 1, right)):
                    self.put(at, y, char, mark or on)
            case Box(_, x, y, width, height, on, mark):
                right, bottom, style = x + width - 1, y + height - 1, mark or on
                for line in (y, bottom):
                    self.line(x, line, right, line, style)
                for column in (x, right):
                    self.line(column, y, column, bottom, style)
            case Label(text, _, y, _, role, _, mark, on):
                style = mark or (on if role in ("operand", "expression") else None)
                self.write(shape.begin(text_width(text)), y, text, style)
            case Dot(x, y):
                if not self.lines[y][x] & (UP | DOWN):
                    self.put(x, y, "●", None)
            case Arrow(x, y, number, out, on):
                self.put(x, y, "►", on)
                self.write(x + 1 if out else x - len(str(number)), y, str(number), on)

    def line(self, x1: int, y1: int, x2: int, y2: int, style) -> None:
        for x in range(x1, x2 + 1) if y1 == y2 else ():
            self.lines[y1][x] |= (LEFT if x > x1 else 0) | (RIGHT if x < x2 else 0)
            self.style(x, y1, style)
        for y in range(y1, y2 + 1) if x1 == x2 else ():
            self.lines[y][x1] |= (UP if y > y1 else 0) | (DOWN if y < y2 else 0)
            self.style(x1, y, style)

    def style(self, x: int, y: int, style) -> None:
        if style is not None and self.styles.get((x, y)) is not True:
            self.styles[x, y] = style

    def put(self, x: int, y: int, char: str, style) -> None:
        self.chars[x, y] = char
        if style is not None:
            self.styles[x, y] = style

    def write(self, x: int, y: int, text: str, style) -> None:
        for char in text:
            size = text_width(char)
            if size:
                self.put(x, y, char, style)
                if size == 2:
                    self.put(x + 1, y, WIDE, style)
                x += size
            elif (x - 1, y) in self.chars:
                self.chars[x - 1, y] += char

    def rows(self, colour: bool = False) -> list[str]:
        return [self.row(y, colour) for y in range(self.height)]

    def row(self, y: int, colour: bool) -> str:
        cells = [LINES[mask] for mask in self.lines[y]]
        for x in range(self.width):
            if (x, y) in self.heavy:
                cells[x] = LOCAL.get(cells[x], cells[x])
            if (x, y) in self.chars:
                cells[x] = self.chars[x, y]
        if not colour:
            return "".join(cell for cell in cells if cell != WIDE).rstrip()
        parts = []
        styled = [(STYLES.get(self.styles.get((x, y))), cell) for x, cell in enumerate(cells) if cell != WIDE]
        for code, run in groupby(styled, key=lambda pair: pair[0]):
            text = "".join(cell for _, cell in run)
            parts.append(text if code is None else f"\x1b[{code}m{text}\x1b[0m")
        return "".join(parts).rstrip()
