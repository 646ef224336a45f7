"""A whole POU on paper: its rungs in order, with numbers, headings and the comments before them."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable

from ldc.draw.arrange import Arrangement, arrange
from ldc.draw.labels import Options, comment_text
from ldc.draw.wrap import bands
from ldc.parser import ast
from ldc.records import record


@record
class Entry:
    """One rung of the sheet. ``number`` counts from 1."""

    number: int
    rung: ast.Rung
    found: Arrangement
    comments: tuple[str, ...]


@record
class Sheet:
    """``heading``: kind, name and title. ``fill``: columns of the widest rung; all rungs take these."""

    heading: tuple[str, ...]
    entries: tuple[Entry, ...]
    fill: int


def heading_of(rung: ast.Rung, number: int | None) -> dict[str, str]:
    """Number, name and title of a rung: those that it has."""
    parts = {"number": str(number or ""), "rung": rung.name or "", "title": rung.title or ""}
    return {role: " ".join(text.split()) for role, text in parts.items() if text}


def sheet_of(pou: ast.Pou, comments: Iterable[ast.Comment], options: Options) -> Sheet:
    """The sheet of a ladder POU; a body in another language gives one without rungs."""
    heading = tuple(part for part in (pou.kind, pou.name, pou.title) if part)
    if not isinstance(pou.body, ast.LadderBody):
        return Sheet(heading, (), 0)
    before = _comments_before(pou.body, comments)
    entries = tuple(
        Entry(number, rung, arrange(rung, options), before[number - 1])
        for number, rung in enumerate(pou.body.rungs, 1)
    )
    fill = max((piece.width for entry in entries for piece in bands(entry.found, options)), default=0)
    return Sheet(heading, entries, fill)


def _comments_before(body: ast.LadderBody, comments: Iterable[ast.Comment]) -> list[tuple[str, ...]]:
    """Per rung, the comments between the rung before (or the beginning of the body) and itself, and
    those behind it on its last line."""
    waiting = sorted(
        (c for c in comments if c.span.source is body.span.source), key=lambda comment: comment.span.start
    )
    starts = [comment.span.start for comment in waiting]
    result, last = [], body.span.start
    for rung in body.rungs:
        source, end = rung.span.source, rung.span.end
        line, _ = source.position(max(end - 1, 0))
        first, at = bisect_left(starts, last), bisect_left(starts, rung.span.start)
        own, after = waiting[first:at], bisect_left(starts, end)
        while after < len(waiting) and waiting[after].span.position[0] == line:
            own.append(waiting[after])
            end = waiting[after].span.end
            after += 1
        result.append(tuple(comment_text(comment.text) for comment in own))
        last = end
    return result
