"""The neutral text of a rung, ``XIC(a)[XIC(b),XIO(c)OTE(d)]OTE(e);``, as a tree of series and branches."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from ldc.diagnostics import Diagnostics
from ldc.parser.foreign import Reading
from ldc.records import record
from ldc.source import Span

MAX_DEPTH, MAX_ELEMENTS = 100, 20_000
_TOKEN = re.compile(r"\s*([A-Za-z_]\w*|[\[\],;(]|\S)")
_IN_OPERANDS = re.compile(r"[()\[\],]|'(?:[^'$]|\$.)*'|'")


_CALLS = re.compile(r"\b(?:JSR|SBR|RET|FOR)\s*\(", re.IGNORECASE)
_NO_CODE = re.compile(r"//[^\n]*|\(\*.*?\*\)|/\*.*?\*/", re.DOTALL)


@record
class Instruction:
    """``name`` in capitals; ``operands``: their texts, without the space around them."""

    name: str
    operands: tuple[Span, ...]
    span: Span


@record
class Branch:
    levels: tuple[tuple[Element, ...], ...]
    span: Span


Element = Instruction | Branch


@dataclass(slots=True)
class _Open:
    """A branch that is being read; the last of ``levels`` is the one that grows."""

    start: int
    levels: list[list[Element]]


def rungs(text: Span, reading: Reading) -> tuple[tuple[tuple[Element, ...], Span], ...]:
    """The rungs of a text, each with where it stands; wrong ones are told and left out. A ``;`` ends each."""
    reader = _Reader(text, reading)
    return tuple(reader.read()) if text.start < text.end else ()


def calls(text: Span, reading: Reading) -> Iterator[Instruction]:
    """The calls of routines in Structured Text, and what it says of its own parameters; nothing is told."""
    quiet = Reading(reading.source, reading.format, Diagnostics())
    code = _NO_CODE.sub(lambda match: " " * len(match[0]), text.text)
    for match in _CALLS.finditer(code):
        found = call(Span(text.source, text.start + match.start(), text.end), quiet)
        if found is not None:
            yield found[0]


def call(text: Span, reading: Reading) -> tuple[Instruction, int] | None:
    """The instruction that a text begins with, and where it ends; None when its operands do not end."""
    reader = _Reader(text, reading)
    match = _TOKEN.match(text.source.text, text.start, text.end)
    reader.at = match.end()
    found = reader.instruction(match[1], match.start(1))
    return None if found is None else (found, reader.at)


class _Reader:
    def __init__(self, text: Span, reading: Reading) -> None:
        self.text, self.reading = text, reading
        self.source = text.source
        self.at = text.start

    def span(self, start: int, end: int) -> Span:
        return Span(self.source, start, end)

    def read(self):
        open_ = [_Open(self.at, [[]])]
        count = 0
        begin = self.at
        while True:
            match = _TOKEN.match(self.source.text, self.at, self.text.end)
            if match is None:
                break
            self.at = match.end()
            start, word = match.start(1), match[1]
            count += 1
            if word[0].isalpha() or word[0] == "_":
                found = self.instruction(word, start)
                if found is None:
                    return
                open_[-1].levels[-1].append(found)
            elif word == "[":
                open_.append(_Open(start, [[]]))
            elif word == "," and len(open_) > 1:
                open_[-1].levels.append([])
            elif word == "]" and len(open_) > 1:
                done = open_.pop()
                branch = Branch(tuple(map(tuple, done.levels)), self.span(done.start, self.at))
                open_[-1].levels[-1].append(branch)
            elif word == ";" and len(open_) == 1:
                yield tuple(open_[0].levels[0]), self._trimmed(begin, start)
                open_, begin, count = [_Open(self.at, [[]])], self.at, 0
            else:
                self._wrong(start, "`;` inside of a branch" if word == ";" else f"`{word}` is not expected",
                            "close the branch with `]`" if word == ";" else
                            "a rung holds instructions and branches")
                return
            if count > MAX_ELEMENTS or len(open_) > MAX_DEPTH:
                deep = len(open_) > MAX_DEPTH
                self.reading.too_large(self.span(start, self.at), MAX_DEPTH if deep else MAX_ELEMENTS,
                                       "branches inside one another" if deep else "elements in one rung")
                return
        if len(open_) > 1:
            self._wrong(open_[-1].start, "a branch is not closed", "close it with `]`")
        elif open_[0].levels[0]:
            # The last `;` is often missing in texts that people write.
            yield tuple(open_[0].levels[0]), self._trimmed(begin, self.text.end)

    def _trimmed(self, start: int, end: int) -> Span:
        text = self.source.text[start:end]
        return self.span(start + len(text) - len(text.lstrip()), start + len(text.rstrip()))

    def _wrong(self, at: int, message: str, help: str) -> None:
        self.reading.malformed(self.span(at, at + 1), message, help=help)

    def instruction(self, word: str, start: int) -> Instruction | None:
        after = _TOKEN.match(self.source.text, self.at, self.text.end)
        if after is None or after[1] != "(":
            return Instruction(word.upper(), (), self.span(start, self.at))
        self.at = after.end()
        operands: list[Span] = []
        begin, closers = self.at, [")"]
        while closers:
            match = _IN_OPERANDS.search(self.source.text, self.at, self.text.end)
            if match is None or len(closers) > MAX_DEPTH:
                self._wrong(start, f"the operands of `{word}` do not end", "close them with `)`")
                return None
            self.at, sign = match.end(), match[0]
            if sign in "([":
                closers.append(")" if sign == "(" else "]")
            elif sign in ")]":
                if closers.pop() != sign:
                    self._wrong(match.start(), f"`{sign}` closes nothing here", "check the brackets")
                    return None
                if not closers:
                    operands.append(self._trimmed(begin, match.start()))
            elif sign == "," and len(closers) == 1:
                operands.append(self._trimmed(begin, match.start()))
                begin = self.at
            elif sign == "'":
                self._wrong(match.start(), "a string does not end", "close it with a quote")
                return None
        if len(operands) == 1 and operands[0].start >= operands[0].end:
            operands.clear()
        return Instruction(word.upper(), tuple(operands), self.span(start, self.at))
