"""The event sequences of the papers as data, and what of them a trace lacks (SPEC 6.3).

A case is a line of items in the order in which they have to happen; between them anything may. An item is a
place of the trace, or a repetition of items: as often as one likes, all of them between its neighbours. Then
pairs that never happen the other way round, and intervals that have to overlap.

Only units are marks. What they set and clear in memory is not repeated here: V.DEFRAME sets the flag of CDF,
C.DEFRAME clears it; who sets a start bit is seen by C.START, and C.END clears it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from ldc.records import record
from runtime.units import (
    A_DEFRAME, A_END, A_EXEC, A_FEEDBACK, A_START, C_BCAST, C_DEFRAME, C_END, C_FEEDBACK, C_LOGIC, C_MSG,
    C_SEND, C_START, V_DEFRAME, V_RX, V_STORE)


class Event(Protocol):
    """What ``runtime.units.UnitEvent`` has."""

    @property
    def time_ns(self) -> int: ...
    @property
    def unit(self) -> str: ...
    @property
    def index(self) -> int: ...
    @property
    def detail(self) -> str: ...


@record
class Mark:
    """An event: of unit ``unit``, about ``role`` (a name that the caller gives an index; "": anything), with
    the detail ``detail`` ("": any)."""

    unit: str
    role: str = ""
    detail: str = ""

    def __str__(self) -> str:
        about = ", ".join(part for part in (self.role, self.detail) if part)
        return f"{self.unit}({about})" if about else self.unit


Matches = Callable[[Mark, Event], bool]
First = Callable[..., int | None]


@record
class Repeated:
    """The marks in their order, ``least`` times or more, before the next mark of the case happens: each time
    one happens, the one before it has happened at least as often."""

    marks: tuple[Mark, ...]
    least: int = 0


@record
class Overlap:
    """``first`` and ``second`` are both under way at some time: from the first event of the first mark to the
    first one after it of the second."""

    first: tuple[Mark, Mark]
    second: tuple[Mark, Mark]


@record
class Case:
    """``chains``: each in its order, independent of the others. ``never``: (a, b): no a before the first b.
    ``once``: happens at most once."""

    name: str
    chains: tuple[tuple[Mark | Repeated, ...], ...]
    never: tuple[tuple[Mark, Mark], ...] = ()
    overlaps: tuple[Overlap, ...] = ()
    once: tuple[Mark, ...] = ()


def _started(module: str, algorithm: str) -> tuple[Mark, ...]:
    """From the start of a module to the execution of its algorithm."""
    return (Mark(C_START, module), Mark(C_SEND, algorithm, "START"), Mark(A_START, algorithm),
            Mark(A_DEFRAME, algorithm), Mark(A_EXEC, algorithm))


def _ended(algorithm: str) -> tuple[Mark, ...]:
    return Mark(A_END, algorithm), Mark(C_FEEDBACK, algorithm, "end")


def _fed_back(algorithm: str) -> Repeated:
    return Repeated((Mark(A_FEEDBACK, algorithm), Mark(C_FEEDBACK, algorithm)))


CASE_ONE = Case(
    "case one: a module on one slave, then one on another",
    ((Mark(C_LOGIC), *_started("module 1", "algorithm 1"), _fed_back("algorithm 1"), *_ended("algorithm 1"),
      Mark(C_LOGIC), *_started("module 2", "algorithm 2"), _fed_back("algorithm 2"),
      *_ended("algorithm 2")),),
    never=((Mark(A_START, "algorithm 2"), Mark(C_FEEDBACK, "algorithm 1", "end")),),
)

CASE_TWO = Case(
    "case two: a message starts the second module while the first works",
    ((Mark(C_LOGIC), *_started("module 1", "algorithm 1"), Mark(C_BCAST, "message"), Mark(C_MSG, "message"),
      *_started("module 2", "algorithm 2"), *_ended("algorithm 1")),
     (Mark(A_EXEC, "algorithm 2"), *_ended("algorithm 2"))),
    overlaps=(Overlap((Mark(A_EXEC, "algorithm 1"), Mark(A_END, "algorithm 1")),
                      (Mark(A_EXEC, "algorithm 2"), Mark(A_END, "algorithm 2"))),),
)

_FRAME = (Mark(V_RX), Mark(V_STORE), Mark(V_DEFRAME, "module"))

VISUAL_FLOW = Case(
    "visual flow: a frame brings the parameters, a second one changes them",
    ((*_FRAME, Mark(C_DEFRAME, "module"), Mark(C_SEND, "algorithm", "START"), Mark(A_START, "algorithm"),
      Mark(A_DEFRAME, "algorithm"), Mark(A_EXEC, "algorithm"), _fed_back("algorithm"),
      *_FRAME, Mark(C_DEFRAME, "module"), Mark(C_SEND, "algorithm", "UPDATE"), Mark(A_DEFRAME, "algorithm"),
      Mark(A_END, "algorithm"), Mark(C_END, "module")),
     (Mark(C_START, "module"), Mark(C_LOGIC), Mark(C_DEFRAME, "module"))),
    never=((Mark(C_DEFRAME, "module"), Mark(C_START, "module")),),
    once=(Mark(A_START, "algorithm"),),
)

CASES = (CASE_ONE, CASE_TWO, VISUAL_FLOW)


def violations(case: Case, trace: Sequence[Event], roles: dict[str, int | tuple[int, ...]]) -> list[str]:
    """What is missing or out of order, in words; empty when the trace shows the case. ``roles``: the indices
    that the names of roles stand for here. Raises KeyError for a role that has none."""
    wanted = {name: {value} if isinstance(value, int) else set(value) for name, value in roles.items()}

    def matches(mark: Mark, event: Event) -> bool:
        return (event.unit == mark.unit and (not mark.role or event.index in wanted[mark.role])
                and (not mark.detail or event.detail == mark.detail))

    def first(mark: Mark, start: int = 0) -> int | None:
        return next((n for n in range(start, len(trace)) if matches(mark, trace[n])), None)

    found: list[str] = []
    for chain in case.chains:
        found += _chain(chain, trace, first, matches)
    for late, early in case.never:
        at, bound = first(late), first(early)
        if at is not None and (bound is None or at < bound):
            when = f"{early}, which never happens" if bound is None else str(early)
            found.append(f"{late} at {trace[at].time_ns} ns is before {when}")
    for mark in case.once:
        if (at := first(mark)) is not None and (again := first(mark, at + 1)) is not None:
            found.append(f"{mark} happens again at {trace[again].time_ns} ns")
    for overlap in case.overlaps:
        found += _overlap(overlap, trace, first)
    return found


def _chain(chain: Sequence[Mark | Repeated], trace: Sequence[Event], first: First, matches: Matches
           ) -> list[str]:
    """Walks the trace once: the earliest event that fits each mark leaves most room for those behind it."""
    at, after = 0, "the begin"
    for number, item in enumerate(chain):
        if isinstance(item, Mark):
            place = first(item, at)
            if place is None:
                return [_missing(item, after, trace, first)]
            at, after = place + 1, f"{item} at {trace[place].time_ns} ns"
            continue
        following = next((i for i in chain[number + 1 :] if isinstance(i, Mark)), None)
        end = None if following is None else first(following, at)
        wrong = _repeated(item, trace[at:end], matches)
        if wrong:
            return [f"{wrong} after {after}"]
    return []


def _repeated(item: Repeated, trace: Sequence[Event], matches: Matches) -> str:
    """What of a repetition is wrong in its part of the trace: one of its marks comes more often than the one
    before it has, or there are too few of them."""
    counts = [0] * len(item.marks)
    for event in trace:
        for number, mark in enumerate(item.marks):
            if matches(mark, event):
                counts[number] += 1
                if number and counts[number] > counts[number - 1]:
                    return f"{mark} at {event.time_ns} ns has no {item.marks[number - 1]} before it,"
    if counts[-1] < item.least:
        return f"{' < '.join(map(str, item.marks))} happens {counts[-1]} times, {item.least} are wanted,"
    return ""


def _missing(mark: Mark, after: str, trace: Sequence[Event], first: First) -> str:
    place = first(mark)
    if place is None:
        return f"{mark} never happens (wanted after {after})"
    return f"{mark} happens at {trace[place].time_ns} ns, and not after {after}"


def _overlap(overlap: Overlap, trace: Sequence[Event], first: First) -> list[str]:
    ends = []
    for begin, end in (overlap.first, overlap.second):
        start = first(begin)
        stop = None if start is None else first(end, start + 1)
        if start is None or stop is None:
            return [f"{begin if start is None else end} never happens: nothing overlaps"]
        ends.append((start, stop))
    (a, b), (c, d) = ends
    low, high = max(trace[a].time_ns, trace[c].time_ns), min(trace[b].time_ns, trace[d].time_ns)
    if high > low:
        return []
    intervals = " and ".join(f"{begin} to {end}" for begin, end in (overlap.first, overlap.second))
    return [f"{intervals} do not overlap: {high - low} ns"]
