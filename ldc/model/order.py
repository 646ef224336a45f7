"""Who calls whom: callees before callers, and recursion, which IEC 61131-3 forbids (2.5.1.1)."""

from __future__ import annotations

import re
from collections.abc import Iterator

from ldc.diagnostics import Diagnostics, Label
from ldc.model import declaration_findings as findings
from ldc.model.project import Pou
from ldc.model.walk import callees, calls_in
from ldc.parser import ast, sfc
from ldc.parser.unread import UnreadPaths
from ldc.patterns import Pattern
from ldc.source import Span
from ldc.types import blocks_in

DEEPEST_CALLS = 100
# Comments and strings are passed over; a word, and whether a bracket follows it.
_WORD = Pattern(
    r"\(\*.*?\*\)|//[^\r\n]*|'(?:[^'$\n]|\$.)*'|\"(?:[^\"$\n]|\$.)*\"|([A-Za-z_]\w*)(?=(\s*\((?!\*))?)",
    re.DOTALL
)


def call_order(pous: dict[str, Pou], diagnostics: Diagnostics) -> tuple[str, ...]:
    """The POUs (capitals), callees first; a circle is reported once and its POUs still appear."""
    return ordered(pous, {key: {} for key in pous}, diagnostics)


def ordered(
    pous: dict[str, Pou], further: dict[str, dict[str, Span | None]], diagnostics: Diagnostics
) -> tuple[str, ...]:
    """As ``call_order``; ``further``: by POU whom else it calls, and where, which no declaration tells."""
    functions = {name: key for key, pou in pous.items() if pou.signature.kind == "FUNCTION"
                 for name in {key, pou.signature.written.upper() or key}}
    calls = {key: dict(_callees(key, pou, pous, functions)) | further[key] for key, pou in pous.items()}
    order: list[str] = []
    depth: dict[str, int] = {}
    state: dict[str, int] = {}  # 1: being visited, 2: done
    for root in pous:
        if root in state:
            continue
        stack = [(root, iter(calls[root]))]
        state[root] = 1
        while stack:
            key, rest = stack[-1]
            following = next(rest, None)
            if following is None:
                stack.pop()
                state[key] = 2
                order.append(key)
                depth[key] = 1 + max((depth.get(c, 0) for c in calls[key]), default=0)
                if depth[key] == DEEPEST_CALLS + 1:
                    findings.nested_too_deep(diagnostics, pous[key].span, f"call by `{pous[key].name}`",
                                             DEEPEST_CALLS)
            elif following not in state:
                state[following] = 1
                stack.append((following, iter(calls[following])))
            elif state[following] == 1:
                path = [k for k, _ in stack]
                _report(path[path.index(following):], pous, calls, diagnostics)
    return tuple(order)


def _report(cycle: list[str], pous: dict[str, Pou], calls, diagnostics: Diagnostics) -> None:
    at = cycle.index(min(cycle, key=list(pous).index))
    cycle = [*cycle[at:], *cycle[:at], cycle[at]]
    names = [pous[key].name for key in cycle]
    labels = [Label(span, f"`{pous[callee].name}` is used here") for caller, callee in zip(cycle, cycle[1:])
              if (span := calls[caller][callee]) is not None]
    findings.recursion(diagnostics, pous[cycle[0]].span, names, labels)


def _callees(
    key: str, pou: Pou, pous: dict[str, Pou], functions: dict[str, str]
) -> Iterator[tuple[str, Span | None]]:
    """The POUs of the project that ``pou`` uses, with one place where it does."""
    for variable in pou.variables.values():
        if variable.kind != "external":
            yield from ((held, variable.span) for held in blocks_in(variable.type) if held in pous)
    if not functions:
        return
    for body in sfc.parts_of(pou):
        yield from _called(key, body, functions)
    if isinstance(pou.body, sfc.SfcBody):
        for node in (call for expression in sfc.expressions(pou.body) for call in calls_in(expression)):
            if node.name.upper() in functions:
                yield functions[node.name.upper()], node.span


def _called(key: str, body: sfc.Body, functions: dict[str, str]) -> Iterator[tuple[str, Span]]:
    """The FUNCTIONs that a body calls. ``functions``: each by the names that texts have for it."""
    if isinstance(body, ast.LadderBody):
        for rung in body.rungs:
            if isinstance(rung.paths, UnreadPaths) and rung.paths.head.calls.isdisjoint(functions):
                continue
            for name, node in callees(rung):
                if name.upper() in functions:
                    yield functions[name.upper()], node.span
        return
    at = body.span
    for match in _WORD.finditer(at.source.text, at.start, at.end):
        name = match[1].upper() if match[1] else ""
        # Inside a FUNCTION its own name is its result, unless it is called.
        if name in functions and (functions[name] != key or match[2]):
            yield functions[name], Span(at.source, match.start(1), match.end(1))
