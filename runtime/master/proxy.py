"""An algorithm as its master sees it: what the ladder wants of it, and what came back (SPEC 2, 6.2).

The instance in the program is a proxy. After each scan its inputs are read: a rising edge of the power asks
for START, a later change for UPDATE; the newest values win while a transfer is open. What the slave tells
(outputs, error, state) waits here until the next scan, which takes it before the logic.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import Enum

from ldc.il.placement import Placed, PlacedPin
from ldc.types import BOOL
from runtime.machine import Machine
from runtime.processors.states import Algorithm as State
from runtime.protocol import receiver, sender
from runtime.protocol.check import Algorithm, Code, Parameter, Situation
from runtime.protocol.endpoint import Endpoint
from runtime.protocol.envelope import Command
from runtime.protocol.memory import Memory
from runtime.protocol.profile import Link, channel
from runtime.symbols import Symbol

Pins = tuple[object, ...]
"""Values of the pins that go to the slave, in the order of ``Placed.parameters``."""

_STATES = tuple(State)

_CLEAR = 5
"""Scans after which flags of the slave that stay 1 are a failure, unless its answers may take longer."""

_REAL = 3.4028235677973366e38
"""A number from which on rounding to 32 bits gives infinity."""


class Told(Enum):
    """What polling has brought. ``FEEDBACK`` waits for the next scan; ``STOPPED``: the slave has taken STOP;
    ``FAULT``: the link stands until it is reset; ``LINKED``: it is new again; ``ANEW``: the slave has begun
    anew, or has given up its master."""

    FEEDBACK = "feedback"
    STOPPED = "stopped"
    FAULT = "fault"
    LINKED = "linked"
    ANEW = "anew"


class Proxy:
    """``executing``: from START until the slave has told the end (or the master has given it up). ``state``:
    AFS as it was told last, ``error`` beside it. ``fault``: why the link stands, OK while it does not.

    ``quiet_scans``: after as many without a word of an algorithm that executes, it gets its parameters once
    more, so that a slave that has died is found out. ``pins``: what goes to the slave; ``raw``: their values
    that were looked at last; ``command``: what is to be sent. ``blocked``: nothing is started until
    ``renew``, and then the power has to rise anew. """

    def __init__(self, placed: Placed, memory: Memory, ack_periods: int, quiet_scans: int) -> None:
        self.placed = placed
        self._quiet, self._quiet_scans = 0, quiet_scans
        out = channel(placed.slave, True, placed.slot, placed.size)
        into = channel(placed.slave, False, placed.slot, placed.size)
        self._taken_by = _algorithm(placed.aid, placed.parameters)
        self._fed_back = _algorithm(placed.aid, placed.feedback)
        situation = Situation({placed.aid: self._fed_back}, frozenset((placed.aid,)))
        periods = {"ack_periods": ack_periods, "clear_periods": max(ack_periods, _CLEAR)}
        self.endpoint = Endpoint(memory.shared, Link(out, **periods), Link(into, **periods), situation)
        self.executing = self.blocked = self._stops = False
        self.state = State.IDLE
        self.fault = Code.OK
        self.error = 0
        self._machine: Machine | None = None
        self.raw: Pins | None = None
        self.pins: tuple[Symbol, ...] = ()
        self._error_pin: Symbol | None = None
        self._write: Callable[[list[object]], None] = list
        self._logical: tuple[int, ...] = ()
        self._good: Pins = ()
        self._sent: Pins = ()
        self.command: Command | None = None
        self._open: Command | None = None
        self._armed = True
        self._box: tuple[float, ...] | None = None

    def bind(self, machine: Machine) -> None:
        """Goes on with the variables of a machine."""
        def symbols(pins: Iterable[PlacedPin]) -> tuple[Symbol, ...]:
            return machine.find(f"{self.placed.path}.{pin.variable}" for pin in pins)

        self._machine, self.raw = machine, None
        self.pins = symbols(self.placed.parameters)
        fed = symbols(self.placed.feedback[:-1])
        self._error_pin, self._write = fed[-1], machine.writer(fed)
        self._logical = tuple(n for n, symbol in enumerate(fed) if symbol.type == BOOL)

    # ---- in the scan -----------------------------------------------------------------------------

    def take(self) -> str | None:
        """C.FEEDBACK: what was delivered goes into the outputs. What it was, None when there was nothing."""
        box, self._box = self._box, None
        if box is None:
            return None
        values = list(box[:-1])
        for n in self._logical:
            values[n] = values[n] != 0
        self._write(values)
        self.error, self.state = box[-2], _STATES[box[-1]]
        if self.state is State.RUNNING:
            return ""
        self._end(self.state is State.DONE)
        return "end"

    def _end(self, rested: bool) -> None:
        """The slave executes it no more. One that came to rest had no power when it did: if it has now, it is
        to begin anew."""
        again = rested and self.executing and self._power() and not self.blocked
        self.executing = self._stops = False
        self.command = None
        if again:
            self.executing, self.command = True, Command.START

    def look(self, raw: Pins) -> None:
        """What the logic wants: the values of ``pins`` after a scan."""
        if raw != self.raw:
            self.raw = raw
            self._decide()

    def _power(self) -> bool:
        """What has no pin for it always has power."""
        return self.raw is not None and (not self.placed.enabled or bool(self.raw[0]))

    def _decide(self) -> None:
        raw, pins = self.raw, self.placed.parameters
        power, good = self._power(), all(map(_accepts, pins, raw))
        self._armed = self._armed or not power
        if good:
            self._good = raw
        elif self._good and self.placed.enabled:
            self._good = raw[0], *self._good[1:]
        if self.executing:
            self._follow()
        elif power and good and self._armed and not self.blocked:
            self.executing, self.command, self._armed = True, Command.START, False

    def _follow(self) -> None:
        if self.command is None and not self._stops and self._good != self._sent:
            self.command = Command.UPDATE

    def send(self) -> Command | None:
        """C.SEND: sends the ``command``, when there is one and the link is free. What was sent."""
        if self.command is None or not self.endpoint.ready:
            return None
        command, self.command = self.command, None
        adata = b""
        if command is not Command.STOP:
            adata = self._taken_by.packed(self._good)
            self._sent = self._good
        self.endpoint.send(self.placed.aid, command, adata)
        self._open = command
        return command

    def stop(self) -> None:
        """Ends the algorithm at once, and keeps it from starting until the power has risen anew."""
        self._armed = not self._power()
        if self.executing and self.command is Command.START and self._open is None:
            self.executing, self.command = False, None
        elif self.executing:
            self.command, self._stops = Command.STOP, True

    def give_up(self) -> None:
        """The slave has ended it without P (emergency)."""
        self.executing = self._stops = False
        self.blocked, self.command, self._box = True, None, None
        self._armed = not self._power()

    def renew(self) -> None:
        """Makes the link new and lets the algorithm be started again; by RESET its slave leaves `serror`."""
        self.blocked, self.fault, self.error = False, Code.OK, 0
        self._armed = self._armed or not self.placed.enabled
        self.raw = None
        self.endpoint.reset()

    def tell_error(self, code: int) -> None:
        """The instance tells a code, as if it were fed back."""
        self.error = code
        self._machine.assign(self._error_pin, code)

    # ---- in the communication thread ---------------------------------------------------------------

    def poll(self) -> Told | None:
        """Serves the transfers; the most important thing that has come of it."""
        told = None
        for event in self.endpoint.poll():
            told = self._learn(event) or told
        return told

    def tick(self, serves: bool) -> Told | None:
        """A scan has passed: what was waited for too long is given up, who is silent for too long is asked.
        ``serves``: a transfer is open, or it is the turn of this one to look after flags that were disturbed
        while nothing is sent."""
        if self.executing:
            self._quiet += 1
            if self._quiet >= self._quiet_scans and not self._stops and self.command is None:
                self._quiet, self.command = 0, Command.UPDATE
        if serves:
            for event in self.endpoint.tick():
                return self._learn(event)
        return None

    def _learn(self, event: sender.Event | receiver.Event) -> Told | None:
        match event:
            case receiver.Delivered(envelope) if envelope.cmd == Command.RESET:
                return Told.ANEW
            case receiver.Delivered(_, values):
                self._quiet, self._box = 0, values
                return Told.FEEDBACK
            case sender.Done():
                return self._taken()
            case sender.Linked():
                self.fault = Code.OK
                return Told.LINKED
            case sender.Fault(code=code):
                return self._failed(code)
        return None

    def _taken(self) -> Told | None:
        command, self._open, self._quiet = self._open, None, 0
        if command is Command.STOP:
            self.executing = self._stops = False
            self.state = State.IDLE
            return Told.STOPPED
        if self.executing:
            self._follow()
        return None

    def _failed(self, code: Code) -> Told:
        self.fault, self._open, self.command = code, None, None
        self.executing = self._stops = False
        self._armed = not self._power()
        return Told.FAULT


def _algorithm(aid: int, pins: Iterable[PlacedPin]) -> Algorithm:
    return Algorithm(aid, tuple(Parameter(pin.pid, pin.type, pin.low, pin.high) for pin in pins))


def _accepts(pin: PlacedPin, value: float) -> bool:
    """The slave would take the value: it is in range, and a number that 32 bits hold."""
    return pin.low <= value <= pin.high and (pin.type != "f32" or -_REAL < value < _REAL)
