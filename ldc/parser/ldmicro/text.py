"""The lines of an LDmicro project: settings, lists, and rungs as trees of series and parallels.

A project is a list of ``KEY=value`` lines, the sections ``VAR LIST`` and ``IO LIST`` up to ``END``, and
behind ``PROGRAM`` the rungs, each ``RUNG`` to ``END`` with one instruction a line.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from ldc.parser.foreign import Reading
from ldc.records import record
from ldc.source import Span

MAX_LINES, MAX_DEPTH, MAX_RUNGS = 200_000, 40, 20_000
SERIES, PARALLEL = "SERIES", "PARALLEL"
_WORDS = re.compile(r"'(?:\\.|[^'\\])'|\S+")
_PIN = re.compile(r"(\S+)\s+at\s+(-?\d+)")
_SIZE = re.compile(r"(\d+)\s+(?:signed\s+|unsigned\s+)?bytes?\s+(\S+)")


@record
class Leaf:
    """An instruction: ``word`` and its operands ``args``; ``rest`` is the text behind the word."""

    word: str
    args: tuple[str, ...]
    rest: str
    span: Span


@dataclass(slots=True)
class Group:
    """``kind``: SERIES or PARALLEL."""

    kind: str
    span: Span
    parts: list[Leaf | Group] = field(default_factory=list)

    def leaves(self) -> Iterator[Leaf]:
        """All instructions, in the order of the text."""
        work: list[Leaf | Group] = [self]
        while work:
            part = work.pop()
            if isinstance(part, Leaf):
                yield part
            else:
                work += reversed(part.parts)


@dataclass(slots=True)
class Text:
    """What was read. ``settings``: the key in capitals to its value; ``pins`` and ``sizes`` by name (a pin
    of the chip, bytes of a variable); ``head`` is the first line."""

    head: Span
    version: str = "0.1"
    settings: dict[str, tuple[str, Span]] = field(default_factory=dict)
    pins: dict[str, tuple[int, Span]] = field(default_factory=dict)
    sizes: dict[str, tuple[int, Span]] = field(default_factory=dict)
    rungs: list[Group] = field(default_factory=list)


def read_text(reading: Reading) -> Text:
    """The whole file. Reading stops where its structure breaks (LD0150) or at a limit (LD0153)."""
    lines = [(line, span) for line, span in _lines(reading) if line]
    text = Text(lines[0][1])
    text.version = "0.1" if lines[0][0] == "LDmicro0.1" else "0.2"
    at = 1
    while at < len(lines) and lines[at][0] != "PROGRAM":
        line, span = lines[at]
        at += 1
        if line in ("IO LIST", "VAR LIST"):
            at = _listed(reading, text, line, lines, at)
        elif "=" in line:
            key, value = line.split("=", 1)
            text.settings[key.strip().upper()] = (value.strip(), span)
        else:
            reading.malformed(span, f"`{line[:40]}` is no setting and no list")
    if at == len(lines):
        reading.malformed(lines[-1][1], "the line PROGRAM is missing", "the file ends here")
        return text
    _rungs(reading, text, lines, at + 1)
    return text


def _lines(reading: Reading) -> Iterator[tuple[str, Span]]:
    """Each line without space around it, and its place."""
    at = 0
    for number, raw in enumerate(reading.source.text.split("\n")):
        line = raw.strip()
        start = at + len(raw) - len(raw.lstrip())
        span = reading.span(start, start + len(line))
        if number >= MAX_LINES:
            reading.too_large(span, MAX_LINES, "lines")
            return
        yield line, span
        at += len(raw) + 1


def _listed(reading: Reading, text: Text, kind: str, lines: list[tuple[str, Span]], at: int) -> int:
    """The entries up to END; where reading goes on."""
    target, pattern = (text.pins, _PIN) if kind == "IO LIST" else (text.sizes, _SIZE)
    begin = lines[at - 1][1]
    while at < len(lines):
        line, span = lines[at]
        at += 1
        if line == "END":
            return at
        match = pattern.match(line)
        if match is None:
            reading.malformed(span, f"`{line[:40]}` is no entry of {kind}")
        elif kind == "IO LIST":
            target[match[1]] = (int(match[2][:9]), span)
        else:
            target[match[2]] = (int(match[1][:9]), span)
    reading.malformed(begin, f"{kind} has no END", "begins here")
    return at


def _rungs(reading: Reading, text: Text, lines: list[tuple[str, Span]], at: int) -> None:
    stack: list[Group] = []
    for line, span in lines[at:]:
        if line.startswith(";"):
            continue
        word = _WORDS.match(line)[0]
        if not stack:
            if word != "RUNG":
                reading.malformed(span, f"`{line[:40]}` stands outside of a rung", "RUNG was expected")
                return
            if len(text.rungs) == MAX_RUNGS:
                reading.too_large(span, MAX_RUNGS, "rungs")
                return
            stack.append(Group(SERIES, span))
            text.rungs.append(stack[0])
        elif line in (SERIES, PARALLEL):
            if len(stack) >= MAX_DEPTH:
                reading.too_large(span, MAX_DEPTH, "groups inside of each other")
                return
            group = Group(line, span)
            stack[-1].parts.append(group)
            stack.append(group)
        elif line == "END":
            stack.pop()
        else:
            rest = line[len(word):].strip()
            stack[-1].parts.append(Leaf(word, tuple(_WORDS.findall(rest)), rest, span))
    if stack:
        reading.malformed(stack[-1].span, "a rung or group has no END", "begins here")
