"""Constants and initial values as IEC 61131-3 literals that read back to the same value."""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from datetime import date, timedelta
from itertools import groupby

from ldc.types import (
    INT, REAL, Array, Enum, Instance, Scalar, String, Struct, Subrange, Type, Value,
    holds_blocks, storage,
)

_EPOCH = date(1970, 1, 1)
_SECOND = 10**9
_DAY = 86_400 * _SECOND
_NAMED = {0x24: "$$", 0x0A: "$L", 0x0C: "$P", 0x0D: "$R", 0x09: "$T"}


def literal(value: Scalar, type_: Type, typed: bool = False) -> str:
    """A scalar (2nd edition, 2.2) as text.

    With ``typed`` the text alone tells the type: a prefix (``DINT#5``) on everything but BOOL, INT,
    REAL, times, dates, strings and enumeration values, which need none.
    """
    if isinstance(type_, Enum):
        return _enum_text(int(value), type_)
    type_ = storage(type_)
    if isinstance(type_, String):
        return _string_text(value, type_.name == "WSTRING")
    match type_.kind:
        case "bool":
            return "TRUE" if value else "FALSE"
        case "int" | "uint":
            return f"{type_.name}#{value}" if typed and type_ != INT else str(int(value))
        case "bits":
            text = str(int(value)) if value <= 9 else f"16#{value:X}"
            return f"{type_.name}#{text}" if typed else text
        case "real":
            text = real_text(float(value), type_ == REAL)
            return f"{type_.name}#{text}" if typed and type_ != REAL else text
        case "time":
            return time_text(int(value))
        case "date":
            return f"D#{_date_text(value)}"
        case "tod":
            return f"TOD#{_clock_text(value)}"
    return f"DT#{_date_text(value // _DAY)}-{_clock_text(value % _DAY)}"


def real_text(value: float, single: bool) -> str:
    """The shortest text that reads back exactly, always with a point; ``single``: as a 32-bit REAL."""
    text = repr(value)
    if single:
        for digits in range(1, 10):
            short = f"{value:.{digits}g}"
            if _as_single(float(short)) == value:
                text = repr(float(short))
                break
    mantissa, _, exponent = text.partition("e")
    if "." not in mantissa:
        mantissa += ".0"
    return f"{mantissa}E{int(exponent)}" if exponent else mantissa


def _as_single(value: float) -> float | None:
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return None


def time_text(nanoseconds: int) -> str:
    """``T#2s``, else ``T#1500ms``: one unit, which every compiler reads, with a fraction only when needed."""
    sign, rest = ("-", -nanoseconds) if nanoseconds < 0 else ("", nanoseconds)
    if rest and rest % _SECOND == 0:
        return f"T#{sign}{rest // _SECOND}s"
    whole, fraction = divmod(rest, 10**6)
    digits = f".{fraction:06d}".rstrip("0") if fraction else ""
    return f"T#{sign}{whole}{digits}ms"


def _date_text(days: int) -> str:
    return (_EPOCH + timedelta(days=days)).isoformat()


def _clock_text(nanoseconds: int) -> str:
    seconds, fraction = divmod(nanoseconds, _SECOND)
    digits = f".{fraction:09d}".rstrip("0") if fraction else ""
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}{digits}"


def _enum_text(value: int, type_: Enum) -> str:
    name = next((n for n, v in type_.values if v == value), None)
    if name is None:
        return str(value)
    return f"{type_.name}#{name}" if type_.name else name


def _string_text(value: bytes | str, wide: bool) -> str:
    quote = '"' if wide else "'"
    codes = [ord(c) for c in value] if wide else value
    return quote + "".join(_character(code, quote, wide) for code in codes) + quote


def _character(code: int, quote: str, wide: bool) -> str:
    if code in _NAMED:
        return _NAMED[code]
    if code == ord(quote):
        return "$" + quote
    if 0x20 <= code < 0x7F or code > 0xFFFF:
        return chr(code)
    return f"${code:04X}" if wide else f"${code:02X}"


Pins = Callable[[str], Mapping[str, Type]]


def initial_text(value: Value, type_: Type, pins: Pins) -> str:
    """An initial value: a literal, ``[1, 2, 3(0)]`` of an array, ``(a := 1)`` of a structure or instance.

    ``pins`` gives the types of the variables of a function block (names in capitals).
    """
    match type_:
        case Array(element=element):
            while len(value) > 1 and _unsaid(value[-1], element):
                value = value[:-1]
            runs = [list(group) for _, group in groupby(value, key=repr)]
            return f"[{', '.join(_run_text(initial_text(run[0], element, pins), len(run)) for run in runs)}]"
        case Struct() | Instance():
            types = pins(type_.pou) if isinstance(type_, Instance) else {
                f.name.upper(): f.type for f in type_.fields}
            texts = (f"{name} := {initial_text(v, types[name.upper()], pins)}" for name, v in value
                     if not _unsaid(v, types[name.upper()]))
            return f"({', '.join(texts)})"
    return literal(value, type_)


def _unsaid(value: Value, type_: Type) -> bool:
    """Whether a value says nothing: that of instances whose pins begin as their types have it."""
    match type_:
        case Instance():
            return not value
        case Array(element=element):
            return holds_blocks(element) and all(_unsaid(v, element) for v in value)
        case Struct():
            return holds_blocks(type_) and all(_unsaid(v, type_.field(name).type) for name, v in value)
    return False


def _run_text(text: str, count: int) -> str:
    return f"{count}({text})" if count > 2 else ", ".join([text] * count)


def type_text(type_: Type) -> str:
    """A type where it is used: its name, or what it is when it has none."""
    match type_:
        case String():
            return type_.name if type_.length == 80 else str(type_)
        case Array(bounds, element):
            ranges = ", ".join(f"{low}..{high}" for low, high in bounds)
            return f"ARRAY [{ranges}] OF {type_text(element)}"
        case Enum() if not type_.name:
            return enum_text(type_)
        case Subrange() if not type_.name:
            return subrange_text(type_)
    return str(type_)


def enum_text(type_: Enum) -> str:
    """``(red, amber := 5, green)``: numbers only where they do not follow from the one before."""
    parts, expected = [], 0
    for name, value in type_.values:
        parts.append(name if value == expected else f"{name} := {value}")
        expected = value + 1
    return f"({', '.join(parts)})"


def subrange_text(type_: Subrange) -> str:
    return f"{type_.base.name} ({type_.low}..{type_.high})"
