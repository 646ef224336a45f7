"""Run-time faults: what stops a task, and where (DESIGN section 4: never silent, with a position)."""

from __future__ import annotations


from ldc.diagnostics import Diagnostic, Label
from ldc.library.faults import DivisionByZero
from ldc.records import record
from ldc.source import Span
from runtime.values import milliseconds


class IndexOutOfRange(Exception):
    """An array index outside the declared bounds (inclusive)."""

    def __init__(self, index: int, low: int, high: int) -> None:
        self.index, self.low, self.high = index, low, high
        super().__init__(f"index {index} is outside {low}..{high}")


class WatchdogExpired(Exception):
    """A task made more backward jumps in one execution than its watchdog allows."""

    def __init__(self, limit: int) -> None:
        self.limit = limit
        super().__init__(f"more than {limit} backward jumps in one execution")


class TaskTooLong(Exception):
    """An execution of a task takes more virtual time than its watchdog allows; both in nanoseconds."""

    def __init__(self, lasts: int, limit: int) -> None:
        self.lasts, self.limit = lasts, limit
        allowed = f"{milliseconds(limit)} ms are allowed"
        super().__init__(f"one execution takes {milliseconds(lasts)} ms, {allowed}")


class TaskOverdue(Exception):
    """Executions of a task have missed some periods, of ``period_ns`` each, since the last one that ended in
    time; the longest took ``worst_ns`` so far from when it was due."""

    def __init__(self, missed: int, period_ns: int, worst_ns: int) -> None:
        self.missed, self.period_ns, self.worst_ns = missed, period_ns, worst_ns
        super().__init__(f"{missed} periods of {milliseconds(period_ns)} ms missed in a row, "
                         f"up to {milliseconds(worst_ns)} ms so far from when it was due")


@record
class Place:
    """A place in the code: the POU, the key of the rung and the number of the instruction in it."""

    pou: str
    rung: str
    instruction: int
    element: int = -1
    span: Span | None = None

    def __str__(self) -> str:
        return f"{self.pou}, rung {self.rung}, instruction {self.instruction}" if self.rung else self.pou


@record
class Fault:
    """Why and where a task stopped. ``calls``: the places of the calls that led there, outermost first.

    ``scan`` and ``now_ns`` tell in which execution (time in nanoseconds since the start).
    """

    code: str
    message: str
    help: str
    task: str
    place: Place
    calls: tuple[Place, ...]
    scan: int
    now_ns: int

    @property
    def sentence(self) -> str:
        """What happened and where, in one line: for logs."""
        file = f" ({self.place.span})" if self.place.span else ""
        return f"{self.message} in rung {self.place.rung} of {self.place.pou}{file}"

    def diagnostic(self) -> Diagnostic:
        """The fault as a finding on the rung element that it happened in."""
        primary = None
        if self.place.span:
            where = f"in scan {self.scan}, rung {self.place.rung} of {self.place.pou}"
            primary = Label(self.place.span, where)
        called = tuple(Label(p.span, f"called from rung {p.rung} of {p.pou}") for p in self.calls if p.span)
        where = "" if primary else f" in {self.place}, scan {self.scan}"
        message = f"task {self.task} stopped: {self.message}{where}"
        return Diagnostic(self.code, message, primary, called, self.help)


FAULTS = (DivisionByZero, ZeroDivisionError, IndexOutOfRange, WatchdogExpired)


def describe(error: Exception) -> tuple[str, str, str]:
    """Code, message and help of an exception in ``FAULTS``, TaskTooLong or TaskOverdue; others are bugs."""
    match error:
        case IndexOutOfRange():
            return ("LD0802", f"array {error}",
                    "test the index before it is used, or declare the array wide enough")
        case WatchdogExpired():
            return ("LD0803", f"watchdog: {error}",
                    "make sure that the loop ends, or jump forward only and go on in the next scan")
        case TaskTooLong():
            return ("LD0831", f"watchdog: {error}",
                    "give it less to do or a higher priority, or a longer watchdog: `watchdog` in [tasks], "
                    "[watchdogs] for a slave")
        case TaskOverdue():
            return ("LD0844", f"watchdog: {error}",
                    "give it less to do or a longer period; `ldc run --timing -` shows how long it takes")
        case DivisionByZero() | ZeroDivisionError():
            return ("LD0801", "division by zero",
                    "test the divisor before, as in `[b <> 0] [a / b > 2]`, or draw the function with ENO")
    raise TypeError(f"{type(error).__name__} is not a run-time fault")
