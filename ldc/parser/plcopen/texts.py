"""Names and expressions that stand in attributes and in the text of elements."""

from __future__ import annotations

import re

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, literals
from ldc.parser.foreign import RESERVED
from ldc.parser.lexer import KEYWORDS, MAX_WORD, lex
from ldc.parser.plcopen import findings
from ldc.parser.plcopen.document import Node
from ldc.parser.reader import parse_expression
from ldc.parser.units import Units
from ldc.patterns import Pattern
from ldc.source import Span

_NAME = Pattern(r"[A-Za-z_]\w*\Z", re.ASCII)
_ISO = Pattern(r"P(?:(\d+)D)?(?:T(?:(\d+)H)?(?:(\d+)M)?(?:(\d+)(?:\.(\d{1,9})\d*)?S)?)?\Z", re.ASCII)
_CLOCK = Pattern(r"(\d\d):(\d\d):(\d\d)(?:\.(\d{1,9}))?\Z", re.ASCII)
_BARE_TIME = Pattern(r"(?:\d+(?:\.\d+)?(?:d|h|m|s|ms|us|ns)_?)+\Z", re.ASCII | re.IGNORECASE)


def expression(span: Span, diagnostics: Diagnostics) -> ast.Expr | None:
    """The expression written there; None when it is none (then it is told)."""
    return named(span) or parse_expression(span.source, span.start, span.end, diagnostics)


def named(span: Span) -> ast.Name | None:
    """The name that is all that is written there, as it is nearly everywhere."""
    text = span.text
    if len(text) <= MAX_WORD and _NAME.match(text) and text.upper() not in KEYWORDS:
        return ast.Name(text, span)
    return None


def name(node: Node, diagnostics: Diagnostics, attribute: str = "name") -> str | None:
    """A name that other things refer to."""
    text = node.get(attribute).strip()
    if _NAME.match(text):
        return text
    what = f"`{text[:40]}` is no name" if text else f"<{node.tag}> has no {attribute}"
    findings.malformed(diagnostics, node.span, what, "names have letters a to z, digits and underscores")
    return None


def is_name(text: str) -> bool:
    return _NAME.match(text) is not None


def type_name(node: Node, diagnostics: Diagnostics) -> tuple[str, Span] | None:
    """The name of a type, without that of a library before it (`Standard.TON`), and where it stands."""
    found, span = node.get("name"), node.attribute("name")
    own = found.rpartition(".")[2]
    if own != found and all(map(_NAME.match, found.strip().split("."))):
        return own.strip(), Span(span.source, span.start + len(found) - len(own), span.end)
    known = name(node, diagnostics)
    return None if known is None else (known, span)


def initial(span: Span, diagnostics: Diagnostics) -> ast.Initial | None:
    """The initial value written there: an expression, `[1, 2(0)]`, `(x := 1, y := 2)`."""
    text = span.text.lstrip()
    if not text.startswith(("[", "(")):
        return expression(span, diagnostics)
    tokens = lex(span.source, span.start, span.end)
    return Units(tokens, diagnostics).parse("single_initial", 0, len(tokens.types), "initial value")


def label(text: str, default: str) -> str:
    """A name made of any text: for what nobody refers to."""
    text = re.sub(r"\W+", "_", text.strip(), flags=re.ASCII).strip("_") or default or "unnamed"
    if text.upper() in RESERVED:
        return f"{text}_"
    return f"_{text}" if text[0].isdigit() else text


def duration(node: Node, attribute: str, diagnostics: Diagnostics) -> ast.Expr | None:
    """An interval: ``T#20ms``, ``20ms``, ISO 8601 (``PT0.02S``), or hours, minutes and seconds
    (``00:00:00.02``); None when it is zero or not given."""
    span = node.attribute(attribute)
    text = node.get(attribute).strip()
    iso, clock = _ISO.match(text.upper()), _CLOCK.match(text)
    if (iso or clock) and text:
        groups = iso.groups() if iso else (None, *clock.groups())
        days, hours, minutes, seconds, fraction = (part or "0" for part in groups)
        whole = ((int(days) * 24 + int(hours)) * 60 + int(minutes)) * 60 + int(seconds)
        return time_literal(whole * 10**9 + int(fraction.ljust(9, "0")), span)
    if _BARE_TIME.match(text):
        return bare_time(text, span, diagnostics)
    if not text:
        return None
    value = expression(span, diagnostics)
    return None if isinstance(value, ast.Literal) and value.value == 0 else value


def bare_time(text: str, span: Span, diagnostics: Diagnostics) -> ast.Expr | None:
    try:
        value, type_, shown = literals.literal(f"T#{text}")
    except literals.Malformed:
        return expression(span, diagnostics)
    return ast.Literal(value, type_, shown, span) if value else None


def time_literal(nanoseconds: int, span: Span) -> ast.Expr | None:
    if not nanoseconds:
        return None
    text = f"T#{nanoseconds // 1_000_000}ms" if nanoseconds % 1_000_000 == 0 else f"T#{nanoseconds}ns"
    return ast.Literal(nanoseconds, "TIME", text, span)


def true(span: Span, value: bool = True) -> ast.Literal:
    return ast.Literal(value, "BOOL", "TRUE" if value else "FALSE", span)


def negated(expr: ast.Expr) -> ast.Expr:
    return ast.Unary("NOT", expr, expr.span)


def line(text: str) -> str:
    """The beginning of a text in one line, without what a terminal would obey."""
    shown = " ".join(text[:200].split())[:40]
    return "".join(c if c.isprintable() else "?" for c in shown)


def prose(node: Node | None) -> str:
    """The words in an element, in one line."""
    if node is None:
        return ""
    if not node.children:
        return " ".join(node.content.text.split())
    return " ".join(filter(None, map(prose, node.children)))
