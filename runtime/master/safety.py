"""The safe state of a master: what begins an emergency, what holds in it, what its end is (SPEC 5, 6.1 R5).

``trip`` is all that the emergency thread does, which pre-empts the control thread between two rungs: it
closes the latch, and outputs have their safe values from then on. What else an emergency ends belongs to the
control thread, which asks for ``taken`` at its next boundary.
"""

from __future__ import annotations

from collections.abc import Callable

from ldc.il.coordination import Coordination
from runtime.machine import Machine
from runtime.master.wiring import Wiring
from runtime.processors.states import MASTER, Master, MasterEvent, follow
from runtime.symbols import Symbol

ESTOP = "ESTOP", 0
"""The message of an emergency stop, and its data."""

Cause = tuple[str, int]

_RUN = Master.RUN


class Safety:
    """``state``: of the master, as SPEC 5 has it. ``estop``: the emergency stop is TRUE, or was when its
    emergency began and nobody has looked since. ``late``: the code computes it (or ``reset``), so it may
    change between two rungs. ``held``: outputs with the values that they keep until ``acknowledge``.
    ``causes``: why one has been demanded, until somebody has taken them. ``on_emergency`` is called when an
    emergency begins, for those who reach the slaves without P."""

    def __init__(self, on_emergency: Callable[[], None], wiring: Wiring | None) -> None:
        self.state, self.estop, self.late = Master.STOP, False, False
        self.held: list[tuple[Symbol, object]] = []
        self._on_emergency, self._wiring = on_emergency, wiring
        self._machine: Machine | None = None
        self._stop: Symbol | None = None
        self._wired: Callable[[], object] | None = None
        self._read: Callable[[], tuple] = tuple
        self._resets = self._on = self._reset_before = False
        self._before: tuple | None = None
        self.causes: list[Cause] = []

    def bind(self, machine: Machine, said: Coordination) -> None:
        """Goes on with the variables of a machine; the wiring is bound already."""
        wanted = machine.find(path for path in (said.estop, said.reset) if path)
        self._machine, self._read, self._before = machine, machine.reader(wanted), None
        self._stop = wanted[0] if said.estop else None
        self._resets = said.reset is not None
        self._wired = self._wiring.input(self._stop) if self._wiring is not None and self._stop else None
        self.late = any(symbol.area != "I" for symbol in wanted)
        if self.state is Master.ERROR:
            self._hold()

    def _hold(self) -> None:
        self.held = self._machine.safe_values(range(len(self._machine.layout.programs)))

    # ---- what begins it --------------------------------------------------------------------------

    def called(self) -> bool:
        """Whether the emergency stop has become TRUE since the call before: in the machine, or at the plant,
        which may be ahead of it. The emergency thread is to be activated then."""
        if self._stop is None:
            return False
        before, self._on = self._on, self._line()
        if not self._on or before or self.estop:
            return False
        self.demand(ESTOP)
        return True

    def _line(self) -> bool:
        machine = self._machine
        if machine.value(self._stop):
            return True
        forced = machine.forces.rows and machine.forces.of(self._stop) is not None
        return self._wired is not None and not forced and bool(self._wired())

    def demand(self, cause: Cause) -> None:
        """``trip`` is to begin an emergency that is told by this message."""
        if cause not in self.causes:
            self.causes.append(cause)

    def trip(self) -> None:
        """The emergency thread: closes the latch, when somebody has demanded it."""
        if not self.causes:
            return
        if ESTOP in self.causes:
            self.estop, self._before = True, None
        self.state = follow(MASTER, self.state, (MasterEvent.ESTOP,))
        self._hold()
        self.force()
        if self._wiring is not None:
            self._wiring.after()
        self._on_emergency()

    def force(self) -> None:
        """All outputs get their safe values, forced ones those that they are forced to."""
        machine = self._machine
        for symbol, value in self.held:
            machine.assign(symbol, value)
        if machine.forces.rows:
            machine.forces.hold()

    # ---- the control thread ----------------------------------------------------------------------

    def look(self) -> bool:
        """Begins an emergency when the variable of the emergency stop has become TRUE. Whether somebody
        wants to acknowledge."""
        now = self._read()
        if now == self._before:
            return False
        self._before = now
        stop = self._stop is not None and bool(now[0])
        if stop and not self.estop:
            self.demand(ESTOP)
            self.trip()
        self.estop = stop
        before, self._reset_before = self._reset_before, self._resets and bool(now[-1])
        return self._reset_before and not before

    def taken(self) -> list[Cause]:
        """Why the latch was closed since the call before: nothing, as long as it is not."""
        if not self.causes or self.state is not Master.ERROR:
            return []
        causes, self.causes = self.causes, []
        return causes

    def work(self, working: bool) -> None:
        """The state follows the modules, outside of an emergency."""
        if working != (self.state is _RUN) and self.state is not Master.ERROR:
            event = MasterEvent.MODULES if working else MasterEvent.NO_MODULES
            self.state = follow(MASTER, self.state, (event,))

    def acknowledge(self) -> bool:
        """The latch opens. Whether it was closed."""
        before, self.state = self.state, follow(MASTER, self.state, (MasterEvent.ACKNOWLEDGE,))
        self.held = []
        return before is Master.ERROR
