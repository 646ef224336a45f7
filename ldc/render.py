"""Diagnostics as people read them: the source line, what is there, and what to do (DESIGN section 9)."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Sequence

from ldc.diagnostics import Diagnostic, Locate, Place, Severity
from ldc.records import record, replace
from ldc.source import SourceFile

SHOWN = 50
"""How many diagnostics are shown in full; the rest is counted."""

_TAB = 4
_ANSI = {
    "error": "1;31",
    "warning": "1;33",
    "note": "1;36",
    "help": "1;32",
    "title": "1",
    "frame": "34",
    "secondary": "34",
}


def paint(style: str, text: str, color: bool) -> str:
    """`text` in one of the styles of this page, or as it is when there is no colour."""
    return f"\x1b[{_ANSI[style]}m{text}\x1b[0m" if color and text else text


def render(
    diagnostics: Iterable[Diagnostic], *, color: bool = False, width: int = 100, limit: int = SHOWN,
    locate: Locate | None = None,
) -> str:
    """All findings with their source lines, and the summary; empty when there are none.

    `width` is that of the terminal in columns: source lines longer than it are cut around the label.
    Errors are shown before warnings when not all are, so that what stops the build is never hidden.
    `locate` tells where in a drawing a label is, and draws that rung.
    """
    found = list(diagnostics)
    if not found:
        return ""
    shown = found
    if len(found) > limit:
        keep = sorted(range(len(found)), key=lambda i: found[i].severity is not Severity.ERROR)[:limit]
        shown = [found[i] for i in sorted(keep)]
    blocks = [_block(diagnostic, color, width, locate) for diagnostic in shown]
    if len(found) > len(shown):
        blocks.append(f"... and {len(found) - len(shown)} more, not shown\n")
    worst = "error" if any(d.severity is Severity.ERROR for d in found) else "warning"
    blocks.append(paint(worst, summary(found), color) + "\n")
    return "\n".join(blocks)


def summary(diagnostics: Iterable[Diagnostic]) -> str:
    """`2 errors, 1 warning`; `no problems` when there are none."""
    counts = dict.fromkeys(Severity, 0)
    for diagnostic in diagnostics:
        counts[diagnostic.severity] += 1
    return ", ".join(plural(n, severity.value) for severity, n in counts.items() if n) or "no problems"


def plural(count: int, noun: str) -> str:
    """`1 rung`, `2 rungs`."""
    return f"{count:,} {noun}" + ("" if count == 1 else "s")


def visible(text: str) -> str:
    """`text` without characters that a terminal would obey: they are shown as their pictures."""
    return text if text.isprintable() else "".join(map(_cell, text))


@record
class _Mark:
    """A label on one line: character columns [start, end) counted from 0."""

    start: int
    end: int
    text: str
    primary: bool


def _block(diagnostic: Diagnostic, color: bool, width: int, locate: Locate | None) -> str:
    severity = diagnostic.severity.value
    head = paint(severity, f"{severity}[{diagnostic.code}]", color)
    lines = [head + paint("title", f": {visible(diagnostic.message)}", color)]
    marks = _marks(diagnostic)
    gutter = max((len(str(line)) for group in marks.values() for line in group), default=0)
    for index, (source, group) in enumerate(marks.items()):
        lines += _excerpt(diagnostic, source, group, index == 0, gutter, color, width)
    place = locate(diagnostic.primary.span, severity) if locate and diagnostic.primary else None
    if place:
        lines += _place(place, gutter, color, width)
    if diagnostic.help:
        if marks:
            lines.append(" " * gutter + paint("frame", " |", color))
        first, *rest = _visible_lines(diagnostic.help)
        lines.append(
            " " * (gutter + 1) + paint("frame", "= ", color) + paint("help", "help", color) + f": {first}"
        )
        lines += [" " * (gutter + 9) + line for line in rest]
    return "\n".join(lines) + "\n"


def _place(place: Place, gutter: int, color: bool, width: int) -> list[str]:
    """Where in a drawing it is, and the rung."""
    bar = " " * (gutter + 1) + paint("frame", "|", color)
    where = ", ".join(filter(None, (place.pou, place.rung, f"{place.element} {place.position}".strip())))
    lines = [bar, " " * (gutter + 1) + paint("frame", "= ", color) + f"in {visible(where)}"]
    if place.picture is not None:
        lines.append(bar)
        lines += [f"{bar} {line}".rstrip() for line in place.picture(width - gutter - 3, color)]
    return lines


def _visible_lines(text: str) -> list[str]:
    return [visible(line) for line in text.splitlines()]


def _marks(diagnostic: Diagnostic) -> dict[SourceFile, dict[int, list[_Mark]]]:
    """Marks by file (that of the primary label first) and line number."""
    result: dict[SourceFile, dict[int, list[_Mark]]] = {}
    labels = [(diagnostic.primary, True)] if diagnostic.primary else []
    for label, primary in [*labels, *((label, False) for label in diagnostic.secondary)]:
        source, (line, column) = label.span.source, label.span.position
        length = len(source.line(line))
        start = min(column - 1, length)
        end, text = start + label.span.end - label.span.start, visible(" ".join(label.text.split()))
        if end > length:
            last = source.position(max(label.span.end - 1, label.span.start))[0]
            end = length
            if last > line:
                text = f"{text} (up to line {last})".lstrip()
        mark = _Mark(start, max(end, start + 1), text, primary)
        result.setdefault(source, {}).setdefault(line, []).append(mark)
    return result


def _excerpt(
    diagnostic: Diagnostic,
    source: SourceFile,
    group: dict[int, list[_Mark]],
    first: bool,
    gutter: int,
    color: bool,
    width: int,
) -> list[str]:
    """The file's name and place, then its marked lines."""
    line = diagnostic.primary.span.position[0] if first and diagnostic.primary else min(group)
    column = min((m for m in group[line]), key=lambda m: not m.primary).start + 1
    arrow = "-->" if first else ":::"
    frame = paint("frame", "|", color)
    bar = " " * (gutter + 1) + frame
    lines = [" " * gutter + paint("frame", arrow, color) + f" {visible(source.path)}:{line}:{column}", bar]
    previous = None
    for number in sorted(group):
        if previous is not None and number - previous > 2:
            lines.append(paint("frame", "...", color))
        elif previous is not None and number - previous == 2:
            text, *_ = _window(source.line(number - 1), 0, width - gutter - 4)
            lines.append(_numbered(number - 1, gutter, text, color))
        lines += _line(source.line(number), number, group[number], gutter, color, width)
        previous = number
    return lines


def _numbered(number: int, gutter: int, text: str, color: bool) -> str:
    return (paint("frame", f"{number:>{gutter}} |", color) + f" {text}").rstrip()


def _line(text: str, number: int, marks: Sequence[_Mark], gutter: int, color: bool, width: int) -> list[str]:
    """One source line, the carets under it, and the texts of its labels."""
    focus = min(marks, key=lambda m: not m.primary).start
    shown, columns, inside = _window(text, focus, max(width - gutter - 4, 20))
    marks = [
        m if m.start in inside else replace(m, text=f"{m.text} (column {m.start + 1})".lstrip())
        for m in marks
    ]
    bar = " " * (gutter + 1) + paint("frame", "|", color) + " "
    placed = sorted(
        ((columns(m.start), max(columns(m.end), columns(m.start) + 1), m) for m in marks),
        key=lambda p: (p[0], p[1], not p[2].primary),
    )
    under = [(" ", "title")] * max(end for _, end, _ in placed)
    for start, end, mark in sorted(placed, key=lambda p: p[2].primary):
        style = _style(mark)
        under[start:end] = [("^" if mark.primary else "-", style)] * (end - start)
    *hanging, (_, end, last) = placed
    row = "".join(paint(style, char, color and char != " ") for char, style in under)
    if end == len(under):
        row += " " + paint(_style(last), last.text, color)
    else:
        hanging.append(placed[-1])
    lines = [_numbered(number, gutter, shown, color), bar + row.rstrip()]
    waiting = [p for p in hanging if p[2].text]
    while waiting:
        start, _, mark = waiting.pop()
        lead, at = "", 0
        for column, style in sorted({(s, _style(m)) for s, _, m in waiting if s < start}):
            if column >= at:
                lead += " " * (column - at) + paint(style, "|", color)
                at = column + 1
        lines.append(bar + lead + " " * (start - at) + paint(_style(mark), mark.text, color))
    return lines


def _style(mark: _Mark) -> str:
    return "error" if mark.primary else "secondary"


def _window(text: str, focus: int, room: int):
    """The part of a line around `focus` that fits, its map from characters to columns, and which they are."""
    low, high = 0, len(text)
    if len(text) > room:
        low = max(0, min(focus - room // 3, len(text) - room + 2))
        high = min(len(text), low + room - 2)
    cells = [_cell(c) for c in text[low:high]]
    starts, at = [], 1 if low else 0
    for cell in cells:
        starts.append(at)
        at += sum(map(_columns, cell))
    starts.append(at)
    shown = ("…" if low else "") + "".join(cells) + ("…" if high < len(text) else "")

    def columns(character: int) -> int:
        return starts[min(max(character - low, 0), len(starts) - 1)]

    return shown, columns, range(low, high + 1)


def _cell(char: str) -> str:
    if char == "\t":
        return " " * _TAB
    code = ord(char)
    if code < 0x20:
        return chr(0x2400 + code)
    if code == 0x7F:
        return "\u2421"
    return char if char == " " or char.isprintable() or unicodedata.category(char) == "Zs" else "\ufffd"


def _columns(char: str) -> int:
    if unicodedata.combining(char):
        return 0
    return 2 if unicodedata.east_asian_width(char) in "WF" else 1
