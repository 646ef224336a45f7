"""The text of an IL body as lines: label, instruction, and where the operand stands."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ldc.patterns import Pattern
from ldc.records import record

DEFERRED = frozenset("AND OR XOR ANDN ORN XORN & &N ADD SUB MUL DIV MOD GT GE EQ NE LE LT".split())
CALLS = frozenset(("CAL", "CALC", "CALCN"))

_WORD = r"[A-Za-z_]\w*"
_NOT_CODE = Pattern(
    r"\(\*.*?(?:\*\)|\Z)|//[^\n]*"
    r"|'(?:\$[^\n]|[^$'\n])*'?|\"(?:\$[^\n]|[^$\"\n])*\"?", re.DOTALL)
_MARK = Pattern(r"\(\* rung \"([^\"\n]*)\"(?:: ([^\n]*))? \*\)\Z")
_LINE = Pattern(
    rf"[^\S\n]*(?:({_WORD})[^\S\n]*:(?!=))?[^\S\n]*(?:({_WORD}|&N?|\))[^\S\n]*)?(\(?)[^\S\n]*([^\n]*)",
    re.ASCII | re.IGNORECASE)
_ARGUMENT = Pattern(rf"(?:(NOT)\s+)?({_WORD})\s*(:=|=>)\s*", re.ASCII | re.IGNORECASE)
_BRACKET = Pattern(r"[()\[\],]|'(?:\$[^\n]|[^$'\n])*'?|\"(?:\$[^\n]|[^$\"\n])*\"?")
_NOT_LINE_BREAK = Pattern(r"[^\n]")
_ENDED = Pattern(r";[ \t\r]*$", re.MULTILINE)


@record
class Mark:
    """A comment ``(* rung "key": title *)`` that the printer sets before each rung."""

    at: int
    key: str
    title: str | None


@record
class Line:
    """One instruction; offsets are those of the source file.

    ``op`` in capitals, "" when only a label stands there. ``paren``: ``(`` follows ``op`` (deferred
    operator, or a call that names its pins). ``start``/``end``: the operand, without blanks, the
    opening parenthesis and, when ``closed``, the closing one. ``arguments``: where the parenthesis of
    an argument list opens, -1 without one. ``after``: text behind its end. ``close``: where all ends.
    """

    op: str
    op_start: int
    op_end: int
    paren: bool
    start: int
    end: int
    label: str = ""
    label_start: int = 0
    closed: bool = False
    after: tuple[int, int] | None = None
    arguments: int = -1
    close: int = 0

    @property
    def stop(self) -> int:
        return max(self.close, self.op_end)


@record
class Argument:
    """``name := value``, ``NOT name => target`` or a value alone (``name`` is then None)."""

    name: str | None
    start: int
    end: int
    output: bool = False
    negated: bool = False
    name_start: int = 0


class Scanner:
    """Lines of ``text[start:end]``; comments count as blanks, and so does a semicolon that ends a line, as
    some editors write it."""

    def __init__(self, text: str, start: int, end: int) -> None:
        self.base = start
        self.marks: list[Mark] = []
        plain = _NOT_CODE.sub(self._blank, text[start:end].replace("\r", "\n"))
        self.text = _ENDED.sub(lambda match: " " * len(match[0]), plain) if ";" in plain else plain

    def _blank(self, match: re.Match) -> str:
        text = match[0]
        if text[0] in "'\"":
            return text
        mark = _MARK.match(text)
        if mark:
            self.marks.append(Mark(self.base + match.start(), mark[1], mark[2]))
        return _NOT_LINE_BREAK.sub(" ", text)

    def lines(self) -> Iterator[Line]:
        text, at, size = self.text, 0, len(self.text)
        while at < size:
            match = _LINE.match(text, at)
            at = match.end() + 1
            label, op, paren, rest = match.groups()
            if not (label or op or paren or rest):
                continue
            line, stop = self._line(match)
            if stop > match.end():
                stop = text.find("\n", stop)
                at = size if stop < 0 else stop + 1
            yield line

    def _line(self, match: re.Match) -> tuple[Line, int]:
        base, op, paren = self.base, (match[2] or "").upper(), bool(match[3])
        if not op:
            start = match.start(3)
            end = match.end() - _trailing(match[0])
            return Line("", base + start, base + end, False, base + start, base + end, *self._label(match),
                        close=base + end), 0
        op_start, op_end = base + match.start(2), base + match.end(2)
        start, end = match.start(4), match.end(4) - _trailing(match[4])
        label = self._label(match)
        opened = match.start(3) if paren and op not in DEFERRED else -1
        if op in CALLS and not paren:
            opened = self.text.find("(", start, end)
        if opened >= 0:
            close = self._close(opened)
            if close < 0:
                return Line(op, op_start, op_end, paren, base + start, base + end, *label,
                            arguments=base + opened, close=base + end), len(self.text)
            tail = self.text.find("\n", close)
            after = self._trim(close + 1, len(self.text) if tail < 0 else tail)
            return Line(op, op_start, op_end, paren, base + start, base + close, *label, True, after,
                        base + opened, base + close + 1), close
        closed = op not in ("", ")") and match[4].rstrip().endswith(")") and self._close_on_line(start, end)
        stop = end
        if closed:
            end -= 1
            end -= _trailing(self.text[start:end])
        return Line(op, op_start, op_end, paren, base + start, base + end, *label, closed,
                    close=base + stop), 0

    def _label(self, match: re.Match) -> tuple[str, int]:
        return match[1] or "", self.base + max(match.start(1), 0)

    def _trim(self, start: int, end: int) -> tuple[int, int] | None:
        while start < end and self.text[start].isspace():
            start += 1
        while end > start and self.text[end - 1].isspace():
            end -= 1
        return (self.base + start, self.base + end) if start < end else None

    def _close(self, opened: int) -> int:
        """Where the parenthesis that opens at ``opened`` closes; -1 when it does not."""
        depth = 0
        for match in _BRACKET.finditer(self.text, opened):
            if match[0] == "(":
                depth += 1
            elif match[0] == ")":
                depth -= 1
                if depth == 0:
                    return match.start()
        return -1

    def _close_on_line(self, start: int, end: int) -> bool:
        """Whether the last ``)`` of an operand closes nothing that opens in it: ``AND( a )``."""
        brackets = [m[0] for m in _BRACKET.finditer(self.text, start, end)]
        return brackets.count(")") > brackets.count("(")

    def split(self, start: int, end: int) -> list[tuple[int, int]]:
        """The parts between commas outside of brackets, without blanks; none when there is only blank."""
        start, end = start - self.base, end - self.base
        if "," not in self.text[start:end]:
            part = self._trim(start, end)
            return [part] if part else []
        cuts, depth = [start], 0
        for match in _BRACKET.finditer(self.text, start, end):
            if match[0] in "([":
                depth += 1
            elif match[0] in ")]":
                depth -= 1
            elif match[0] == "," and depth == 0:
                cuts.append(match.end())
        ends = [c - 1 for c in cuts[1:]] + [end]
        parts = [self._trim(a, b) or (self.base + a, self.base + a) for a, b in zip(cuts, ends)]
        return parts

    def arguments(self, start: int, end: int) -> list[Argument]:
        result = []
        for first, last in self.split(start, end):
            match = _ARGUMENT.match(self.text, first - self.base, last - self.base)
            if match is None:
                result.append(Argument(None, first, last, name_start=first))
            else:
                result.append(Argument(match[2], self.base + match.end(), last, match[3] == "=>",
                                       bool(match[1]), self.base + match.start(2)))
        return result


def _trailing(text: str) -> int:
    return len(text) - len(text.rstrip())
