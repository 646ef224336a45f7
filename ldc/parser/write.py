"""Trees as text, whatever source they come from: what `ldc import` and `ldc export` write.

The text is put down by the same functions that the formatter uses, read, and formatted, so that it is canonical; comments of the source are not in the tree, what a foreign
source says about a variable becomes one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, reader, unparse
from ldc.parser.format import format_file, heading, program_text, task_text
from ldc.parser.format_statements import StatementPrinter
from ldc.parser.statements import StatementBody
from ldc.source import SourceFile

Part = ast.Pou | ast.TypeDecl | ast.VarBlock | ast.Configuration
_INDENT = unparse.INDENT


def ending(pou: ast.Pou) -> str:
    """The ending of a file that can hold the POU: its body decides."""
    if isinstance(pou.body, ast.LadderBody):
        return ".ld"
    return ".il" if isinstance(pou.body, ast.TextBody) else ".st"


def written(parts: Iterable[Part], path: str, diagnostics: Diagnostics) -> ast.File:
    """The parts as a file with canonical text (in ``source``), read from that text: the same trees, with
    spans there. The ending of ``path`` has to fit the bodies. What a text cannot say is reported."""
    draft = SourceFile(path, "\n".join(_lines(parts)) + "\n")
    file = reader.parse_file(draft, diagnostics)
    if diagnostics.has_errors:
        return file
    return reader.parse_file(SourceFile(path, format_file(file)), diagnostics)


def _lines(parts: Iterable[Part]) -> Iterator[str]:
    for is_type, group in groupby(parts, key=lambda part: isinstance(part, ast.TypeDecl)):
        if is_type:
            yield "TYPE"
            yield from (f"{t.name} : {unparse.declared_text(t)};" for t in group)
            yield "END_TYPE"
            continue
        for part in group:
            if isinstance(part, ast.Pou):
                yield from _pou(part)
            elif isinstance(part, ast.VarBlock):
                yield from _section(part)
            else:
                yield from _configuration(part)
            yield ""


def _section(block: ast.VarBlock) -> Iterator[str]:
    yield " ".join((block.kind, *block.qualifiers))
    for _, group in groupby(block.variables, key=lambda v: (v.group_span, id(v.type), v.location, v.note)):
        variables = list(group)
        first = variables[0]
        place = f" AT {first.location}" if first.location else ""
        note = f"  // {' '.join(first.note.split())}" if first.note and first.note.split() else ""
        names = ", ".join(v.name for v in variables)
        yield f"{_INDENT}{names}{place} : {unparse.declared_text(first)};{note}"
    yield "END_VAR"


def _pou(pou: ast.Pou) -> Iterator[str]:
    yield heading(pou)
    for block in pou.var_blocks:
        yield from _section(block)
    if isinstance(pou.body, StatementBody):
        printer = _Plain()
        StatementPrinter(printer).list(pou.body.statements, _INDENT)
        yield from printer.lines
    elif isinstance(pou.body, ast.TextBody):
        yield pou.body.span.text.strip("\n")
    else:
        for rung in pou.body.rungs:
            yield unparse.rung_text(rung)
    yield f"END_{pou.kind}"


class _Plain:
    """Takes the lines of statements; there are no comments to put between them."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def own_lines(self, comments: Sequence[ast.Comment], indent: str) -> None:
        self.lines += [indent + comment.text for comment in comments]

    def above(self, start: int, indent: str) -> None:
        """Nothing stands above a statement."""

    def line(self, text: str, end: int, opens: bool = False) -> None:
        self.lines.append(text)


def _configuration(configuration: ast.Configuration) -> Iterator[str]:
    yield f"CONFIGURATION {configuration.name}"
    for block in configuration.var_blocks:
        yield from _section(block)
    for resource in configuration.resources:
        yield f"RESOURCE {resource.name} ON {resource.processor}"
        for block in resource.var_blocks:
            yield from _section(block)
        yield from map(task_text, resource.tasks)
        yield from map(program_text, resource.programs)
        yield "END_RESOURCE"
    yield "END_CONFIGURATION"
