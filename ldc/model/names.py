"""Names: which ones a project may not take, and which one was probably meant."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import islice

from ldc.library import blocks, functions
from ldc.similar import similar
from ldc.types import ELEMENTARY

PREFIX = "_LDC_"

# IEC 61131-3, table 52: words at the start of a line of IL.
IL_WORDS = frozenset(
    "LD LDN ST STN S R AND ANDN OR ORN XOR XORN NOT ADD SUB MUL DIV MOD GT GE EQ NE LE LT "
    "JMP JMPC JMPCN CAL CALC CALCN RET RETC RETCN".split()
)


def standard(key: str) -> str | None:
    """What the standard calls by this name (in capitals), in words; None when the name is free."""
    if key in ELEMENTARY:
        return "a data type of the standard"
    if blocks.signature(key) is not None:
        return "a standard function block"
    if functions.lookup(key) is not None and functions.typed(key) is None:
        return "a standard function"
    return None


# Thousands of unknown names compared with thousands of variables would take minutes.
_MANY, _COMPARED = 1_000, 50


def suggest(name: str, candidates: Iterable[str]) -> str:
    """Help text that names what was probably meant; empty when nothing comes near.

    When there are very many, only those are looked at that begin alike and are about as long.
    """
    names = list(candidates)
    if len(names) > _MANY:
        least, first = len(name) - 2, (name[:1].lower(), name[:1].upper())
        names = islice((c for c in names if least <= len(c) <= least + 4 and c.startswith(first)), _COMPARED)
    spellings = {c.upper(): c for c in names if not c.upper().startswith(PREFIX)}
    near = similar(name.upper(), spellings, 3, 0.6)
    if not near:
        return ""
    return "did you mean " + " or ".join(f"`{spellings[key]}`" for key in near) + "?"
