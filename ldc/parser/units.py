"""One unit of text (a rung, a declaration, a header) to its tree: limits, parsing, and what went wrong."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ldc.diagnostics import Diagnostics
from ldc.parser import beyond, lr, syntax
from ldc.parser.chart_rules import ChartBuilder
from ldc.parser.findings import MAX_DEPTH, MAX_OPERATORS, Findings
from ldc.parser.lexer import BAD, MAX_TOKENS, MAX_WORD, OPENING, Tokens
from ldc.parser.literals import Malformed
from ldc.parser.tables import tables
from ldc.patterns import Pattern

_OPERATORS = frozenset(("BINOP", "WORDOP", "=", "<", ">", "/", "-", "+", "NOT", ".", "["))
_PREFIXES = ("NOT", "-", "+")
_NESTS = {**OPENING, "STRUCT": "END_STRUCT"}
_CLOSES = frozenset(_NESTS.values())
_SHOWN = 20
_DURATION = Pattern(r"\d+(us|ms|[smhd])", re.IGNORECASE)


class Units:
    """Parses units of one file. A unit that failed is None, and its findings are in the bag.

    ``lost``: a declaration or heading failed, whose names are now unknown. ``statements``: how many were
    read. Raises TooMany after a thousand findings.
    """

    def __init__(self, tokens: Tokens, diagnostics: Diagnostics) -> None:
        self.tokens, self.types = tokens, tokens.types
        self.findings = Findings(tokens, diagnostics)
        self.builder = ChartBuilder(tokens, self.findings)
        self.lost = False
        self.statements = 0
        self._tables = tables()

    def parse(self, symbol: str, first: int, end: int, what: str) -> object | None:
        """The tokens ``first`` to ``end`` (exclusive) as ``symbol``; ``what`` names it in messages."""
        value = self.attempt(symbol, first, end, what)
        if isinstance(value, lr.Failure):
            syntax.explain(value, self.findings, first, end, what)
            value = None
        self.lost |= value is None and what in ("declaration", "heading")
        return value

    def lines(self, symbol: str, first: int, end: int) -> Iterator[object]:
        """What is ended by ``;``, one by one. After a missing ``;`` it goes on at the next name."""
        at = first
        while at < end:
            stop = self._line_end(at, end)
            if "{" in self.types[at:stop]:
                self.findings.pragma(self.types.index("{", at))
                self.lost, at = True, stop
                continue
            value = self.attempt(symbol, at, stop, "declaration")
            if isinstance(value, lr.Failure):
                told = beyond.tell_types(self.tokens, at, stop, self.findings)
                if told:
                    self.lost, at = True, told
                    continue
                syntax.explain(value, self.findings, at, stop, "declaration")
                index = value.index
                if at < index < stop and ";" in value.expected and self._begins_line(index):
                    stop = index
                value = None
            if value is None:
                self.lost = True
            else:
                yield value
            at = stop

    def bad(self, first: int, end: int) -> bool:
        """Report what is no token; True when there was any."""
        types, shown = self.types, 0
        if BAD not in types[first:end]:
            return False
        for index in range(first, end):
            if types[index] == BAD and shown < _SHOWN:
                shown += 1
                self._bad_token(index)
        return True

    def attempt(self, symbol: str, first: int, end: int, what: str) -> object | lr.Failure | None:
        """Like ``parse``, but what does not follow the grammar is not reported yet."""
        self.findings.enough(first)
        if self.bad(first, end) or (end - first > MAX_DEPTH and self._too_big(first, end, what)):
            return None
        value = lr.parse(self._tables, self.builder, symbol, self.types, first, end)
        failed, self.builder.failed = self.builder.failed, False
        return None if failed and not isinstance(value, lr.Failure) else value

    def _line_end(self, at: int, end: int) -> int:
        """Behind the next ``;`` that is not inside a STRUCT."""
        depth = 0
        for index in range(at, end):
            kind = self.types[index]
            if kind == "STRUCT":
                depth += 1
            elif kind == "END_STRUCT":
                depth -= 1
                if depth == 0 and self.types[index + 1 : index + 2] not in ([";"], [":="]):
                    return index + 1
            elif kind == ";" and depth <= 0:
                return index + 1
        return end

    def _begins_line(self, index: int) -> bool:
        return self.types[index] == "NAME" and self.types[index + 1 : index + 2] in ([":"], [","], ["AT"])

    # ---- limits

    def _too_big(self, first: int, end: int, what: str) -> bool:
        if end - first > MAX_TOKENS:
            self.findings.too_long(first + MAX_TOKENS, f"the {what}", MAX_TOKENS, "symbols")
            return True
        types = self.types[first:end]
        if sum(map(types.count, (*_NESTS, *_PREFIXES, "ARRAY"))) > MAX_DEPTH and self._too_deep(first, end):
            return True
        return sum(map(_OPERATORS.__contains__, types)) > MAX_OPERATORS and self._too_long(
            first, end, int(what != "rung"))

    def _too_deep(self, first: int, end: int) -> bool:
        """Brackets or structures in one another, prefix operators on one another, arrays of arrays."""
        depth = prefixes = arrays = 0
        for index in range(first, end):
            kind = self.types[index]
            prefixes = prefixes + 1 if kind in _PREFIXES else 0
            arrays = 0 if kind == ";" else arrays + (kind == "ARRAY")
            if kind in _NESTS:
                depth += 1
            elif kind in _CLOSES:
                depth -= 1
            if max(depth, prefixes, arrays) > MAX_DEPTH:
                what = "NOT and signs" if prefixes > MAX_DEPTH else (
                    "types" if arrays > MAX_DEPTH or kind == "STRUCT" else "brackets")
                self.findings.too_deep(index, f"{what} are")
                return True
        return False

    def _too_long(self, first: int, end: int, level: int) -> bool:
        """Operators, steps and indexes of each expression; it ends where a pin, an element or a branch does.

        ``levels[-1]`` counts the brackets open since the innermost brace: at 0 between elements, at 1 in a
        contact or between the pins of a block. ``level`` is that of the unit: 1 when it is no ladder.
        """
        levels, count = [level], 0
        for index in range(first, end):
            kind = self.types[index]
            if kind == "{":
                levels.append(0)
            elif kind == "}" and len(levels) > 1:
                levels.pop()
            elif kind in (")", "]"):
                levels[-1] = max(0, levels[-1] - 1)
            elif kind in _OPERATORS and levels[-1] and (kind != "/" or self.types[index - 1] not in "[("):
                count += 1
                if count > MAX_OPERATORS:
                    self.findings.too_long(index, "the expression", MAX_OPERATORS, "operators")
                    return True
            if kind in ("(", "["):
                levels[-1] += 1
            elif kind in (";", "|", "{", "}") or (levels[-1] == 0 and kind in (")", "]")) or (
                    levels[-1] <= 1 and kind in (",", ":=", "=>")):
                count = 0
        return False

    # ---- what is no token

    def _bad_token(self, index: int) -> None:
        span = self.tokens.point(index)
        head = span.source.text[span.start : span.start + 2]
        if head[0] == "^":
            # What is a pointer is followed by no value.
            raised = self.types[index + 1 : index + 2] in (
                ["NAME"], ["INTEGER"], ["NUMBER"], ["LITERAL"], ["("])
            self.findings.beyond(index, "^ value" if raised else "^")
        elif head in ("(*", "/*"):
            self.findings.open_comment(span.start)
        elif head[0] in "'\"":
            self.findings.open_string(span)
        elif span.end - span.start > MAX_WORD and (head[0].isalpha() or head[0] in "_%") and head.isascii():
            self.findings.long_word(index)
        elif head[0].isascii() and (head[0].isalnum() or head[0] == "_"):
            help = "names do not begin with digits"
            if "#" in span.text:
                help = "`NAME#` is followed by a value"
            elif _DURATION.fullmatch(span.text):
                help = f"a time is written `T#{span.text}`"
            self.findings.literal(span, Malformed("this is no literal", help))
        else:
            self.findings.character(span, beyond.operator_help(span.source.text, span.start))
