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
    ``fault``: a module stands after a fault, and so does the sequence."""

    what: Awaited
    waited_ns: int
    fault: bool = False

    @property
    def text(self) -> str:
        """In words."""
        what, long = self.what, milliseconds(self.waited_ns)
        step = f"step {what.number} of {what.steps} (`{what.module}`)" if what.number else "the first step"
        if self.fault:
            return f"{step} stands after a fault, until [safety] reset ({long} ms by now)"
        thing = f"`{what.path}`" if what.path else f"module `{what.module}` to end"
        return f"{step} waits for {thing} ({long} ms by now)"

    def diagnostic(self) -> Diagnostic:
        """As a note at the end of a run."""
        help_ = f"`{self.what.path}` has to become TRUE" if self.what.path else (
            "it has ended when its `done` is TRUE and none of its algorithms executes")
        return Diagnostic("LD0848", f"the sequence: {self.text}", None, (), help_, Severity.NOTE)


class Waiting:
    """Looks at the sequence after every scan, and notes when it has gone on."""

    __slots__ = ("_moves", "_since_ns")

    def __init__(self) -> None:
        self._moves = self._since_ns = 0

    def look(self, program: Customised, now_ns: int) -> None:
        if program.moves != self._moves:
            self._moves, self._since_ns = program.moves, now_ns

    def told(self, program: Customised, now_ns: int, fault: bool) -> StepWaits | None:
        """What is waited for now."""
        what = program.awaited
        return StepWaits(what, now_ns - self._since_ns, fault) if what is not None else None
