"""Peripherals of the chip as variables: what surrounds the program sets the inputs and reads the outputs."""

from __future__ import annotations

from ldc.parser.ldmicro.context import Context, converted
from ldc.parser.ldmicro.text import Leaf
from ldc.parser.ldmicro.variables import BIT, INT, number

SENT = "uart_sent"
_MAX_TEXT = 128
_DIGIT, _SIGN, _FIRST_UNSIGNED, _FIRST_SIGNED = -1, -2, -3, -4
_ESCAPES = {"a": 7, "b": 8, "e": 27, "f": 12, "n": 10, "r": 13, "t": 9, "v": 11, "\\": 92, "'": 39, '"': 34,
            "?": 63}


def read_adc(context: Context, leaf: Leaf) -> str:
    target = context.integer(leaf.args[0], leaf)
    source = context.added(
        f"{target.name}_input", INT, leaf, f"what the A/D converter of {target.name} reads"
    )
    context.reading.remark("mapped", f"READ_ADC {leaf.args[0]}", f"copies {source}", leaf.span)
    return context.move(source, INT, target)


def set_pwm(context: Context, leaf: Leaf) -> str:
    """SET_PWM duty frequency [name [resolution]]."""
    name = leaf.args[2] if len(leaf.args) > 2 else ""
    name = name if name[:1] == "P" else f"P{name}"
    target = context.added(f"{name}_duty", INT, leaf, f"the duty cycle of {name} in percent")
    type_ = context.operand_type(leaf.args[0], leaf) or INT
    context.reading.remark("mapped", f"SET_PWM {name}", f"sets {target}, at {leaf.args[1]} Hz", leaf.span)
    value = converted(context.operand(leaf.args[0], type_, leaf), type_, INT)
    return f"<MOVE(IN := {value}, OUT => {target})>"


def persist(context: Context, leaf: Leaf) -> str:
    if leaf.span.start != context.first:
        context.reading.unsupported(leaf.span, "PERSIST behind a condition",
                                    "put it alone into a rung: the variable is kept always")
    context.integer(leaf.args[0], leaf).retain = True
    context.reading.remark("mapped", f"PERSIST {leaf.args[0]}", "RETAIN", leaf.span)
    return ""


# ---- buses

def i2c(context: Context, leaf: Leaf) -> str:
    """I2C_RD and I2C_WR bus send recv mode address register ...: a register of a device is a variable."""
    bus, send, receive, _, address, register = leaf.args[:6]
    where = number(address), number(register)
    if None in where:
        context.reading.unsupported(leaf.span, f"{leaf.word} at an address that a variable holds",
                                    "write the address and the register as numbers")
        return ""
    place = context.added(f"{bus}_{where[0]:x}h_{where[1]}", INT, leaf,
                          f"register {where[1]} of the device at {address} on {bus}")
    context.reading.remark("mapped", f"{leaf.word} {bus} {address} {register}", place, leaf.span)
    if leaf.word == "I2C_RD":
        return context.move(place, INT, context.integer(receive, leaf))
    return _sent(context, leaf, send, place)


def spi(context: Context, leaf: Leaf) -> str:
    """SPI bus send recv ...: a byte goes out and one comes in."""
    bus, send, receive = leaf.args[:3]
    out = context.added(f"{bus}_out", INT, leaf, f"what was sent over {bus}")
    source = context.added(f"{bus}_in", INT, leaf, f"what comes over {bus}")
    context.reading.remark("mapped", f"SPI {bus}", f"sets {out}, copies {source}", leaf.span)
    return f"{_sent(context, leaf, send, out)} {context.move(source, INT, context.integer(receive, leaf))}"


def _sent(context: Context, leaf: Leaf, text: str, place: str) -> str:
    type_ = context.operand_type(text, leaf) or INT
    return f"<MOVE(IN := {converted(context.operand(text, type_, leaf), type_, INT)}, OUT => {place})>"


# ---- the serial port


def _received(context: Context, leaf: Leaf) -> str:
    return context.added("uart_received", BIT, leaf, "a character has come; UART_RECV takes it")


def _busy(context: Context, leaf: Leaf) -> str:
    return context.added("uart_busy", BIT, leaf, "the serial port takes no character now")


def _output(context: Context, leaf: Leaf) -> tuple[str, str]:
    return (context.added("uart_out", INT, leaf, "the last character that was sent"),
            context.added(SENT, BIT, leaf, "a character was sent in this scan"))


def _one_byte(context: Context, leaf: Leaf) -> bool:
    if leaf.args[1:2] in ((), ("1",)) and leaf.args[2:3] in ((), ("0",)):
        return True
    context.reading.unsupported(leaf.span, f"{leaf.word} of several bytes, or one that waits",
                                "send and receive one character a scan")
    return False


def uart_receive(context: Context, leaf: Leaf) -> str:
    if not _one_byte(context, leaf):
        return ""
    target, flag = context.integer(leaf.args[0], leaf), _received(context, leaf)
    source = context.added("uart_in", INT, leaf, "the character that has come")
    return f"[{flag}] {context.move(source, INT, target)} (R {flag})"


def uart_send(context: Context, leaf: Leaf) -> str:
    if not _one_byte(context, leaf):
        return ""
    block, (out, sent) = context.supporting("uart_send"), _output(context, leaf)
    type_ = context.operand_type(leaf.args[0], leaf) or INT
    value = converted(context.operand(leaf.args[0], type_, leaf), type_, INT)
    return (f"<{context.instance(block, 'uart_send', leaf)}: {block}(BUSY := {_busy(context, leaf)}, "
            f"VALUE := {value}, CHARACTER := {out}, SENT := {sent})>")


def uart_available(context: Context, leaf: Leaf) -> str:
    return f"[{_received(context, leaf)}]"


def uart_ready(context: Context, leaf: Leaf) -> str:
    return f"[/{_busy(context, leaf)}]"


def formatted_string(context: Context, leaf: Leaf) -> str:
    """FORMATTED_STRING variable count codes...: one character a scan; power goes on while it sends."""
    codes = _codes(context, leaf)
    digits = codes.count(_DIGIT) + (_FIRST_SIGNED in codes or _FIRST_UNSIGNED in codes)
    if bool(digits) != (leaf.args[0] != "(none)"):
        context.reading.malformed(leaf.span, "a text has a variable and the place for it, or none of them")
        return ""
    out, sent = _output(context, leaf)
    block = context.supporting(
        "text", name=f"LDMICRO_TEXT_{len(context.blocks) + 1}",
        last=max(len(codes) - 1, 0), codes=", ".join(map(str, codes or [0])), steps=len(codes),
        sign=_SIGN, digit=_DIGIT, unsigned=_FIRST_UNSIGNED, power=10 ** max(digits - 1, 0))
    value = ""
    if digits:
        variable = context.integer(leaf.args[0], leaf)
        value = f"VALUE := {converted(variable.name, variable.type, 'DINT')}, "
    return (f"<{context.instance(block, 'text', leaf)}: {block}(BUSY := {_busy(context, leaf)}, {value}"
            f"CHARACTER := {out}, SENT := {sent})>")


def _codes(context: Context, leaf: Leaf) -> list[int]:
    """The characters to send, and negative marks where the variable stands (``\\-3``: a sign, 3 digits)."""
    text, wrong = _string(leaf), False
    codes: list[int] = []
    at = 0
    while at < len(text):
        at += 1
        if text[at - 1] != "\\":
            codes.append(ord(text[at - 1]) & 0xFF)
            continue
        code, at = text[at : at + 1], at + 1
        if code == "-" or code.isdigit() and code != "0":
            signed = code == "-"
            count = text[at : at + 1] if signed else code
            at += signed
            wrong |= count not in tuple("12345") or _DIGIT in codes or min(codes, default=0) < 0
            codes += [_SIGN, _FIRST_SIGNED] if signed else [_FIRST_UNSIGNED]
            codes += [_DIGIT] * (int(count) - 1 if count in tuple("12345") else 0)
        elif code in ("x", "X"):
            value = number(f"0x{text[at : at + 2]}")
            wrong |= value is None
            codes.append((value or 0) & 0xFF)
            at += 2
        else:
            wrong |= code not in _ESCAPES
            codes.append(_ESCAPES.get(code, 0))
    if wrong or len(codes) > _MAX_TEXT:
        context.reading.malformed(leaf.span, "the text has a wrong escape, or is too long")
        return []
    return codes


def _string(leaf: Leaf) -> str:
    """The text: a count and that many codes, or the characters themselves."""
    count = number(leaf.args[1]) if len(leaf.args) > 1 else None
    if count is not None and len(leaf.args) > 2 or leaf.args[1:] == ("0",):
        codes = [number(text) for text in leaf.args[2 : 2 + (count or 0)]]
        return "".join(chr(code & 0xFF) if code is not None and code >= 32 else "X" for code in codes)
    text = leaf.rest[len(leaf.args[0]):].strip()
    return "" if text == "(none)" else text
