"""Structured Text inside of the XML, read like that of .st files."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.parser.findings import TooMany
from ldc.parser.lexer import lex
from ldc.parser.statements import StatementBody
from ldc.parser.structured import read_body
from ldc.parser.units import Units
from ldc.source import Span


def statements(text: Span, diagnostics: Diagnostics) -> StatementBody:
    """The statements in a part of a text; what cannot be read is left out and told."""
    tokens = lex(text.source, text.start, text.end, statements=True)
    try:
        return read_body(Units(tokens, diagnostics), 0, len(tokens.types), text)
    except TooMany:
        return StatementBody((), text)
