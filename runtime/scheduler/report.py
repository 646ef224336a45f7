"""What became of the threads of a run, as figures: per thread and as a table of values."""

from __future__ import annotations

from collections.abc import Iterable

from ldc.records import record
from runtime.scheduler.thread import Thread


@record
class Row:
    """One thread. Responses (activation to end) and jitter (how much the delays from activation to begin
    differ) in microseconds; utilisation: its share of the processor, in %. ``watchdogs``: how often
    three periods were missed in a row; ``lost``: events."""

    processor: str
    task: str
    executions: int
    response_worst_us: float
    response_mean_us: float
    jitter_us: float
    overruns: int
    missed: int
    watchdogs: int
    lost: int
    preemptions: int
    utilisation_percent: float


COLUMNS = Row.__match_args__


def rows(processor: str, threads: Iterable[Thread], now_ns: int, began_ns: int = 0) -> tuple[Row, ...]:
    """The threads of a processor from ``began_ns`` to ``now_ns`` of virtual time."""
    def share(thread: Thread) -> float:
        busy = thread.counts.busy - max(thread.ends - now_ns, 0)
        return round(100 * busy / (now_ns - began_ns), 3) if now_ns > began_ns else 0.0

    return tuple(
        Row(processor, thread.name, c.executions, c.worst / 1000, round(c.mean / 1000, 3), c.jitter / 1000,
            c.overruns, c.missed, c.watchdogs, c.lost, c.preemptions, share(thread))
        for thread in threads for c in (thread.counts,))
