"""The canonical form of sequential function charts, and of actions: their parts in the order written."""

from __future__ import annotations

from typing import Protocol

from ldc.parser import ast, sfc
from ldc.parser.format_statements import Lines, StatementPrinter
from ldc.parser.statements import StatementBody
from ldc.parser.unparse import INDENT, expr_text


class ChartLines(Lines, Protocol):
    """What takes the lines of a chart. ``token_end``: the offset behind the next token ``word``."""

    opened: bool

    def blank(self) -> None: ...

    def token_end(self, word: str, start: int) -> int: ...

    def close(self, word: str, end: int, indent: str, inner: str) -> None: ...

    def rung(self, rung: ast.Rung, indent: str) -> None: ...

    def listing(self, body: ast.TextBody) -> None: ...


class ChartPrinter:
    def __init__(self, lines: ChartLines) -> None:
        self.lines = lines

    def chart(self, chart: sfc.SfcBody) -> None:
        self._parts((*chart.steps, *chart.transitions, *chart.actions))

    def actions(self, actions: tuple[sfc.Action, ...]) -> None:
        """Those of a POU that is no chart."""
        self._parts(actions)

    def _parts(self, parts: tuple[sfc.Step | sfc.Transition | sfc.Action, ...]) -> None:
        for part in sorted(parts, key=lambda p: p.span.start):
            self.lines.blank()
            self.lines.above(part.span.start, "")
            match part:
                case sfc.Step():
                    self._step(part)
                case sfc.Transition():
                    self._transition(part)
                case sfc.Action():
                    end = self.lines.token_end(":", part.name_span.start)
                    self.lines.line(f"ACTION {part.name}:", end, opens=True)
                    self._body(part.body)
                    self.lines.close("END_ACTION", part.span.end, "", INDENT)

    def _step(self, step: sfc.Step) -> None:
        end = self.lines.token_end(":", step.name_span.start)
        self.lines.line(f"{'INITIAL_STEP' if step.initial else 'STEP'} {step.name}:", end, opens=True)
        for one in step.associations:
            self.lines.above(one.span.start, INDENT)
            self.lines.line(f"{INDENT}{association_text(one)};", one.span.end)
        self.lines.close("END_STEP", step.span.end, "", INDENT)

    def _transition(self, transition: sfc.Transition) -> None:
        start, head = transition.targets[-1].span.start, heading(transition)
        if isinstance(transition.condition, sfc.Body):
            self.lines.line(f"{head}:", self.lines.token_end(":", start), opens=True)
            self._body(transition.condition)
        else:
            self.lines.line(head, transition.targets[-1].span.end, opens=True)
            condition = transition.condition
            self.lines.above(condition.span.start, INDENT)
            end = self.lines.token_end(";", condition.span.start)
            self.lines.line(f"{INDENT}:= {expr_text(condition)};", end)
        self.lines.close("END_TRANSITION", transition.span.end, "", INDENT)

    def _body(self, body: sfc.Body) -> None:
        if isinstance(body, StatementBody):
            StatementPrinter(self.lines).list(body.statements, INDENT)
            return
        if isinstance(body, ast.TextBody):
            self.lines.listing(body)
            return
        for number, rung in enumerate(body.rungs):
            if number:
                self.lines.blank()
            self.lines.rung(rung, INDENT)


def association_text(one: sfc.Association) -> str:
    """``motor(D, T#2s)``, without a semicolon."""
    parts = (one.qualifier, *(expr_text(e) for e in (one.time, *one.indicators) if e is not None))
    return f"{expr_text(one.action)}({', '.join(parts)})"


def heading(transition: sfc.Transition) -> str:
    """``TRANSITION name (PRIORITY := 1) FROM a TO (b, c)``."""
    name = "" if transition.name is None else f" {transition.name}"
    priority = "" if transition.priority is None else f" (PRIORITY := {transition.priority})"
    ends = (_steps(steps) for steps in (transition.sources, transition.targets))
    return f"TRANSITION{name}{priority} FROM {' TO '.join(ends)}"


def _steps(steps: tuple[ast.Name, ...]) -> str:
    names = ", ".join(step.name for step in steps)
    return names if len(steps) == 1 else f"({names})"
