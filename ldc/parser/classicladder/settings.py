"""The tables of a ClassicLadder project: presets, symbols, sections, expressions, steps and transitions."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from ldc.parser.classicladder.container import Line, Part
from ldc.parser.foreign import Reading
from ldc.records import record
from ldc.source import Span

BASES = (60_000, 1_000, 100)
"""Milliseconds of the bases 0, 1 and 2."""
LADDER, SEQUENTIAL = 0, 1
CLASSIC, SYSTEM_BITS, REGISTERS = 0, 1, 2
SWITCHES = 10
_NUMBERED = re.compile(r"(\d{4}),(.*)\Z", re.DOTALL)
_NAMED = re.compile(r"[A-Z]{1,2}(\d{1,4}),(.*)\Z", re.DOTALL)
_CONDITION = re.compile(r"C(\d{1,4}),\d+,(\d{1,4})/(\d{1,6})\s*\Z")


@record
class Preset:
    """Of a timer or counter: ``base`` in milliseconds, ``preset`` in units of it, ``mode`` (IEC)."""

    base: int
    preset: int
    mode: int
    span: Span


@record
class Section:
    """``subroutine`` is -1 for a main section; ``first`` and ``last`` are rungs."""

    number: int
    name: str
    language: int
    subroutine: int
    first: int
    last: int
    page: int
    span: Span


@record
class Step:
    """``number`` is what %X is called by."""

    initial: bool
    number: int
    page: int
    span: Span


@dataclass(slots=True)
class Transition:
    """``activates``, ``deactivates``: indexes of steps; ``condition``: type and offset of a variable."""

    activates: list[int]
    deactivates: list[int]
    page: int
    span: Span
    condition: tuple[int, int] = (0, 0)


@dataclass(slots=True)
class Settings:
    """``age`` of the tool: CLASSIC up to 0.8 and in LinuxCNC, or what has system bits, or registers too."""

    age: int = CLASSIC
    period: int = 50
    sizes: dict[str, int] = field(default_factory=dict)
    timers: dict[int, Preset] = field(default_factory=dict)
    monostables: dict[int, Preset] = field(default_factory=dict)
    counters: dict[int, Preset] = field(default_factory=dict)
    timers_iec: dict[int, Preset] = field(default_factory=dict)
    symbols: dict[str, tuple[str, str, Span]] = field(default_factory=dict)
    sections: list[Section] = field(default_factory=list)
    expressions: dict[int, Line] = field(default_factory=dict)
    steps: dict[int, Step] = field(default_factory=dict)
    transitions: dict[int, Transition] = field(default_factory=dict)


def settings(reading: Reading, parts: dict[str, Part]) -> Settings:
    found = Settings()
    general = parts.get("general.txt")
    if general is not None:
        found.period = general.integer("PERIODIC_REFRESH", 50)
        found.sizes = {key: general.integer(key, 0) for key in general.settings if key.startswith("SIZE_")}
        if not 1 <= found.period <= 3_600_000:
            reading.malformed(general.span, f"a period of {found.period} ms")
            found.period = 50
    if "SIZE_NBR_REGISTERS" in found.sizes:
        found.age = REGISTERS
    elif "project_infos.txt" in parts:
        found.age = SYSTEM_BITS
    for name in ("timers", "monostables", "counters", "timers_iec"):
        if f"{name}.csv" in parts:
            setattr(found, name, _table(reading, name, parts[f"{name}.csv"]))
    if "symbols.csv" in parts:
        for line in parts["symbols.csv"].written:
            variable, symbol, comment = (*(part.strip() for part in line.text.split(",", 2)), "", "")[:3]
            if symbol and symbol != variable:
                found.symbols[variable.upper()] = (symbol, comment, line.span)
    if "sections.csv" in parts:
        found.sections = _sections(reading, parts["sections.csv"])
    if "arithmetic_expressions.csv" in parts:
        found.expressions = _expressions(parts["arithmetic_expressions.csv"])
    if "sequential.csv" in parts:
        _sequential(reading, parts["sequential.csv"], found)
    return found


def _table(reading: Reading, name: str, part: Part) -> dict[int, Preset]:
    """Rows follow each other, or begin with their names (``T3,1,10``); then rows without a preset are not
    there."""
    rows: dict[int, Preset] = {}
    for line in part.written:
        named = _NAMED.match(line.text)
        if named is None:
            rows[len(rows)] = _preset(reading, name, line)
        else:
            rows[int(named[1])] = _preset(reading, name, _behind(line, named))
    return rows


def _behind(line: Line, match: re.Match[str]) -> Line:
    """What stands behind the number (group 2)."""
    span = line.span
    return Line(match[2], Span(span.source, span.start + match.start(2), span.end))


def _preset(reading: Reading, name: str, line: Line) -> Preset:
    numbers = line.integers()
    count = {"counters": 1, "timers_iec": 3}.get(name, 2)
    if numbers is None or len(numbers) < count:
        reading.malformed(line.span, f"{name}.csv: `{line.text[:40]}` is no row of {count} numbers")
        return Preset(1_000, 0, 0, line.span)
    if name == "counters":
        return Preset(1, numbers[0], 0, line.span)
    if not 0 <= numbers[0] < len(BASES):
        reading.malformed(line.span, f"{name}.csv: there is no time base {numbers[0]}")
        return Preset(1_000, 0, 0, line.span)
    base = BASES[numbers[0]]
    if abs(numbers[1]) * base >= 1 << 31:
        reading.malformed(line.span, f"{name}.csv: a preset of {numbers[1]} x {base} ms is too long")
        return Preset(base, 0, 0, line.span)
    return Preset(base, numbers[1], numbers[2] if name == "timers_iec" else 0, line.span)


def _sections(reading: Reading, part: Part) -> list[Section]:
    found = []
    for line in part.written:
        numbers = line.integers()
        if numbers is None or len(numbers) < 6:
            reading.malformed(line.span, f"sections.csv: `{line.text[:40]}` is no row of 6 numbers")
            continue
        name = part.setting(f"NAME{numbers[0]:03d}").strip() or f"section_{numbers[0]}"
        found.append(Section(numbers[0], name, *numbers[1:6], line.span))
    return sorted(found, key=lambda section: section.number)


def _expressions(part: Part) -> dict[int, Line]:
    """By number: named by it since version 2, one a line before. What has no number follows the line
    before."""
    found: dict[int, Line] = {}
    number = 0
    for line in part.lines:
        match = _NUMBERED.match(line.text)
        if match:
            number, line = int(match[1]), _behind(line, match)
        found[number] = line
        number += 1
    return found


def _sequential(reading: Reading, part: Part, found: Settings) -> None:
    for line in part.written:
        kind, numbers = line.text[:1], Line(line.text[1:], line.span).integers()
        condition = _CONDITION.match(line.text)
        if kind == "N":
            continue
        if kind == "S" and numbers is not None and len(numbers) >= 4:
            found.steps[numbers[0]] = Step(numbers[1] != 0, numbers[2], numbers[3], line.span)
        elif kind == "T" and numbers is not None and len(numbers) >= 4 * SWITCHES + 2:
            lists = [numbers[1 + n * SWITCHES : 1 + (n + 1) * SWITCHES] for n in range(2)]
            on, off = ([*steps, -1][: [*steps, -1].index(-1)] for steps in lists)
            found.transitions[numbers[0]] = Transition(on, off, numbers[4 * SWITCHES + 1], line.span)
        elif condition and int(condition[1]) in found.transitions:
            found.transitions[int(condition[1])].condition = (int(condition[2]), int(condition[3]))
        else:
            reading.malformed(
                line.span, f"sequential.csv: `{line.text[:40]}` is no step, transition or condition"
            )
    for number, transition in list(found.transitions.items()):
        if any(step not in found.steps for step in (*transition.activates, *transition.deactivates)):
            del found.transitions[number]
            reading.malformed(transition.span, "a transition leads from or to a step that does not exist")
