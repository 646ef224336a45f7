"""Devices and constants: as operands of rungs, and as the variables that they become."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ldc.parser import ast
from ldc.parser.foreign import Reading
from ldc.parser.melsec.family import FX, Family
from ldc.parser.melsec.lines import Operand
from ldc.records import record
from ldc.source import Span

_DEVICE = re.compile(r"(S[MTD]|ZR|[XYMSTCDLVZBWFR])([0-9A-F]{1,8})\Z")
_BIT = re.compile(r"([A-Z]+[0-9A-F]+)\.([0-9A-F])\Z")
GROUP = re.compile(r"K([1-8])([XYMSLBF])([0-9A-F]+)\Z")
_CONSTANT = re.compile(r"K?([+-]?\d{1,11})\Z")
_HEX = re.compile(r"H([0-9A-F]{1,8})\Z")
_DIRECTIONS = range(8200, 8235)
"""Relays of FX that make the counters C200 to C234 count down."""

TIMERS, COUNTERS = frozenset(("T", "ST")), frozenset("C")
BITS = frozenset((*"XYMSTCLBF", "ST", "SM"))
COILS = frozenset("XYMSLBF")
WORDS = frozenset((*"DVZTCWR", "ZR", "ST", "SD"))
REGISTERS = frozenset((*"DVZWR", "ZR"))
ROWS = frozenset((*"DWR", "ZR"))
"""Registers that lie in long rows."""

_KEPT = frozenset(("L", "R", "ZR"))


@record
class Device:
    """``number``: as a number, however the controller counts; ``radix``: how it does. ``by_number``: whether
    the number tells the kind of a timer or counter, as in FX."""

    kind: str
    number: int
    radix: int = 10
    by_number: bool = True

    @property
    def name(self) -> str:
        if self.radix == 10:
            return f"{self.kind}{self.number}"
        return f"{self.kind}{self.number:o}" if self.radix == 8 else f"{self.kind}{self.number:X}"

    @property
    def is_long(self) -> bool:
        """Whether its value has 32 bits by itself."""
        return self.kind == "C" and self.number >= 200 and self.by_number

    @property
    def type(self) -> str:
        if self.kind == "ST" or self.kind == "T" and self.by_number and 246 <= self.number <= 255:
            return "FX_TIMER_ACC"
        if self.kind == "T":
            return "FX_TIMER"
        if self.kind == "C":
            return "FX_COUNTER_32" if self.is_long else "FX_COUNTER"
        return "INT" if self.kind in WORDS else "BOOL"

    @property
    def unit(self) -> int:
        """Of a timer whose number tells it, in milliseconds."""
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

    def __init__(self, reading: Reading, family: Family = FX) -> None:
        self.reading, self.family = reading, family
        self.used: dict[Device, Use] = {}
        self.functions: set[str] = set()

    # ---- operands

    def device(self, operand: Operand, kinds: frozenset[str], what: str) -> Device | None:
        match = _DEVICE.match(operand.text)
        radix = self.family.radix.get(match[1], 10) if match is not None else 10
        if match is None or match[1] not in kinds or match[1] not in self.family.most:
            if re.match(r"[A-Z]+\d+[0-9A-F]*[A-Z.]|[$@]", operand.text):
                self.reading.unsupported(operand.span, f"`{operand.text[:40]}`",
                                         "write indexed devices out device by device")
            elif match is not None and match[1] in kinds:
                self.reading.malformed(operand.span,
                                       f"{self.family.name} has no device `{operand.text[:40]}`",
                                       help="a comment `; QCPU` says for which controller a list is")
            else:
                self.reading.malformed(operand.span, f"`{operand.text[:40]}` is no {what}")
            return None
        kind, digits = match.groups()
        if not set(digits) <= set("0123456789ABCDEF"[:radix]):
            eights = ("X and Y are counted in eights: X7 is followed by X10; "
                      "for a controller of the Q series write a comment `; QCPU`")
            self.reading.malformed(operand.span, f"`{operand.text[:40]}` is no {what}",
                                   help=eights if radix == 8 else "")
            return None
        return self.numbered(kind, int(digits, radix), operand.span, what)

    def numbered(self, kind: str, number: int, span: Span, what: str) -> Device | None:
        family = self.family
        made = Device(kind, number, family.radix.get(kind, 10), not family.by_word)
        if number > family.most[kind]:
            self.reading.malformed(span, f"there is no {what} {made.name}")
            return None
        if kind == "C" and number >= 235 and made.by_number:
            self.reading.unsupported(span, f"the high-speed counter {made.name}", "use a counter below C235")
            return None
        known = kind == family.special and (family.known(number) or family is FX and number in _DIRECTIONS)
        if family.special_relay(kind, number) and not known:
            self.reading.unsupported(
                span, f"the special device {made.name}",
                "M8000 to M8003, the clocks M8011 to M8014 and M8200 to M8234 are known" if family is FX
                else "SM400 to SM403 and the clocks SM409 to SM413 are known")
            return None
        self.used.setdefault(made, Use(span))
        return made

    def write(self, operand: Operand, kinds: frozenset[str], what: str) -> ast.Name | None:
        """A variable that the list writes."""
        device = self.device(operand, kinds, what)
        return self.written(device, operand.span) if device is not None else None

    def written(self, device: Device, span: Span) -> ast.Name | None:
        if device.kind == self.family.special and self.family.known(device.number):
            self.reading.malformed(span, f"{device.name} is written by the controller alone")
            return None
        self.used[device].written = True
        return ast.Name(device.name, span)

    def bit(self, operand: Operand) -> ast.Expr | None:
        """What a contact reads: of timers and counters the done bit."""
        bit, family = _BIT.match(operand.text), self.family
        if bit is not None:
            word = self.device(Operand(bit[1], operand.span), REGISTERS, "register")
            return None if word is None else one_bit(ast.Name(word.name, operand.span), int(bit[2], 16))
        device = self.device(operand, BITS, "device with a contact")
        if device is None:
            return None
        name = ast.Name(device.name, operand.span)
        if device.kind == family.special and device.number in family.always:
            value = family.always[device.number]
            del self.used[device]
            return ast.Literal(value, "BOOL", "TRUE" if value else "FALSE", operand.span)
        if device.kind == family.special and device.number == family.later:
            del self.used[device]
            self.numbered(device.kind, family.first, operand.span, "relay")
            return ast.Unary("NOT", ast.Name(f"{device.kind}{family.first}", operand.span), operand.span)
        return ast.Member(name, "Q", operand.span) if device.kind in TIMERS | COUNTERS else name

    def group(self, operand: Operand) -> list[Device] | None:
        """The relays of a group such as K4M0, the lowest first; None when the operand is none (nothing is
        told then) or names what is not there."""
        match = GROUP.match(operand.text)
        first = self.device(Operand(f"{match[2]}{match[3]}", operand.span), COILS, "device with a coil"
                            ) if match is not None else None
        if first is None:
            return None
        found = [self.numbered(first.kind, first.number + n, operand.span, "device")
                 for n in range(4 * int(match[1]))]
        return None if None in found else found

    def word_bit(self, operand: Operand) -> tuple[ast.Name, int] | None:
        """The register and the number of the bit that are written by ``D0.5``."""
        match = _BIT.match(operand.text)
        word = self.device(Operand(match[1], operand.span), REGISTERS, "register") if match else None
        name = self.written(word, operand.span) if word is not None else None
        return None if name is None else (name, int(match[2], 16))

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
        if GROUP.match(operand.text):
            return self._gathered(operand, bits)
        device = self.device(operand, WORDS, "value")
        if device is None:
            return None
        name = ast.Name(device.name, operand.span)
        if device.is_long and bits == 16:
            self.reading.unsupported(operand.span, f"{device.name} as a value of 16 bits",
                                     "counters from C200 on have 32 bits: use the D form of the instruction")
            return None
        if device.kind in TIMERS | COUNTERS:
            found = ast.Member(name, "V", operand.span)
            return found if device.is_long or bits == 16 else _call("INT_TO_DINT", found)
        if bits == 16:
            return name
        if device.kind not in ROWS:
            self._pair(operand)
            return None
        other = self.numbered(device.kind, device.number + 1, operand.span, "data register")
        return self.call("FX_LONG", name, ast.Name(other.name, operand.span)) if other is not None else None

    def _gathered(self, operand: Operand, bits: int) -> ast.Expr | None:
        """The value of a group of relays."""
        relays = self.group(operand)
        if relays is None:
            return None
        if len(relays) > bits:
            self.reading.malformed(operand.span, f"{operand.text} has more than {bits} bits")
            return None
        names: list[ast.Expr] = [ast.Name(relay.name, operand.span) for relay in relays]
        if len(names) > 8:
            width = 16 if bits == 16 else 32
            names += [ast.Literal(False, None, "FALSE", operand.span)] * (width - len(names))
            return self.call(f"FX_GROUP_{width}", *names)
        string = "WORD" if bits == 16 else "DWORD"
        found: ast.Expr | None = None
        for at, name in enumerate(names):
            bit = _call(f"BOOL_TO_{string}", name)
            bit = _call("SHL", bit, ast.Literal(at, None, str(at), operand.span)) if at else bit
            found = bit if found is None else ast.Binary("OR", found, bit, operand.span)
        return _call(f"{string}_TO_{'INT' if bits == 16 else 'DINT'}", found)

    def registers(self, operand: Operand, count: int) -> list[ast.Name] | None:
        """Data registers that are written, from one on."""
        first = self.device(operand, REGISTERS, "data register")
        if first is None:
            return None
        if first.kind not in ROWS and count > 1:
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
            groups[("RETAIN",) if device.kind in _KEPT else ()].append(made)
        groups[()] += extra
        return tuple(ast.VarBlock("VAR", qualifiers, tuple(found), found[0].span)
                     for qualifiers, found in groups.items() if found)

    def helpers(self) -> list[tuple[Device, str, int | None]]:
        """Special relays that something has to drive: (relay, type, period), in order."""
        own = {d.number: d for d in self.used if d.kind == self.family.special}
        found = [(own[self.family.first], "FX_FIRST", None)] if self.family.first in own else []
        return found + [(own[n], "FX_CLOCK", period) for n, period in self.family.clocks.items() if n in own]


def one_bit(word: ast.Expr, number: int) -> ast.Binary:
    """A bit of an INT."""
    mask = ast.Literal(1 << number, "WORD", f"WORD#16#{1 << number:X}", word.span)
    none = ast.Literal(0, "WORD", "WORD#0", word.span)
    return ast.Binary("<>", ast.Binary("AND", _call("INT_TO_WORD", word), mask, word.span), none, word.span)


def _call(function: str, *values: ast.Expr) -> ast.Call:
    span = values[0].span
    return ast.Call(function, tuple(ast.Argument(None, value, False, span) for value in values), span)
