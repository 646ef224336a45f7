"""The pragma by which function blocks ask the compiler of Beremiz and OpenPLC for the time.

Its own timers begin with it, and so do those that are copied from them:
`{__SET_VAR(data__->,now,,__CURRENT_TIME)}` gives the variable `now` the time since a moment that is not said.
Here that is the first execution: what a timer says that runs since then.
"""

from __future__ import annotations

from ldc.parser import ast
from ldc.parser import statements as st
from ldc.parser.plcopen.guarded import Additions
from ldc.patterns import Pattern
from ldc.source import Span

_ASKS = Pattern(r"\{\s*__SET_VAR\(\s*data__->\s*,\s*(\w+)\s*,\s*,\s*__CURRENT_TIME\s*\)\s*;?\s*\}")
_DAYS = 36_500
_EVER = _DAYS * 86_400 * 10**9
"""The longest time that the timer says, in nanoseconds: a hundred years."""


def variable(pragma: Span) -> Span | None:
    """The variable that gets the time; None for another pragma."""
    found = _ASKS.match(pragma.source.text, pragma.start, pragma.end)
    return Span(pragma.source, *found.span(1)) if found is not None else None


def stands_between(pragma: Span, statements: tuple[st.Statement, ...]) -> bool:
    """Whether a pragma is inside of none of the statements."""
    return all(one.span.end <= pragma.start or one.span.start >= pragma.end for one in statements)


def told(body: st.StatementBody, asked: list[Span], more: Additions) -> st.StatementBody:
    """The body with assignments where it asks for the time for the variables ``asked``; ``more`` takes the
    timer, which is called at the beginning."""
    if not asked:
        return body
    span = asked[0]
    timer = ast.Name(more.fresh("clock"), span)
    more.variables.append(ast.VarDecl(timer.name, None, ast.NamedType("TON", None, span), None, span, span))
    given = (ast.Argument("IN", ast.Literal(True, "BOOL", "TRUE", span), False, span),
             ast.Argument("PT", ast.Literal(_EVER, "TIME", f"T#{_DAYS}d", span), False, span))
    made = [st.Assign(ast.Name(at.text, at), ast.Member(timer, "ET", at), at) for at in asked]
    found = sorted((*body.statements, *made), key=lambda one: one.span.start)
    return st.StatementBody((st.Invoke(timer, given, span), *found), body.span)
