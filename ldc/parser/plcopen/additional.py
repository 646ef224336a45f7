"""The function blocks that Beremiz and OpenPLC bring along with those of the standard.

They are examples of IEC 61131-3 (2nd edition, table 37: RTC; annex F: the others). A file that uses one and
has none of its own gets it as a supporting POU.
"""

from __future__ import annotations

from collections.abc import Iterable

from ldc.parser import ast
from ldc.parser.foreign import stored

PACKAGE = "ldc.parser.plcopen"
NAMES = frozenset(("SEMA", "RTC", "INTEGRAL", "DERIVATIVE", "PID", "RAMP", "HYSTERESIS"))


def wanted(
    pous: Iterable[ast.Pou], shared: Iterable[ast.VarBlock], own: Iterable[str]
) -> tuple[ast.Pou, ...]:
    """Those that variables of POUs and global ones name as their types, and what these need; without those
    that are declared, whose names are ``own``."""
    known = {name.upper() for name in own}
    blocks = [*shared, *(block for pou in pous for block in pou.var_blocks)]
    used = _types(blocks) - known
    if not used:
        return ()
    found = {pou.name.upper(): pou for pou in stored(PACKAGE, "additional")}
    more = used
    while more:
        more = {key for name in more for key in _types(found[name].var_blocks)} - known - used
        used |= more
    return tuple(pou for name, pou in found.items() if name in used)


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
