"""What tells the files of OpenPLC Editor 4 from those of this project, by their content."""

from __future__ import annotations

import re

from ldc.patterns import Pattern
from ldc.source import SourceFile, Span

FORMAT = "OpenPLC"
_PROJECT = Pattern(r'\s*\{\s*"(?:meta|data)"\s*:')
DRAWN = Pattern(r'\{\s*"(?:name|rungs|rung)"\s*:')
"""The JSON of a drawing, behind the declarations of its POU."""

_LATE_ADDRESS = Pattern(r":\s*[A-Za-z_]\w*(?:\s*\[[^\]\n]{1,80}\])?\s+AT\s+%", re.IGNORECASE)
_HEAD = Pattern(r"(?>(?:\s++|\(\*(?s:.*?)\*\))*)(?:PROGRAM|FUNCTION|FUNCTION_BLOCK)\s", re.IGNORECASE)
_OTHER_LANGUAGES = (".py", ".cpp")
_PLACE = Pattern(r"(?:\A|[\\/])pous[\\/](?:programs|functions|function-blocks)[\\/][^\\/]+\.(?:st|il)\Z",
                 re.IGNORECASE)


_POSITION = Pattern(
    r'"position"\s*:\s*\{\s*"x"\s*:\s*(-?\d+)[\d.]*\s*,\s*"y"\s*:\s*(-?\d+)[\d.]*\s*\}')
_NEAR = 50_000
"""Characters before the name of a node in which its position is written."""


def position(span: Span) -> str:
    """Where the node that has a name is drawn, in words: `at (40, 60)`; nodes begin with their position."""
    found = _POSITION.findall(span.source.text, max(0, span.start - _NEAR), span.start)
    return f"at ({found[-1][0]}, {found[-1][1]})" if found else ""


def kind_of(source: SourceFile) -> str | None:
    """``project``, ``pou``, or None when it is no such file. A POU in a text language is told by its place in
    the project, or by an address behind the type (``start : BOOL AT %IX0.0;``), which IEC 61131-3 writes
    before the colon."""
    text = source.text
    if _PROJECT.match(text):
        return "project"
    if not _HEAD.match(text):
        return None
    if source.path.lower().endswith(_OTHER_LANGUAGES) or _PLACE.search(source.path):
        return "pou"
    return "pou" if DRAWN.search(text) or _LATE_ADDRESS.search(text) else None
