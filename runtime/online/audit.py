"""The audit log: one JSON object a line for every change of what runs, and for every refusal."""

from __future__ import annotations

import errno
import hashlib
import json
import os
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path

from runtime.online.controller import Event


class Audit:
    """Appends to a file of the user's own (mode 0600). ``warn`` is told when it cannot be written any more:
    the program runs on, and the log tells how many lines it lacks once there is room again. Raises OSError
    when it cannot be opened."""

    def __init__(self, path: Path, warn: Callable[[str], None]) -> None:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        self._file = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o600)
        self._warn, self._lost = warn, 0

    def event(self, event: Event, settings: str) -> None:
        """An event of the controller; ``settings``: digest of those that count from then on."""
        codes = [fault.code for fault in event.faults]
        self.line(event.action, scan=event.scan, t_ns=event.now_ns, program=event.digest,
                  settings=settings, client=client_name(event.owner), detail=event.detail, codes=codes)

    def line(self, action: str, **more: object) -> None:
        """One line; ``time`` is UTC."""
        try:
            if self._lost:
                self._append("lost", {"lines": self._lost})
                self._lost = 0
            self._append(action, more)
        except OSError as error:
            if not self._lost:
                self._warn(f"the audit log cannot be written: {error}")
            self._lost += 1

    def _append(self, action: str, more: Mapping[str, object]) -> None:
        """A whole line or none. Raises OSError."""
        row = {"time": datetime.now(UTC).isoformat(timespec="milliseconds"), "action": action, **more}
        data = (json.dumps(row) + "\n").encode()
        written = os.write(self._file, data)
        if written < len(data):
            os.ftruncate(self._file, os.fstat(self._file).st_size - written)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def close(self) -> None:
        os.close(self._file)


def client_name(owner: str) -> str:
    """Tells clients apart without telling their secret."""
    return hashlib.sha256(owner.encode()).hexdigest()[:8] if owner else ""
