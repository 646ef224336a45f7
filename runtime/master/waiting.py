"""How long the sequence has waited, and for what: for people at the machine and at the end of a run."""

from __future__ import annotations

from ldc.diagnostics import Diagnostic, Severity
from ldc.records import record
from runtime.master.sequence import Awaited, Customised
from runtime.values import milliseconds

LONG_NS = 10_000_000_000
"""Time of the program after which a step that still waits is told at the end of a run."""


@record
class StepWaits:
    """A step waits for ``what``. ``waited_ns``: how long it has waited for its condition, or has lasted.
    ``fault``: a module stands after a fault, and so does the sequence; ``over``: it has gone on since.
    ``errors``: outputs `error` of algorithms that are not 0 now, by path."""

    what: Awaited
    waited_ns: int
    fault: bool = False
    over: bool = False
    errors: tuple[tuple[str, int], ...] = ()

    @property
    def text(self) -> str:
        """In words."""
        what, long = self.what, milliseconds(self.waited_ns)
        step = f"step {what.number} of {what.steps} (`{what.module}`)" if what.number else "the first step"
        if self.fault:
            return f"{step} stands after a fault, until [safety] reset ({long} ms by now)"
        thing = f"`{what.path}`" if what.path else f"module `{what.module}` to end"
        if self.over:
            return f"{step} waited {long} ms for {thing}"
        errors = "".join(f", `{path}` is {value}" for path, value in self.errors)
        return f"{step} waits for {thing} ({long} ms by now){errors}"

    def diagnostic(self) -> Diagnostic:
        """As a note at the end of a run."""
        help_ = f"`{self.what.path}` has to become TRUE" if self.what.path else (
            "it has ended when its `done` is TRUE and none of its algorithms executes")
        if self.errors:
            help_ = "errors of algorithms: 6 and 7 are inputs that are no number or out of range"
        return Diagnostic("LD0848", f"the sequence: {self.text}", None, (), help_, Severity.NOTE)


class Waiting:
    """Looks at the sequence after every scan, and notes when it has gone on. ``long``: steps that have waited
    longer than ``LONG_NS`` and have gone on, each once, with its longest time."""

    __slots__ = ("long", "_moves", "_since_ns", "_looked", "_late")

    def __init__(self) -> None:
        self.long: dict[Awaited, StepWaits] = {}
        self._moves = self._since_ns = 0
        self._looked, self._late = False, None  # once the limit is passed: what is waited for

    def look(self, program: Customised, now_ns: int) -> None:
        waited = now_ns - self._since_ns
        if program.moves != self._moves:
            late, self._late = self._late, None
            if late is not None and (late not in self.long or self.long[late].waited_ns < waited):
                self.long[late] = StepWaits(late, waited, over=True)
            self._moves, self._since_ns, self._looked = program.moves, now_ns, False
        elif waited > LONG_NS and not self._looked:
            what, self._looked = program.awaited, True
            self._late = what if what is not None and what.number > 0 else None

    def told(self, program: Customised, now_ns: int, fault: bool) -> StepWaits | None:
        """What is waited for now."""
        what = program.awaited
        return StepWaits(what, now_ns - self._since_ns, fault) if what is not None else None
