"""Sources to ast.File, whatever language they are in, and back (unparse, format)."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, formats, reader
from ldc.parser.formats import format_of
from ldc.parser.reader import parse_expression, parse_type
from ldc.parser.unread import Heads
from ldc.source import SourceFile

__all__ = ["format_of", "parse_expression", "parse_file", "parse_files", "parse_type"]


def parse_file(source: SourceFile, diagnostics: Diagnostics, heads: Heads | None = None) -> ast.File:
    """What a source says; what cannot be read is left out and told (codes LD01xx). Formats of other
    tools are known by their content, text languages by the ending of the path. ``heads``: of
    rungs in the ladder language that were read before."""
    foreign = format_of(source)
    if foreign is not None:
        return foreign.read(source, diagnostics)
    if promised := formats.named(source):
        return formats.not_as_named(source, promised, diagnostics)
    return reader.parse_file(source, diagnostics, heads)


def parse_files(
    sources: Iterable[SourceFile], diagnostics: Diagnostics,
    parse: Callable[[SourceFile], ast.File] | None = None,
) -> tuple[ast.File, ...]:
    """All sources of a project, as they are together. ``parse`` reads one, ``parse_file`` unless told."""
    files = tuple(parse(source) if parse else parse_file(source, diagnostics) for source in sources)
    return formats.settled(files, diagnostics)
