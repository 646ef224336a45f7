"""A ClassicLadder project file: small files between ``_FILE-name`` and ``_/FILE-name``, as lines."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from ldc.parser.foreign import Reading
from ldc.records import record
from ldc.source import Span

MAX_LINES = 500_000
_INTEGER = re.compile(r"\s*(-?\d{1,9})\s*\Z", re.ASCII)


@record
class Line:
    text: str
    span: Span

    def integers(self) -> list[int] | None:
        """The numbers between commas; None when something is no number."""
        found = [_INTEGER.match(part) for part in self.text.split(",")]
        return [int(match[1]) for match in found] if all(found) else None


@dataclass(slots=True)
class Part:
    """One of the files. ``settings``: lines ``#KEY=value`` and ``KEY=value`` by key; ``lines``: the others,
    without those that begin with ``;``, blank ones too."""

    name: str
    span: Span
    settings: dict[str, Line] = field(default_factory=dict)
    lines: list[Line] = field(default_factory=list)

    @property
    def written(self) -> list[Line]:
        """The lines that say something."""
        return [line for line in self.lines if line.text.strip()]

    def setting(self, key: str) -> str:
        return self.settings[key].text if key in self.settings else ""

    def integer(self, key: str, default: int) -> int:
        match = _INTEGER.match(self.setting(key))
        return int(match[1]) if match else default


def parts(reading: Reading) -> dict[str, Part]:
    """The files by name. What the container breaks is told (LD0150), what is complete is read."""
    found: dict[str, Part] = {}
    current: Part | None = None
    at = 0
    for number, text in enumerate(reading.source.text.split("\n")):
        span = reading.span(at, at + len(text))
        at += len(text) + 1
        if number >= MAX_LINES:
            reading.too_large(span, MAX_LINES, "lines")
            return found
        if text.startswith("_FILE-"):
            if current is not None:
                reading.malformed(current.span, f"{current.name} has no end", "begins here")
            current = Part(text[6:].strip(), span)
        elif text.startswith("_/FILE-"):
            if current is not None:
                found[current.name] = current
            current = None
        elif current is not None:
            _add(current, text, span)
        elif text.strip() == "_/FILES_CLASSICLADDER":
            return found
        elif text.strip() not in ("", "_FILES_CLASSICLADDER"):
            reading.malformed(span, f"`{text[:40]}` stands outside of the files")
            return found
    reading.malformed(reading.span(at - 1, at - 1), "the project has no end", "the file ends here")
    return found


def _add(part: Part, text: str, span: Span) -> None:
    if text.startswith(";"):
        return
    key, separator, value = text.lstrip("#").partition("=")
    if separator and (text.startswith("#") or part.name.endswith(".txt")):
        start = span.end - len(value)
        part.settings[key] = Line(value, Span(span.source, start, span.end))
    elif not text.startswith("#"):
        part.lines.append(Line(text, span))
