"""Values as text and back: what *_TO_STRING prints and STRING_TO_* reads (docs/semantics.md).

Printing gives the IEC literal of the value. Reading takes such a literal, with or without the
prefix, between spaces; ``None`` stands for text that is none, or that does not fit the type.
"""

from __future__ import annotations

import datetime
import re

from ldc.library.values import DAY, SECOND, to_real
from ldc.patterns import Pattern
from ldc.types import Elementary

_UNITS = (("d", DAY), ("h", 3600 * SECOND), ("m", 60 * SECOND), ("s", SECOND), ("ms", 1_000_000),
          ("us", 1_000), ("ns", 1))
_FLAGS = re.ASCII | re.IGNORECASE
_DECIMAL = Pattern(r"([+-]?)(\d+(?:_\d+)*)\Z", _FLAGS)
_BASED = Pattern(r"(2|8|16)#([\dA-F]+(?:_[\dA-F]+)*)\Z", _FLAGS)
_REAL = Pattern(r"[+-]?(?:\d+(?:_\d+)*(?:\.\d+(?:_\d+)*)?(?:E[+-]?\d+)?|inf|nan)\Z", _FLAGS)
_SPAN = Pattern(r"(?:T(?:IME)?#)?([+-]?)((?:\d+(?:\.\d+)?(?:d|h|ms|m|s|us|ns)_?)+)\Z", _FLAGS)
_PART = Pattern(r"(\d+)(?:\.(\d+))?(d|h|ms|m|s|us|ns)_?", _FLAGS)
_DATE = Pattern(r"(?:D(?:ATE)?#)?(\d{4,8})-(\d\d?)-(\d\d?)\Z", _FLAGS)
_CLOCK = r"(\d\d?):(\d\d?)(?::(\d\d?)(?:\.(\d{1,9}))?)?\Z"
_TOD = Pattern(r"(?:(?:TOD|TIME_OF_DAY)#)?" + _CLOCK, _FLAGS)
_DT = Pattern(r"(?:(?:DT|DATE_AND_TIME)#)?(\d{4,8}-\d\d?-\d\d?)-(.*)\Z", _FLAGS)
_ERA, _ERA_YEARS = 146_097, 400  # days in 400 years
_EPOCH = datetime.date(1970, 1, 1).toordinal() - 1


def print_value(value, type_: Elementary) -> str:
    """The text of a value; the same on every engine, character by character."""
    match type_.kind:
        case "bool":
            return "TRUE" if value else "FALSE"
        case "bits":
            return f"16#{value:X}"
        case "real":
            return _print_real(value, type_.bits == 32)
        case "time":
            return _print_time(value)
        case "date":
            return "D#" + _print_date(value)
        case "tod":
            return "TOD#" + _print_clock(value % DAY)
        case "dt":
            return f"DT#{_print_date(value // DAY)}-{_print_clock(value % DAY)}"
    return str(value)


def _print_real(value: float, single: bool) -> str:
    """The fewest significant digits of ``%.*e`` that read back as the same value."""
    if value != value:
        return "nan"
    if value in (float("inf"), float("-inf")):
        return "inf" if value > 0 else "-inf"
    for precision in range(9 if single else 17):
        text = f"{value:.{precision}e}"
        back = float(text)
        if (to_real(back) if single else back) == value:
            break
    mantissa, _, power = text.partition("e")
    sign, digits = ("-", mantissa[1:]) if mantissa[0] == "-" else ("", mantissa)
    digits, exponent = digits.replace(".", ""), int(power)
    if not -4 <= exponent < 16:
        return f"{sign}{digits[0]}.{digits[1:] or '0'}e{exponent:+03d}"
    if exponent < 0:
        return f"{sign}0.{'0' * (-exponent - 1)}{digits}"
    whole = digits[: exponent + 1].ljust(exponent + 1, "0")
    return f"{sign}{whole}.{digits[exponent + 1 :] or '0'}"


def _print_time(value: int) -> str:
    if value == 0:
        return "T#0ms"
    rest, parts = abs(value), []
    for unit, size in _UNITS:
        count, rest = divmod(rest, size)
        if count:
            parts.append(f"{count}{unit}")
    return f"T#{'-' if value < 0 else ''}{''.join(parts)}"


def _print_date(days: int) -> str:
    eras, rest = divmod(days + _EPOCH, _ERA)
    date = datetime.date.fromordinal(rest + 1)
    return f"{date.year + eras * _ERA_YEARS:04d}-{date.month:02d}-{date.day:02d}"


def _print_clock(value: int) -> str:
    seconds, rest = divmod(value, SECOND)
    fraction = f".{rest:09d}".rstrip("0") if rest else ""
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}{fraction}"


def read_value(text: str, type_: Elementary):
    """The value that ``text`` is a literal of, or None."""
    text = text.strip(" ")
    match type_.kind:
        case "bool":
            return {"TRUE": True, "1": True, "FALSE": False, "0": False}.get(text.upper())
        case "real":
            return _read_real(text, type_.bits == 32)
        case "time":
            found = _read_time(text)
        case "date":
            found = _read_date(text)
        case "tod":
            match = _TOD.match(text)
            return _read_clock(match) if match else None
        case "dt":
            found = _read_moment(text)
        case _:
            found = _read_integer(text)
    low, high = type_.range
    return found if found is not None and low <= found <= high else None


def _read_integer(text: str) -> int | None:
    if match := _DECIMAL.match(text):
        digits = match[2].replace("_", "").lstrip("0") or "0"
        value = int(digits) if len(digits) <= 20 else 1 << 64
        return -value if match[1] == "-" else value
    if match := _BASED.match(text):
        base, digits = int(match[1]), match[2].replace("_", "").lstrip("0") or "0"
        if len(digits) > 64 or any(int(d, 16) >= base for d in digits):
            return None
        return int(digits, base)
    return None


def _read_real(text: str, single: bool) -> float | None:
    if not _REAL.match(text):
        return None
    value = float(text.replace("_", ""))
    return to_real(value) if single else value


def _read_time(text: str) -> int | None:
    match = _SPAN.match(text)
    if not match:
        return None
    total, sizes, previous = 0, dict(_UNITS), 1 << 64
    parts = _PART.findall(match[2])
    for number, (whole, fraction, unit) in enumerate(parts):
        size = sizes[unit.lower()]
        whole = whole.lstrip("0")
        if size >= previous or len(whole) > 20 or (fraction and number < len(parts) - 1):
            return None
        total += int(whole or "0") * size + int(fraction[:18] or "0") * size // 10 ** len(fraction[:18])
        previous = size
    return -total if match[1] == "-" else total


def _read_date(text: str) -> int | None:
    match = _DATE.match(text)
    if not match:
        return None
    year, month, day = int(match[1]), int(match[2]), int(match[3])
    eras, year = divmod(year - 1, _ERA_YEARS)
    try:
        ordinal = datetime.date(year + 1, month, day).toordinal()
    except ValueError:
        return None
    return ordinal - 1 + eras * _ERA - _EPOCH


def _read_clock(match: re.Match) -> int | None:
    hours, minutes, seconds = int(match[1]), int(match[2]), int(match[3] or 0)
    if hours > 23 or minutes > 59 or seconds > 59:
        return None
    fraction = int((match[4] or "").ljust(9, "0"))
    return (hours * 3600 + minutes * 60 + seconds) * SECOND + fraction


def _read_moment(text: str) -> int | None:
    match = _DT.match(text)
    clock = _TOD.match(match[2]) if match else None
    if clock is None or "#" in match[2]:
        return None
    date, time = _read_date(match[1]), _read_clock(clock)
    return None if date is None or time is None else date * DAY + time
