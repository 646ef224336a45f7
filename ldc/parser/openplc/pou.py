"""A POU in a file of its own: declarations and heading as text, the body as JSON or as text."""

from __future__ import annotations

from collections.abc import Mapping

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.findings import TooMany
from ldc.parser.foreign import Reading
from ldc.parser.lexer import SECTIONS, Tokens, lex
from ldc.parser.openplc.drawing import Drawings
from ldc.parser.openplc.known import DRAWN, FORMAT
from ldc.parser.openplc.types import plain_pou
from ldc.parser.openplc.values import JsonText
from ldc.parser.plcopen.guarded import Additions, Pins, added, pins_of, retype
from ldc.parser.reader import POUS, Reader
from ldc.records import replace
from ldc.source import SourceFile, Span

_HYBRID = {".py": "Python", ".cpp": "C++"}


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """The POU of a file. Its text is read like that of .ld, .st and .il files."""
    reading = Reading(source, FORMAT, diagnostics)
    hybrid = next((name for ending, name in _HYBRID.items() if source.path.lower().endswith(ending)), None)
    drawn = DRAWN.search(source.text) if hybrid is None else None
    text = None
    if hybrid is not None:
        tokens = _declarations(source)
        _unsupported_body(reading, tokens, hybrid)
    elif drawn is not None:
        text = JsonText(reading, drawn.start())
        tokens = lex(source, 0, drawn.start())
        if text.root is None:
            _close(tokens, len(source.text))
        else:
            join(tokens, lex(source, text.end))
    else:
        tokens = lex(source)
    addresses_first(tokens)
    reader = Reader(tokens, diagnostics)
    try:
        reader.read()
    except TooMany:
        reader.units.lost = True
    pous = tuple(reader.pous)
    comments = [ast.Comment(source.text[a:b], Span(source, a, b)) for a, b in tokens.comments]
    if text is not None and text.root is not None and pous:
        body = Drawings(reading, text, pous[-1].name, more := additions(pous[-1], {}))
        pous = (*pous[:-1], *drawn_pou(pous[-1], body.body(text.root), more, reading))
    pous = tuple(plain_pou(_titled(pou, comments)) for pou in pous)
    return ast.File(source, pous, tuple(reader.type_decls), tuple(reader.globals),
                    tuple(reader.configurations), tuple(comments),
                    reading.lost or reader.units.lost, tuple(reading.remarks))


def additions(pou: ast.Pou, interfaces: Mapping[str, Pins]) -> Additions:
    """What the drawing of a POU may use and add. ``interfaces``: of the function blocks of the project."""
    local = {v.name.upper(): v for section in pou.var_blocks for v in section.variables}
    return Additions(dict(interfaces), local, prefix=f"{pou.name}_")


def drawn_pou(
    pou: ast.Pou, body: ast.LadderBody, more: Additions, reading: Reading
) -> tuple[ast.Pou, ...]:
    """A POU with its drawing, and the function blocks that this needs."""
    reading.remarks += (*more.remarks(pou.name), *map(added, more.pous.values()))
    sections = retype(pou.var_blocks, more.retyped)
    if more.variables:
        sections = (*sections, ast.VarBlock("VAR", (), tuple(more.variables), pou.name_span))
    return replace(pou, var_blocks=sections, body=body), *more.pous.values()


def interface(pou: ast.Pou) -> Pins:
    return pins_of(pou.var_blocks)


def join(tokens: Tokens, more: Tokens) -> None:
    """Append tokens."""
    tokens.types.extend(more.types)
    tokens.starts.extend(more.starts)
    tokens.ends.extend(more.ends)
    tokens.comments.extend(more.comments)


def addresses_first(tokens: Tokens) -> None:
    """Bring `name : TYPE AT %IX0.0` into the order of the standard, `name AT %IX0.0 : TYPE`."""
    types = tokens.types
    colon = None
    inside = False
    for index, kind in enumerate(types):
        if kind in SECTIONS or kind == "END_VAR":
            inside = kind != "END_VAR"
        elif kind == ";":
            colon = None
        elif kind == ":" and inside:
            colon = index
        elif kind == "AT" and colon is not None and types[index + 1 : index + 2] == ["DIRECT"]:
            for column in (tokens.types, tokens.starts, tokens.ends):
                column[colon : index + 2] = [*column[index : index + 2], *column[colon:index]]
            colon = None


def _declarations(source: SourceFile) -> Tokens:
    """Heading and declarations of a POU whose body is in no language of the standard."""
    whole = lex(source)
    end = max((i for i, kind in enumerate(whole.types) if kind == "END_VAR"), default=1) + 1
    stop = whole.ends[min(end, len(whole.ends)) - 1] if whole.ends else 0
    tokens = lex(source, 0, stop)
    _close(tokens, stop)
    return tokens


def _close(tokens: Tokens, at: int) -> None:
    """End the POU that is open."""
    kind = next((kind for kind in tokens.types if kind in POUS), None)
    if kind is not None:
        join(tokens, Tokens(tokens.source, [f"END_{kind}"], [at], [at], []))


def _unsupported_body(reading: Reading, tokens: Tokens, language: str) -> None:
    name = tokens.text(1) if len(tokens.types) > 1 else "the POU"
    reading.unsupported(tokens.point(1), f"the {language} body of `{name[:40]}`",
                        "write it in ST, or call it from outside", "a body in another language")


def _titled(pou: ast.Pou, comments: list[ast.Comment]) -> ast.Pou:
    """The comment above a POU is its title, one behind a declaration its note."""
    title = pou.title
    if title is None and comments and comments[0].span.end <= pou.span.start:
        title = _words(comments[0].text)[:200] or None
    line = {comment.span.position[0]: _words(comment.text) for comment in comments}
    sections = tuple(replace(section, variables=tuple(
        replace(v, note=line.get(v.span.position[0])) for v in section.variables))
        for section in pou.var_blocks)
    return replace(pou, title=title, var_blocks=sections)


def _words(comment: str) -> str:
    """A comment without its marks, in one line."""
    return " ".join((comment[2:-2] if comment.startswith("(*") else comment[2:]).split())
