"""The standard function blocks as IL units, compiled from the library's own text."""

from __future__ import annotations

from functools import cache

from ldc.diagnostics import Diagnostics, Invalid
from ldc.il.program import Unit
from ldc.il.reader import parse_unit
from ldc.library import blocks
from ldc.model import Scope, resolve
from ldc.model.settings import Settings
from ldc.parser import ast, reader
from ldc.records import replace
from ldc.source import SourceFile


@cache
def unit(name: str) -> Unit:
    """The unit of a standard function block, by name in capitals; made once.

    Raises LookupError for a name that the library does not have, Invalid when its text is wrong.
    """
    if blocks.signature(name) is None:
        raise LookupError(name)
    diagnostics = Diagnostics()
    source = SourceFile(f"{name}.il", blocks.source(name))
    project = ast.Project((reader.parse_file(source, diagnostics),))
    model = resolve(project, diagnostics, Settings(library=True))
    found = None
    if not diagnostics.has_errors:
        pou = next(iter(model.pous.values()))
        found = parse_unit(pou, Scope(model, pou.name), diagnostics)
    if found is None:
        raise Invalid(diagnostics)
    return replace(found, standard=True)
