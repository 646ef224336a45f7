"""Durations as people write them on a command line and in ldc.toml: `10ms`, `1.5s`, `T#1h30m`."""

from __future__ import annotations

import re

from ldc.patterns import Pattern

_UNITS = {
    "d": 86_400_000_000_000,
    "h": 3_600_000_000_000,
    "m": 60_000_000_000,
    "s": 1_000_000_000,
    "ms": 1_000_000,
    "us": 1_000,
    "µs": 1_000,
    "ns": 1,
}
_PART = Pattern(r"(\d[\d_]*(?:\.\d+)?)\s*(ms|us|µs|ns|d|h|m|s)_?")


def parse_duration(text: str) -> int | None:
    """Nanoseconds, or None when `text` is no duration, has no unit, or is beyond a signed 64-bit TIME."""
    from fractions import Fraction  # slow to load, and few commands are told a duration

    rest = text.strip().lower()
    rest = re.sub(r"^(t|time)#", "", rest)
    total, at = Fraction(0), 0
    while at < len(rest):
        match = _PART.match(rest, at)
        if not match:
            return None
        total += Fraction(match[1].replace("_", "")) * _UNITS[match[2]]
        at = match.end()
    if not rest or total.denominator != 1 or total >= 1 << 63:
        return None
    return int(total)


def duration_text(nanoseconds: int) -> str:
    """The shortest exact form with one unit: `10ms`, `1500ms`, `2s`."""
    for unit in ("s", "ms", "us"):
        if nanoseconds % _UNITS[unit] == 0:
            return f"{nanoseconds // _UNITS[unit]}{unit}"
    return f"{nanoseconds}ns"
