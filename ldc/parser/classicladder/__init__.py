"""ClassicLadder projects (``.clp``, ``.clprj``) to the tree that every source gives.

What cells, blocks and expressions mean: docs/import-classicladder.md.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.source import SourceFile

_FIRST_LINE = "_FILES_CLASSICLADDER"


def recognises(source: SourceFile) -> bool:
    """Whether the first line says so."""
    return source.text.startswith(_FIRST_LINE) or source.text.lstrip().startswith(_FIRST_LINE)


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """The program, its subroutines, and the blocks that timers and counters are written in."""
    from ldc.parser.classicladder.project import project

    return project(source, diagnostics)
