"""Sequential function charts as they were written (IEC 61131-3, 2nd edition, 2.6), with spans."""

from __future__ import annotations

from ldc.parser.ast import Expr, LadderBody, Name, TextBody
from ldc.parser.statements import StatementBody
from ldc.records import record
from ldc.source import Span

PLAIN = ("N", "R", "S", "P", "P0", "P1")
TIMED = ("L", "D", "SD", "DS", "SL")
QUALIFIERS = (*PLAIN, *TIMED)
"""Of an action (table 45 of the standard); those of TIMED have a time."""

Body = LadderBody | StatementBody | TextBody


@record
class Association:
    """``action(qualifier, time, indicators)`` in a step. ``action`` names an ACTION of the chart or a BOOL
    variable. Indicators are variables that the action is said to set; they have no effect."""

    action: Expr
    qualifier: str
    time: Expr | None
    indicators: tuple[Expr, ...]
    span: Span


@record
class Step:
    """``STEP name: ... END_STEP``, or INITIAL_STEP."""

    name: str
    initial: bool
    associations: tuple[Association, ...]
    span: Span
    name_span: Span


@record
class Transition:
    """``TRANSITION name (PRIORITY := n) FROM sources TO targets := condition; END_TRANSITION``.

    A ``condition`` that is a body leaves its result in the BOOL variable with the transition's name.
    """

    name: str | None
    priority: int | None
    sources: tuple[Name, ...]
    targets: tuple[Name, ...]
    condition: Expr | Body
    span: Span
    name_span: Span | None = None


@record
class Action:
    """``ACTION name: ... END_ACTION``."""

    name: str
    body: Body
    span: Span
    name_span: Span


@record
class SfcBody:
    """The body of a POU that is a chart, or several charts beside each other. The order of ``transitions``
    is that of the drawing from left to right, ``actions`` are executed in their order."""

    steps: tuple[Step, ...]
    transitions: tuple[Transition, ...]
    actions: tuple[Action, ...]
    span: Span


def bodies(chart: SfcBody) -> tuple[Body, ...]:
    """The bodies of transitions, then those of actions."""
    conditions = (t.condition for t in chart.transitions if isinstance(t.condition, Body))
    return (*conditions, *(action.body for action in chart.actions))


def parts_of(pou) -> tuple[Body, ...]:
    """All that is executed in a POU (of the tree or of the model): its body, or those in its chart, and the
    bodies of its actions."""
    own = bodies(pou.body) if isinstance(pou.body, SfcBody) else (pou.body,)
    return (*own, *(action.body for action in pou.actions))


def expressions(chart: SfcBody) -> tuple[Expr, ...]:
    """Conditions that are no bodies, and times."""
    conditions = (t.condition for t in chart.transitions if not isinstance(t.condition, Body))
    times = (a.time for step in chart.steps for a in step.associations if a.time is not None)
    return (*conditions, *times)


def rungs_of(pou) -> tuple:
    """The rungs of a POU in order, those in its chart and its actions too."""
    return tuple(rung for body in parts_of(pou) if isinstance(body, LadderBody) for rung in body.rungs)
