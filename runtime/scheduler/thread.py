"""Threads of a processor: their kinds and levels (SPEC 6.1), what they do, what became of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

LEVELS: dict[str, tuple[int, int]] = {
    "emergency": (0, 0), "visual": (1, 0), "communication": (1, 1), "control": (2, 0), "algorithm": (2, 0),
    "customised": (2, 1), "diagnostics": (3, 0),
}
"""Kind of thread -> its level, 0 is the most urgent, and its rank inside of the level."""

MOST_PRIORITY = (1 << 16) - 1

NEVER = 1 << 63
"""A time in ns that does not come."""

Work = Callable[[int], Iterator[int] | None]
"""What a thread does when it is activated, given the time: it executes and returns None (it took no time), or
an iterator that executes one indivisible piece (a rung) at each ``next`` and yields what it cost, in ns. An
iterator that is asked for its length hint and says 0 (lists, ``Pieces`` of a machine) ends with its last
piece; another one ends when it is asked for a piece more and has none, which is a piece without cost."""


class Entry(NamedTuple):
    """A line of the log. ``what``: began, preempted, resumed, paused (its budget is used up), ended, overrun,
    missed (a period), watchdog, lost (an event)."""

    time_ns: int
    processor: int
    thread: str
    what: str


@dataclass(slots=True, eq=False)
class Counts:
    """What became of a thread's activations; times in ns. A response lasts from the activation to the end, a
    delay from the activation to the begin. ``executions`` are those that ended."""

    executions: int = 0
    response: int = 0
    worst: int = 0
    least_delay: int = NEVER
    most_delay: int = 0
    busy: int = 0
    overruns: int = 0
    missed: int = 0
    preemptions: int = 0
    watchdogs: int = 0
    lost: int = 0

    @property
    def mean(self) -> float:
        """The mean response in ns; 0 before the first execution."""
        return self.response / self.executions if self.executions else 0.0

    @property
    def jitter(self) -> int:
        """How much the delays differ, in ns."""
        return self.most_delay - min(self.least_delay, self.most_delay)


@dataclass(slots=True, eq=False)
class Thread:
    """One thread of one processor.

    ``period_ns``: time between two activations, the first at ``offset_ns``; None: by events, by ``release``,
    or, when it is customised, after each scan of the processor's first control thread. ``budget_ns``: the
    most that a customised thread gets per scan (it never gets more than 30 % of the slack). ``priority``:
    inside of the level, 0 is the most urgent; one of higher priority pre-empts one of lower priority, as
    threads of different levels do.
    ``on_watchdog``: called with the time when the watchdog comes (rule R3).
    Raises ValueError for a kind, a time or a priority that is none.
    """

    name: str
    kind: str
    period_ns: int | None
    work: Work
    budget_ns: int | None = None
    offset_ns: int = 0
    priority: int = 0
    on_watchdog: Callable[[int], None] | None = None
    counts: Counts = field(default_factory=Counts, init=False)
    # What the scheduler notes. ``on``: its processor; ``quick``: nobody notes its end or follows it;
    # ``urgency``: level and priority; ``order``: that and the rank; ``number``: among equals; ``left``: of the
    # budget; ``ends``: when the piece ends that it was last in work at.
    on: object = field(init=False, repr=False, default=None)
    quick: bool = field(init=False, repr=False, default=False)
    urgency: int = field(init=False, repr=False)
    order: int = field(init=False, repr=False)
    number: int = field(init=False, repr=False, default=0)
    due: int | None = field(init=False, repr=False, default=None)
    active: bool = field(init=False, repr=False, default=False)
    released: int = field(init=False, repr=False, default=-1)
    pieces: Iterator[int] | None = field(init=False, repr=False, default=None)
    halted: bool = field(init=False, repr=False, default=False)
    paused: bool = field(init=False, repr=False, default=False)
    pending: int | None = field(init=False, repr=False, default=None)
    late: bool = field(init=False, repr=False, default=False)
    streak: int = field(init=False, repr=False, default=0)
    left: int = field(init=False, repr=False, default=0)
    ends: int = field(init=False, repr=False, default=0)

    def __post_init__(self) -> None:
        if self.kind not in LEVELS:
            raise ValueError(f"no kind of thread: {self.kind!r}")
        if self.period_ns is not None and self.period_ns <= 0 or self.offset_ns < 0:
            raise ValueError(f"thread {self.name}: a period is longer than nothing, an offset not negative")
        if not 0 <= self.priority <= MOST_PRIORITY:
            raise ValueError(f"thread {self.name}: priority {self.priority} is outside 0..{MOST_PRIORITY}")
        if self.kind == "customised" and self.period_ns is not None:
            raise ValueError(f"thread {self.name}: a customised thread follows the scan, it has no period")
        level, rank = LEVELS[self.kind]
        self.urgency = level << 16 | self.priority
        self.order = self.urgency << 1 | rank
