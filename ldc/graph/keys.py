"""The identity of a rung: what online change, hidden memories and the source map know it by."""

from __future__ import annotations

import hashlib

from ldc.diagnostics import Diagnostics, Label
from ldc.parser import ast
from ldc.parser.unparse import body_text
from ldc.parser.unread import UnreadPaths


def rung_keys(rungs: tuple[ast.Rung, ...], diagnostics: Diagnostics | None = None) -> tuple[str, ...]:
    """One key per rung of a POU: its name, or ``r`` + 8 hex digits of the SHA-256 of its canonical
    text in capitals + ``_`` + ordinal from 1 among the equal ones (DESIGN section 2). A name that an earlier rung
    has is reported; the later rung then gets a key like an unnamed one."""
    names: dict[str, ast.Rung] = {}
    for rung in rungs:
        if rung.name is not None:
            names.setdefault(rung.name.upper(), rung)
    counts: dict[str, int] = {}
    keys = []
    for rung in rungs:
        if rung.name is not None and names[rung.name.upper()] is rung:
            keys.append(rung.name)
            continue
        if rung.name is not None and diagnostics is not None:
            _duplicate(rung, names[rung.name.upper()], diagnostics)
        keys.append(_unnamed(rung, names, counts))
    return tuple(keys)


def stem(rung: ast.Rung) -> str:
    """What the key of a rung without a name begins with."""
    if isinstance(rung.paths, UnreadPaths):
        return rung.paths.head.stem
    text = f"RUNG\n{body_text(rung)}"
    # Identifiers and keywords are one word in any case: respelling them makes no other rung.
    return "r" + hashlib.sha256(text.upper().encode()).hexdigest()[:8]


def _unnamed(rung: ast.Rung, names: dict[str, ast.Rung], counts: dict[str, int]) -> str:
    start = stem(rung)
    while True:
        counts[start] = counts.get(start, 0) + 1
        key = f"{start}_{counts[start]}"
        if key.upper() not in names:
            return key


def _duplicate(rung: ast.Rung, first: ast.Rung, diagnostics: Diagnostics) -> None:
    diagnostics.error(
        "LD0314", f"two rungs of this POU are named {rung.name}", rung.name_span or rung.span,
        "named again here", secondary=(Label(first.name_span or first.span, "first named here"),),
        help="a rung's name is its jump label and its identity in an online change: choose another one",
    )
