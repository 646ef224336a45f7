"""Structured Text inside of the XML, read like that of .st files."""

from __future__ import annotations

import re

from ldc.diagnostics import Diagnostics
from ldc.parser.findings import TooMany
from ldc.parser.foreign import Reading
from ldc.parser.lexer import Tokens, lex
from ldc.parser.plcopen import dialect, texts
from ldc.parser.statements import StatementBody
from ldc.parser.structured import read_body
from ldc.parser.units import Units
from ldc.patterns import Pattern
from ldc.source import Span

_WITHOUT_EFFECT = Pattern(
    r"\{\s*(attribute|warning|info|text|region|endregion|analysis|flow|nobp|bp|docu|messageguid)\b",
    re.IGNORECASE)

_OTHER_CODE = Pattern(r"^[ \t]*(#include\b|void\s+(?:setup|loop)\s*\(\s*\))", re.MULTILINE)
"""How a program in C++ begins, which OpenPLC keeps where statements stand."""


def statements(text: Span, diagnostics: Diagnostics) -> StatementBody:
    """The statements in a part of a text; what cannot be read is left out and told."""
    code = _OTHER_CODE.search(text.source.text, text.start, text.end)
    if code is not None:
        span = Span(text.source, code.start(1), code.end(1))
        Reading(text.source, "PLCopen XML", diagnostics).unsupported(
            span, "a body in C or C++", "write it in Structured Text, or as a component in C", "no statement")
        return StatementBody((), text)
    tokens = lex(text.source, text.start, text.end, statements=True)
    _tell_pragmas(tokens, Reading(text.source, "PLCopen XML", diagnostics))
    tokens = dialect.standard(tokens)
    try:
        return read_body(Units(tokens, diagnostics), 0, len(tokens.types), text)
    except TooMany:
        return StatementBody((), text)


def _tell_pragmas(tokens: Tokens, reading: Reading) -> None:
    """Pragmas tell an editor or a compiler something; others hold text for a C compiler, or conditions."""
    told = False
    for first, last in dialect.pragmas(tokens):
        span = tokens.span(first, last)
        if not _WITHOUT_EFFECT.match(span.text):
            reading.unsupported(span, f"the pragma `{texts.line(span.text)}`",
                                "write what it does in Structured Text", "for another compiler")
        elif not told:
            told = True
            reading.left_out(span, f"the pragma `{texts.line(span.text)}`", "for another compiler")
