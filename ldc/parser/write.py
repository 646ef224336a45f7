"""Trees as text, whatever source they come from: what `ldc import` and `ldc export` write.

The text is put down by the functions that the formatter uses, read, and formatted, so that it is canonical.
Comments are not in the tree; what a foreign source says about a variable becomes one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import count, groupby

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, reader, unparse
from ldc.parser.format import format_file, heading, program_text, task_text
from ldc.parser.format_charts import ChartPrinter
from ldc.parser.format_statements import StatementPrinter
from ldc.parser.lexer import lex
from ldc.parser.listing import is_list, listed
from ldc.parser.sfc import SfcBody, bodies, parts_of
from ldc.parser.statements import StatementBody
from ldc.records import replace
from ldc.source import SourceFile, Span

Part = ast.Pou | ast.TypeDecl | ast.VarBlock | ast.Configuration
_INDENT = unparse.INDENT


def ending(pou: ast.Pou) -> str:
    """The ending of a file that can hold the POU: its body decides."""
    inside = bodies(pou.body) if isinstance(pou.body, SfcBody) else (pou.body,)
    if any(isinstance(body, ast.LadderBody) for body in inside):
        return ".ld"
    listed = not isinstance(pou.body, SfcBody) and all(isinstance(body, ast.TextBody)
                                                       for body in parts_of(pou))
    return ".il" if listed else ".st"


def written(parts: Iterable[Part], path: str, diagnostics: Diagnostics) -> ast.File:
    """The parts as a file with canonical text (in ``source``), read from that text: the same trees, with
    spans there. The ending of ``path`` has to fit the bodies. What a text cannot say is reported."""
    parts = [part for part in parts if not isinstance(part, ast.Pou) or _has_text(part, diagnostics)]
    if not parts:
        return ast.File(SourceFile(path, ""), (), (), (), (), (), incomplete=True)
    draft = SourceFile(path, "\n".join(_lines(parts)) + "\n")
    file = reader.parse_file(draft, diagnostics)
    if diagnostics.has_errors:
        return file
    return reader.parse_file(SourceFile(path, format_file(file)), diagnostics)


def _has_text(pou: ast.Pou, diagnostics: Diagnostics) -> bool:
    """Whether a text file can hold the POU: bodies in Instruction List among others have to begin as no
    statement does, and stand in no ladder."""
    if ending(pou) == ".il":
        return True
    for body in parts_of(pou):
        if isinstance(body, ast.TextBody) and not _told(body):
            diagnostics.error(
                "LD0154", f"`{pou.name}` has a body in Instruction List that begins like a statement",
                body.span,
                "no text file holds this beside bodies in other languages",
                help="begin it with LD, write it in Structured Text or as a ladder; as it is, the file "
                     "compiles "
                     "without import")
            return False
    return True


def _told(body: ast.TextBody) -> bool:
    text = lex(SourceFile("", body.span.text))
    return is_list(text, 0, len(text.types))


def _lines(parts: Iterable[Part]) -> Iterator[str]:
    for is_type, group in groupby(parts, key=lambda part: isinstance(part, ast.TypeDecl)):
        if is_type:
            yield "TYPE"
            for declared in group:
                yield from _type(declared)
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


def _type(declared: ast.TypeDecl) -> Iterator[str]:
    if not isinstance(declared.type, ast.StructType):
        yield f"{declared.name} : {unparse.declared_text(declared)};{_note(declared)}"
        return
    yield f"{declared.name} : STRUCT{_note(declared)}"
    yield from _variables(declared.type.fields)
    value = f" := {unparse.initial_text(declared.initial)}" if declared.initial is not None else ""
    yield f"END_STRUCT{value};"


def _section(block: ast.VarBlock) -> Iterator[str]:
    yield " ".join((block.kind, *block.qualifiers))
    yield from _variables(block.variables)
    yield "END_VAR"


def _variables(declared: Iterable[ast.VarDecl]) -> Iterator[str]:
    """Lines of declarations, with their notes."""
    for _, group in groupby(declared, key=lambda v: (v.group_span, id(v.type), v.location, v.note)):
        variables = list(group)
        first = variables[0]
        place = f" AT {first.location}" if first.location else ""
        names = "" if first.unnamed else ", ".join(v.name for v in variables)
        yield f"{_INDENT}{names}{place} : {unparse.declared_text(first)};{_note(first)}"


def _note(declared: ast.VarDecl | ast.TypeDecl) -> str:
    """What is said about a declaration, as a comment behind it."""
    words = (declared.note or "").split()
    return f"  // {' '.join(words)}" if words else ""


def _pou(pou: ast.Pou) -> Iterator[str]:
    yield heading(pou)
    for block in pou.var_blocks:
        yield from _section(block)
    if isinstance(pou.body, StatementBody):
        printer = _Plain()
        StatementPrinter(printer).list(pou.body.statements, _INDENT)
        yield from printer.lines
    elif isinstance(pou.body, SfcBody):
        printer = _Plain()
        ChartPrinter(printer).chart(_in_order(pou.body))
        yield from printer.lines
    elif isinstance(pou.body, ast.TextBody):
        yield pou.body.span.text.strip("\n")
    else:
        for rung in pou.body.rungs:
            yield unparse.rung_text(rung)
    printer = _Plain()
    ChartPrinter(printer).actions(_at_places(pou.actions, pou.span, count()))
    yield from printer.lines
    yield f"END_{pou.kind}"


def _in_order(chart: SfcBody) -> SfcBody:
    """The chart with spans that put its parts into their order; a drawing may have them anywhere."""
    places = count()
    parts = (chart.steps, chart.transitions, chart.actions)
    return SfcBody(*(_at_places(group, chart.span, places) for group in parts), chart.span)


def _at_places(parts: Iterable, around: Span, places: Iterator[int]) -> tuple:
    """The parts with one place after the other as their spans."""
    return tuple(replace(part, span=Span(around.source, at, at)) for part, at in zip(parts, places))


class _Plain:
    """Takes the lines of statements and charts; there are no comments to put between them."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.opened = False

    def own_lines(self, comments: Sequence[ast.Comment], indent: str) -> None:
        self.lines += [indent + comment.text for comment in comments]

    def above(self, start: int, indent: str) -> None:
        """Nothing stands above a line."""

    def blank(self) -> None:
        self.lines.append("")

    def line(self, text: str, end: int, opens: bool = False) -> None:
        self.lines.append(text)

    def token_end(self, word: str, start: int) -> int:
        return start

    def close(self, word: str, end: int, indent: str, inner: str) -> None:
        self.lines.append(indent + word)

    def rung(self, rung: ast.Rung, indent: str) -> None:
        self.lines.append(indent + unparse.rung_text(rung))

    def listing(self, body: ast.TextBody) -> None:
        self.lines.append(listed(body).replace("\r", "\n").strip("\n"))


def _configuration(configuration: ast.Configuration) -> Iterator[str]:
    yield f"CONFIGURATION {configuration.name}"
    for block in configuration.var_blocks:
        yield from _section(block)
    for resource in configuration.resources:
        if resource.name:
            yield f"RESOURCE {resource.name} ON {resource.processor}"
        for block in resource.var_blocks:
            yield from _section(block)
        yield from map(task_text, resource.tasks)
        yield from map(program_text, resource.programs)
        if resource.name:
            yield "END_RESOURCE"
    yield "END_CONFIGURATION"
