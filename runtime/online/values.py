"""Values of the running program for those who put it into operation: read, set, forced, traced.

Everything here is done between two scans (docs/commissioning.md); the server asks, and writes the audit log.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from ldc.diagnostics import Diagnostic, Invalid
from runtime import value_findings as findings
from runtime.forces import Force
from runtime.machine import Machine
from runtime.online import wire
from runtime.online.wire import Answer, Arm, Collect, Forced, Get, Set, Trace, Unforce, Value
from runtime.ring import Ring, found
from runtime.symbols import Symbol, UnknownSymbol
from runtime.values import parse, show

_MOST = 1000
"""Variables that one request names, and forces that there are."""

_CHUNK_CELLS = 100_000
_ABANDONED = 10.0
"""Seconds after which a trace that nobody asks for may be replaced by another client's."""

Requests = Get | Set | wire.Force | Unforce | Forced | Arm | Collect
Log = Callable[..., None]


class Values:
    """What clients see and change. ``log``: action and details, a line of the audit log each. One trace ring
    at a time."""

    def __init__(self, log: Log) -> None:
        self._log = log
        self._ring: Ring | None = None
        self._owner, self._asked = "", 0.0

    # ---- of the thread that runs scans -----------------------------------------------------------

    def scanned(self) -> None:
        """To be called after every scan."""
        if self._ring is not None:
            self._ring.sample()

    def follow(self, machine: Machine) -> None:
        """Another program goes on with the state."""
        if self._ring is not None:
            self._ring.follow(machine)

    def answer(self, request: Requests, machine: Machine) -> Callable[[], Answer]:
        """Does what is asked for, between two scans; the answer is made by what is returned, which may take
        its time in another thread. Raises Invalid (LD0855 to LD0859)."""
        match request:
            case Get(paths=paths):
                symbols = found(machine, "read", _few(paths))
                rows = list(zip(paths, symbols, machine.sample(symbols), strict=True))
                scan, now = machine.scans, machine.now_ns
                return lambda: Answer(values=[_value(*row) for row in rows], scan=scan, now_ns=now)
            case Forced():
                rows = [(row.path, row.symbol, row.value) for row in machine.forces.rows]
                return lambda: Answer(values=[_value(*row) for row in rows])
            case Set():
                self._set(request, machine)
            case wire.Force():
                self._force(request, machine)
            case Unforce():
                self._unforce(request, machine)
            case Arm():
                self._arm(request, machine)
            case Collect():
                return self._collect(request)
        return Answer

    def _set(self, request: Set, machine: Machine) -> None:
        try:
            symbol = machine.symbols.find(request.path)
            value = parse(request.value, symbol.type)
        except (UnknownSymbol, ValueError) as error:
            raise Invalid([findings.no_value("set", request.path, error)]) from error
        machine.put(symbol, value)
        path, shown = machine.symbols.full(symbol), show(value, symbol.type)
        self._tell("set", request.owner, machine, path=path, value=shown)

    def _force(self, request: wire.Force, machine: Machine) -> None:
        if len(machine.forces.rows) >= _MOST:
            raise Invalid([_full()])
        try:
            row = machine.forces.add(request.path, request.value)
        except (UnknownSymbol, ValueError) as error:
            raise Invalid([findings.no_value("force", request.path, error)]) from error
        self._tell("forced", request.owner, machine, path=row.path, value=row.shown)

    def _unforce(self, request: Unforce, machine: Machine) -> None:
        rows: list[Force] = []
        if request.path is None:
            for row in list(machine.forces.rows):
                machine.forces.remove(row.path)
                rows.append(row)
        else:
            try:
                row = machine.forces.remove(request.path)
            except UnknownSymbol as error:
                raise Invalid([findings.no_value("unforce", request.path, error)]) from error
            if row is None:
                raise Invalid([findings.not_forced(request.path)])
            rows.append(row)
        for row in rows:
            self._tell("unforced", request.owner, machine, path=row.path, value=row.shown)

    def _arm(self, request: Arm, machine: Machine) -> None:
        if self._ring is not None and self._owner != request.owner and self._age() < _ABANDONED:
            raise Invalid([findings.too_much("another client has a trace running",
                                             "wait until it has its rows")])
        self._ring = Ring(machine, _few(request.paths), request.trigger, request.before, request.after)
        self._owner, self._asked = request.owner, time.monotonic()
        self._tell("traced", request.owner, machine, detail=request.trigger)

    def _collect(self, request: Collect) -> Callable[[], Answer]:
        ring = self._ring
        if ring is None or self._owner != request.owner:
            raise Invalid([findings.too_much("this client has no trace running",
                                             "another one took its place, or the runtime was started again: "
                                             "ask for it once more")])
        self._asked = time.monotonic()
        if not ring.done:
            state = "filling" if ring.event is not None else "lost" if ring.lost else "waiting"
            return lambda: Answer(trace=Trace(state))
        rows, first = len(ring.rows), max(request.first, 0)
        count = max(1, _CHUNK_CELLS // max(len(ring.names), 1))
        end = min(first + count, rows)
        if end == rows:
            self._ring = None
        # Nothing changes a ring that is done, so its text is made beside the scans.
        return lambda: Answer(trace=Trace("done", ring.csv(first, count), end, rows, ring.event))

    def _age(self) -> float:
        return time.monotonic() - self._asked

    def _tell(self, action: str, owner: str, machine: Machine, **more: str) -> None:
        self._log(action, owner, scan=machine.scans, t_ns=machine.now_ns, **more)


def _few(paths: list[str]) -> list[str]:
    if len(paths) > _MOST:
        raise Invalid([findings.too_much(f"{len(paths)} variables in one request", f"name {_MOST} at most")])
    return paths


def _full() -> Diagnostic:
    return findings.too_much(f"{_MOST} variables are forced", "let some of them go with `ldc online unforce`")


def _value(path: str, symbol: Symbol, value: object) -> Value:
    return Value(path, str(symbol.type), show(value, symbol.type))
