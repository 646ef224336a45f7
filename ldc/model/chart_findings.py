"""The findings about sequential function charts, LD0226 to LD0239: one function raises each code."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics, Label
from ldc.model.declaration_findings import head
from ldc.source import Span


def no_initial_step(diagnostics: Diagnostics, span: Span) -> None:
    diagnostics.error("LD0226", "the chart has no initial step", head(span), "no step is ever active",
                      help="write INITIAL_STEP instead of STEP where the sequence begins")


def two_initial_steps(diagnostics: Diagnostics, span: Span, name: str, first: Span) -> None:
    diagnostics.error("LD0227", f"`{name}` is a second initial step of one chart", span, "begins here too",
                      secondary=(Label(first, "the chart begins here"),),
                      help="make it a STEP; steps that begin together follow a transition to `(a, b)`")


def unknown_step(diagnostics: Diagnostics, span: Span, name: str, help: str) -> None:
    diagnostics.error("LD0228", f"there is no step `{name}`", span, "unknown step",
                      help=help or f"declare it: `STEP {name}: END_STEP`")


def no_action(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str) -> None:
    diagnostics.error("LD0229", message, span, label, help=help)


def never_reached(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.warning("LD0230", f"step `{name}` is never active", span,
                        "no sequence of transitions leads here",
                        help="add a transition that leads to it, or remove it")


def unsafe(diagnostics: Diagnostics, span: Span, name: str, step: Span) -> None:
    diagnostics.warning("LD0231", f"this transition can lead to `{name}` while that is still active", span,
                        "one of the two activations would be lost", secondary=(Label(step, "this step"),),
                        help="let sequences that began together end together: `FROM (a, b) TO c`")


def never_fires(diagnostics: Diagnostics, span: Span, names: str) -> None:
    diagnostics.warning("LD0232", f"this transition never fires: {names} are never active together", span,
                        "waits for ever",
                        help="only sequences that began together, `TO (a, b)`, can end together")


def chart_in_function(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.error("LD0233", f"FUNCTION `{name}` is a chart", head(span), "steps have to be remembered",
                      help="a FUNCTION has no memory: make it a FUNCTION_BLOCK")


def step_twice(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.error("LD0234", f"step `{name}` is named twice on one side of a transition", span,
                      "named again here", help="name every step once")


def unused_action(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.warning("LD0235", f"no step names the action `{name}`", span, "never executed",
                        help=f"write `{name}(N);` into a step, or remove the action")
