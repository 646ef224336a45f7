"""LDmicro projects (``.ld``, formats 0.1 and 0.2) to the tree that every source gives.

What each instruction means: docs/import-ldmicro.md.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.patterns import Pattern
from ldc.source import SourceFile

_FIRST_LINE = Pattern(r"\s*LDmicro\d")


def recognises(source: SourceFile) -> bool:
    """Whether the first line says so."""
    return _FIRST_LINE.match(source.text) is not None


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """The program, its subprograms, and the blocks that its instructions are written in."""
    from ldc.parser.ldmicro.program import project

    return project(source, diagnostics)
