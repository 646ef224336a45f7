"""Declarations that stand in a PLCopen file as text only, as some editors keep them in additional data."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.findings import TooMany
from ldc.parser.lexer import lex
from ldc.parser.plcopen import dialect
from ldc.parser.plcopen.document import Node
from ldc.parser.reader import parse_sections

_TAGS = ("InterfaceAsPlainText", "textDeclaration")


def sections(pou: Node, diagnostics: Diagnostics) -> tuple[ast.VarBlock, ...]:
    """The sections in the text of a POU's interface; none when there is no such text. An interface that is
    written both ways is read from its elements, so this is for those that have no elements."""
    holders = (node for data in (*pou.all("interface"), pou) for node in data.all("addData"))
    found = next((node for holder in holders for node in holder.descendants(*_TAGS)), None)
    if found is None:
        return ()
    text = found.content
    tokens = dialect.standard(lex(text.source, text.start, text.end, statements=True))
    try:
        return parse_sections(tokens, diagnostics)
    except TooMany:
        return ()
