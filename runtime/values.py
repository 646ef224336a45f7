"""Values at the boundary of a machine: from what people write, to what traces print."""

from __future__ import annotations

import math

from ldc.library import text as literals
from ldc.library.values import to_real
from ldc.types import BOOL, Elementary, Enum, String, Subrange, Type, storage

_ESCAPES = {"$": "$", "'": "'", '"': '"', "L": "\n", "N": "\n", "P": "\f", "R": "\r", "T": "\t"}


def parse(text: str, type_: Type):
    """The machine's value of a written one: ``0 1 TRUE FALSE 12 -3 16#FF 1.5 T#20ms 'text' red``.

    A bare number for a TIME is milliseconds, as traces print it; a string may stand without quotes.
    Raises ValueError with a message that says what the type takes.
    """
    text = text.strip()
    if isinstance(type_, String):
        return _parse_string(text, type_)
    if isinstance(type_, Enum):
        return _parse_enum(text, type_)
    base = storage(type_)
    plain = text
    prefix, mark, rest = text.partition("#")
    if mark and prefix.upper() == base.name:
        plain = rest if base.kind not in ("time", "date", "tod", "dt") else text
    value = literals.read_value(plain, base)
    if value is None and base.kind == "time":
        number = literals.read_value(plain, Elementary("LREAL", "real", 64))
        if number is not None and abs(number) < 9.2e12:
            value = round(number * 1_000_000)
    if value is None:
        raise ValueError(f"`{text}` is no value of {type_} ({_example(base)})")
    if base.kind == "real" and math.isinf(value) and "inf" not in plain.lower():
        raise ValueError(f"`{text}` is too large for {type_}")  # as the compiler says it of a literal
    if isinstance(type_, Subrange) and not type_.low <= value <= type_.high:
        raise ValueError(f"{value} is outside {type_.low}..{type_.high}")
    return value


def _example(base: Elementary) -> str:
    match base.kind:
        case "bool":
            return "0, 1, TRUE or FALSE"
        case "real":
            return "like 1.5 or 2e-3"
        case "time":
            return "like T#1s500ms or 20, in milliseconds"
        case "date":
            return "like D#2025-01-31"
        case "tod":
            return "like TOD#12:30:00"
        case "dt":
            return "like DT#2025-01-31-12:30:00"
    low, high = base.range
    return f"{low} to {high}"


def _parse_enum(text: str, type_: Enum) -> int:
    name = text.rpartition("#")[2].upper()
    for known, number in type_.values:
        if known.upper() == name or str(number) == name:
            return number
    raise ValueError(f"`{text}` is no value of {type_} ({', '.join(n for n, _ in type_.values)})")


def _parse_string(text: str, type_: String) -> bytes | str:
    if len(text) >= 2 and text[0] == text[-1] and text[0] in "'\"":
        parts, rest = [], text[1:-1]
        digits = 2 if type_.name == "STRING" else 4
        while rest:
            head, mark, rest = rest.partition("$")
            parts.append(head)
            if mark:
                code = rest[:digits]
                if rest[:1].upper() in _ESCAPES:
                    parts.append(_ESCAPES[rest[:1].upper()])
                    rest = rest[1:]
                elif len(code) == digits and all(c in "0123456789abcdefABCDEF" for c in code):
                    parts.append(chr(int(code, 16)))
                    rest = rest[digits:]
                else:
                    raise ValueError(f"`${rest[:1]}` is no escape of a string")
        text = "".join(parts)
    return _string(text, type_)


def _string(text: str, type_: String) -> bytes | str:
    if type_.name != "STRING":
        return text[: type_.length]
    try:
        return text.encode("latin-1")[: type_.length]
    except UnicodeEncodeError as error:
        raise ValueError(f"`{text[error.start]}` is not in Latin-1, which STRING is kept in") from None


def coerce(value: object, type_: Type):
    """A Python value (bool, int, float, str, bytes) as the machine's; text is parsed unless a string is due.

    TIME takes an int of nanoseconds. Raises ValueError when it does not fit the type.
    """
    if isinstance(type_, String):
        if isinstance(value, bytes) and type_.name == "STRING":
            return value[: type_.length]
        if isinstance(value, str):
            return _string(value, type_)
    elif isinstance(value, str):
        return parse(value, type_)
    elif isinstance(value, int | float):
        base = storage(type_)
        if base.kind == "real":
            return to_real(float(value)) if base.bits == 32 else float(value)
        if base == BOOL and value in (0, 1):
            return bool(value)
        low, high = (type_.low, type_.high) if isinstance(type_, Subrange) else base.range
        if base != BOOL and value == int(value) and low <= value <= high:
            return int(value)
    raise ValueError(f"{value!r} is no value of {type_}")


def outward(value: object, type_: Type) -> bool | int | float | str:
    """The machine's value as bool, int, float or str."""
    return value.decode("latin-1") if isinstance(value, bytes) else value


def show(value: object, type_: Type) -> str:
    """How traces print a value: BOOL 0/1, TIME in milliseconds, enumerations by name, text as it is."""
    if isinstance(type_, Enum):
        return next((name for name, number in type_.values if number == value), str(value))
    if isinstance(type_, String):
        return outward(value, type_)
    base = storage(type_)
    match base.kind:
        case "bool":
            return "1" if value else "0"
        case "time":
            return milliseconds(value)
        case "bits":
            return str(value)
    return literals.print_value(value, base)


def milliseconds(nanoseconds: int) -> str:
    """Nanoseconds as milliseconds, exact, without trailing zeros: ``20``, ``0.5``, ``-1.25``."""
    whole, rest = divmod(abs(nanoseconds), 1_000_000)
    fraction = f".{rest:06d}".rstrip("0") if rest else ""
    return f"{'-' if nanoseconds < 0 else ''}{whole}{fraction}"
