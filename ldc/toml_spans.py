"""Where the keys and values of a TOML text stand: tomllib reads the values but tells no places."""

from __future__ import annotations

import re

from ldc.patterns import Pattern
from ldc.records import record
from ldc.source import SourceFile, Span

_BLANK = Pattern(r"(?:[ \t\r\n]|#[^\n]*)*")
_KEY = Pattern(r"""[ \t]*("(?:\\.|[^"\\\n])*"|'[^'\n]*'|[A-Za-z0-9_-]+)[ \t]*""")
_STRING = Pattern(r'"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'', re.DOTALL)
_DATE = Pattern(r"\d{4}-\d\d-\d\d \d\d:[^\s,\]}#]*")  # a date and its time may have a space between them
_BARE = Pattern(r"[^\s,\[\]{}#\"']+")


@record
class Entry:
    """A key (or the header of a table) and its value; the value of a table is its header."""

    key: Span
    value: Span


def toml_spans(source: SourceFile) -> dict[tuple[str | int, ...], Entry]:
    """Places by path (`("run", "period")`) of a text that tomllib has accepted.

    An item of an array has its number in the path (`("requires", "inputs", 0, "type")`); its key is the
    item itself. The tables of an array of tables share one path, the first one's place counts.
    """
    return _Places(source).found


class _Places:
    """Walks a text once. Brackets nest no deeper than tomllib accepts."""

    def __init__(self, source: SourceFile) -> None:
        self.source, self.text = source, source.text
        self.found: dict[tuple[str | int, ...], Entry] = {}
        text, at = source.text, 0
        prefix: tuple[str | int, ...] = ()
        while (at := _BLANK.match(text, at).end()) < len(text):
            start = at
            if text[at] == "[":
                at += 2 if text.startswith("[[", at) else 1
                prefix, at = self._key(at)
                at = text.find("]", at)
                at = len(text) if at < 0 else at + (2 if text.startswith("]]", at) else 1)
                self._add(prefix, Span(source, start, at), Span(source, start, at))
            else:
                at = self._entry(prefix, at)

    def _add(self, path: tuple[str | int, ...], key: Span, value: Span) -> None:
        self.found.setdefault(path, Entry(key, value))

    def _entry(self, prefix: tuple[str | int, ...], start: int) -> int:
        """`key = value` from `start`; where it ends."""
        path, at = self._key(start)
        key = Span(self.source, start, start + len(self.text[start:at].rstrip()))
        begin = _BLANK.match(self.text, at + 1).end()
        end = self._value((*prefix, *path), begin)
        self._add((*prefix, *path), key, Span(self.source, begin, end))
        return end

    def _key(self, at: int) -> tuple[tuple[str, ...], int]:
        """A dotted key from `at`, and where it ends."""
        parts = []
        while match := _KEY.match(self.text, at):
            part = match[1]
            parts.append(part[1:-1] if part[0] in "\"'" else part)
            at = match.end()
            if not self.text.startswith(".", at):
                break
            at += 1
        return tuple(parts), max(at, 1)

    def _value(self, path: tuple[str | int, ...], at: int) -> int:
        """The end of the value that begins at `at`."""
        text = self.text
        if text[at : at + 1] in ("[", "{"):
            return self._items(path, at)
        match = _STRING.match(text, at) or _DATE.match(text, at) or _BARE.match(text, at)
        return match.end() if match else at + 1

    def _items(self, path: tuple[str | int, ...], at: int) -> int:
        """The end of an array or inline table that begins at `at`."""
        text, table, number = self.text, self.text[at] == "{", 0
        at = _BLANK.match(text, at + 1).end()
        while at < len(text) and text[at] not in "]}":
            start = at
            if table:
                at = self._entry(path, at)
            else:
                at = self._value((*path, number), at)
                self._add((*path, number), Span(self.source, start, at), Span(self.source, start, at))
            number += 1
            at = _BLANK.match(text, max(at, start + 1)).end()
            if text[at : at + 1] == ",":
                at = _BLANK.match(text, at + 1).end()
        return min(at + 1, len(text))
