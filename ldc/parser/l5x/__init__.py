"""Rockwell L5X exports: ladder routines in neutral text, tags, types, Add-On Instructions, tasks.

``recognises`` is cheap; the reader is loaded when a file needs it.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.source import SourceFile

NAME = "L5X"
_ROOT, _HEAD = "<RSLogix5000Content", 4096


def recognises(source: SourceFile) -> bool:
    """Whether the root element is that of a Logix Designer export."""
    return _ROOT in source.text[:_HEAD]


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """The controller, its programs, routines, types and tasks (codes LD0150 to LD0153)."""
    from ldc.parser.l5x.project import read as read_project

    return read_project(source, diagnostics)
