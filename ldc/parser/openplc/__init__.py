"""Files of OpenPLC Editor 4 to ast.File: POUs with JSON drawings, and ``project.json``."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.openplc.known import kind_of, position
from ldc.source import SourceFile

__all__ = ["is_openplc", "position", "read", "settled"]


def is_openplc(source: SourceFile) -> bool:
    """Whether a source is a POU or a project of that editor."""
    return kind_of(source) is not None


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """All that the file declares (codes LD0150 to LD0153, and LD014x for what is drawn)."""
    from ldc.parser.openplc import pou, project

    reader = project if kind_of(source) == "project" else pou
    return reader.read(source, diagnostics)


def settled(files: tuple[ast.File, ...], diagnostics: Diagnostics) -> tuple[ast.File, ...]:
    """The files of one project, with what only all of them together tell."""
    from ldc.parser.openplc import together

    return together.settled(files, diagnostics)
