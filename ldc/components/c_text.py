"""C behind the preprocessor: where its places are in the author's files, what a parser of C11 reads of it."""

from __future__ import annotations

import re
from bisect import bisect_right

from ldc.patterns import Pattern
from ldc.records import record

_MARKER = Pattern(r'^#(?:line)? (\d+) "((?:\\.|[^"\\\n])*)".*$', re.MULTILINE)
_FOREIGN = Pattern(
    r"""
      (?P<literal> "(?:\\.|[^"\\\n])*" | '(?:\\.|[^'\\\n])*' )
    | (?P<directive> ^[ \t]*\#[^\n]* )
    | (?P<universal> \\u[0-9a-fA-F]{4} | \\U[0-9a-fA-F]{8} )
    | \b (?P<call> __attribute__ | __attribute | __builtin_offsetof | __builtin_va_arg ) \s* (?=\()
    | \b (?P<word> __extension__ | __builtin_va_list ) \b
    """,
    re.MULTILINE | re.VERBOSE,
)
_PARENTHESES = Pattern(r""" "(?:\\.|[^"\\\n])*" | '(?:\\.|[^'\\\n])*' | [()] """, re.VERBOSE)
_STANDS_FOR = {"__builtin_offsetof": "0", "__builtin_va_arg": "0", "__builtin_va_list": "int"}


@record
class CText:
    """``text``: what the preprocessor gave, with standard ``#line`` directives. ``plain``: the same, place by
    place, as C11 without directives: attributes are blank, what the headers of the standard make of
    compilers' own functions is a constant. ``origins``: file and line of each line, from its marker."""

    text: str
    plain: str
    starts: tuple[int, ...]
    origins: tuple[tuple[str, int], ...]

    def offset(self, line: int, column: int) -> int:
        """The offset of a line and column, from 1, as parsers of ``plain`` tell them."""
        return self.starts[line - 1] + column - 1

    def origin(self, offset: int) -> tuple[str, int, int]:
        """File, line and column, from 1, that the author knows a place by."""
        line = bisect_right(self.starts, offset)
        file, number = self.origins[line - 1]
        return file, number, offset - self.starts[line - 1] + 1

    def replaced(self, edits: dict[tuple[int, int], str]) -> str:
        """The text with other words at some places (begin, end); no line moves."""
        pieces, at = [], 0
        for (start, end), new in sorted(edits.items()):
            pieces += [self.text[at:start], new, "\n" * self.text.count("\n", start, end)]
            at = end
        return "".join([*pieces, self.text[at:]])


def cut(preprocessed: str) -> CText:
    """The text of a preprocessor (``gcc -E``)."""
    text = _MARKER.sub(lambda m: f'#line {max(int(m[1]), 1)} "{m[2]}"', preprocessed)
    starts, origins = [], []
    at, file, number = 0, "", 1
    for line in text.split("\n"):
        starts.append(at)
        origins.append((file, number))
        at += len(line) + 1
        number += 1
        marker = _MARKER.match(line)
        if marker is not None:
            number, file = int(marker[1]), re.sub(r"\\(.)", r"\1", marker[2])
    return CText(text, _plain(text), tuple(starts), tuple(origins))


def _plain(text: str) -> str:
    pieces, at = [], 0
    for match in _FOREIGN.finditer(text):
        if match.start() < at or match["literal"]:
            continue
        end, new = match.end(), ""
        if match["universal"]:
            new = f"_{match[0][1:]}"
        elif match["call"]:
            end, new = _closed(text, match.end()), _STANDS_FOR.get(match["call"], "")
        elif match["word"]:
            new = _STANDS_FOR.get(match["word"], "")
        old = re.sub(r"[^\n]", " ", text[match.start() : end])
        pieces += [text[at : match.start()], new, old[len(new) :]]
        at = end
    return "".join([*pieces, text[at:]])


def _closed(text: str, start: int) -> int:
    """Behind the parenthesis that closes the one at ``start``; the end of the text when none does."""
    depth = 0
    for match in _PARENTHESES.finditer(text, start):
        depth += {"(": 1, ")": -1}.get(match[0], 0)
        if depth == 0:
            return match.end()
    return len(text)
