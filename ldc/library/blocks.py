"""The standard function blocks (IEC 61131-3, 2nd edition, tables 34 to 37), written in IL once.

Every engine compiles the same text, so all of them share its meaning (ADR 0003). ``%NOW`` in it is
the time of the current task execution, a TIME that is 0 in the first one. The bodies have no
jumps: they become branch-free code.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from ldc.patterns import Pattern
from ldc.symbols import Parameter, Signature
from ldc.types import DINT, ELEMENTARY, INT, LINT, UDINT, ULINT

_FOLDER = Path(__file__).with_name("blocks")
_COUNTED = {"": INT, "_INT": INT, "_DINT": DINT, "_LINT": LINT, "_UDINT": UDINT, "_ULINT": ULINT}
# Name of the block -> (file, type that a counter counts in).
_BLOCKS = {name: (name.lower(), None) for name in ("SR", "RS", "R_TRIG", "F_TRIG")} | {
    counter + suffix: (counter.lower(), type_)
    for counter in ("CTU", "CTD", "CTUD") for suffix, type_ in _COUNTED.items()
} | {name: (name.lower(), None) for name in ("TP", "TON", "TOF")}
_SECTION = Pattern(r"^VAR_(INPUT|OUTPUT)\n(.*?)^END_VAR", re.DOTALL | re.MULTILINE)
_PIN = Pattern(r"^ +(\w+) : (\w+);", re.MULTILINE)


def names() -> tuple[str, ...]:
    """The names of all standard function blocks, in the order of the standard's tables."""
    return tuple(_BLOCKS)


@cache
def source(name: str) -> str:
    """The block as IL text, declarations and body; ``name`` in any case. KeyError: there is none."""
    key = name.upper()
    file, type_ = _BLOCKS[key]
    text = (_FOLDER / f"{file}.il").read_text(encoding="ascii")
    if type_ is None:
        return text
    least, greatest = type_.range
    return text.format(name=key, type=type_.name, least=least, greatest=greatest)


@cache
def signature(name: str) -> Signature | None:
    """The pins of a standard function block in the standard's order; None when there is no such block."""
    key = name.upper()
    if key not in _BLOCKS:
        return None
    pins = {
        kind: tuple(Parameter(pin, ELEMENTARY[type_]) for pin, type_ in _PIN.findall(text))
        for kind, text in _SECTION.findall(source(key))
    }
    return Signature("FUNCTION_BLOCK", key, pins["INPUT"], pins["OUTPUT"], standard=True)
