"""Lists that GX Works and GX Developer write to tables: a row for each instruction and further operand.

The cells of a row are step, statement, instruction, device, an empty one, statement of a pointer, note;
between them are tabs or commas, around them quotes. What stands above the first step tells the program and
the controller.
"""

from __future__ import annotations

from collections.abc import Iterator

from ldc.parser.foreign import Reading
from ldc.parser.melsec.lines import MAX_INSTRUCTIONS, Comment, Instruction, Operand
from ldc.patterns import Pattern
from ldc.source import Span

_CELL = Pattern(r'"((?:[^"\n]|"")*)"|([^\t,\n"]*)')
_STEPS, _STATEMENT, _WORD, _DEVICE, _NOTE = 0, 1, 2, 3, 6


class Rows:
    """The instructions of a table, in order, its comments, and what it says of the controller. ``gap``: what
    stands between its cells."""

    def __init__(self, reading: Reading, gap: str) -> None:
        self.reading = reading
        self.comments: list[Comment] = []
        self.controller = ""
        self.instructions = list(self._read(gap))

    def _read(self, gap: str) -> Iterator[Instruction]:
        word: Span | None = None
        operands: list[Operand] = []
        above: list[str] = []
        begun: tuple[str, ...] = ()
        count, started = 0, False
        for cells in self._rows(gap):
            texts = [cell.text.replace('""', '"').strip() for cell in cells]
            if not started and not (texts[_STEPS].isdigit() or texts[_WORD : _WORD + 1] == ["LD"]):
                self._heading(cells, texts)
                continue
            started = True
            texts += [""] * (_NOTE + 1 - len(texts))
            if texts[_WORD] or texts[_STATEMENT]:
                if word is not None:
                    yield _instruction(word, operands, begun)
                word, operands = None, []
            if texts[_STATEMENT]:
                above.append(texts[_STATEMENT].lstrip("*> "))
            if texts[_NOTE]:
                self.comments.append(Comment(texts[_NOTE], cells[_NOTE], False))
            if texts[_WORD]:
                count += 1
                if count > MAX_INSTRUCTIONS:
                    self.reading.too_large(cells[_WORD], MAX_INSTRUCTIONS, "instructions")
                    return
                word, begun, above = cells[_WORD], tuple(above), []
            if texts[_DEVICE]:
                if word is None:
                    self.reading.malformed(cells[_DEVICE],
                                           f"`{texts[_DEVICE][:40]}` belongs to no instruction")
                else:
                    operands.append(Operand(texts[_DEVICE].upper(), cells[_DEVICE]))
        if word is not None:
            yield _instruction(word, operands, begun)

    def _heading(self, cells: list[Span], texts: list[str]) -> None:
        """A row above the program: its name alone, the controller, or the names of the columns."""
        if len(texts) == 2:
            self.controller = texts[1]
            self.reading.remark("left out", texts[1], "the controller that the list was made for", cells[1])
        elif texts[0] and not any(texts[1:]) and not self.comments:
            self.comments.append(Comment(texts[0].strip("()"), cells[0], True))

    def _rows(self, gap: str) -> Iterator[list[Span]]:
        """The cells of each row that holds something; without the quotes around them."""
        source = self.reading.source
        text, start = source.text, 0
        while start < len(text):
            end = text.find("\n", start)
            end = len(text) if end < 0 else end
            cells: list[Span] = []
            at = start
            while at <= end:
                match = _CELL.match(text, at, end)
                cells.append(Span(source, *match.span(1 if match[1] is not None else 2)))
                at = text.find(gap, match.end(), end) + 1 or end + 1
            if any(cell.text.strip() for cell in cells):
                yield cells
            start = end + 1


def _instruction(word: Span, operands: list[Operand], above: tuple[str, ...]) -> Instruction:
    span = word.to(operands[-1].span) if operands else word
    return Instruction(word.text.strip().upper(), tuple(operands), span, above)
