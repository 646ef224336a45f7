"""Structured Text as the editors of PLCopen files write it, made to that of the standard, token by token.

What has no effect is taken away: pragmas (`{...}`), and arguments without a value (`t(IN := a, ET => )`).
What editors do without is put in: the semicolon behind the end of a block.
"""

from __future__ import annotations

from collections.abc import Iterator

from ldc.parser.lexer import Tokens

_ENDS = frozenset(("END_IF", "END_CASE", "END_FOR", "END_WHILE", "END_REPEAT"))
_ASSIGNS = (":=", "=>")
_CLOSES = (",", ")")


def standard(tokens: Tokens) -> Tokens:
    """The tokens without and with these; the same object when there is nothing to do."""
    types = tokens.types
    if "{" not in types and not _ENDS.intersection(types) and not any(
            types[at + 1] in _CLOSES for at, kind in enumerate(types[:-1]) if kind in _ASSIGNS):
        return tokens
    kept = list(_kept(types))
    made = Tokens(tokens.source, [], [], [], tokens.comments)
    for place, at in enumerate(kept):
        made.types.append(types[at])
        made.starts.append(tokens.starts[at])
        made.ends.append(tokens.ends[at])
        if types[at] in _ENDS and (place + 1 == len(kept) or types[kept[place + 1]] != ";"):
            made.types.append(";")
            made.starts.append(tokens.ends[at])
            made.ends.append(tokens.ends[at])
    return made


def pragmas(tokens: Tokens) -> Iterator[tuple[int, int]]:
    """The first and the last token of every pragma."""
    at, types = 0, tokens.types
    while at < len(types):
        if types[at] == "{":
            last = _closing(types, at)
            yield at, last
            at = last
        at += 1


def _closing(types: list[str], at: int) -> int:
    """The brace that closes a pragma; the opening one alone when nothing does."""
    try:
        return types.index("}", at)
    except ValueError:
        return at


def _kept(types: list[str]) -> Iterator[int]:
    """The tokens that stay. An argument without a value goes with the comma behind it, the last one with
    the comma before it."""
    found: list[int] = []
    at = 0
    while at < len(types):
        if types[at] == "{":
            at = _closing(types, at) + 1
            continue
        empty = types[at] in _ASSIGNS and at + 1 < len(types) and types[at + 1] in _CLOSES
        if not empty or not found or types[found[-1]] != "NAME":
            found.append(at)
            at += 1
            continue
        found.pop()
        if types[at + 1] == ",":
            at += 2
        else:
            at += 1
            if found and types[found[-1]] == ",":
                found.pop()
    yield from found
