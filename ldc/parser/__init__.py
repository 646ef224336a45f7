"""Sources to ast.File, whatever language they are in, and back (unparse, format)."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, plcopen, reader
from ldc.parser.reader import parse_expression
from ldc.source import SourceFile

__all__ = ["parse_expression", "parse_file"]


def parse_file(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """What a source says; what cannot be read is left out and told (codes LD01xx). XML is known by its
    content, text languages by the ending of the path."""
    if plcopen.is_xml(source):
        return plcopen.read(source, diagnostics)
    return reader.parse_file(source, diagnostics)
