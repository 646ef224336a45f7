"""A sequential function chart with its names known and its expressions typed (IEC 61131-3, 2.6)."""

from __future__ import annotations

from collections.abc import Iterable

from ldc.diagnostics import Diagnostics
from ldc.expr import Expr, Load, Place
from ldc.model import chart_findings as findings
from ldc.model import chart_names as names
from ldc.model import chart_rules, expressions, places, statements, type_findings
from ldc.model.environment import Environment
from ldc.model.names import suggest
from ldc.parser import ast, sfc
from ldc.records import record
from ldc.types import BOOL, TIME, storage


@record
class Association:
    """``number`` of the association in its step, from 1; ``time`` for the qualifiers that have one."""

    step: sfc.Step
    number: int
    qualifier: str
    time: Expr | None


@record
class Transition:
    """``condition``: an expression, or a body that sets the variable with the transition's name.
    ``shared``: of ``sources``, those that another transition leads away from as well."""

    node: sfc.Transition
    sources: tuple[sfc.Step, ...]
    targets: tuple[sfc.Step, ...]
    condition: Expr | sfc.Body
    shared: frozenset[str]


@record
class Action:
    """``name``: for its memories. ``body`` None: a BOOL variable, ``place``."""

    name: str
    body: sfc.Action | None
    place: Place | None
    associations: tuple[Association, ...]


@record
class Chart:
    """``transitions``: in the order in which they are tested. ``actions``: variables, then bodies in their
    order."""

    node: sfc.SfcBody
    transitions: tuple[Transition, ...]
    actions: tuple[Action, ...]


def chart(env: Environment, node: sfc.SfcBody, damaged: bool, diagnostics: Diagnostics) -> Chart:
    """The chart; what is wrong is told and left out. ``damaged``: parts were not understood, so that what
    seems to be missing may be just that."""
    typing = _Typing(env, node, damaged, diagnostics)
    made = Chart(node, tuple(typing.transitions()), tuple(typing.actions()))
    if not damaged:
        typing.check(made)
    return made


class _Typing:
    def __init__(self, env: Environment, node: sfc.SfcBody, damaged: bool, diagnostics: Diagnostics) -> None:
        self.env, self.node, self.damaged, self.diagnostics = env, node, damaged, diagnostics
        self.steps: dict[str, sfc.Step] = {}
        for step in node.steps:
            self.steps.setdefault(step.name.upper(), step)
        self.bodies: dict[str, sfc.Action] = {}
        for action in node.actions:
            self.bodies.setdefault(action.name.upper(), action)

    # ---- transitions

    def transitions(self) -> Iterable[Transition]:
        known = [(node, self._steps(node.sources), self._steps(node.targets))
                 for node in self.node.transitions]
        leading: dict[str, int] = {}
        for _, sources, _ in known:
            for step in sources or ():
                leading[step.name] = leading.get(step.name, 0) + 1
        several = frozenset(name for name, count in leading.items() if count > 1)
        for node, sources, targets in sorted(known, key=_rank):
            condition = node.condition
            if not isinstance(condition, sfc.Body):
                condition = statements.condition(self.env, condition, "the condition of a transition",
                                                 self.diagnostics)
            if sources and targets and condition is not None:
                shared = several.intersection(step.name for step in sources)
                yield Transition(node, sources, targets, condition, shared)

    def _steps(self, references: tuple[ast.Name, ...]) -> tuple[sfc.Step, ...] | None:
        found: dict[str, sfc.Step] = {}
        for reference in references:
            key = reference.name.upper()
            if key in found:
                findings.step_twice(self.diagnostics, reference.span, reference.name)
            elif key in self.steps:
                found[key] = self.steps[key]
            elif not self.damaged:
                near = suggest(reference.name, (step.name for step in self.node.steps))
                findings.unknown_step(self.diagnostics, reference.span, reference.name, near)
        return tuple(found.values()) if len(found) == len(references) else None

    # ---- actions

    def actions(self) -> Iterable[Action]:
        bodies: dict[str, Action] = {}
        for name, found in names.controlled(self.node):
            typed = tuple(filter(None, (self._association(*one) for one in found)))
            first = found[0][2].action
            body = self.bodies.get(first.name.upper()) if isinstance(first, ast.Name) else None
            if body is not None:
                bodies[body.name] = Action(name, body, None, typed)
                continue
            place = self._variable(first)
            if place is not None:
                yield Action(name, None, place, typed)
        for body in self.bodies.values():
            if body.name in bodies:
                yield bodies[body.name]
            elif not self.damaged:
                findings.unused_action(self.diagnostics, body.name_span, body.name)

    def _association(self, step: sfc.Step, number: int, node: sfc.Association) -> Association | None:
        for indicator in node.indicators:
            places.place(self.env, indicator, self.diagnostics)
        if node.time is None:
            return Association(step, number, node.qualifier, None)
        what = f"the time of {node.qualifier}"
        time = expressions.expression(self.env, node.time, TIME, self.diagnostics, what)
        return None if time is None else Association(step, number, node.qualifier, time)

    def _variable(self, node: ast.Expr) -> Place | None:
        """The BOOL variable that an association names when it names no ACTION."""
        key = node.name.upper() if isinstance(node, ast.Name) else ""
        if key and self.env.variable(key) is None:
            if not self.damaged and not self.env.silent(key):
                near = suggest(node.name, (*(a.name for a in self.node.actions), *self.env.names()))
                findings.no_action(self.diagnostics, node.span, f"there is no action `{node.name}`",
                                   "neither an ACTION nor a variable",
                                   near or f"write `ACTION {node.name}: ... END_ACTION`, or declare a "
                                   "BOOL variable")
            return None
        place = places.place(self.env, node, self.diagnostics, write=True)
        if place is None or storage(place.type) == BOOL:
            return place
        findings.no_action(self.diagnostics, node.span, f"`{node.span.text}` is no action",
                           f"this is {type_findings.described(place.type)}",
                           "a step names an ACTION or a BOOL variable")
        return None

    # ---- the whole

    def check(self, made: Chart) -> None:
        begin = self.node.steps[0].name_span if self.node.steps else self.node.span
        if self.env.kind == "FUNCTION":
            findings.chart_in_function(self.diagnostics, begin, self.env.pou)
        if not any(step.initial for step in self.node.steps):
            findings.no_initial_step(self.diagnostics, begin)
        ends = [(t.node, _keys(t.sources), _keys(t.targets)) for t in made.transitions]
        if len(ends) == len(self.node.transitions):
            chart_rules.check(self.steps, ends, self.diagnostics)


def _rank(known: tuple) -> tuple[int, int]:
    """Transitions with a priority come first, the least number before; the others follow as written."""
    priority = known[0].priority
    return (1, 0) if priority is None else (0, priority)


def _keys(steps: tuple[sfc.Step, ...]) -> tuple[str, ...]:
    return tuple(step.name.upper() for step in steps)


def flag(step: sfc.Step) -> Load:
    """``step.X``."""
    return names.load(step.name, BOOL, "X", step.name_span)
