"""Instructions behind the contacts: coils, timers, counters, and those that move and compute data."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from ldc.parser import ast
from ldc.parser.melsec.devices import COILS, COUNTERS, GROUP, REGISTERS, ROWS, TIMERS, Device, Devices
from ldc.parser.melsec.lines import Instruction, Operand
from ldc.source import Span

MAX_RANGE = 1_024
"""Devices that one instruction writes."""

NO_WIRE = "_"
_STEPS = {"INC": "ADD", "DEC": "SUB"}
_SIGNS = {"+": "ADD", "-": "SUB", "*": "MUL", "/": "DIV"}
_UNITS = {"OUT": 100, "OUTH": 10, "OUTHS": 1}
"""Milliseconds of a timer where the instruction tells them."""

_FORM = re.compile(r"(D)?(MOV|ADD|SUB|MUL|DIV|INC|DEC|CMP|NEG|CML|BCD|BIN|XCH|[-+*/])(P)?\Z")
_WORDWISE = re.compile(r"([WD])(AND|OR|XOR)(P)?\Z")
_PLAIN = re.compile(r"(ZRST|BMOV|FMOV|ALT)(P)?\Z")


Operands = tuple[Operand, ...]
Paths = list[list[ast.Item]] | None
"""Parallel paths, None when an operand cannot be read."""


class Outputs:
    """Writes instructions as items of a rung: a list of paths that lie parallel; None when one cannot be read
    (that is told). ``instance(base, type, span)`` declares an instance of a function block; ``targets``: what
    labels mean that are not the name of a rung."""

    def __init__(self, devices: Devices, instance: Callable[[str, str, Span], ast.Name],
                 targets: Mapping[str, str]) -> None:
        self.devices, self.reading, self.instance = devices, devices.reading, instance
        self.targets = targets

    def write(self, it: Instruction) -> Paths:
        """The paths of an output; an empty list when the word is no output."""
        if it.name in _SIMPLE:
            operands = self.operands(it, _SIMPLE[it.name][0])
            return None if operands is None else _SIMPLE[it.name][1](self, it, operands)
        for pattern in (_FORM, _WORDWISE, _PLAIN):
            match = pattern.match(it.name)
            if match is not None:
                return self._data(it, match)
        return []

    def operands(self, it: Instruction, counts: range) -> Operands | None:
        if len(it.operands) in counts:
            return it.operands
        wanted = " or ".join(map(str, counts))
        self.reading.malformed(it.span, f"{it.name} has {wanted} operands, here are {len(it.operands)}")
        return None

    # ---- coils

    def _coil(self, it: Instruction, operands: Operands) -> Paths:
        kind = re.match(r"[A-Z]*", operands[0].text)[0]
        counts = kind in TIMERS | COUNTERS
        if it.name in _UNITS and counts and len(operands) == 2:
            return self._timer_or_counter(it, operands)
        if it.name == "RST" and counts:
            device = self.devices.device(operands[0], TIMERS | COUNTERS, "timer or counter")
            return [[self._reset(device, it.span)]] if device is not None else None
        if "." in operands[0].text and it.name in ("OUT", "SET", "RST") and len(operands) == 1:
            return self._bit_of_word(it, operands[0])
        if it.name == "RST" and kind in REGISTERS:
            names = self.devices.registers(operands[0], 1)
            return [[_move(_number(0, it.span), names[0], it.span)]] if names else None
        if len(operands) != 1 or it.name not in _MODIFIERS and not counts:
            self.operands(it, range(2, 3) if it.name not in _MODIFIERS else range(1, 2))
            return None
        if it.name in _UNITS and counts:
            self.reading.malformed(it.span, f"{it.span.text} has no preset", "it takes two operands",
                                   f"write `{it.span.text} K10`, or the D that holds the preset")
            return None
        target = self.devices.write(operands[0], COILS, "device with a coil")
        return [[ast.Coil(_MODIFIERS[it.name], target, it.span)]] if target is not None else None

    def _bit_of_word(self, it: Instruction, operand: Operand) -> Paths:
        """OUT, SET or RST of D0.5."""
        found = self.devices.word_bit(operand)
        if found is None:
            return None
        word, number = found
        pins = [("W", word), ("N", _number(number, it.span))]
        self.devices.functions.add("FX_PUT_BIT")
        if it.name == "OUT":
            pins = [ast.Pin(name, value, False, it.span) for name, value in pins]
            pins.append(ast.Pin("OUT", word, True, it.span))
            return [[ast.Block(None, "FX_PUT_BIT", tuple(pins), "IN", NO_WIRE, it.span)]]
        on = ast.Literal(it.name == "SET", "BOOL", "TRUE" if it.name == "SET" else "FALSE", it.span)
        return [[_block("FX_PUT_BIT", it.span, [("IN", on), *pins], [("OUT", word)])]]

    def _invert(self, it: Instruction, operands: Operands) -> Paths:
        """FF: a rise of the power turns the device."""
        target = self.devices.write(operands[0], COILS, "device with a coil")
        if target is None:
            return None
        return [[*self._pulse(True, it.span), _move(ast.Unary("NOT", target, it.span), target, it.span)]]

    def _timer_or_counter(self, it: Instruction, operands: Operands) -> Paths:
        device = self.devices.device(operands[0], TIMERS | COUNTERS, "timer or counter")
        preset = self.devices.value(operands[1], 32 if device is not None and device.is_long else 16)
        if device is None or preset is None:
            return None
        pins = [("K", preset)]
        if it.name != "OUT" and (device.kind == "C" or device.by_number):
            self.reading.malformed(it.span, f"{it.name} of {device.name}", help="OUT is for this device")
            return None
        if device.kind in TIMERS:
            unit = device.unit if device.by_number else _UNITS[it.name]
            pins.append(("UNIT", _number(unit, it.span)))
        elif device.is_long:
            direction = Device("M", 8000 + device.number)
            if direction in self.devices.used:
                pins.append(("DOWN", ast.Name(direction.name, it.span)))
        return [[self._instance_of(device, pins, it.span, None)]]

    def _reset(self, device: Device, span: Span) -> ast.Block:
        return self._instance_of(device, [], span, "R")

    def _instance_of(self, device: Device, pins: list, span: Span, power: str | None) -> ast.Block:
        inputs = tuple(ast.Pin(name, value, False, span) for name, value in pins)
        return ast.Block(ast.Name(device.name, span), device.type, inputs, power, NO_WIRE, span)

    def _jump(self, it: Instruction, operands: Operands) -> Paths:
        label = label_of(operands[0].text)
        if label is None:
            self.reading.malformed(operands[0].span, f"`{operands[0].text[:40]}` is no label",
                                   help="labels are P0 to P4095")
            return None
        jump = ast.Jump(self.targets.get(label, label), it.span)
        return [[*self._pulse(it.name == "CJP", it.span), jump]]

    # ---- data

    def _pulse(self, wanted: bool, span: Span) -> list[ast.Item]:
        if not wanted:
            return []
        return [ast.Block(self.instance("pulse", "R_TRIG", span), "R_TRIG", (), None, None, span)]

    def _data(self, it: Instruction, match: re.Match) -> Paths:
        if match.re is _PLAIN:
            name, long, pulse = match[1], False, match[2]
        elif match.re is _WORDWISE:
            name, long, pulse = match[2], match[1] == "D", match[3]
        else:
            name, long, pulse = _SIGNS.get(match[2], match[2]), bool(match[1]), match[3]
        kind = "BITWISE" if match.re is _WORDWISE else name
        count, write = _DATA[kind]
        two = kind == "BITWISE" or match[2] in ("+", "-")
        operands = self.operands(it, range(count - two, count + 1))
        if operands is not None and len(operands) == 2 and two:
            # D := D op S is written `op S D`.
            operands = (operands[1], operands[0], operands[1])
        found = write(self, it, name, 32 if long else 16, operands) if operands is not None else None
        before = self._pulse(bool(pulse), it.span) if found else []
        if not before:
            return found
        return [[*before, *found[0]]] if len(found) == 1 else [[*before, ast.Branches(
            tuple(ast.Path(tuple(path), it.span) for path in found), it.span)]]

    def _values(self, operands: Operands, bits: int) -> list[ast.Expr] | None:
        found = [self.devices.value(operand, bits) for operand in operands]
        return None if None in found else found

    def _store(self, value: ast.Expr, operand: Operand, bits: int, span: Span) -> Paths:
        """A value into one data register or two, or into a group of relays."""
        if operand.text[:1] == "K":
            return self._spread(value, operand, bits, span)
        targets = self.devices.registers(operand, bits // 16)
        if targets is None:
            return None
        if bits == 16:
            return [[_move(value, targets[0], span)]]
        self.devices.functions.add("FX_SPLIT")
        return [[_block("FX_SPLIT", span, [("IN", value)], [("OUT", targets[0]), ("HI", targets[1])])]]

    def _spread(self, value: ast.Expr, operand: Operand, bits: int, span: Span) -> Paths:
        """A value into relays, the lowest bit first."""
        relays = self.devices.group(operand)
        if relays is None:
            if self.devices.constant(operand, bits) is not None:
                self.reading.malformed(operand.span, f"`{operand.text[:40]}` cannot be written")
            return None
        type_, string = ("INT", "WORD") if bits == 16 else ("DINT", "DWORD")
        paths: list[list[ast.Item]] = []
        if not isinstance(value, (ast.Literal, ast.Name)):
            kept = self.instance("value", type_, span)
            paths.append([_move(value, kept, span)])
            value = kept
        for at, relay in enumerate(relays[:bits]):
            target = self.devices.written(relay, operand.span)
            if target is None:
                return None
            mask = ast.Literal(1 << at, string, f"{string}#16#{1 << at:X}", span)
            none = ast.Literal(0, string, f"{string}#0", span)
            bit = ast.Binary("AND", _pattern(bits, value), mask, span)
            paths.append([_move(ast.Binary("<>", bit, none, span), target, span)])
        return paths

    def _copied(self, name: str, operands: Operands, bits: int, span: Span) -> Paths:
        """MOV or CML of a group of relays into another, relay by relay; None when one of them is none or is
        too wide."""
        if not all(GROUP.match(operand.text) for operand in operands):
            return None
        source, target = (self.devices.group(operand) for operand in operands)
        if source is None or target is None or len(source) > bits:
            return None
        pairs = []
        for at, relay in enumerate(target[:bits]):
            written = self.devices.written(relay, span)
            if written is None:
                return None
            value = ast.Name(source[at].name, span) if at < len(source) else ast.Literal(
                False, None, "FALSE", span)
            value = ast.Unary("NOT", value, span) if name == "CML" else value
            pairs.append([_move(value, written, span)])
        # A relay that is in both is read before it is written.
        upwards = source[0].kind == target[0].kind and source[0].number < target[0].number
        return pairs[::-1] if upwards else pairs

    def _move(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        if name in ("MOV", "CML") and (paths := self._copied(name, operands, bits, it.span)) is not None:
            return paths
        values = self._values(operands[:1], bits)
        if values is None:
            return None
        value = values[0]
        if name == "BCD":
            text, long = ("WORD", "INT") if bits == 16 else ("DWORD", "DINT")
            value = _call(f"U{long}_TO_BCD_{text}", _call(f"{long}_TO_U{long}", value))
            value = _call(f"{text}_TO_{long}", value)
        elif name == "BIN":
            text, long = ("WORD", "INT") if bits == 16 else ("DWORD", "DINT")
            value = _call(f"{text}_BCD_TO_U{long}", _pattern(bits, value))
            value = _call(f"U{long}_TO_{long}", value)
        elif name == "CML":
            value = _converted(bits, ast.Unary("NOT", _pattern(bits, value), value.span))
        return self._store(value, operands[1], bits, it.span)

    def _exchange(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        values = self._values(operands, bits)
        if values is None:
            return None
        kept = self.instance("value", "INT" if bits == 16 else "DINT", it.span)
        stores = (self._store(values[1], operands[0], bits, it.span),
                  self._store(kept, operands[1], bits, it.span))
        return None if None in stores else [[_move(values[0], kept, it.span)], *stores[0], *stores[1]]

    def _negate(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        values = self._values(operands, bits)
        if values is None:
            return None
        value = ast.Binary("-", _number(0, it.span), values[0], it.span)
        return self._store(value, operands[0], bits, it.span)

    def _arithmetic(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        values = self._values(operands[:2], bits)
        if values is None:
            return None
        if bits == 16 and operands[2].text[:1] != "K":
            targets = self.devices.registers(operands[2], 1)
            pins = [("IN1", values[0]), ("IN2", values[1])]
            return [[_block(name, it.span, pins, [("OUT", targets[0])])]] if targets else None
        operator = "+" if name == "ADD" else "-"
        return self._store(ast.Binary(operator, *values, it.span), operands[2], bits, it.span)

    def _step(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        one = Operand("K1", operands[0].span)
        return self._arithmetic(it, _STEPS[name], bits, (operands[0], one, operands[0]))

    def _bitwise(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        values = self._values(operands[:2], bits)
        if values is None:
            return None
        patterns = (_pattern(bits, value) for value in values)
        return self._store(_converted(bits, ast.Binary(name, *patterns, it.span)), operands[2], bits, it.span)

    def _multiply(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        values = self._values(operands[:2], bits)
        if values is None:
            return None
        if bits == 16:
            factors = (_call("INT_TO_DINT", value) for value in values)
            return self._store(ast.Binary("*", *factors, it.span), operands[2], 32, it.span)
        return self._words("FX_DMUL", values, operands[2], it.span)

    def _divide(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        values = self._values(operands[:2], bits)
        if values is None:
            return None
        if bits == 32:
            found = self._words("FX_DDIV", values, operands[2], it.span)
        else:
            targets = self.devices.registers(operands[2], 2)
            self.devices.functions.add("FX_DIV")
            pins = [("A", values[0]), ("B", values[1])]
            outputs = [("OUT", targets[0]), ("R", targets[1])] if targets else []
            found = [[_block("FX_DIV", it.span, pins, outputs)]] if targets else None
        if found is None:
            return None
        safe = ast.Binary("<>", values[1], _number(0, it.span), it.span)
        return [[ast.Contact("", safe, it.span), *found[0]]]

    def _words(self, function: str, values: list[ast.Expr], operand: Operand, span: Span) -> Paths:
        targets = self.devices.registers(operand, 4)
        if targets is None:
            return None
        self.devices.functions |= {function, "FX_SPLIT"}
        outputs = list(zip(("OUT", "W1", "W2", "W3"), targets))
        return [[_block(function, span, [("A", values[0]), ("B", values[1])], outputs)]]

    def _compare(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        """Three bits in a row: greater, equal, less."""
        values = self._values(operands[:2], bits)
        first = self.devices.device(operands[2], COILS - {"X"}, "device with a coil")
        if values is None or first is None:
            return None
        paths = []
        for number, operator in enumerate((">", "=", "<")):
            device = self.devices.numbered(first.kind, first.number + number, it.span, "device")
            target = self.devices.written(device, operands[2].span) if device is not None else None
            if target is None:
                return None
            value = ast.Binary(operator, *values, it.span)
            paths.append([_move(value, target, it.span)])
        return paths

    # ---- ranges

    def _zone(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        """Reset from one device to another."""
        kinds = COILS - {"X"} | TIMERS | COUNTERS | ROWS
        ends = [self.devices.device(operand, kinds, "device") for operand in operands]
        if None in ends:
            return None
        first, last = ends
        if first.kind != last.kind or last.number < first.number or last.number - first.number >= MAX_RANGE:
            self.reading.malformed(it.span, f"{first.name} to {last.name} is no range of at most {MAX_RANGE} "
                                   "devices")
            return None
        paths = []
        for number in range(first.number, last.number + 1):
            device = self.devices.numbered(first.kind, number, it.span, "device")
            if device is None:
                return None
            if device.kind in TIMERS | COUNTERS:
                paths.append([self._reset(device, it.span)])
                continue
            target = self.devices.written(device, it.span)
            if target is None:
                return None
            paths.append([_move(_number(0, it.span), target, it.span) if device.kind in ROWS
                          else ast.Coil("R", target, it.span)])
        return paths

    def _count(self, operand: Operand) -> int | None:
        found = self.devices.constant(operand, 16)
        if found is None or not 1 <= found.value <= MAX_RANGE:
            self.reading.unsupported(operand.span, f"`{operand.text[:40]}` as a number of devices",
                                     f"write a constant from K1 to K{MAX_RANGE}")
            return None
        return found.value

    def _copy(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        """BMOV copies a row of registers as it was before, FMOV one value into a row."""
        count = self._count(operands[2])
        targets = self.devices.registers(operands[1], count) if count else None
        if targets is None:
            return None
        if name == "FMOV":
            value = self.devices.value(operands[0], 16)
            values = [value] * count if value is not None else None
        else:
            first = self.devices.device(operands[0], ROWS, "data register")
            row = [self.devices.numbered(first.kind, first.number + n, it.span, "data register")
                   for n in range(count)] if first is not None else [None]
            values = None if None in row else [ast.Name(device.name, operands[0].span) for device in row]
        if values is None:
            return None
        pairs = list(zip(values, targets))
        if name == "BMOV" and any(value.name == targets[0].name for value in values):
            pairs.reverse()
        return [[_move(value, target, it.span)] for value, target in pairs]

    def _alternate(self, it: Instruction, name: str, bits: int, operands: Operands) -> Paths:
        target = self.devices.write(operands[0], COILS, "device with a coil")
        if target is None:
            return None
        return [[_move(ast.Unary("NOT", target, it.span), target, it.span)]]


_MODIFIERS = {"OUT": "", "OUTI": "/", "SET": "S", "RST": "R", "PLS": "P", "PLF": "N"}
_SIMPLE = {
    **dict.fromkeys(_MODIFIERS, (range(1, 2), Outputs._coil)),
    **dict.fromkeys(_UNITS, (range(1, 3), Outputs._coil)),
    "FF": (range(1, 2), Outputs._invert),
    "CJ": (range(1, 2), Outputs._jump), "CJP": (range(1, 2), Outputs._jump),
}
_DATA = {
    "MOV": (2, Outputs._move), "CML": (2, Outputs._move), "NEG": (1, Outputs._negate),
    "ADD": (3, Outputs._arithmetic), "SUB": (3, Outputs._arithmetic), "MUL": (3, Outputs._multiply),
    "DIV": (3, Outputs._divide), "INC": (1, Outputs._step), "DEC": (1, Outputs._step),
    "BCD": (2, Outputs._move), "BIN": (2, Outputs._move), "XCH": (2, Outputs._exchange),
    "CMP": (3, Outputs._compare), "BITWISE": (3, Outputs._bitwise), "ZRST": (2, Outputs._zone),
    "BMOV": (3, Outputs._copy), "FMOV": (3, Outputs._copy), "ALT": (1, Outputs._alternate),
}
"""Instruction: its number of operands, and what writes it."""


def label_of(text: str) -> str | None:
    """``P7`` for ``P007``; None when it is no label."""
    match = re.match(r"P(\d{1,4})\Z", text)
    return f"P{int(match[1])}" if match and int(match[1]) < 4096 else None


def _number(value: int, span: Span) -> ast.Literal:
    return ast.Literal(value, None, str(value), span)


def _block(function: str, span: Span, inputs: list, outputs: list) -> ast.Block:
    pins = [ast.Pin(name, value, False, span) for name, value in inputs]
    pins += [ast.Pin(name, target, True, span) for name, target in outputs]
    return ast.Block(None, function, tuple(pins), None, NO_WIRE, span)


def _move(value: ast.Expr, target: ast.Name, span: Span) -> ast.Block:
    return _block("MOVE", span, [("IN", value)], [("OUT", target)])


def _call(function: str, value: ast.Expr) -> ast.Call:
    return ast.Call(function, (ast.Argument(None, value, False, value.span),), value.span)


def _pattern(bits: int, value: ast.Expr) -> ast.Expr:
    """A number as a string of bits."""
    if isinstance(value, ast.Literal):
        digits = value.value & ((1 << bits) - 1)
        return ast.Literal(digits, None, f"16#{digits:X}", value.span)
    return _call("INT_TO_WORD" if bits == 16 else "DINT_TO_DWORD", value)


def _converted(bits: int, value: ast.Expr) -> ast.Expr:
    return _call("WORD_TO_INT" if bits == 16 else "DWORD_TO_DINT", value)
