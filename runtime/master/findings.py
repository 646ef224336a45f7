"""What happened in a master that people are told when the run ends, beside the faults of its tasks."""

from __future__ import annotations


from ldc.diagnostics import Diagnostic
from ldc.records import record
from runtime.faults import TaskOverdue, describe
from runtime.protocol.check import Code
from runtime.values import milliseconds

WATCHDOG = "ALARM", 844 << 16
"""The message of the watchdog of the control thread, and its data: as LD0844."""

_WORDS = {
    Code.LEN: "a transfer has a wrong length", Code.CRC: "transfers arrive damaged",
    Code.SEQ: "transfers are not in order", Code.AID: "it does not know the algorithm",
    Code.PID: "it knows other parameters", Code.TYPE: "a parameter is no number of its type",
    Code.RANGE: "a parameter is outside of its range", Code.STATE: "the command does not fit its state",
    Code.STALE: "the data are too old", Code.SILENT: "it does not answer", Code.STUCK: "its flags stay set",
}


@record
class LinkFault:
    """P has given up a transfer of an algorithm (``path``). ``scan``, ``now_ns``: of the master."""

    slave: int
    path: str
    code: Code
    scan: int
    now_ns: int

    def diagnostic(self) -> Diagnostic:
        """The fault in words."""
        when = f"in scan {self.scan}, at {milliseconds(self.now_ns)} ms"
        return Diagnostic(
            "LD0845", f"slave{self.slave}: {_WORDS[self.code]}: `{self.path}` was ended {when}", None, (),
            f"this is code {int(self.code)} ({self.code.name}) of the transfers: see docs/protocol.md; "
            "the module stands until [safety] reset")


@record
class SlaveAnew:
    """A slave has begun anew. ``scan``, ``now_ns``: of the master when it was told."""

    slave: int
    scan: int
    now_ns: int

    def diagnostic(self) -> Diagnostic:
        """What has ended, and what leads on."""
        when = f"in scan {self.scan}, at {milliseconds(self.now_ns)} ms"
        return Diagnostic(
            "LD0861", f"slave{self.slave} has begun anew: all that it executed ended {when}", None, (),
            "it had no power, its process was ended, or it could not reach the master; its modules stand "
            "until [safety] reset, which makes the links new")


@record
class ScanOverdue:
    """The watchdog of the control thread has ended everything. ``scan``, ``now_ns``: of the master."""

    error: TaskOverdue
    scan: int
    now_ns: int

    def diagnostic(self) -> Diagnostic:
        """What was late, and what followed."""
        code, message, help_ = describe(self.error)
        when = f"in scan {self.scan}, at {milliseconds(self.now_ns)} ms"
        return Diagnostic(code, f"emergency {when}: {message}", None, (), help_)
