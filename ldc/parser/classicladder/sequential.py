"""A sequential page as rungs: a flag for each step, a rung for each transition, repeated while one fires.

As in the tool: transitions are tried in their order, up to 50 times a scan as long as one of the page fires;
then %X and the times of all steps follow the flags.
"""

from __future__ import annotations

from collections.abc import Iterator

from ldc.parser import ast, fragments
from ldc.parser.classicladder.settings import Settings, Transition
from ldc.parser.classicladder.variables import STEP, STEP_TIME, Variables
from ldc.source import Span

_ROUNDS = 50


class Pages:
    """All pages of a project; the flags of steps are made once. ``timed``: the numbers of steps whose time
    an expression names."""

    def __init__(self, variables: Variables, settings: Settings, timed: set[int]) -> None:
        self.variables, self.settings, self.timed = variables, settings, timed
        self.flags = {
            index: variables.added(f"step_{step.number}", "BOOL", step.span, f"step {step.number} is active",
                                   "TRUE" if step.initial else None)
            for index, step in sorted(settings.steps.items())}
        self.times = {
            index: variables.added(f"step_{step.number}_ms", "DINT", step.span,
                                   f"milliseconds that step {step.number} is active")
            for index, step in sorted(settings.steps.items()) if step.number in timed}

    def rungs(self, page: int, title: str, span: Span) -> Iterator[ast.Rung]:
        variables = self.variables
        for name in (*self.flags.values(), *self.times.values()):
            variables.used[name] = variables.found["added", name]
        transitions = [t for _, t in sorted(self.settings.transitions.items()) if t.page == page]
        if transitions:
            again = variables.added(f"page_{page}_fired", "BOOL", span, f"a transition of page {page} fired")
            rounds = variables.added(f"page_{page}_rounds", "DINT", span, f"rounds of page {page} in a scan")
            label = variables.names.fresh(f"page_{page}")
            yield _rung(f"<MOVE(IN := 0, OUT => {rounds})>", span, title)
            yield _rung(f"<ADD({rounds}, 1, OUT => {rounds})> (R {again})", span, None, label)
            for transition in transitions:
                yield _rung(self._transition(transition, again), transition.span)
            yield _rung(f"[{again}] [{rounds} < {_ROUNDS}] >>{label}", span)
        for index, step in sorted(self.settings.steps.items()):
            flag = self.flags[index]
            shown = variables.place(STEP, step.number, step.span).text
            yield _rung(f"[{flag}] ({shown})", step.span)
            if index in self.times:
                time = self.times[index]
                seconds = variables.place(STEP_TIME, step.number, step.span).text
                yield _rung(f"{{ [{flag}] <ADD({time}, {self.settings.period}, OUT => {time})> | "
                            f"[/{flag}] <MOVE(IN := 0, OUT => {time})> }}", step.span)
                yield _rung(f"<MOVE(IN := {time} / 1000, OUT => {seconds})>", step.span)

    def _transition(self, transition: Transition, again: str) -> str:
        place = self.variables.place(*transition.condition, transition.span)
        condition = f"[{place.text}]" if place.type == "BOOL" else f"[{place.text} <> 0]"
        left = [self.flags[step] for step in dict.fromkeys(transition.deactivates)]
        entered = [self.flags[step] for step in dict.fromkeys(transition.activates)]
        parts = [condition, *(f"[{flag}]" for flag in left), *(f"(R {flag})" for flag in left),
                 *(f"(S {flag})" for flag in entered), f"(S {again})"]
        return " ".join(parts)


def _rung(text: str, span: Span, title: str | None = None, name: str | None = None) -> ast.Rung:
    return ast.Rung(
        name, title, (fragments.path(fragments.items(text, span), span),), span, span if name else None
    )
