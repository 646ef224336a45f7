"""Rungs as self-contained SVG: crisp lines, light and dark, no font files, no scripts."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from html import escape

from ldc.draw.arrange import Arrangement, arrange
from ldc.draw.charts import ladders_of
from ldc.draw.labels import BlockPins, Options, fold, notes_of, shorten, standard_pins, text_width
from ldc.draw.shapes import Arrow, Box, Dot, Drawing, Label, Rail, Shape, Symbol, Wire
from ldc.draw.sheet import Sheet, heading_of, sheet_of
from ldc.draw.style import CSS
from ldc.draw.wrap import bands
from ldc.parser import ast
from ldc.parser.unparse import paths_text
from ldc.records import replace
from ldc.source import Span

CELL, LINE, EDGE = 8, 20, 16
"""Pixels: a column (a 13 px font advances 7.8), a line, the margin around the picture."""
ANCHOR = {"start": -3, "middle": 0, "end": 3}
NEAR = {"start": -9, "middle": 0, "end": 9}
"""Pixels from the middle of a cell to where a text begins or ends; values stand nearer to their pins."""
HAIR = 5
"""How much an expression's frame is drawn inside its cells."""


def rung_svg(
    rung: ast.Rung, *, width: int = 120, number: int | None = None, fill: int = 0,
    pins_of: Callable[[ast.Block], BlockPins | None] = standard_pins,
    notes: Mapping[str, tuple[str, ...]] | None = None, mark: Mapping[Span, str] | None = None,
    power: Callable[[ast.Item, str | None], bool | None] | None = None,
) -> str:
    """The rung as an SVG document; ``width`` is counted in columns of 8 px, the rest is as in
    ``ldc.draw.rung_text``."""
    page = _Page(Options(width, pins_of, notes or {}, mark or {}, power))
    page.rung(rung, number, arrange(rung, page.options), fill)
    return page.document("  ".join(heading_of(rung, number).values()) or "Rung", paths_text(rung))


def pou_svg(
    pou: ast.Pou, *, comments: Iterable[ast.Comment] = (), width: int = 120,
    pins_of: Callable[[ast.Block], BlockPins | None] = standard_pins, addresses: bool = True,
    power: Callable[[ast.Item, str | None], bool | None] | None = None,
) -> str:
    """All rungs of a ladder POU under each other, with numbers, titles and comments."""
    return project_svg(
        (pou,), comments=comments, width=width, pins_of=pins_of, addresses=addresses, power=power
    )


def project_svg(
    pous: Iterable[ast.Pou], *, comments: Iterable[ast.Comment] = (), width: int = 120,
    pins_of: Callable[[ast.Block], BlockPins | None] = standard_pins, addresses: bool = True,
    power: Callable[[ast.Item, str | None], bool | None] | None = None,
) -> str:
    """Several POUs in one document. POUs in other languages are left out, as they have no drawing."""
    comments = tuple(comments)
    page = _Page(Options(width, pins_of, {}, {}, power))
    ladders = [ladder for pou in pous for ladder in ladders_of(pou)]
    for pou in ladders:
        notes = notes_of(pou, comments) if addresses else {}
        page.options = Options(width, pins_of, notes, {}, power)
        sheet = sheet_of(pou, comments, page.options)
        page.title(sheet)
        for entry in sheet.entries:
            page.comments(entry.comments)
            page.rung(entry.rung, entry.number, entry.found, sheet.fill)
    about = "; ".join(f"{pou.name}: {len(pou.body.rungs)} rungs" for pou in ladders)
    return page.document(", ".join(pou.name for pou in ladders) or "No ladder", about)

_UNKNOWN = re.compile("[^\t\n\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


class _Page:
    """Grows downwards; keeps what was drawn as text."""

    def __init__(self, options: Options) -> None:
        self.options = options
        self.out: list[str] = []
        self.top = EDGE
        self.width = 20 * CELL

    def title(self, sheet: Sheet) -> None:
        roles = ("kind", "pou", "about")
        self.headline(dict(zip(roles, sheet.heading, strict=False)), 20)
        self.top += 8

    def comments(self, comments: tuple[str, ...]) -> None:
        for comment in comments:
            for line in fold(comment, max(self.options.width, 20), 1000):
                self.headline({"comment": line}, LINE)

    def headline(self, parts: dict[str, str], height: int) -> None:
        """Texts of different roles on one line, two columns between."""
        x = EDGE
        for role, text in parts.items():
            shown = shorten(text, max(8, self.options.width - (x - EDGE) // CELL))
            full = f"<title>{_text(text)}</title>" if shown != text else ""
            y = self.top + height - 5
            self.out.append(f'<text class="ldc-{role}" x="{x}" y="{y}">{full}{_text(shown)}</text>')
            x += (text_width(shown) + 2) * CELL
        self.width = max(self.width, x - EDGE - 2 * CELL)
        self.top += height

    def rung(self, rung: ast.Rung, number: int | None, found: Arrangement, fill: int) -> None:
        heading = heading_of(rung, number)
        if heading:
            self.headline(heading, LINE)
            self.top += 6
        for at, band in enumerate(bands(found, self.options, fill)):
            self.top += LINE if at else 0
            _Band(self.out, self.top).draw(band)
            self.top += band.height * LINE
            self.width = max(self.width, band.width * CELL)
        self.top += LINE

    def document(self, title: str, about: str) -> str:
        width, height = self.width + 2 * EDGE, self.top
        head = (
            f'<svg xmlns="http://www.w3.org/2000/svg" class="ldc" role="img" width="{width}" '
            f'height="{height}" viewBox="0 0 {width} {height}">'
        )
        named = f"<title>{_text(title)}</title>\n<desc>{_text(about)}</desc>"
        paper = f'<rect class="ldc-paper" width="{width}" height="{height}"/>'
        return "\n".join((head, named, f"<style>{CSS}</style>", paper, *self.out, "</svg>", ""))


class _Band:
    """Draws shapes, ``top`` pixels down the page."""

    def __init__(self, out: list[str], top: int) -> None:
        self.out, self.top = out, top

    def x(self, column: float) -> int:
        return EDGE + int(column * CELL) + CELL // 2

    def y(self, line: int) -> int:
        return self.top + line * LINE + LINE // 2

    def draw(self, drawing: Drawing) -> None:
        order = (Wire, Rail, Box, Symbol, Dot, Arrow, Label)
        for shape in sorted(_joined(drawing.shapes), key=lambda s: order.index(type(s))):
            self.shape(shape)

    def shape(self, shape: Shape) -> None:
        match shape:
            case Wire(x1, y1, x2, y2, on):
                if (x1, y1) != (x2, y2):
                    self.path("ldc-wire", on, f"M{self.x(x1)} {self.y(y1)}L{self.x(x2)} {self.y(y2)}")
            case Rail(x, y1, y2, local):
                reach = LINE // 2
                style = "ldc-rail ldc-local" if local else "ldc-rail"
                self.path(style, None, f"M{self.x(x)} {self.y(y1) - reach}V{self.y(y2) + reach}")
            case Box():
                self.box(shape)
            case Symbol():
                self.symbol(shape)
            case Dot(x, y, on):
                style = _style("ldc-dot", on)
                self.out.append(f'<circle class="{style}" cx="{self.x(x)}" cy="{self.y(y)}" r="3"/>')
            case Arrow(x, y, number, out, on):
                left, middle = self.x(x) - (8 if out else 2), self.y(y)
                self.path("ldc-arrow", on, f"M{left} {middle - 5}L{left + 10} {middle}L{left} {middle + 5}Z")
                text_x, anchor = (left + 14, "start") if out else (left - 4, "end")
                at = f'x="{text_x}" y="{middle + 4}" text-anchor="{anchor}"'
                self.out.append(f'<text class="ldc-next" {at}>{number}</text>')
            case Label():
                self.label(shape)

    def path(self, style: str, on: bool | None, data: str, mark: str | None = None) -> None:
        self.out.append(f'<path class="{_style(style, on, mark)}" d="{data}"/>')

    def box(self, box: Box) -> None:
        x, y = self.x(box.x), self.y(box.y)
        width, height = (box.width - 1) * CELL, (box.height - 1) * LINE
        if box.kind == "expression":
            y, height = y + HAIR, height - 2 * HAIR
        self.out.append(
            f'<rect class="{_style("ldc-box ldc-" + box.kind, box.on, box.mark)}" x="{x}" y="{y}" '
            f'width="{width}" height="{height}" rx="3"><title>{_text(box.full)}</title></rect>'
        )
        if box.kind == "block":
            self.path("ldc-rule", box.on, f"M{x + 1} {y + LINE + 10}H{x + width - 1}", box.mark)

    def symbol(self, symbol: Symbol) -> None:
        x, y, modifier = self.x(symbol.x), self.y(symbol.y), symbol.modifier
        self.out.append(f'<g class="{_style("ldc-symbol", symbol.on, symbol.mark)}">')
        self.out.append(f"<title>{_text(symbol.full)}</title>")
        self.out.append(f'<rect class="ldc-back" x="{x - 12}" y="{y - 12}" width="24" height="24" rx="4"/>')
        if symbol.kind == "contact":
            self.out.append(f'<path d="M{x - 8} {y - 10}V{y + 10}M{x + 8} {y - 10}V{y + 10}"/>')
        else:
            left, right = "a12.125 12.125 0 0 0 0 18", "a12.125 12.125 0 0 1 0 18"
            self.out.append(f'<path d="M{x - 4} {y - 9}{left}M{x + 4} {y - 9}{right}"/>')
        if modifier == "/":
            reach = 6 if symbol.kind == "contact" else 4
            self.out.append(f'<path d="M{x - reach} {y + 8}L{x + reach} {y - 8}"/>')
        elif modifier:
            self.out.append(f'<text x="{x}" y="{y + 4}" text-anchor="middle">'
                            f'{escape(modifier, quote=False)}</text>')
        self.out.append("</g>")

    def label(self, label: Label) -> None:
        if label.role == "caret":
            return
        anchors = NEAR if label.role in ("value", "tag") else ANCHOR
        x, y = self.x(label.x) + anchors[label.anchor], self.y(label.y) + 4
        full = f"<title>{_text(label.full)}</title>" if label.full else ""
        anchor = "" if label.anchor == "start" else f' text-anchor="{label.anchor}"'
        style = _style("ldc-" + ("text" if label.role == "expression" else label.role), label.on, label.mark)
        self.out.append(f'<text class="{style}" x="{x}" y="{y}"{anchor}>{full}{_text(label.text)}</text>')


def _joined(shapes: Iterable[Shape]) -> list[Shape]:
    """Level wires that continue each other with the same power become one, without a seam."""
    result = [s for s in shapes if not isinstance(s, Wire) or s.y1 != s.y2]
    level = [s for s in shapes if isinstance(s, Wire) and s.y1 == s.y2]
    level.sort(key=lambda w: (w.y1, str(w.on), w.x1, w.x2))
    for wire in level:
        last = result[-1] if result else None
        if isinstance(last, Wire) and (last.y1, last.y2, last.on) == (wire.y1, wire.y1, wire.on):
            if wire.x1 <= last.x2:
                result[-1] = replace(last, x2=max(last.x2, wire.x2))
                continue
        result.append(wire)
    return result


def _style(base: str, on: bool | None, mark: str | None = None) -> str:
    """Class names; a mark says more than power."""
    if mark:
        return f"{base} ldc-mark-{''.join(c for c in mark if c.isalnum() or c in '-_')}"
    return base if on is None else f"{base} ldc-on" if on else f"{base} ldc-off"


def _text(text: str) -> str:
    """Escaped, and without the characters that XML does not know."""
    return escape(_UNKNOWN.sub("\ufffd", text), quote=False)
