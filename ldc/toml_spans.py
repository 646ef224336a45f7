"""Where the keys and values of a TOML text stand: tomllib reads the values but tells no places."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ldc.source import SourceFile, Span

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_KEY = re.compile(r"""[ \t]*("(?:\\.|[^"\\\n])*"|'[^'\n]*'|[A-Za-z0-9_-]+)[ \t]*""")
_STRING = re.compile(r'"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'', re.DOTALL)
_BARE = re.compile(r"[^\s,\[\]{}#\"']+")


@dataclass(frozen=True, slots=True)
class Entry:
    """A key (or the header of a table) and its value; the value of a table is its header."""

    key: Span
    value: Span


def toml_spans(source: SourceFile) -> dict[tuple[str, ...], Entry]:
    """Places by path (`("run", "period")`) of a text that tomllib has accepted.

    Inside arrays and inline tables nothing is looked up: their place is that of the whole value. The
    tables of an array of tables share one path, the first one's place counts.
    """
    text, at = source.text, 0
    prefix: tuple[str, ...] = ()
    found: dict[tuple[str, ...], Entry] = {}
    while (at := _BLANK.match(text, at).end()) < len(text):
        start = at
        header = text[at] == "["
        if header:
            at += 2 if text.startswith("[[", at) else 1
        path, at = _key(text, at)
        key = Span(source, start, at)
        if header:
            at = text.find("]", at)
            at = len(text) if at < 0 else at + (2 if text.startswith("]]", at) else 1)
            prefix = path
            found.setdefault(path, Entry(Span(source, start, at), Span(source, start, at)))
            continue
        begin = _BLANK.match(text, at + 1).end()
        at = _value(text, begin)
        found.setdefault(
            prefix + path,
            Entry(Span(source, key.start, start + len(key.text.rstrip())), Span(source, begin, at)),
        )
    return found


def _key(text: str, at: int) -> tuple[tuple[str, ...], int]:
    """A dotted key from `at`, and where it ends."""
    parts = []
    while match := _KEY.match(text, at):
        part = match[1]
        parts.append(part[1:-1] if part[0] in "\"'" else part)
        at = match.end()
        if not text.startswith(".", at):
            break
        at += 1
    return tuple(parts), max(at, 1)


def _value(text: str, at: int) -> int:
    """The end of the value that begins at `at`."""
    depth = 0
    while at < len(text):
        char = text[at]
        if char in "\"'":
            match = _STRING.match(text, at)
            at = match.end() if match else at + 1
        elif char in "[{":
            depth, at = depth + 1, at + 1
        elif char in "]}":
            depth, at = depth - 1, at + 1
        elif depth and char in ", \t\r\n#":
            at = at + 1 if char == "," else _BLANK.match(text, at).end()
            continue
        else:
            match = _BARE.match(text, at)
            at = match.end() if match else at + 1
        if depth <= 0 and (at >= len(text) or text[at] in " \t\r\n#,"):
            # A date and its time may have a space between them.
            if not (depth == 0 and re.match(r" \d\d:", text[at : at + 4])):
                return at
    return at
