"""Pieces of ladder text as trees at a place of a foreign source: readers say in text what they mean.

The text is ours: names in it are legal, and what is wrong in it is a slip of the reader that made it
(ValueError), not of the file that is read.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.lexer import lex
from ldc.parser.units import Units
from ldc.records import is_record, replace
from ldc.source import SourceFile, Span

_PLAIN = re.compile(
    r"(?:\[(?:(/)|([PN]) )?|\((?:(/)|([PNSR]) )?)(?!(?:TRUE|FALSE)\b)([A-Za-z_]\w*)[\])]", re.ASCII
)
_NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)


def items(text: str, span: Span) -> tuple[ast.Item, ...]:
    """Elements in series: ``[a] { [b] | [c] } (d)``."""
    plain = _PLAIN.fullmatch(text)
    if plain:  # most elements are contacts and coils of a variable: no parser is needed
        name = ast.Name(plain[5], span)
        if text[0] == "[":
            return (ast.Contact(plain[1] or plain[2] or "", name, span),)
        return (ast.Coil(plain[3] or plain[4] or "", name, span),)
    rung = _parsed("rung", f"RUNG {text}")
    return _moved(rung.paths[0].items, span)


def expression(text: str, span: Span) -> ast.Expr:
    return _moved(_parsed("single_expression", text), span)


def variable(name: str, type_: str, span: Span, *, initial: str | None = None, location: str | None = None,
             note: str | None = None) -> ast.VarDecl:
    """A declaration: ``type_`` and ``initial`` as text."""
    if initial is None and location is None and _NAME.fullmatch(type_):
        return ast.VarDecl(name, None, ast.NamedType(type_, None, span), None, span, span, note)
    place = f" AT {location}" if location else ""
    value = f" := {initial}" if initial else ""
    (line,) = _parsed("var_line", f"{name}{place} : {type_}{value};")
    return replace(_moved(line, span), note=note)


def path(parts: Iterable[ast.Item], span: Span) -> ast.Path:
    return ast.Path(tuple(parts), span)


def configuration(name: str, program: str, interval: str, span: Span) -> ast.Configuration:
    """One task on one processor; ``interval`` as text, ``T#10ms``."""
    priority = ast.Literal(0, None, "0", span)
    task = ast.Task("scan", expression(interval, span), None, priority, span)
    instance = ast.ProgramInstance(program, "scan", program, span)
    return ast.Configuration(
        name, (), (ast.Resource("master", "master", (), (task,), (instance,), span),), span
    )


@lru_cache(maxsize=1_000)
def _parsed(symbol: str, text: str):
    diagnostics = Diagnostics()
    tokens = lex(SourceFile("fragment", text))
    tree = Units(tokens, diagnostics).parse(symbol, 0, len(tokens.types), "fragment")
    if tree is None:
        raise ValueError(f"`{text}`: " + "; ".join(d.message for d in diagnostics))
    return tree


def _moved(tree, span: Span):
    """The same tree with all spans at another place. Fragments are shallow, so it may recurse."""
    if isinstance(tree, Span):
        return span
    if isinstance(tree, tuple):
        return tuple(_moved(part, span) for part in tree)
    if not is_record(tree):
        return tree
    return replace(tree, **{f: _moved(getattr(tree, f), span) for f in tree.__match_args__})
