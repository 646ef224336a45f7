"""What a chart does in one execution of its POU, as statements and guarded bodies (docs/sfc.md).

Time passes for active steps; transitions are tested on the marking as it was, one after the other, and take
the steps that they leave; then steps change, actions are switched, and the bodies of those that are on are
executed. The first execution tests no transition: the initial step begins with it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from ldc.diagnostics import Diagnostics
from ldc.expr import Apply, Const, Expr, Load, Place
from ldc.model import actions, statements
from ldc.model import chart_names as names
from ldc.model.charts import Action, Association, Chart, Transition, flag
from ldc.model.environment import Environment
from ldc.parser import ast, sfc
from ldc.parser import statements as st
from ldc.records import record
from ldc.source import Span
from ldc.types import BOOL, TIME

TRUE, FALSE, ZERO = Const(True, BOOL), Const(False, BOOL), Const(0, TIME)
_LONGEST = TIME.range[1]


@record
class Control:
    """Statements; ``title`` tells what part of the chart they are."""

    title: str
    actions: tuple[actions.Action, ...]
    span: Span


@record
class Guarded:
    """A body that is executed when ``when`` is TRUE; RETURN in it leads behind it. ``result``: the variable
    that takes a BOOL accumulator at the end of Instruction List, when the body is that of a transition."""

    title: str
    when: Expr
    body: sfc.Body
    span: Span
    result: Place | None = None


Part = Control | Guarded


def parts(env: Environment, chart: Chart, diagnostics: Diagnostics) -> Iterator[Part]:
    """In the order of execution."""
    node = chart.node
    yield Control("time of steps", (*_clock(env, node.span, diagnostics), *_passing(node.steps)), node.span)
    for transition in chart.transitions:
        yield from _transition(transition)
    yield Control("steps", tuple(_marking(node.steps, node.span)), node.span)
    found = tuple(statement for action in chart.actions for statement in _switch(action))
    if found:
        yield Control("actions", found, node.span)
    for action in chart.actions:
        if action.body is not None:
            when = names.load(action.body.name, BOOL, "A", action.body.name_span)
            yield Guarded(f"action {action.body.name}", when, action.body.body, action.body.span)


# ---- small words


def _set(name: str, value: Expr, span: Span) -> actions.Assign:
    return actions.Assign(names.place(name, value.type, "", span), value, span)


def _if(condition: Expr, body: Iterable[actions.Action], span: Span, otherwise=()) -> actions.If:
    return actions.If((actions.Arm(condition, tuple(body)),), tuple(otherwise), span)


def _all(items: Sequence[Expr]) -> Expr:
    return items[0] if len(items) == 1 else Apply("AND", tuple(items), BOOL)


def _any(items: Sequence[Expr]) -> Expr:
    return (items[0] if len(items) == 1 else Apply("OR", tuple(items), BOOL)) if items else FALSE


def _not(item: Expr) -> Expr:
    return Apply("NOT", (item,), BOOL)


def _plus(now: Load) -> Expr:
    return Apply("ADD", (now, names.load(names.PASSED, TIME)), TIME)


def _time(step: sfc.Step) -> Load:
    return names.load(step.name, TIME, "T", step.name_span)


# ---- time and steps


def _clock(env: Environment, span: Span, diagnostics: Diagnostics) -> tuple[actions.Action, ...]:
    """How much time has passed since the execution before: a timer that always runs tells the time."""
    clock = ast.Name(names.CLOCK, span)
    given = (("IN", ast.Literal(True, "BOOL", "TRUE", span)),
             ("PT", ast.Literal(_LONGEST, "TIME", f"T#{_LONGEST}ns", span)))
    called = st.Invoke(clock, tuple(ast.Argument(name, value, False, span) for name, value in given), span)
    now, last = names.load(names.CLOCK, TIME, "ET", span), names.load(names.LAST, TIME)
    return (*statements.body(env, (called,), diagnostics),
            _set(names.PASSED, Apply("SUB", (now, last), TIME), span), _set(names.LAST, now, span))


def _passing(steps: Iterable[sfc.Step]) -> Iterator[actions.Action]:
    running = names.load(names.RUNNING)
    for step in steps:
        span, time = step.name_span, _time(step)
        yield _if(flag(step), (actions.Assign(time.place, _plus(time), span),), span)
        yield _set(names.entered(step), _not(running) if step.initial else FALSE, span)
        yield _set(names.left(step), FALSE, span)


def _marking(steps: Iterable[sfc.Step], whole: Span) -> Iterator[actions.Action]:
    yield _set(names.RUNNING, TRUE, whole)
    for step in steps:
        span = step.name_span
        entered, left = names.load(names.entered(step)), names.load(names.left(step))
        yield _if(entered, (actions.Assign(_time(step).place, ZERO, span),), span)
        stays = _all((flag(step), _not(left)))
        yield actions.Assign(flag(step).place, _any((entered, stays)), span)


# ---- transitions


def _transition(transition: Transition) -> Iterator[Part]:
    node, condition = transition.node, transition.condition
    span = node.name_span or Span(node.span.source, node.sources[0].span.start, node.targets[-1].span.end)
    enabled = [names.load(names.RUNNING)]
    enabled += [flag(step) for step in transition.sources]
    enabled += [_not(names.load(names.left(step))) for step in transition.sources
                if step.name in transition.shared]
    fires = (*(_set(names.left(step), TRUE, span) for step in transition.sources),
             *(_set(names.entered(step), TRUE, span) for step in transition.targets))
    title = f"transition {node.name}" if node.name else "transition {} to {}".format(
        *(", ".join(s.name for s in steps) for steps in (transition.sources, transition.targets)))
    if not isinstance(condition, sfc.Body):
        yield Control(title, (_if(_all(enabled), (_if(condition, fires, span),), span),), node.span)
        return
    result = names.load(node.name)
    taken = result.place if isinstance(condition, ast.TextBody) else None
    yield Control(title, (_set(node.name, FALSE, span),), span)
    yield Guarded(f"condition of {title}", _all(enabled), condition, node.span, taken)
    yield Control(title, (_if(result, fires, span),), span)


# ---- actions: what figure 15 of the standard draws


def _switch(action: Action) -> Iterator[actions.Action]:
    """The action control: when the action is on. A body is executed once more when it is no longer."""
    levels, pulses, resets = [], [], []
    for one in action.associations:
        on, span = flag(one.step), one.step.associations[one.number - 1].span
        match one.qualifier:
            case "N":
                levels.append(on)
            case "R":
                resets.append(on)
            case "P" | "P1":
                pulses.append(names.load(names.entered(one.step)))
            case "P0":
                pulses.append(names.load(names.left(one.step)))
            case "L":
                levels.append(_all((on, Apply("LT", (_time(one.step), one.time), BOOL))))
            case "D":
                levels.append(_all((on, _lasted(_time(one.step), one.time))))
            case "S":
                yield _if(on, (_set(names.stored(action.name), TRUE, span),), span)
            case "DS":
                set_ = _set(names.stored(action.name), TRUE, span)
                yield _if(_all((on, _lasted(_time(one.step), one.time))), (set_,), span)
            case _:
                held, level = _held(one, on, span)
                yield held
                levels.append(level)
    first = action.associations[0].step.associations[action.associations[0].number - 1].span
    forgets = [_set(names.held(one.step, one.number)[0], FALSE, first) for one in action.associations
               if one.qualifier in names.HELD]
    if any(one.qualifier in names.STORING for one in action.associations):
        forgets.append(_set(names.stored(action.name), FALSE, first))
        levels.append(names.load(names.stored(action.name)))
    if resets and forgets:
        yield _if(_any(resets), forgets, first)
    yield from _outputs(action, levels, pulses, resets, first)


def _lasted(time: Load, wanted: Expr) -> Expr:
    return Apply("GE", (time, wanted), BOOL)


def _held(one: Association, on: Expr, span: Span) -> tuple[actions.Action, Expr]:
    """SD and SL are set with the step, and count from then on whether or not it stays active."""
    flag_name, since_name = names.held(one.step, one.number)
    is_set, since = names.load(flag_name), names.load(since_name, TIME)
    starts = (_set(flag_name, TRUE, span), actions.Assign(since.place, ZERO, span))
    goes_on = actions.Arm(is_set, (actions.Assign(since.place, _plus(since), span),))
    counting = actions.If((goes_on, actions.Arm(on, starts)), (), span)
    in_time = _lasted(since, one.time) if one.qualifier == "SD" else Apply("LT", (since, one.time), BOOL)
    return counting, _all((is_set, in_time))


def _outputs(action: Action, levels: list[Expr], pulses: list[Expr], resets: list[Expr],
             span: Span) -> Iterator[actions.Action]:
    allowed = [_not(reset) for reset in resets]
    if action.body is None:
        yield actions.Assign(action.place, _all((*allowed, _any(levels + pulses))), span)
        return
    name = action.body.name
    before = names.load(names.before(action.name))
    on, executed = (names.load(name, BOOL, field, span) for field in "QA")
    yield actions.Assign(executed.place, before, span)
    yield _set(before.place.root, _all((*allowed, _any(levels))), span)
    yield actions.Assign(on.place, _any((before, *(_all((*allowed, pulse)) for pulse in pulses))), span)
    yield actions.Assign(executed.place, _any((on, executed)), span)
