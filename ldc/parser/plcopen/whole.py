"""What is asked of the whole text of a file: whether it is XML, as expat says; names of attributes.

A document type is refused.
"""

from __future__ import annotations

import re
from xml.parsers import expat

from ldc.patterns import Pattern

DOCTYPE = "<!DOCTYPE"
_DECLARATION = 200
"""Characters in which a file says that it is XML, and in which encoding."""
_NAME = Pattern(r"""\s(?!(?:localId|refLocalId|formalParameter|x|y|width|height|name)=)
    ([^\s=<>"'/]++)\s*+=\s*+["']""", re.VERBOSE)
"""A name, but for those that most of a drawing consists of."""

Fault = tuple[int, str]
"""Where a text ceases to be XML that is read, and why: `DOCTYPE` for a document type."""


def asked(text: str) -> tuple[Fault | None, frozenset[str]]:
    """What is wrong with a text, and the names of its attributes."""
    return fault(text), names(text)


def fault(text: str, end: int | None = None) -> Fault | None:
    """What is wrong with a text up to ``end``; None when nothing is."""
    skip = len(text) - len(text.lstrip())
    data = text[skip:end].encode("utf-8", "replace")
    parser = expat.ParserCreate("utf-8")
    parser.StartDoctypeDeclHandler = _refused
    try:
        parser.Parse(data, end is None)
    except _DocumentType:
        return max(0, text.find(DOCTYPE)), DOCTYPE
    except expat.ExpatError as error:
        before = data[: max(0, parser.ErrorByteIndex)].decode("utf-8", "ignore")
        return min(skip + len(before), len(text)), expat.ErrorString(error.code) or "no XML"
    return None


def names(text: str) -> frozenset[str]:
    """The names of attributes, and of what looks like one, but for some that each drawing has."""
    return frozenset(_NAME.findall(text, max(text.find("?>", 0, _DECLARATION), 0)))


def _refused(*_: object) -> None:
    raise _DocumentType


class _DocumentType(Exception):
    """A document type begins."""
