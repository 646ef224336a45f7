"""Variables of an LDmicro program: bits are BOOL, numbers are signed integers of 8, 16 or 32 bits.

Nothing is declared there but sizes: what an instruction names exists. Counters and timers (``C``, ``T``)
are as wide as their limits need, the others as VAR LIST says, 16 bits without one.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from ldc.parser import ast, fragments
from ldc.parser.foreign import Names, Reading
from ldc.parser.ldmicro.text import Leaf, Text
from ldc.source import Span

BIT, SINT, INT, DINT = "BOOL", "SINT", "INT", "DINT"
BITS = {SINT: 8, INT: 16, DINT: 32}
STRINGS = {SINT: "BYTE", INT: "WORD", DINT: "DWORD"}
_NAME = re.compile(r"[A-Za-z_]\w*\Z", re.ASCII)
_REGISTER = re.compile(r"#[A-Za-z]\w*\Z", re.ASCII)
_NUMBER = re.compile(r"([+-]?)(0[xX][0-9A-Fa-f]{1,16}|0[bB][01]{1,64}|0[oO][0-7]{1,22}|\d{1,18})\Z")
_CHARACTER = re.compile(r"'(\\?)(.)'\Z", re.DOTALL)
_ESCAPES = {"a": 7, "b": 8, "e": 27, "f": 12, "n": 10, "r": 13, "t": 9, "v": 11}
_SYSTEM = {"ROverflowFlagV": "the overflow flag"}


def number(text: str) -> int | None:
    """The value of a literal: decimal, ``0x``, ``0b``, ``0o``, or a character in quotes; None for a name."""
    character = _CHARACTER.match(text)
    if character:
        escaped, code = character.groups()
        return _ESCAPES.get(code, ord(code)) if escaped else ord(code)
    match = _NUMBER.match(text)
    if match is None:
        return None
    sign, digits = match.groups()
    value = int(digits, 0) if digits[:2].lower() in ("0x", "0b", "0o") else int(digits, 10)
    return -value if sign == "-" else value


def wider(*types: str) -> str:
    return max(types, key=BITS.__getitem__)


def needed(value: int) -> str:
    """The least type, of 16 bits at least, that holds a value."""
    return INT if -(1 << 15) <= value < 1 << 15 else DINT


@dataclass(slots=True)
class Variable:
    name: str
    type: str
    span: Span
    initial: str | None = None
    note: str | None = None
    retain: bool = False


@dataclass(slots=True)
class Variables:
    """All variables of the program. ``limits``: what counters and timers reach."""

    reading: Reading
    text: Text
    names: Names
    limits: dict[str, str] = field(default_factory=dict)
    found: dict[str, Variable] = field(default_factory=dict)

    def bit(self, foreign: str, span: Span) -> str:
        return self._use(foreign, BIT, span).name

    def integer(self, foreign: str, span: Span) -> Variable:
        """The variable of a number."""
        return self._use(foreign, self._type(foreign, span), span)

    def added(
        self, wanted: str, type_: str, span: Span, why: str, initial: str | None, key: str
    ) -> Variable:
        """A variable that the file has no name for; the same one for the same ``key``."""
        known = self.found.get(f"+{key}")
        if known is None:
            known = self.found[f"+{key}"] = Variable(self.names.fresh(wanted), type_, span, initial, why)
            self.reading.remark("added", known.name, why, span)
        return known

    def _type(self, foreign: str, span: Span) -> str:
        known = self.found.get(foreign)
        if known is not None and known.type != BIT:
            return known.type
        size, where = self.text.sizes.get(foreign, (2, span))
        if size > 4:
            self.reading.unsupported(
                where, f"`{foreign}` of {size} bytes", "variables have 1 to 4 bytes here"
            )
        elif size == 3:
            self.reading.remark("mapped", foreign, "24 bits became 32: only its overflow differs", where)
        declared = {0: INT, 1: SINT, 2: INT}.get(size, DINT)
        if foreign[:1] in ("T", "C"):
            return wider(INT, declared, self.limits.get(foreign, INT))
        return declared

    def _use(self, foreign: str, type_: str, span: Span) -> Variable:
        known = self.found.get(foreign)
        if known is None:
            if foreign in _SYSTEM:
                self.reading.unsupported(
                    span, f"{_SYSTEM[foreign]} `{foreign}`", "compare the operands instead"
                )
            elif _REGISTER.match(foreign):
                self.reading.remark("mapped", foreign, f"a variable {foreign[1:]}: the pins of a port are "
                                    "variables of their own, which do not follow it", span)
            elif not _NAME.match(foreign):
                self.reading.unsupported(
                    span, f"`{foreign[:40]}` as a variable",
                    "memory of the chip and elements of arrays have no name here: use a variable")
            pin = self.text.pins.get(foreign, (0, span))[0]
            name = self.names.name(foreign, span, foreign)
            known = Variable(name, type_, span, note=f"pin {pin}" if pin > 0 else None)
            self.found[foreign] = known
        elif known.type != type_:
            self.reading.malformed(span, f"`{foreign[:40]}` is a bit in one place and a number in another")
            return Variable(known.name, type_, span)
        return known


def limits(text: Text, periods: dict[int, int | None]) -> dict[str, str]:
    """How wide counters and timers are: ``periods`` by the place of a timer's line."""
    found: dict[str, str] = {}
    for rung in text.rungs:
        for leaf in rung.leaves():
            for value in _reached(leaf, periods):
                found[leaf.args[0]] = wider(found.get(leaf.args[0], INT), needed(value))
    return found


def _reached(leaf: Leaf, periods: dict[int, int | None]) -> list[int]:
    if leaf.word in ("CTU", "CTD", "CTC", "CTR"):
        return [value for text in leaf.args[1:3] if (value := number(text)) is not None]
    period = periods.get(leaf.span.start)
    return [period] if period is not None else []


def sections(kind: str, variables: Iterable[Variable]) -> tuple[ast.VarBlock, ...]:
    """The declarations of variables; those that keep their values are apart."""
    blocks = []
    for retain in (False, True):
        chosen = [v for v in variables if v.retain == retain]
        declared = tuple(fragments.variable(v.name, v.type, v.span, initial=v.initial, note=v.note)
                         for v in chosen)
        if declared:
            blocks.append(ast.VarBlock(kind, ("RETAIN",) if retain else (), declared, chosen[0].span))
    return tuple(blocks)
