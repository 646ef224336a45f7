"""The function blocks and functions that editors bring along with those of the standard.

Those of Beremiz and OpenPLC are examples of IEC 61131-3 (2nd edition, table 37: RTC; annex F: the others).
The editors of the CODESYS family have a library Util, whose HYSTERESIS has other pins. A file that uses one and
has none of its own gets it as a supporting POU.
"""

from __future__ import annotations

from collections.abc import Iterable, Set

from ldc.parser import ast
from ldc.parser.foreign import stored
from ldc.parser.plcopen.guarded import nodes

PACKAGE = "ldc.parser.plcopen"
_ANNEX = ("SEMA", "RTC", "INTEGRAL", "DERIVATIVE", "PID", "RAMP", "HYSTERESIS")
_UTIL = ("BLINK", "HYSTERESIS", "LIMITALARM", "UNPACK")
_FUNCTIONS = ("PACK", "EXTRACT", "PUTBIT", "BCD_TO_INT", "INT_TO_BCD")
FAMILY = "3s-software"
"""In the names of the additional data that editors of the CODESYS family write."""
NAMES = frozenset((*_ANNEX, *_UTIL, *_FUNCTIONS))


def wanted(
    pous: Iterable[ast.Pou], shared: Iterable[ast.VarBlock], own: Iterable[str], text: str
) -> tuple[ast.Pou, ...]:
    """Blocks that variables of POUs and global ones name as their types, what these need, and functions that
    bodies call; without those that are declared, whose names are ``own``. ``text``: of the file."""
    pous = tuple(pous)
    known = {name.upper() for name in own}
    blocks = [*shared, *(block for pou in pous for block in pou.var_blocks)]
    used = _types(blocks)
    if FAMILY in text and any(name in text for name in _FUNCTIONS):
        used |= {name for pou in pous for node in nodes(pou.body, (ast.Call, ast.Block))
                 if (name := (node.name if isinstance(node, ast.Call) else node.type).upper()) in _FUNCTIONS}
    used -= known
    if not used:
        return ()
    books = ("additional", "util") if FAMILY in text else ("util", "additional")
    found = {pou.name.upper(): pou for book in books for pou in stored(PACKAGE, book)}
    more = used
    while more:
        more = {key for name in more for key in _types(found[name].var_blocks)} - known - used
        used |= more
    return tuple(pou for name, pou in found.items() if name in used)


def fitting(name: str, words: Set[str], otherwise: ast.Pou | None) -> ast.Pou | None:
    """For texts, which say no editor: the block of a name (capitals) of whose pins the most are among the ``words``
    of a text (capitals). None when there is none, or the block that the name means ``otherwise`` fits as well."""
    if name not in (*_ANNEX, *_UTIL):
        return None
    found = [pou for book in ("additional", "util") for pou in stored(PACKAGE, book) if pou.name.upper() == name]
    best = max((otherwise, *found) if otherwise else found, key=lambda pou: _share(pou, words))
    return None if best is otherwise else best


def _share(pou: ast.Pou, words: Set[str]) -> float:
    pins = [v.name.upper() for block in pou.var_blocks if block.kind in ("VAR_INPUT", "VAR_OUTPUT")
            for v in block.variables]
    return sum(pin in words for pin in pins) / max(len(pins), 1)


def _types(blocks: Iterable[ast.VarBlock]) -> set[str]:
    """Which of the blocks are types of variables, or of the elements of arrays."""
    names = set()
    for block in blocks:
        for variable in block.variables:
            type_ = variable.type
            while isinstance(type_, ast.ArrayType):
                type_ = type_.element
            if isinstance(type_, ast.NamedType):
                names.add(type_.name.upper())
    return names & NAMES
