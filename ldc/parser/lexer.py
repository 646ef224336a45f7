"""The scanner: a text to tokens, once and in linear time, whatever the text is.

It never fails. What is no token becomes one of type ``BAD``, which is reported only when the unit that it
stands in is parsed (the body of an ST or IL POU has other rules). Tokens are kept in columns; a token is
known by its index.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from ldc.source import SourceFile, Span

OPENING = {"(": ")", "[": "]", "{": "}"}
BAD = "BAD"

SECTIONS = ("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR_TEMP", "VAR_EXTERNAL", "VAR_GLOBAL")
QUALIFIERS = ("RETAIN", "NON_RETAIN", "CONSTANT")
_SAME = """
    PROGRAM END_PROGRAM FUNCTION END_FUNCTION FUNCTION_BLOCK END_FUNCTION_BLOCK TYPE END_TYPE
    STRUCT END_STRUCT CONFIGURATION END_CONFIGURATION RESOURCE END_RESOURCE TASK
    END_VAR VAR_ACCESS VAR_CONFIG READ_ONLY READ_WRITE
    ARRAY OF AT ON WITH RUNG RETURN NOT R_EDGE F_EDGE
    IF THEN ELSE ELSIF END_IF CASE END_CASE FOR TO BY DO END_FOR WHILE END_WHILE REPEAT UNTIL END_REPEAT EXIT
    ACTION END_ACTION STEP END_STEP INITIAL_STEP TRANSITION END_TRANSITION FROM
"""
KEYWORDS: dict[str, str] = {word: word for word in (*_SAME.split(), *SECTIONS, *QUALIFIERS)} | {
    "AND": "WORDOP", "OR": "WORDOP", "XOR": "WORDOP", "MOD": "WORDOP",
    "TRUE": "LITERAL", "FALSE": "LITERAL", "_": "_",
}
"""Reserved words in capitals, and the type of their tokens (IEC 61131-3, annex C, and RUNG)."""

_OPERATORS = {op: "BINOP" for op in ("**", "<=", ">=", "<>", "&", "*")}
_MODIFIERS = frozenset("PNSRpnsr")
_STRING = r"'(?:[^'$\n]++|\$[^\n])*+'"
_TEXT = r'"(?:[^"$\n]++|\$[^\n])*+"'
_SCAN = re.compile(
    rf"""
    (?P<SPACE> [ \t\r\n\f\v]+ )
  | (?P<WORD>  [A-Za-z_]\w*+ (?!\#) )
  | (?P<OP>    \((?!\*) | /(?!/) | := | => | >(?=>>) | >> | >= | <= | <> | \*\* | \.\.
             | [\[\]){{}}<>=:;,.@|&*+-] )
  | (?P<COMMENT> \(\*(?s:.*?)\*\) | //[^\r\n]* )
  | (?P<LITERAL>
        (?i: L?REAL )\#[+-]?\d[\d_]*+(?:\.\d[\d_]*+)?(?:[eE][+-]?\d+)?(?!\w|\#)
      | (?i: L?DATE_AND_TIME | L?DT | L?DATE | L?D )\#\d[\d_]*+(?:[-:.]\d\w*+)*+
      | [A-Za-z_]\w*\#(?: [+-]?\d\w*+(?:[.:\#]\w+)*+ | [A-Za-z_]\w*+ | {_STRING} | {_TEXT} ) )
  | (?P<NUMBER> \d[\d_]*+(?: \.\d[\d_]*+(?:[eE][+-]?\d+)? | [eE][+-]?\d+ | \#\w++ )(?!\w) )
  | (?P<INTEGER> \d[\d_]*+(?!\w) )
  | (?P<DIRECT> %[A-Za-z_]\w*+(?:\.\d+)*+ )
  | (?P<STRING> {_STRING} )
  | (?P<TEXT> {_TEXT} )
  | (?P<BAD>   \(\*(?s:.*) | ['"][^\n]* | \d[\w\#]* | [A-Za-z_]\w*\#[^\s;,()\[\]{{}}]*
             | [^\x00-\x7f]+ | [\x00-\x1f\x7f]+ | . )
    """,
    re.VERBOSE | re.ASCII,
)


@dataclass(frozen=True, slots=True, eq=False)
class Tokens:
    """All tokens of a text, in columns; ``comments`` are the spans (start, end) of what is no token."""

    source: SourceFile
    types: list[str]
    starts: list[int]
    ends: list[int]
    comments: list[tuple[int, int]]

    def text(self, index: int) -> str:
        return self.source.text[self.starts[index] : self.ends[index]]

    def span(self, first: int, last: int) -> Span:
        """From the first to the last token, both inclusive."""
        return Span(self.source, self.starts[first], self.ends[last])

    def point(self, index: int) -> Span:
        """The span of a token, or behind the last one when there are no more."""
        if index < len(self.types):
            return Span(self.source, self.starts[index], self.ends[index])
        end = self.ends[-1] if self.ends else 0
        return Span(self.source, end, end)


def lex(source: SourceFile, start: int = 0, end: int | None = None) -> Tokens:
    """The tokens of a text, or of a part of it (offsets stay those of the whole)."""
    text = source.text
    types, starts, ends, comments = [], [], [], []
    known: dict[str, str] = {}
    modifiers = []
    for match in _SCAN.finditer(text, start, len(text) if end is None else end):
        kind = match.lastgroup
        if kind == "SPACE":
            continue
        at, to = match.span()
        if kind == "WORD":
            word = text[at:to]
            kind = known.get(word)
            if kind is None:
                kind = known[word] = KEYWORDS.get(word.upper(), "NAME")
            if to - at == 1 and word in _MODIFIERS and types and types[-1] in ("[", "("):
                modifiers.append(len(types))
        elif kind == "OP":
            word = text[at:to]
            kind = _OPERATORS.get(word, word)
        elif kind == "COMMENT":
            comments.append((at, to))
            continue
        elif kind == "BAD" and at == 0 and text[0] == "\ufeff":
            continue
        types.append(kind)
        starts.append(at)
        ends.append(to)
    for index in modifiers:  # P N S R are modifiers only before a name
        if index + 1 < len(types) and types[index + 1] in ("NAME", "DIRECT"):
            types[index] = "MODIFIER"
    return Tokens(source, types, starts, ends, comments)
