"""The scanner: a text to tokens, once and in linear time, whatever the text is.

It never fails. What is no token becomes one of type ``BAD``, which is reported only when the unit that it
stands in is parsed (the body of an ST or IL POU has other rules). Tokens are kept in columns; a token is
known by its index.
"""

from __future__ import annotations

import re

from ldc.patterns import Pattern
from ldc.records import entity
from ldc.source import SourceFile, Span

OPENING = {"(": ")", "[": "]", "{": "}"}
BAD = "BAD"
MAX_WORD, MAX_TOKENS, MOST_TOKENS = 1_000, 200_000, 4_000_000
"""Characters of a name or an address; symbols of a rung or a declaration; symbols of a file."""

SECTIONS = ("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR_TEMP", "VAR_EXTERNAL", "VAR_GLOBAL",
            "VAR_CONFIG")
QUALIFIERS = ("RETAIN", "NON_RETAIN", "CONSTANT")
_SAME = """
    PROGRAM END_PROGRAM FUNCTION END_FUNCTION FUNCTION_BLOCK END_FUNCTION_BLOCK TYPE END_TYPE
    STRUCT END_STRUCT CONFIGURATION END_CONFIGURATION RESOURCE END_RESOURCE TASK
    END_VAR VAR_ACCESS READ_ONLY READ_WRITE
    ARRAY OF AT ON WITH RUNG RETURN NOT R_EDGE F_EDGE
    IF THEN ELSE ELSIF END_IF CASE END_CASE FOR TO BY DO END_FOR WHILE END_WHILE REPEAT UNTIL END_REPEAT EXIT
    ACTION END_ACTION STEP END_STEP INITIAL_STEP TRANSITION END_TRANSITION FROM
"""
KEYWORDS: dict[str, str] = {word: word for word in (*_SAME.split(), *SECTIONS, *QUALIFIERS)} | {
    "AND": "WORDOP", "OR": "WORDOP", "XOR": "WORDOP", "MOD": "WORDOP",
    "AND_THEN": "WORDOP", "OR_ELSE": "WORDOP",
    "TRUE": "LITERAL", "FALSE": "LITERAL", "_": "_",
}
"""Reserved words in capitals, and the type of their tokens (IEC 61131-3, annex C, and RUNG)."""

SOFT = frozenset(("STEP", "INITIAL_STEP", "ACTION", "TRANSITION", "FROM", "ON", "WITH"))
"""Reserved words before a name only: elsewhere in texts with statements, and in IL, they are names, as in
many editors."""
_LED = frozenset(("NAME", "INTEGER", "BAD", *SOFT))
_BOUNDARIES = frozenset(
    (*SECTIONS, *(word for word in _SAME.split() if word.startswith("END_")), "PROGRAM", "FUNCTION",
     "FUNCTION_BLOCK", "TYPE", "CONFIGURATION", "RESOURCE", "RUNG", "STEP", "INITIAL_STEP", "TRANSITION",
     "ACTION"))
_WITH_LINES = frozenset((*SECTIONS, "TYPE", "RESOURCE"))
_OPERATORS = {op: "BINOP" for op in ("**", "<=", ">=", "<>", "&", "*")}
_MODIFIERS = frozenset("PNSRpnsr")
_STRING = r"'(?>(?:[^'$\n]++|\$[^\n])*)'"
_TEXT = r'"(?>(?:[^"$\n]++|\$[^\n])*)"'
# OpenPLC appends C for its debugger, a line in each comment, which `*)` of a cast seems to end: lines go
# whole there.
_DEBUG = r"(?<![^\n])\(\*DBG:[^\n]*\*\)[ \t\r]*(?=\n|\Z)"
_SCAN = Pattern(
    rf"""
    (?P<SPACE> [ \t\r\n\f\v]+ )
  | (?P<WORD>  [A-Za-z_]\w*+ (?!\#) )
  | (?P<OP>    \((?!\*) | /(?![/*]) | := | => | >(?=>>) | >> | >= | <= | <> | \*\* | \.\.
             | [\[\]){{}}<>=:;,.@|&*+-] )
  | (?P<COMMENT> {_DEBUG} | \(\*(?s:.*?)\*\) | //[^\r\n]* | /\*(?s:.*?)\*/ )
  | (?P<LITERAL>
        (?i: L?REAL )\#[+-]?\d[\d_]*+(?:\.\d[\d_]*+)?(?:[eE][+-]?\d+)?(?!\w|\#)
      | (?i: L?DATE_AND_TIME | L?DT | L?DATE | L?D )\#\d[\d_]*+(?>(?:[-:.]\d\w*+)*)
      | [A-Za-z_]\w*\#(?: [+-]?\d\w*+(?>(?:[.:\#]\w+)*) | [A-Za-z_]\w*+ | {_STRING} | {_TEXT} ) )
  | (?P<NUMBER> \d[\d_]*+(?: \.\d[\d_]*+(?:[eE][+-]?\d+)? | [eE][+-]?\d+ | \#\w++ )(?!\w) )
  | (?P<INTEGER> \d[\d_]*+(?!\w) )
  | (?P<DIRECT> %[IQMiqm][XBWDLxbwdl]?\* | %[A-Za-z_]\w*+(?>(?:\.\d+)*) )
  | (?P<STRING> {_STRING} )
  | (?P<TEXT> {_TEXT} )
  | (?P<BAD>   (?:\(\*|/\*)(?s:.*) | ['"][^\n]* | \d[\w\#]* | [A-Za-z_]\w*\#[^\s;,()\[\]{{}}]*
             | [^\x00-\x7f]+ | [\x00-\x1f\x7f]+ | . )
    """,
    re.VERBOSE | re.ASCII,
)

_NESTS = Pattern(r"\(\*|\*\)")
_PRAGMA = Pattern(
    r"""\{\s*(?:attribute|warning|info|text|region|endregion|analysis|flow|nobp|bp|docu|messageguid|pack_mode)\b
        (?:[^{}'"]|'[^'\n]*'|"[^"\n]*")*\}""", re.VERBOSE | re.IGNORECASE)
"""What an editor or a compiler may do without."""
_WORDS = "|".join(sorted(_BOUNDARIES))
_BOUNDARY = Pattern(
    rf"""{_DEBUG} | \(\*(?s:.*?)\*\) | //[^\r\n]* | /\*(?s:.*?)\*/ | {_STRING} | {_TEXT} | \b(?P<word>{_WORDS})\b""",
    re.VERBOSE | re.ASCII | re.IGNORECASE,
)


@entity
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


def lex(source: SourceFile, start: int = 0, end: int | None = None, statements: bool = False) -> Tokens:
    """The tokens of a text, or of a part of it (offsets stay those of the whole). ``statements``: it holds
    some, ended by ``;``, whatever the path says.

    A file far above the limit ends there (its reader tells). A rung or declaration is cut there: it is wrong
    already, and the rest of it may be many megabytes. Scanning goes on at the next word that begins or ends
    something.
    """
    end = len(source.text) if end is None else end
    columns = Tokens(source, [], [], [], [])
    modifiers: list[int] = []
    soft: list[int] = []
    at = start
    while at < end and len(columns.types) <= MOST_TOKENS:
        at = _boundary(source.text, _lex(columns, modifiers, soft, at, end, statements), end)
    types = columns.types
    for index in modifiers:  # P N S R are modifiers only before a name
        if index + 1 < len(types) and types[index + 1] in ("NAME", "DIRECT"):
            types[index] = "MODIFIER"
    for index in soft:
        following = types[index + 1] if index + 1 < len(types) else "NAME"
        led = following in _LED or following == "(" and types[index] in ("TRANSITION", "FROM")
        if not led or types[index - 1 : index] == ["."]:
            types[index] = "NAME"
    return columns


def _lex(
    columns: Tokens, modifiers: list[int], soft: list[int], start: int, end: int, statements: bool
) -> int:
    """Append tokens until the end or until a unit is too long; where it stopped."""
    text, types, starts, ends = columns.source.text, columns.types, columns.starts, columns.ends
    known: dict[str, str] = {}
    written = columns.source.path.lower().endswith(".st")
    statements |= written
    relaxed = statements or columns.source.path.lower().endswith(".il")
    lines, limit = statements, _limit(types)
    nests, braces = True, written  # whether comments close what they open; whether braces are pragmas
    passed = 0  # what ends there was taken as a whole
    for match in _SCAN.finditer(text, start, end):
        kind = match.lastgroup
        if passed:
            if match.start() < passed:
                continue
            passed = 0
        if kind == "SPACE":
            continue
        at, to = match.span()
        if kind == "WORD":
            word = text[at:to]
            kind = known.get(word)
            if kind is None:
                kind = KEYWORDS.get(word.upper(), "NAME") if to - at <= MAX_WORD else BAD
                known[word] = kind
            if to - at == 1 and word in _MODIFIERS and types and types[-1] in ("[", "("):
                modifiers.append(len(types))
            if relaxed and kind in SOFT:
                soft.append(len(types))
            if kind in _BOUNDARIES:
                braces = written and kind != "RUNG"
                lines, limit = statements or kind in _WITH_LINES, _limit(types)
        elif kind == "OP":
            word = text[at:to]
            kind = _OPERATORS.get(word, word)
            if braces and word == "{" and (pragma := _PRAGMA.match(text, at, end)) is not None:
                columns.comments.append(pragma.span())
                passed = pragma.end()
                continue
            if kind == ";" and lines and types[-1:] != [";"]:
                limit = _limit(types)
        elif kind == "COMMENT":
            if nests and text.startswith("(*", at) and text.find("(*", at + 2, to) >= 0 and (
                    not text.startswith("(*DBG:", at)):
                passed = _closed(text, at, end)
                nests = passed > 0
                to = passed = max(passed, to)
            columns.comments.append((at, to))
            continue
        elif to - at > MAX_WORD and (kind == "DIRECT" or kind == "LITERAL" and text[to - 1] not in "'\""):
            kind = BAD
        elif kind == "BAD" and at == 0 and text[0] == "\ufeff":
            continue
        types.append(kind)
        starts.append(at)
        ends.append(to)
        if len(types) > limit:
            return to
    return end


def _closed(text: str, start: int, end: int) -> int:
    """Where a comment ends that holds others; 0 when not all of them are closed, as in the 2nd edition, where
    `(*` in a comment opens nothing."""
    depth = 0
    for match in _NESTS.finditer(text, start, end):
        depth += 1 if match[0] == "(*" else -1
        if depth == 0:
            return match.end()
    return 0


def _limit(types: list[str]) -> int:
    """Where the unit that begins behind these tokens is too long, or the file."""
    return min(len(types) + 2 * MAX_TOKENS, MOST_TOKENS)


def _boundary(text: str, start: int, end: int) -> int:
    """The start of the next word that begins or ends a unit, or the end."""
    found = _BOUNDARY.finditer(text, start, end)
    return next((match.start() for match in found if match["word"]), end)
