"""The text of an instruction list: instructions with their operands, and the comments around them."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ldc.parser.foreign import Reading
from ldc.patterns import Pattern
from ldc.records import record
from ldc.source import Span

MAX_INSTRUCTIONS = 500_000
_COMMENT = Pattern(r"(;|//)(.*)")
_BLOCK = Pattern(r"\(\*.*?\*\)", re.DOTALL)
_LINE = Pattern(
    r"[ \t]*(?:\d+[ \t]+)?(?P<name>[Dd]?[-+*/][Pp]?(?=\s)|[A-Za-z]\w*+(?:[<>=]{1,2}(?!\w))?)"
    r"(?P<colon>[ \t]*:)?(?P<rest>.*)")
_OPERAND = Pattern(r"[^\s,]+")


@record
class Operand:
    """``text`` in capitals."""

    text: str
    span: Span


@record
class Instruction:
    """``name`` in capitals; ``above``: comments in the lines directly above it."""

    name: str
    operands: tuple[Operand, ...]
    span: Span
    above: tuple[str, ...]


@record
class Comment:
    """``alone``: on a line without an instruction."""

    text: str
    span: Span
    alone: bool


class Lines:
    """The instructions of a list, in order, and its comments."""

    def __init__(self, reading: Reading) -> None:
        self.reading = reading
        self.comments: list[Comment] = []
        self.instructions = list(self._read())

    def _read(self) -> Iterator[Instruction]:
        source = self.reading.source
        text = _BLOCK.sub(self._block, source.text)
        above: list[str] = []
        start = count = 0
        while start < len(text):
            end = text.find("\n", start)
            end = len(text) if end < 0 else end
            code = self._comment(text, start, end)
            if text[start:code].strip():
                count += 1
                if count > MAX_INSTRUCTIONS:
                    self.reading.too_large(Span(source, start, code), MAX_INSTRUCTIONS, "instructions")
                    return
                found = self._instruction(text, start, code, tuple(above))
                if found is not None:
                    yield found
                above = []
            elif code == end and not source.text[start:end].strip():
                above = []
            elif self.comments and self.comments[-1].span.start >= start:
                above.append(self.comments[-1].text)
            start = end + 1

    def _block(self, match: re.Match) -> str:
        """Blanks in place of a comment, so that everything stays where it is."""
        span = Span(self.reading.source, *match.span())
        self.comments.append(Comment(" ".join(match[0][2:-2].split()), span, True))
        return re.sub(r"[^\n]", " ", match[0])

    def _comment(self, text: str, start: int, end: int) -> int:
        """Where the comment of a line begins, its end when it has none."""
        found = _COMMENT.search(text, start, end)
        if found is None:
            return end
        words = found[2].strip()
        if words:
            alone = not text[start : found.start()].strip()
            self.comments.append(Comment(words, Span(self.reading.source, found.start(), end), alone))
        return found.start()

    def _instruction(self, text: str, start: int, end: int, above: tuple[str, ...]) -> Instruction | None:
        source = self.reading.source
        match = _LINE.match(text, start, end)
        if match is None:
            first = start + len(text[start:end]) - len(text[start:end].lstrip())
            self.reading.malformed(Span(source, first, end), "this is no instruction",
                                   help="an instruction is a word and its devices: `LD X0`, `OUT T0 K10`")
            return None
        operands = tuple(Operand(o[0].upper(), Span(source, *o.span()))
                         for o in _OPERAND.finditer(text, match.start("rest"), end))
        last = operands[-1].span.end if operands else match.end("name")
        return Instruction(match["name"].upper(), operands, Span(source, match.start("name"), last), above)
