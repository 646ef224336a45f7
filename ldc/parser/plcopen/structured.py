"""Structured Text inside of the XML, read like that of .st files."""

from __future__ import annotations

import re

from ldc.diagnostics import Diagnostics
from ldc.parser.findings import TooMany
from ldc.parser.foreign import Reading
from ldc.parser.lexer import Tokens, lex
from ldc.parser.plcopen import clock, dialect, texts
from ldc.parser.plcopen.guarded import Additions
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


def statements(text: Span, diagnostics: Diagnostics, more: Additions | None = None) -> StatementBody:
    """The statements in a part of a text; what cannot be read is left out and told. ``more`` takes what the
    body needs beside what is declared, where that is possible."""
    code = _OTHER_CODE.search(text.source.text, text.start, text.end)
    if code is not None:
        span = Span(text.source, code.start(1), code.end(1))
        Reading(text.source, "PLCopen XML", diagnostics).unsupported(
            span, "a body in C or C++", "write it in Structured Text, or as a component in C", "no statement")
        return StatementBody((), text)
    written = lex(text.source, text.start, text.end, statements=True)
    tokens = dialect.standard(written)
    try:
        body = read_body(Units(tokens, diagnostics), 0, len(tokens.types), text)
    except TooMany:
        body = StatementBody((), text)
    asked = _pragmas(written, body, more, Reading(text.source, "PLCopen XML", diagnostics))
    return clock.told(body, asked, more) if more is not None else body


def _pragmas(tokens: Tokens, body: StatementBody, more: Additions | None, reading: Reading) -> list[Span]:
    """Pragmas tell an editor or a compiler something; others hold text for a C compiler, or conditions. The
    variables for which one asks the time."""
    told, asked = False, []
    for first, last in dialect.pragmas(tokens):
        span = tokens.span(first, last)
        now = clock.variable(span) if more is not None else None
        if now is not None and clock.stands_between(span, body.statements):
            asked.append(now)
        elif not _WITHOUT_EFFECT.match(span.text):
            reading.unsupported(span, f"the pragma `{texts.line(span.text)}`",
                                "write what it does in Structured Text", "for another compiler")
        elif not told:
            told = True
            reading.left_out(span, f"the pragma `{texts.line(span.text)}`", "for another compiler")
    return asked
