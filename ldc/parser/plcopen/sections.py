"""Sections of interfaces that hold what they may not hold here.

Some editors give addresses to inputs and outputs of a program: these become VAR, which nothing but the image
sees either. Others repeat address and initial value of a global variable where it is external.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator

from ldc.parser import ast
from ldc.parser.foreign import Reading
from ldc.records import replace

_PINS = ("VAR_INPUT", "VAR_OUTPUT")


def legal(pous: tuple[ast.Pou, ...], shared: Iterable[ast.VarBlock], reading: Reading) -> tuple[ast.Pou, ...]:
    """The POUs with legal sections; ``shared``: the sections of the global variables."""
    known = {v.name.upper() for block in shared for v in block.variables}
    return tuple(replace(pou, var_blocks=tuple(_legal(pou, known, reading)))
                 if any(map(_awkward, pou.var_blocks)) else pou for pou in pous)


def _awkward(block: ast.VarBlock) -> bool:
    return block.kind in (*_PINS, "VAR_EXTERNAL") and any(v.location or v.initial for v in block.variables)


def _legal(pou: ast.Pou, known: Container[str], reading: Reading) -> Iterator[ast.VarBlock]:
    for block in pou.var_blocks:
        if block.kind == "VAR_EXTERNAL":
            repeated = [v for v in block.variables if v.name.upper() in known and (v.location or v.initial)]
            for v in repeated:
                reading.remark("left out", f"address and value of {pou.name}.{v.name}",
                               "those of the global variable count", v.span)
            yield replace(block, variables=tuple(
                replace(v, location=None, initial=None) if v in repeated else v for v in block.variables))
            continue
        located = [v for v in block.variables if v.location]
        if pou.kind != "PROGRAM" or block.kind not in _PINS or not located:
            yield block
            continue
        if others := tuple(v for v in block.variables if not v.location):
            yield replace(block, variables=others)
        for v in located:
            reading.remark("mapped", f"{pou.name}.{v.name}", f"VAR, for it is at {v.location}", v.span)
        yield replace(block, kind="VAR", variables=tuple(located))
