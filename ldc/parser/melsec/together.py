"""Several lists of one project: they work on the devices of one controller, so these become global."""

from __future__ import annotations

import re

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.records import replace

_DEVICE = re.compile(r"[A-Z]{1,2}[0-9A-F]+\Z")


def settled(files: tuple[ast.File, ...], diagnostics: Diagnostics) -> tuple[ast.File, ...]:
    """One list stays as it is. Of more, the first holds the devices of all, and the blocks that they need."""
    if len(files) < 2:
        return files
    devices: dict[str, tuple[tuple[str, ...], ast.VarDecl]] = {}
    for file in files:
        for section in file.pous[0].var_blocks:
            for variable in filter(_is_device, section.variables):
                known = devices.get(variable.name)
                # An input that one of the lists writes is an input nowhere.
                if known is None or variable.location is None:
                    note = variable.note or (known[1].note if known else None)
                    devices[variable.name] = section.qualifiers, replace(variable, note=note)
    made, seen = [], set()
    for file in files:
        pous = (_sharing(file.pous[0]), *(pou for pou in file.pous[1:] if pou.name not in seen))
        seen |= {pou.name for pou in file.pous[1:]}
        made.append(replace(file, pous=pous))
    span = files[0].pous[0].name_span
    kept = {qualifiers: tuple(v for own, v in devices.values() if own == qualifiers)
            for qualifiers in dict.fromkeys(own for own, _ in devices.values())}
    shared = tuple(ast.VarBlock("VAR_GLOBAL", qualifiers, found, span) for qualifiers, found in kept.items())
    return (replace(made[0], globals=shared), *made[1:])


def _is_device(variable: ast.VarDecl) -> bool:
    return _DEVICE.match(variable.name) is not None


def _sharing(pou: ast.Pou) -> ast.Pou:
    """A program whose devices lie outside of it."""
    own, outside = [], []
    for section in pou.var_blocks:
        outside += [replace(v, location=None, note=None) for v in section.variables if _is_device(v)]
        left = tuple(v for v in section.variables if not _is_device(v))
        own += [replace(section, variables=left)] if left else []
    declared = (ast.VarBlock("VAR_EXTERNAL", (), tuple(outside), pou.name_span),) if outside else ()
    return replace(pou, var_blocks=(*declared, *own))
