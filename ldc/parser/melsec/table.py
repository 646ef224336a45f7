"""How a list that is a table begins; apart from what reads it, for every text is asked for it."""

from __future__ import annotations

import re

from ldc.patterns import Pattern
from ldc.source import SourceFile

_STEP = Pattern(r'^"?\d*"?(?P<gap>[\t,])"?[^"\t\n]*"?(?P=gap)"?(?:LD[A-Z]*[<>=]*|NOP|P\d+)"?(?P=gap)',
                re.MULTILINE)
_HEAD = 6_000
"""Characters in which the first instruction of a table stands."""


def first_step(source: SourceFile) -> re.Match[str] | None:
    """The first row with an instruction in its third cell; its group ``gap`` is what stands between cells."""
    return _STEP.search(source.text, 0, _HEAD)
