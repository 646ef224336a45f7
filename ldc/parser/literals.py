"""What a literal of the text is worth (IEC 61131-3, 2.2): numbers, durations, dates, strings, enumerations.

Every function returns (value, type, canonical text) or raises ``Malformed`` with what is wrong.
"""

from __future__ import annotations

import re
from datetime import date
from math import isinf

from ldc.patterns import Pattern

Parts = tuple[bool | int | float | bytes | str, str | None, str]

_INTEGERS = {f"{u}{s}INT" for u in ("", "U") for s in ("", "S", "D", "L")}
_BITS = {"BYTE", "WORD", "DWORD", "LWORD"}
_REALS = {"REAL", "LREAL"}
_TIMES = {"T", "TIME", "LT", "LTIME"}
_DATES = {"D", "DATE", "LD", "LDATE"}
_CLOCKS = {"TOD", "TIME_OF_DAY", "LTOD", "LTIME_OF_DAY"}
_STAMPS = {"DT", "DATE_AND_TIME", "LDT", "LDATE_AND_TIME"}
TYPED = _INTEGERS | _BITS | _REALS | _TIMES | _DATES | _CLOCKS | _STAMPS | {"BOOL", "STRING", "WSTRING"}
"""Prefixes in capitals that make a literal of an elementary type; any other is an enumeration's."""

_NUMBER = Pattern(r"([+-]?)(?:(\d[\d_]*)#)?(\w+)\Z", re.ASCII)
_REAL = Pattern(r"[+-]?\d[\d_]*(?:\.\d[\d_]*)?(?:[eE][+-]?\d+)?\Z", re.ASCII)
_DURATION = Pattern(r"(\d[\d_]*)(?:\.(\d[\d_]*))?(MS|US|NS|D|H|M|S)_?")
_UNITS = {"D": 86_400_000_000_000, "H": 3_600_000_000_000, "M": 60_000_000_000, "S": 1_000_000_000,
          "MS": 1_000_000, "US": 1_000, "NS": 1}
_CLOCK = Pattern(r"(\d\d?):(\d\d?)(?::(\d\d?)(?:\.(\d+))?)?\Z", re.ASCII)
_DATE = Pattern(r"(\d{1,4})-(\d\d?)-(\d\d?)", re.ASCII)
_DIGITS = 400
_DAY = _UNITS["D"]
_ESCAPES = {"$": "$", "'": "'", '"': '"', "L": "\n", "N": "\n", "P": "\f", "R": "\r", "T": "\t"}


class Malformed(Exception):
    """The text is no literal. ``range``: it is well formed, but no type holds its value."""

    def __init__(self, message: str, help: str = "", range: bool = False) -> None:
        super().__init__(message)
        self.help, self.range = help, range


def number(text: str) -> Parts:
    """An untyped number: ``5``, ``16#FF``, ``1.5e3``. With a sign when ``text`` has one."""
    if "#" not in text and not text.lstrip("+-").replace("_", "").isdigit():
        return _real(text, None), None, text
    return _integer(text), None, text


def literal(text: str) -> Parts:
    """A literal with a prefix, a boolean, or a string; an enumeration's has the value of its name (str)."""
    if text[0] in "'\"":
        return string(text), None, text
    prefix, mark, rest = text.partition("#")
    if not mark:
        return text.upper() == "TRUE", "BOOL", text.upper()
    name = prefix.upper()
    if name not in TYPED:
        if not re.fullmatch(r"[A-Za-z_]\w*", rest, re.ASCII):
            raise Malformed(f"`{prefix}` is not the name of an elementary type",
                            "values of enumerations have names")
        return rest, prefix, text
    return *_typed(name, rest), f"{name}#{rest}"


def is_enumeration(text: str) -> bool:
    """Whether a literal's prefix names a type of the project."""
    prefix, mark, _ = text.partition("#")
    return bool(mark) and prefix[0] not in "'\"" and prefix.upper() not in TYPED


def _typed(name: str, rest: str) -> tuple[bool | int | float | bytes | str, str]:
    if name in _TIMES:
        return _duration(rest), "TIME"
    if name in _DATES:
        return _date(rest), "DATE"
    if name in _CLOCKS:
        return _clock(rest), "TIME_OF_DAY"
    if name in _STAMPS:
        day, mark, clock = rest.rpartition("-")
        if not mark or ":" not in clock:
            raise Malformed("a date with a time of day has the form DT#2026-01-31-23:59:59")
        return _date(day) * _DAY + _clock(clock), "DATE_AND_TIME"
    if name in ("STRING", "WSTRING"):
        if rest[0] != ("'" if name == "STRING" else '"'):
            raise Malformed(f"a {name} literal stands between {QUOTES[name]}")
        return string(rest), name
    if name == "BOOL":
        value = {"0": False, "1": True, "FALSE": False, "TRUE": True}.get(rest.upper())
        if value is None:
            raise Malformed("a BOOL is 0, 1, FALSE or TRUE")
        return value, name
    if name in _REALS:
        return _real(rest, name), name
    value = _integer(rest)
    if value < 0 and name in _BITS:
        raise Malformed(f"a {name} has no sign")
    return value, name


QUOTES = {"STRING": "single quotes", "WSTRING": "double quotes"}


def _integer(text: str) -> int:
    match = _NUMBER.match(text)
    if not match or not all(part for part in text.split("_")):
        raise Malformed("this is no number", "underscores stand between digits; bases are 2#, 8# and 16#")
    base = int(match[2].replace("_", "")) if match[2] and len(match[2]) < 4 else 10 if not match[2] else 0
    if base not in (2, 8, 10, 16) or (match[2] and base == 10):
        raise Malformed("the base of a number is 2, 8 or 16", "write 2#1010, 8#17 or 16#FF")
    digits = match[3].replace("_", "")
    if len(digits) > _DIGITS:
        raise Malformed("no type holds this number", "LINT and ULINT have 64 bits", range=True)
    try:
        value = int(match[1] + digits, base)
    except ValueError:
        raise Malformed(f"not all of these are digits of base {base}") from None
    if not -(1 << 63) <= value < 1 << 64:
        raise Malformed("no type holds this number", "LINT and ULINT have 64 bits", range=True)
    return value


def _real(text: str, name: str | None) -> float:
    if not _REAL.match(text) or "__" in text:
        raise Malformed("this is no number", "a REAL has the form 12.5 or 1.25e-3")
    if len(text) > _DIGITS:
        raise Malformed("the number has too many digits", "an LREAL has about 16 of them", range=True)
    value = float(text.replace("_", ""))
    if isinf(value) or (name == "REAL" and abs(value) > 3.4028235677973366e38):
        raise Malformed(f"no {name or 'LREAL'} holds this number", range=True)
    return value


def _duration(text: str) -> int:
    """Nanoseconds, rounded; units in falling order, a fraction only on the last (2.2.3.1)."""
    sign, body = (-1, text[1:]) if text[0] == "-" else (1, text.removeprefix("+"))
    body, at, total, last, fraction = body.upper(), 0, 0, 1 << 62, False
    help = "write for example T#1.5s or T#2h30m; the units are d h m s ms us ns, the greater first"
    while at < len(body):
        match = _DURATION.match(body, at)
        if not match or fraction or _UNITS[match[3]] >= last or len(match[0]) > _DIGITS:
            raise Malformed("this is no duration", help)
        last = _UNITS[match[3]]
        total += int(match[1].replace("_", "")) * last
        if match[2]:
            fraction, digits = True, match[2].replace("_", "")
            scale = 10 ** len(digits)
            total += (2 * int(digits) * last + scale) // (2 * scale)
        at = match.end()
    if not -(1 << 63) <= sign * total < 1 << 63:
        raise Malformed("no TIME holds this duration", "the longest is about 292 years", range=True)
    return sign * total


def _date(text: str) -> int:
    """Days since 1970-01-01."""
    match = _DATE.fullmatch(text)
    try:
        days = (date(*map(int, match.groups())) - date(1970, 1, 1)).days if match else None
    except ValueError:
        raise Malformed("there is no such day", "months have 28 to 31 days") from None
    if days is None:
        raise Malformed("this is no date", "write for example D#2026-01-31")
    if days < 0:
        raise Malformed("dates begin at 1970-01-01", range=True)
    return days


def _clock(text: str) -> int:
    """Nanoseconds since midnight."""
    match = _CLOCK.match(text)
    if not match:
        raise Malformed("this is no time of day", "write for example TOD#23:59:59.5")
    hour, minute, second = int(match[1]), int(match[2]), int(match[3] or 0)
    if hour > 23 or minute > 59 or second > 59:
        raise Malformed("a day ends at 23:59:59")
    return (hour * 3600 + minute * 60 + second) * _UNITS["S"] + int((match[4] or "")[:9].ljust(9, "0"))


def string(text: str) -> bytes | str:
    """What stands between the quotes; single ones make Latin-1 bytes, double ones text (2.2.2)."""
    quote, wide, body = text[0], text[0] == '"', text[1:-1]
    if "$" in body:
        pattern = r"\$([0-9A-Fa-f]{4}|.?)" if wide else r"\$([0-9A-Fa-f]{2}|.?)"
        body = re.sub(pattern, lambda m: _escape(m[1], quote), body, flags=re.DOTALL)
    if wide:
        return body
    try:
        return body.encode("latin-1")
    except UnicodeEncodeError as error:
        raise Malformed(f"a STRING has only Latin-1 characters, not `{body[error.start]}`",
                        "write it between double quotes: that makes a WSTRING") from None


def _escape(code: str, quote: str) -> str:
    if len(code) > 1:
        return chr(int(code, 16))
    found = _ESCAPES.get(code.upper())
    if found is None or (found in "'\"" and found != quote):
        digits = "four hexadecimal digits" if quote == '"' else "two hexadecimal digits"
        raise Malformed(f"`${code}` stands for no character",
                        f"$$ is a dollar, ${quote} a quote, $N a new line; {digits} are a code")
    return found


def quoted(text: str) -> str:
    """A title as a WSTRING literal."""
    codes = {"$": "$$", '"': '$"', "\n": "$N", "\f": "$P", "\r": "$R", "\t": "$T"}
    coded = (codes.get(c) or (f"${ord(c):04X}" if c < " " or c == "\x7f" else c) for c in text)
    return f'"{"".join(coded)}"'
