"""Which bodies of a text file are Instruction List: those that begin as no statement can; and their text.

It is text with bodies in several languages, as the generators of Beremiz and OpenPLC write it: one file,
whose POUs, actions and transitions are statements or lists.
"""

from __future__ import annotations

from ldc.parser import ast
from ldc.parser.lexer import Tokens, lex
from ldc.symbols import Location

_FIRST = frozenset(("LD", "LDN", "CAL", "JMP", "RET"))
"""What a list begins with: nothing else does something without a current result but a call of a function."""
_OF_STATEMENTS = frozenset((":=", ".", "[", "(", ";", "=>"))


def is_list(tokens: Tokens, first: int, end: int) -> bool:
    """Whether the tokens ``first`` to ``end`` (exclusive) are instructions (IEC 61131-3, 2nd edition, 3.2),
    as far as the first one tells; a label may stand before it."""
    kinds = tokens.types[first:min(end, first + 5)]
    if kinds[:2] == ["NAME", ":"]:
        first, kinds = first + 2, kinds[2:]
    if kinds[:1] != ["NAME"] or tokens.text(first).upper() not in _FIRST:
        return False
    return kinds[1:2] == [] or kinds[1] not in _OF_STATEMENTS and kinds[1:3] != ["NAME", "="]


def listed(body: ast.TextBody) -> str:
    """The text of a list, with names for the addresses that stand for variables."""
    if not body.names:
        return body.span.text
    names, text, at = dict(body.names), body.span.source.text, body.span.start
    tokens, parts = lex(body.span.source, body.span.start, body.span.end), []
    for index, kind in enumerate(tokens.types):
        name = names.get(Location.usual(tokens.text(index))) if kind == "DIRECT" else None
        if name is not None:
            parts += [text[at:tokens.starts[index]], name]
            at = tokens.ends[index]
    return "".join((*parts, text[at:body.span.end]))
