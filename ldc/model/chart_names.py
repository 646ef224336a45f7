"""The variables that a chart has beside the declared ones: step flags, action controls, memories.

``step.X`` and ``step.T``, ``action.Q`` and ``action.A`` are for everybody to read; the chart writes them.
What begins with ``_ldc_sfc_`` is kept by the control of the chart (docs/sfc.md tells its use).
"""

from __future__ import annotations

from collections.abc import Iterator

from ldc.expr import FieldStep, Load, Place
from ldc.parser import ast, sfc
from ldc.parser.unparse import expr_text
from ldc.source import Span
from ldc.symbols import Variable
from ldc.types import BOOL, TIME, Field, Instance, Struct, Type

STEP = Struct("_ldc_step", (Field("X", BOOL), Field("T", TIME)))
ACTION = Struct("_ldc_action", (Field("Q", BOOL), Field("A", BOOL)))
RUNNING, CLOCK, LAST, PASSED = (f"_ldc_sfc_{name}" for name in ("running", "clock", "last", "passed"))
STORING = ("S", "DS")
HELD = ("SD", "SL")
"""Qualifiers whose associations remember that they were set, and since when."""


def entered(step: sfc.Step) -> str:
    """TRUE in the execution in which a transition leads to the step, or in which the chart begins with it."""
    return f"_ldc_sfc_in_{step.name}"


def left(step: sfc.Step) -> str:
    """TRUE in the execution in which a transition leads away from the step."""
    return f"_ldc_sfc_out_{step.name}"


def stored(action: str) -> str:
    """What S and DS set and R resets."""
    return f"_ldc_sfc_stored_{action}"


def before(action: str) -> str:
    """Whether the action was on in the execution before, pulses apart."""
    return f"_ldc_sfc_before_{action}"


def held(step: sfc.Step, number: int) -> tuple[str, str]:
    """What an association with SD or SL remembers: that it is set, and the time since then."""
    return f"_ldc_sfc_set_{number}_{step.name}", f"_ldc_sfc_since_{number}_{step.name}"


def flags(chart: sfc.SfcBody) -> Iterator[str]:
    """The variables, in capitals, that only the chart itself writes."""
    yield from (part.name.upper() for part in (*chart.steps, *chart.actions))


def place(name: str, type_: Type = BOOL, field: str = "", span: Span | None = None) -> Place:
    return Place(name, type_, (FieldStep(field),) if field else (), False, span)


def load(name: str, type_: Type = BOOL, field: str = "", span: Span | None = None) -> Load:
    return Load(place(name, type_, field, span), span)


def controlled(chart: sfc.SfcBody) -> Iterator[tuple[str, list[tuple[sfc.Step, int, sfc.Association]]]]:
    """Every action that steps name, as a name for its memories, with its associations (step, number from 1,
    association) in the order of the text. Variables with steps or indexes get a number for a name."""
    found: dict[str, list[tuple[sfc.Step, int, sfc.Association]]] = {}
    names: dict[str, str] = {}
    for step in chart.steps:
        for number, one in enumerate(step.associations, 1):
            text = expr_text(one.action).upper()
            if text not in names:
                plain = isinstance(one.action, ast.Name)
                names[text] = one.action.name if plain else str(len(names) + 1)
            found.setdefault(names[text], []).append((step, number, one))
    yield from found.items()


def variables(chart: sfc.SfcBody) -> Iterator[Variable]:
    """All of them; names may occur twice when the chart is wrong."""
    for step in chart.steps:
        initial = (("X", step.initial), ("T", 0))
        yield Variable(step.name, STEP, "local", initial, span=step.name_span)
    for action in chart.actions:
        yield Variable(action.name, ACTION, "local", span=action.name_span)
    for transition in chart.transitions:
        if isinstance(transition.condition, sfc.Body):
            yield Variable(transition.name, BOOL, "local", span=transition.name_span)
    yield Variable(RUNNING, BOOL, "hidden")
    yield Variable(CLOCK, Instance("TON"), "hidden", ())
    yield from (Variable(name, TIME, "hidden") for name in (LAST, PASSED))
    for step in chart.steps:
        yield from (Variable(name, BOOL, "hidden") for name in (entered(step), left(step)))
        for number, one in enumerate(step.associations, 1):
            if one.qualifier in HELD:
                flag, since = held(step, number)
                yield from (Variable(flag, BOOL, "hidden"), Variable(since, TIME, "hidden"))
    bodies = {action.name.upper() for action in chart.actions}
    for name, associations in controlled(chart):
        if any(one.qualifier in STORING for _, _, one in associations):
            yield Variable(stored(name), BOOL, "hidden")
        if name.upper() in bodies:
            yield Variable(before(name), BOOL, "hidden")
