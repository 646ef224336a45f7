"""Devices and constants of FX controllers: as operands of rungs, and as the variables that they become."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ldc.parser import ast
from ldc.parser.foreign import Reading
from ldc.parser.melsec.lines import Operand
from ldc.records import record
from ldc.source import Span

_DEVICE = re.compile(r"([XYMSTCDLVZ])(\d{1,6})\Z")
_CONSTANT = re.compile(r"K?([+-]?\d{1,11})\Z")
_HEX = re.compile(r"H([0-9A-F]{1,8})\Z")
_MOST = {"X": 0o17777, "Y": 0o17777, "T": 511, "C": 255, "M": 8511, "S": 4095, "L": 9999, "D": 8511,
         "V": 7, "Z": 7}
_CLOCKS = {8011: 10, 8012: 100, 8013: 1000, 8014: 60_000}
"""Special relays that are on in the first half of every period, in milliseconds."""

_DIRECTIONS = range(8200, 8235)
_ALWAYS = {8000: True, 8001: False}
_FIRST, _LATER = 8002, 8003
BITS = frozenset("XYMSTCL")
WORDS = frozenset("DVZTC")


@record
class Device:
    """``number``: counted in eights for X and Y, as the controller does, here as a number."""

    kind: str
    number: int

    @property
    def name(self) -> str:
        return f"{self.kind}{self.number:o}" if self.kind in "XY" else f"{self.kind}{self.number}"

    @property
    def is_long(self) -> bool:
        """Whether its value has 32 bits by itself."""
        return self.kind == "C" and self.number >= 200

    @property
    def type(self) -> str:
        if self.kind == "T":
            return "FX_TIMER_ACC" if 246 <= self.number <= 255 else "FX_TIMER"
        if self.kind == "C":
            return "FX_COUNTER_32" if self.is_long else "FX_COUNTER"
        return "INT" if self.kind in "DVZ" else "BOOL"

    @property
    def unit(self) -> int:
        """Of a timer, in milliseconds."""
        if self.number < 200 or 250 <= self.number <= 255:
            return 100
        return 10 if self.number < 246 else 1


@dataclass(slots=True)
class Use:
    """Where a device occurs first; ``written``: whether the list writes it."""

    span: Span
    written: bool = False


class Devices:
    """Operands to expressions; remembers which devices occur. What cannot be read is told and gives None."""

    def __init__(self, reading: Reading) -> None:
        self.reading = reading
        self.used: dict[Device, Use] = {}
        self.functions: set[str] = set()

    # ---- operands

    def device(self, operand: Operand, kinds: frozenset[str], what: str) -> Device | None:
        match = _DEVICE.match(operand.text)
        if match is None or match[1] not in kinds:
            if re.match(r"[A-Z]+\d+[A-Z.]", operand.text):
                self.reading.unsupported(
                    operand.span, f"`{operand.text[:40]}`",
                    "write groups of bits, bits of words and indexed devices out device by device")
            else:
                self.reading.malformed(operand.span, f"`{operand.text[:40]}` is no {what}")
            return None
        kind, digits = match.groups()
        if kind in "XY" and not set(digits) <= set("01234567"):
            self.reading.malformed(operand.span, f"`{operand.text}` is no {what}",
                                   help="X and Y are counted in eights: X7 is followed by X10")
            return None
        return self.numbered(kind, int(digits, 8 if kind in "XY" else 10), operand.span, what)

    def numbered(self, kind: str, number: int, span: Span, what: str) -> Device | None:
        made = Device(kind, number)
        if number > _MOST[kind]:
            self.reading.malformed(span, f"there is no {what} {made.name}")
            return None
        if kind == "C" and number >= 235:
            self.reading.unsupported(span, f"the high-speed counter {made.name}", "use a counter below C235")
            return None
        special = kind in "MD" and number >= 8000
        known = kind == "M" and (number in _ALWAYS or number in (_FIRST, _LATER) or number in _CLOCKS
                                 or number in _DIRECTIONS)
        if special and not known:
            self.reading.unsupported(span, f"the special device {made.name}",
                                     "M8000 to M8003, the clocks M8011 to M8014 and M8200 to M8234 are known")
            return None
        self.used.setdefault(made, Use(span))
        return made

    def write(self, operand: Operand, kinds: frozenset[str], what: str) -> ast.Name | None:
        """A variable that the list writes."""
        device = self.device(operand, kinds, what)
        return self.written(device, operand.span) if device is not None else None

    def written(self, device: Device, span: Span) -> ast.Name | None:
        if device.kind == "M" and device.number in (*_ALWAYS, _FIRST, _LATER, *_CLOCKS):
            self.reading.malformed(span, f"{device.name} is written by the controller alone")
            return None
        self.used[device].written = True
        return ast.Name(device.name, span)

    def bit(self, operand: Operand) -> ast.Expr | None:
        """What a contact reads: of timers and counters the done bit."""
        device = self.device(operand, BITS, "device with a contact")
        if device is None:
            return None
        name = ast.Name(device.name, operand.span)
        if device.kind == "M" and device.number in _ALWAYS:
            value = _ALWAYS[device.number]
            del self.used[device]
            return ast.Literal(value, "BOOL", "TRUE" if value else "FALSE", operand.span)
        if device.kind == "M" and device.number == _LATER:
            del self.used[device]
            self.numbered("M", _FIRST, operand.span, "relay")
            return ast.Unary("NOT", ast.Name(f"M{_FIRST}", operand.span), operand.span)
        return ast.Member(name, "Q", operand.span) if device.kind in "TC" else name

    def constant(self, operand: Operand, bits: int) -> ast.Literal | None:
        """``K10``, ``H1F``, ``10``; None when it is none. Hexadecimal ones are patterns of bits."""
        match = _CONSTANT.match(operand.text)
        pattern = _HEX.match(operand.text)
        if match is None and pattern is None:
            return None
        value = int(match[1]) if match else int(pattern[1], 16)
        if pattern and 1 << (bits - 1) <= value < 1 << bits:
            value -= 1 << bits
        if not -(1 << (bits - 1)) <= value < 1 << (bits - 1):
            self.reading.malformed(operand.span, f"{operand.text} has more than {bits} bits")
            value = 0
        return ast.Literal(value, None, str(value), operand.span)

    def value(self, operand: Operand, bits: int) -> ast.Expr | None:
        """A value of 16 bits (INT) or 32 bits (DINT)."""
        found = self.constant(operand, bits)
        if found is not None:
            return found
        device = self.device(operand, WORDS, "value")
        if device is None:
            return None
        name = ast.Name(device.name, operand.span)
        if device.is_long and bits == 16:
            self.reading.unsupported(operand.span, f"{device.name} as a value of 16 bits",
                                     "counters from C200 on have 32 bits: use the D form of the instruction")
            return None
        if device.kind in "TC":
            found = ast.Member(name, "V", operand.span)
            return found if device.is_long or bits == 16 else _call("INT_TO_DINT", found)
        if bits == 16:
            return name
        if device.kind != "D":
            self._pair(operand)
            return None
        other = self.numbered(device.kind, device.number + 1, operand.span, "data register")
        return self.call("FX_LONG", name, ast.Name(other.name, operand.span)) if other is not None else None

    def registers(self, operand: Operand, count: int) -> list[ast.Name] | None:
        """Data registers that are written, from one on."""
        first = self.device(operand, frozenset("DVZ"), "data register")
        if first is None:
            return None
        if first.kind != "D" and count > 1:
            self._pair(operand)
            return None
        found = [self.numbered(first.kind, first.number + n, operand.span, "data register")
                 for n in range(count)]
        return None if None in found else [self.written(d, operand.span) for d in found]

    def _pair(self, operand: Operand) -> None:
        self.reading.unsupported(operand.span, f"`{operand.text}` as a value of 32 bits",
                                 "use data registers")

    def call(self, function: str, *values: ast.Expr) -> ast.Call:
        self.functions.add(function)
        return _call(function, *values)

    # ---- variables

    def sections(self, notes: dict[str, str], extra: list[ast.VarDecl]) -> tuple[ast.VarBlock, ...]:
        """A variable for each device that occurs. ``notes``: what comments say of them, by name."""
        groups: dict[tuple[str, ...], list[ast.VarDecl]] = {(): [], ("RETAIN",): []}
        for device, use in sorted(self.used.items(), key=lambda item: (item[0].kind, item[0].number)):
            location = None
            if device.kind == "Y" or device.kind == "X" and not use.written:
                area = "I" if device.kind == "X" else "Q"
                location = f"%{area}X{device.number // 8}.{device.number % 8}"
                self.reading.remark("mapped", device.name, location, use.span)
            elif device.kind == "X":
                self.reading.remark("mapped", device.name,
                                    "a variable without an address, since it is written", use.span)
            else:
                self.reading.remark("added", device.name, f"a variable of type {device.type}", use.span)
            made = ast.VarDecl(device.name, location, ast.NamedType(device.type, None, use.span), None,
                               use.span, use.span, notes.get(device.name))
            groups[("RETAIN",) if device.kind == "L" else ()].append(made)
        groups[()] += extra
        return tuple(ast.VarBlock("VAR", qualifiers, tuple(found), found[0].span)
                     for qualifiers, found in groups.items() if found)

    def helpers(self) -> list[tuple[str, str, int | None]]:
        """Special relays that something has to drive: (relay, type, period), in order."""
        found = [(f"M{_FIRST}", "FX_FIRST", None)] if Device("M", _FIRST) in self.used else []
        return found + [(f"M{n}", "FX_CLOCK", period) for n, period in _CLOCKS.items()
                        if Device("M", n) in self.used]


def _call(function: str, *values: ast.Expr) -> ast.Call:
    span = values[0].span
    return ast.Call(function, tuple(ast.Argument(None, value, False, span) for value in values), span)
