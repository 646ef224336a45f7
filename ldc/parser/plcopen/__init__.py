"""PLCopen TC6 XML (2.00, 2.01) with LD, FBD, ST and IL bodies to ast.File.

``is_xml`` is cheap; the reader is loaded when a file needs it.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.source import SourceFile, Span

__all__ = ["is_xml", "position", "read"]


def is_xml(source: SourceFile) -> bool:
    """Whether a source is XML: no text language of ours begins with ``<``."""
    return source.text[:1] == "<" or source.text.lstrip()[:1] == "<"


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """All POUs, types, global variables and configurations of the project (codes LD014x)."""
    from ldc.parser.plcopen.project import read as read_project

    return read_project(source, diagnostics)


def position(span: Span) -> str:
    """Where the element that holds the beginning of a span is drawn, in words: `at (40, 60)`."""
    from ldc.parser.plcopen.drawing import position as position_of

    return position_of(span)
