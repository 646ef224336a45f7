"""What can be said of a chart without its conditions: which steps can be active, and together.

A transition may fire whenever its steps are active. All markings that can then be reached are looked at,
one by one, up to a limit; beyond it only what holds for single steps is told.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence

from ldc.diagnostics import Diagnostics
from ldc.model import chart_findings as findings
from ldc.model.declaration_findings import head
from ldc.parser import sfc

MARKINGS, TRIALS = 5_000, 500_000
"""Markings and firings that are looked at."""

Ends = tuple[sfc.Transition, tuple[str, ...], tuple[str, ...]]
"""A transition with its sources and targets, by names in capitals; all of them are known."""


def check(steps: Mapping[str, sfc.Step], transitions: Sequence[Ends], diagnostics: Diagnostics) -> None:
    """Initial steps (one for each connected chart), steps that are never active, transitions that never fire
    or that activate a step that may be active already."""
    charts = _connected(steps, transitions)
    initial = [[key for key in chart if steps[key].initial] for chart in charts]
    for several in initial:
        for key in several[1:]:
            findings.two_initial_steps(diagnostics, steps[key].name_span, steps[key].name,
                                       steps[several[0]].name_span)
    reached = _reached({key for found in initial for key in found}, transitions)
    for key in steps.keys() - reached if any(initial) else ():
        findings.never_reached(diagnostics, steps[key].name_span, steps[key].name)
    for chart, begin in zip(charts, initial, strict=True):
        if len(begin) == 1:
            own = [ends for ends in transitions if ends[1][0] in chart]
            _explore(steps, begin[0], [ends for ends in own if reached.issuperset(ends[1])], diagnostics)


def _connected(steps: Mapping[str, sfc.Step], transitions: Sequence[Ends]) -> list[dict[str, None]]:
    """The steps that transitions join, in the order of the text."""
    parent = {key: key for key in steps}

    def find(key: str) -> str:
        while parent[key] != key:
            parent[key] = key = parent[parent[key]]
        return key

    for _, sources, targets in transitions:
        for key in (*sources[1:], *targets):
            parent[find(key)] = find(sources[0])
    charts: dict[str, dict[str, None]] = {}
    for key in steps:
        charts.setdefault(find(key), {})[key] = None
    return list(charts.values())


def _reached(begin: set[str], transitions: Sequence[Ends]) -> set[str]:
    """The steps that may become active, each by itself."""
    reached, waiting = set(begin), {n: len(ends[1]) for n, ends in enumerate(transitions)}
    users: dict[str, list[int]] = {}
    for number, (_, sources, _) in enumerate(transitions):
        for key in sources:
            users.setdefault(key, []).append(number)
    work = list(begin)
    while work:
        for number in users.get(work.pop(), ()):
            waiting[number] -= 1
            if waiting[number] == 0:
                new = set(transitions[number][2]) - reached
                reached |= new
                work += new
    return reached


def _explore(steps: Mapping[str, sfc.Step], begin: str, transitions: Sequence[Ends],
             diagnostics: Diagnostics) -> None:
    bits = {key: 1 << n for n, key in enumerate(steps)}
    masks = [(sum(bits[key] for key in sources), sum(bits[key] for key in targets))
             for _, sources, targets in transitions]
    seen, work, trials = {bits[begin]}, deque((bits[begin],)), 0
    fired: set[int] = set()
    while work:
        marking = work.popleft()
        trials += len(masks)
        if len(seen) > MARKINGS or trials > TRIALS:
            return
        for number, (sources, targets) in enumerate(masks):
            if marking & sources != sources:
                continue
            fired.add(number)
            rest = marking & ~sources
            if rest & targets:  # what follows from this one is no news
                transition, _, names = transitions[number]
                step = steps[next(key for key in names if bits[key] & rest)]
                findings.unsafe(diagnostics, head(transition.span), step.name, step.name_span)
                return
            if rest | targets not in seen:
                seen.add(rest | targets)
                work.append(rest | targets)
    for number, (transition, sources, _) in enumerate(transitions):
        if number not in fired:
            names = " and ".join(f"`{steps[key].name}`" for key in sources)
            findings.never_fires(diagnostics, head(transition.span), names)
