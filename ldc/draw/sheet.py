"""A whole POU on paper: its rungs in order, with numbers, headings and the comments before them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ldc.draw.arrange import Arrangement, arrange
from ldc.draw.labels import Options, comment_text
from ldc.draw.wrap import bands
from ldc.parser import ast


@dataclass(frozen=True, slots=True)
class Entry:
    """One rung of the sheet. ``number`` counts from 1."""

    number: int
    rung: ast.Rung
    found: Arrangement
    comments: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Sheet:
    """``fill``: columns of the widest rung that fits the page; all rungs take these."""

    heading: str
    entries: tuple[Entry, ...]
    fill: int


def heading_of(rung: ast.Rung, number: int | None) -> str:
    """Number, name and title of a rung, those that it has, two blanks between."""
    parts = (str(number) if number is not None else None, rung.name, rung.title)
    return "  ".join(part for part in parts if part)


def sheet_of(pou: ast.Pou, comments: Iterable[ast.Comment], options: Options) -> Sheet:
    """The sheet of a ladder POU; a body in another language gives one without rungs."""
    heading = "  ".join(part for part in (pou.kind, pou.name, pou.title) if part)
    rungs = pou.body.rungs if isinstance(pou.body, ast.LadderBody) else ()
    before = _comments_before(rungs, comments)
    entries = tuple(
        Entry(number, rung, arrange(rung, options), before[number - 1]) for number, rung in enumerate(rungs, 1)
    )
    fill = max((piece.width for entry in entries for piece in bands(entry.found, options)), default=0)
    return Sheet(heading, entries, fill)


def _comments_before(
    rungs: tuple[ast.Rung, ...], comments: Iterable[ast.Comment]
) -> list[tuple[str, ...]]:
    """Per rung, the comments between the rung before (its line's end) and itself."""
    result = []
    waiting = sorted(comments, key=lambda comment: comment.span.start)
    last = 0
    for rung in rungs:
        source, start = rung.span.source, rung.span.start
        own = [c for c in waiting if c.span.source is source and last <= c.span.start < start]
        result.append(tuple(comment_text(c.text) for c in own))
        last = rung.span.end
    return result
