"""Where a finding is in a drawing: POU, rung, element and position, and the rung with the element marked."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator
from itertools import accumulate

from ldc.diagnostics import Place
from ldc.draw.excerpt import excerpt
from ldc.draw.figures import drawn
from ldc.draw.labels import BlockPins, shorten, standard_pins
from ldc.parser import ast, format_of
from ldc.parser.sfc import SfcBody, rungs_of
from ldc.parser.unparse import expr_text
from ldc.records import is_record, record
from ldc.source import Span

_LONGEST = 60
_WORDS = {"/": "closed ", "S": "set ", "R": "reset ", "P": "rising edge ", "N": "falling edge "}


class Locator:
    """Finds places in sources that are drawings: those in the formats of other tools. A source in a text
    language shows itself, so nothing is found in it. ``pins_of``: see ``ldc.draw.labels.Options``."""

    def __init__(
        self, files: Iterable[ast.File], pins_of: Callable[[ast.Block], BlockPins | None] = standard_pins
    ) -> None:
        self.files = {file.source.path: file for file in files}
        self.pins_of = pins_of
        self._drawings: dict[str, _Drawing | None] = {}

    def __call__(self, span: Span, style: str) -> Place | None:
        """The place of a span; ``style`` (error, warning, note) is that of its mark. Offsets count, not the
        identity of the source: readers make twins of a text, as long as it is."""
        path = span.source.path
        if path not in self._drawings:
            file = self.files.get(path)
            foreign = format_of(file.source) if file is not None else None
            self._drawings[path] = _Drawing(file, foreign.position) if foreign else None
        drawing = self._drawings[path]
        return drawing.place(span, style, self.pins_of) if drawing is not None else None


class _Drawing:
    """One file: its POUs in the order of the text. Those that a reader adds lie inside of others."""

    def __init__(self, file: ast.File, position: Callable[[Span], str] | None) -> None:
        self.position = position
        self.pous: list[ast.Pou] = []
        for pou in sorted(file.pous, key=lambda p: (p.span.start, -p.span.end)):
            if pou.span.source.path == file.source.path and (
                    not self.pous or pou.span.start >= self.pous[-1].span.end):
                self.pous.append(pou)
        self.elements: dict[int, _Elements] = {}

    def place(
        self, span: Span, style: str, pins_of: Callable[[ast.Block], BlockPins | None]
    ) -> Place | None:
        index = bisect_right(self.pous, span.start, key=lambda pou: pou.span.start) - 1
        if index < 0 or span.end > self.pous[index].span.end:
            return None
        pou = self.pous[index]
        name = f"{pou.kind} {pou.name}"
        body = pou.body
        if isinstance(body, SfcBody) or pou.actions:
            body = ast.LadderBody(rungs_of(pou), pou.span)
        if not isinstance(body, ast.LadderBody):
            return Place(name)
        if index not in self.elements:
            self.elements[index] = _Elements(body)
        hit = self.elements[index].at(span)
        at = hit.item.span if hit is not None else span
        inside = body.span.start <= at.start < body.span.end
        position = self.position(at) if self.position is not None and inside else ""
        if hit is None:
            return Place(name, position=position)

        def picture(width: int, colour: bool) -> list[str]:
            return excerpt(hit.rung, hit.item, style, width, colour, pins_of)

        words = rung_words(hit.rung, hit.number), element_words(hit.item, hit.pin)
        return Place(name, *words, position, picture)


@record
class _Hit:
    """``number`` of the rung from 1; ``pin`` of a block when the place is there."""

    rung: ast.Rung
    number: int
    item: ast.Item
    pin: ast.Pin | None

    @property
    def added(self) -> bool:
        """Whether a reader needed the element for what is drawn otherwise."""
        return isinstance(self.item, ast.Contact) and isinstance(self.item.expr, ast.Literal)


class _Elements:
    """The spans in the rungs of a body, and the element that each belongs to."""

    def __init__(self, body: ast.LadderBody) -> None:
        self.exact: dict[tuple[int, int], _Hit] = {}
        rungs = list(body.rungs)
        for before, rung in reversed(body.unread):
            rungs.insert(before, rung)
        for number, rung in enumerate(rungs, 1):
            for item in drawn(rung):
                for pin, span in _spans(item):
                    key = span.start, span.end
                    if key not in self.exact or self.exact[key].added:
                        self.exact[key] = _Hit(rung, number, item, pin)
        self.spans = sorted(self.exact)
        self.reach = list(accumulate((end for _, end in self.spans), max))

    def at(self, span: Span) -> _Hit | None:
        """The smallest element or part of one that holds a span."""
        found = self.exact.get((span.start, span.end))
        if found is not None:
            return found
        best: tuple[int, int] | None = None
        index = bisect_right(self.spans, (span.start, float("inf"))) - 1
        while index >= 0 and self.reach[index] >= span.end:
            start, end = self.spans[index]
            if end >= span.end and (best is None or end - start < best[1] - best[0]):
                best = start, end
            index -= 1
        return self.exact[best] if best is not None else None


def _spans(item: ast.Item) -> Iterator[tuple[ast.Pin | None, Span]]:
    """The spans of an element and of what is written in it, each with the pin that it is at. Networks at
    pins are elements of their own."""
    work: list[tuple[ast.Pin | None, object]] = [(None, item)]
    while work:
        pin, node = work.pop()
        if isinstance(node, tuple):
            work += [(pin, part) for part in node]
        elif is_record(node) and not isinstance(node, Span | ast.Branches | ast.Path):
            pin = node if isinstance(node, ast.Pin) else pin
            yield pin, node.span
            work += [(pin, getattr(node, name)) for name in node.__match_args__ if name != "span"]


def rung_words(rung: ast.Rung, number: int) -> str:
    """``rung 3 `seal_in` "Start and stop"``."""
    name = f" `{rung.name}`" if rung.name else ""
    title = f' "{shorten(" ".join(rung.title.split()), _LONGEST)}"' if rung.title else ""
    return f"rung {number}{name}{title}"


def element_words(item: ast.Item, pin: ast.Pin | None = None) -> str:
    """``closed contact `stop` ``, ``pin `PV` of block `c1: CTU` ``."""
    match item:
        case ast.Contact(modifier, expr):
            words = f"{_WORDS.get(modifier, '')}contact `{_short(expr)}`"
        case ast.Coil(modifier, target):
            words = f"{_WORDS.get(modifier, '')}coil `{_short(target)}`"
        case ast.Block(instance, type_):
            words = f"block `{_short(instance)}: {type_}`" if instance else f"function `{type_}`"
        case ast.Jump(target):
            words = f"jump to `{target}`"
        case ast.Junction(name):
            words = f"junction `{name}`"
        case ast.Branches():
            words = "branches"
    return f"pin `{pin.name}` of {words}" if pin is not None and pin.name else words


def _short(expr: ast.Expr) -> str:
    return shorten(expr_text(expr), _LONGEST)
