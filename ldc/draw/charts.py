"""Sequential function charts on paper: steps with what they do and what leads on, then the ladders."""

from __future__ import annotations

from collections.abc import Iterator
from textwrap import dedent

from ldc.draw.labels import shorten
from ldc.parser import ast, sfc
from ldc.parser.format_charts import association_text
from ldc.parser.unparse import INDENT, expr_text
from ldc.records import replace


def ladders_of(pou: ast.Pou) -> tuple[ast.Pou, ...]:
    """The POU when it is a ladder; of a chart one for each ladder in it, named ``pou.action``."""
    if isinstance(pou.body, ast.LadderBody):
        return (pou,)
    if not isinstance(pou.body, sfc.SfcBody):
        return ()
    parts = [(t.name, t.condition, "TRANSITION", t.span) for t in pou.body.transitions]
    parts += [(a.name, a.body, "ACTION", a.span) for a in pou.body.actions]
    return tuple(replace(pou, kind=kind, name=f"{pou.name}.{name}", title=None, body=body, span=span)
                 for name, body, kind, span in parts if isinstance(body, ast.LadderBody))


def chart_text(pou: ast.Pou, width: int = 100) -> str:
    """The steps of a chart in their order, each with its actions and the transitions that leave it; then the
    actions that are no ladders."""
    heading = "  ".join(part for part in (pou.kind, pou.name, pou.title) if part)
    return "\n".join(shorten(line, width) for line in (heading, *_steps(pou.body), *_statements(pou.body)))


def _steps(chart: sfc.SfcBody) -> Iterator[str]:
    leaving: dict[str, list[sfc.Transition]] = {}
    for transition in chart.transitions:
        for source in transition.sources:
            leaving.setdefault(source.name.upper(), []).append(transition)
    for step in chart.steps:
        yield ""
        yield f"{'╞ ' if step.initial else '─ '}{step.name}{' (initial)' if step.initial else ''}"
        for one in step.associations:
            yield f"{INDENT}{association_text(one)}"
        for transition in leaving.get(step.name.upper(), ()):
            yield f"{INDENT}{_transition(transition)}"


def _transition(transition: sfc.Transition) -> str:
    condition = transition.name or ""
    if not isinstance(transition.condition, sfc.Body):
        condition = f"{condition}: " * bool(condition) + expr_text(transition.condition)
    priority = "" if transition.priority is None else f" [priority {transition.priority}]"
    targets = " and ".join(step.name for step in transition.targets)
    together = " and ".join(step.name for step in transition.sources)
    waits = f", with {together}" if len(transition.sources) > 1 else ""
    return f"┼ {condition}{priority} → {targets}{waits}"


def _statements(chart: sfc.SfcBody) -> Iterator[str]:
    bodies = [(f"TRANSITION {t.name}", t.condition) for t in chart.transitions]
    bodies += [(f"ACTION {a.name}", a.body) for a in chart.actions]
    for heading, body in bodies:
        if isinstance(body, sfc.Body) and not isinstance(body, ast.LadderBody):
            yield from ("", heading)
            text = body.span.text.strip("\n")
            yield from (f"{INDENT}{line}".rstrip() for line in dedent(text).strip().splitlines())
