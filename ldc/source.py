"""Source files and spans: where every thing that we know about was written."""

from __future__ import annotations

from bisect import bisect_right

from ldc.records import entity, field, record


def as_text(path: str) -> str:
    """A path whose bytes are no UTF-8, which Python keeps as lone surrogates, with escapes in their place."""
    return path.encode("utf-8", "backslashreplace").decode()


@entity
class SourceFile:
    """One text that is compiled. ``path`` is what the user typed, for messages only."""

    path: str
    text: str
    _line_starts: list[int] = field(default_factory=list, repr=False)

    @property
    def name(self) -> str:
        """The path as text that can be written in any file."""
        return as_text(self.path)

    @property
    def line_starts(self) -> list[int]:
        """Offsets at which lines begin. Looked up when the first place is asked for: most texts are right."""
        starts = self._line_starts
        if not starts:
            starts.append(0)
            at = self.text.find("\n")
            while at >= 0:
                starts.append(at + 1)
                at = self.text.find("\n", at + 1)
        return starts

    def position(self, offset: int) -> tuple[int, int]:
        """Line and column, both counted from 1, of a character offset."""
        line = bisect_right(self.line_starts, offset)
        return line, offset - self.line_starts[line - 1] + 1

    def line(self, number: int) -> str:
        """The text of line ``number`` (from 1) without its line end; empty past the last."""
        if not 1 <= number <= len(self.line_starts):
            return ""
        start = self.line_starts[number - 1]
        end = self.line_starts[number] if number < len(self.line_starts) else len(self.text)
        return self.text[start:end].rstrip("\r\n")

    def line_span(self, number: int) -> Span:
        """The text of line ``number`` (from 1) without the blanks around it."""
        text = self.line(number)
        start = self.line_starts[min(max(number, 1), len(self.line_starts)) - 1]
        return Span(self, start + len(text) - len(text.lstrip()), start + max(len(text.rstrip()), 1))


@record
class Span:
    """Characters ``start`` (inclusive) to ``end`` (exclusive) of a source file."""

    source: SourceFile
    start: int
    end: int

    @property
    def text(self) -> str:
        return self.source.text[self.start : self.end]

    @property
    def position(self) -> tuple[int, int]:
        """Line and column, from 1, of the first character."""
        return self.source.position(self.start)

    def to(self, other: Span) -> Span:
        """The span from the start of this one to the end of ``other``."""
        return Span(self.source, self.start, max(self.end, other.end))

    def __str__(self) -> str:
        line, column = self.position
        return f"{self.source.path}:{line}:{column}"
