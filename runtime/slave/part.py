"""A slave as a part: its memory, its algorithms and their states, without a clock or a thread of its own.

``communicate`` is its communication thread (level 1): it serves the transfers of its slots. ``execute`` is its
algorithm thread (level 2): it executes what is due (SPEC 6.1). Whoever has them runs them in virtual or in real
time, one after the other. The part touches its own memory, its words of the shared memory and the field.

An algorithm executes from START until one of these:
- an execution without power has changed neither its outputs nor its state: A.END, AFS = done, feedback;
- ``error`` is not 0 after an execution: A.END, AFS = error, feedback;
- STOP, or RESET of its link: it ends at once, AFS = idle, and nothing is fed back;
- a fault in its IL, or a link that fails: the slave goes to ``serror`` and all algorithms end at once, AFS = error
  of the one concerned; so does an emergency. RESET of any link leads back, with the algorithm made anew.
Where it ends at once or with an error, its local outputs get their initial values. In ``serror`` a START is taken
and answered by AFS = error.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import gcd

from ldc.il.areas import PROCESSORS, areas
from ldc.il.placement import Placed, PlacedPin, same_body
from runtime import units
from runtime.field import Field
from runtime.processors.invariants import Executed, Took
from runtime.processors.states import ALGORITHM, SLAVE, AlgorithmEvent, Slave, SlaveEvent, follow
from runtime.processors.states import Algorithm as State
from runtime.protocol.check import Algorithm as Parameters
from runtime.protocol.check import Parameter, Situation, adata_of, values_of
from runtime.protocol.endpoint import Endpoint
from runtime.protocol.envelope import Command, Envelope
from runtime.protocol.memory import Memory, bit
from runtime.protocol.profile import U_STAR, Link, Profile, channel
from runtime.protocol.receiver import Delivered
from runtime.protocol.sender import Fault, Phase
from runtime.slave.algorithm import NOT_A_NUMBER, Algorithm, AlgorithmFault, Maker
from runtime.units import UnitEvent

_F32 = 3.4028235677973366e38
"""From here on a number is infinite when it is rounded to 32 bits."""


def of_p(aid: int, pins: Iterable[PlacedPin]) -> Parameters:
    """What P knows of the pins of one direction."""
    return Parameters(aid, tuple(Parameter(p.pid, p.type, p.low, p.high) for p in pins))


class _Slot:
    """An algorithm and its link. ``live``: it has been started and has not ended; ``due``: when it is executed
    next; ``seq``: the transfer whose parameters it has. ``tell``: feedback is to go out; ``sent``: what went out
    last."""

    __slots__ = ("placed", "maker", "algorithm", "endpoint", "mask", "taken", "fed", "live", "begun", "first", "due",
                 "last", "seq", "fresh", "values", "state", "error", "tell", "sent", "feed_at", "good")

    def __init__(self, placed: Placed, maker: Maker, algorithm: Algorithm, endpoint: Endpoint) -> None:
        self.placed, self.maker, self.algorithm, self.endpoint = placed, maker, algorithm, endpoint
        self.mask = endpoint.into.channel.mask
        self.taken, self.fed = of_p(placed.aid, placed.parameters), of_p(placed.aid, placed.feedback)
        self.live = self.begun = self.first = self.fresh = self.tell = False
        self.due = self.last = self.seq = self.error = self.feed_at = 0
        self.values: dict[int, float] = {}
        self.state = State.IDLE
        self.sent: tuple = ()
        self.good: tuple = ()


class SlavePart:
    """``placed``: the algorithms of the project, of which those of slave ``number`` are taken; ``makers`` by names
    of units in capitals (``algorithm.makers``). ``note`` is given the units as they are executed, ``seen`` what
    invariants ask for; None: nobody listens. ``now``: the time in ns. ``scan_ns``: of the master; feedback goes
    out no more often. ``ack_periods``: milliseconds without an answer until a transfer is repeated.

    Raises what makers raise.
    """

    def __init__(self, number: int, memory: Memory, placed: Sequence[Placed], makers: Mapping[str, Maker], field: Field,
                 note: Callable[[UnitEvent], None] | None, now: Callable[[], int], *,
                 seen: Callable[[Took | Executed], None] | None = None, scan_ns: int = 0, ack_periods: int = 5,
                 profile: Profile = U_STAR) -> None:
        self.number, self.memory, self.field = number, memory, field
        self.name = PROCESSORS[number]
        self.state = Slave.STOP
        self.faults: list[AlgorithmFault] = []
        self._note, self._seen, self._now, self._scan_ns = note, seen, now, scan_ns
        self._limits = {"profile": profile, "ack_periods": ack_periods}
        self._slots: list[_Slot] = []
        self._live: list[_Slot] = []
        self._open = self._idle_at = 0
        self._tick_at = 0
        first = channel(number, True)
        self._running = first.running
        self.place(placed, makers)

    # ---- which algorithms there are ----------------------------------------------------------------

    def place(self, placed: Sequence[Placed], makers: Mapping[str, Maker], field: Field | None = None) -> None:
        """Another placement, between two periods: an algorithm that has its place, its pins and its body still
        goes on with its state; others end at once, and new ones are made. ``field``: with all their points."""
        self.field = field or self.field
        before = {slot.placed.path.upper(): slot for slot in self._slots}
        kept = []
        for p in (p for p in placed if p.slave == self.number):
            old, maker = before.get(p.path.upper()), makers[p.unit.upper()]
            if old is not None and _goes_on(old, p, maker):
                old.placed = p
                kept.append(before.pop(p.path.upper()))
            else:
                kept.append(_Slot(p, maker, maker(p, self.field), self._endpoint(p)))
        for gone in before.values():
            self._cease(gone, State.IDLE)
            self._open &= ~gone.mask
        self._slots = kept
        self._situations()

    def _endpoint(self, p: Placed) -> Endpoint:
        out, into = (Link(channel(p.slave, to_slave, p.slot, p.size), **self._limits) for to_slave in (False, True))
        return Endpoint(self.memory.shared, out, into, Situation())

    def _situations(self) -> None:
        for slot in self._slots:
            self._situate(slot)

    def _situate(self, slot: _Slot) -> None:
        """What P is to know when it checks the next envelope."""
        aid = frozenset((slot.placed.aid,))
        rested = not slot.live and slot.state in (State.DONE, State.ERROR)
        slot.endpoint.situation = Situation({slot.placed.aid: slot.taken}, aid if slot.live else frozenset(),
                                            ended=aid if rested else frozenset())

    @property
    def period_ns(self) -> int:
        """The greatest period that all algorithms are executed in time with; 0 without any."""
        return gcd(*(slot.placed.period_ns for slot in self._slots))

    @property
    def executing(self) -> int:
        """AFE: the algorithms that execute, a bit a slot."""
        return self.memory.bits.load(_AFE[0])

    @property
    def busy(self) -> bool:
        """An algorithm executes or is about to, so ``execute`` is to be called every ``period_ns``."""
        return bool(self._live)

    @property
    def waiting(self) -> bool:
        """A transfer is open, so ``communicate`` is to be called every period."""
        return self._open != 0

    # ---- communication, level 1 --------------------------------------------------------------------

    def communicate(self) -> bool:
        """Serves the transfers of this slave as far as they go on now. Whether there was anything to do, so that
        the master may have to do something too."""
        pending = self.memory.shared.load(self._running) | self._open
        ticks = False
        now = self._now()
        if now >= self._tick_at:
            self._tick_at, ticks = now + 1_000_000, True
            pending |= self._scrub()
        if not pending:
            return False
        for slot in self._slots:
            if slot.mask & pending:
                self._serve(slot, ticks)
        return True

    def _scrub(self) -> int:
        """One slot a period is looked after though it has no work: flags that were disturbed do not stay."""
        if not self._slots:
            return 0
        self._idle_at = (self._idle_at + 1) % len(self._slots)
        slot = self._slots[self._idle_at]
        if slot.endpoint.idle:
            slot.endpoint.tick()
        return 0 if slot.endpoint.idle else slot.mask

    def _serve(self, slot: _Slot, ticks: bool) -> None:
        end = slot.endpoint
        events = end.tick() if ticks and not end.idle else ()
        while True:
            for event in (*events, *end.poll()):
                match event:
                    case Delivered(envelope):
                        self._take(slot, envelope)
                    case Fault():
                        self._fail(slot)
            if not (slot.tell and end.ready):
                break
            self._feed(slot)
            events = ()
        self._open = self._open & ~slot.mask if end.idle else self._open | slot.mask

    def _take(self, slot: _Slot, envelope: Envelope) -> None:
        cmd = envelope.cmd
        if cmd == Command.RESET:
            self._reset(slot)
            return
        if self._seen is not None:
            self._seen(Took(self.number, envelope.seq, slot.placed.aid, cmd))
        if cmd == Command.STOP:
            self._cease(slot, State.IDLE)
            return
        slot.values, slot.seq = values_of(envelope, slot.taken), envelope.seq
        slot.fresh = True
        if cmd == Command.START:
            self._start(slot)

    def _start(self, slot: _Slot) -> None:
        if self.state is Slave.ERROR:
            slot.state, slot.tell = State.ERROR, True
            self._put_state(slot)
            return
        slot.live, slot.begun, slot.error = True, False, 0
        self._live.append(slot)
        self._move(SlaveEvent.START)
        self._situate(slot)

    def _move(self, *events: SlaveEvent) -> None:
        self.state = follow(SLAVE, self.state, events)

    def _reset(self, slot: _Slot) -> None:
        self._cease(slot, State.IDLE)
        if slot.endpoint.sender.phase is Phase.FAULT:
            slot.endpoint.reset()
        if self.state is Slave.ERROR:
            self._move(SlaveEvent.RESET)
            for other in self._slots:
                self._clear(other)

    def _clear(self, slot: _Slot) -> None:
        """After ``serror``: IL that came to a fault begins anew, errors are forgotten."""
        if slot.state is State.ERROR:
            if self.faults and slot.error > 15:
                slot.algorithm = slot.maker(slot.placed, self.field)
            slot.state, slot.error = follow(ALGORITHM, slot.state, (AlgorithmEvent.CLEAR,)), 0
            self._put_state(slot)
            self._situate(slot)

    def _fail(self, slot: _Slot) -> None:
        """The master does not take the feedback: nobody watches what is executed here."""
        slot.endpoint.reset()
        slot.tell = False
        self.emergency()

    # ---- execution, level 2 ------------------------------------------------------------------------

    def execute(self) -> bool:
        """A period of each algorithm that is due. Whether a transfer is open then, so that ``communicate`` has
        something to do."""
        if not self._live:
            return False
        now = self._now()
        for slot in tuple(self._live):
            if not slot.begun:
                self._begin(slot, now)
            if now >= slot.due and slot.live:
                self._once(slot, now)
        return self._open != 0

    def _begin(self, slot: _Slot, now: int) -> None:
        """A.START."""
        slot.begun = slot.first = True
        slot.due = now
        self.memory.bits.set(_AFE[0], slot.mask)
        events = (AlgorithmEvent.CLEAR, AlgorithmEvent.BEGIN)
        slot.state = follow(ALGORITHM, slot.state, events)
        self._put_state(slot)
        self._move(SlaveEvent.START, SlaveEvent.EXECUTES)
        slot.tell = True
        self._told(units.A_START, slot, now)

    def _once(self, slot: _Slot, now: int) -> None:
        placed, algorithm = slot.placed, slot.algorithm
        if slot.fresh:
            self._deframe(slot, now)
        dt = 0 if slot.first else now - slot.last
        slot.first, slot.last = False, now
        slot.due += placed.period_ns
        if slot.due <= now:
            slot.due = now + placed.period_ns
        if self._note is not None:
            self._note(UnitEvent(now, self.name, units.A_EXEC, placed.aid))
        if self._seen is not None:
            self._seen(Executed(self.number, slot.seq, placed.aid))
        try:
            goes_on = algorithm.execute(dt)
        except AlgorithmFault as fault:
            self._fault(slot, fault, now)
            return
        if algorithm.error:
            self._error(slot, algorithm.error, now)
        elif not goes_on:
            self._end(slot, AlgorithmEvent.DONE, now)
        elif slot.tell or now >= slot.feed_at:
            self._offer(slot)

    def _deframe(self, slot: _Slot, now: int) -> None:
        """A.DEFRAME: the parameters that were taken last go into AD, and to the algorithm."""
        slot.fresh = False
        pins, ad = slot.placed.parameters, _AD + slot.placed.ad
        self.memory.data.write(ad, b"".join([_word(slot.values[p.pid], p.type) for p in pins]))
        slot.algorithm.take([slot.values[p.pid] for p in pins])
        self._told(units.A_DEFRAME, slot, now)

    def _error(self, slot: _Slot, error: int, now: int) -> None:
        slot.error = error
        slot.algorithm.safe()
        self._end(slot, AlgorithmEvent.FAULT, now)

    def _end(self, slot: _Slot, event: AlgorithmEvent, now: int) -> None:
        """A.END, and the feedback that says so."""
        self._drop(slot, follow(ALGORITHM, slot.state, (event,)))
        self._told(units.A_END, slot, now)
        slot.tell = True
        self._offer(slot)

    def _drop(self, slot: _Slot, state: State) -> None:
        """An algorithm executes no more."""
        slot.live = slot.begun = slot.tell = False
        if slot in self._live:
            self._live.remove(slot)
        self.memory.bits.clear(_AFE[0], slot.mask)
        slot.state = state
        self._put_state(slot)
        self._situate(slot)
        if not self.executing:
            self._move(*(SlaveEvent.ENDED, SlaveEvent.START) if self._live else (SlaveEvent.ENDED, SlaveEvent.STOP))

    def _cease(self, slot: _Slot, state: State) -> None:
        """It ends at once, and its local outputs are safe."""
        live = slot.live
        self._drop(slot, state)
        if live:
            slot.algorithm.safe()
            self._told(units.A_END, slot, self._now(), "stop")

    def _fault(self, slot: _Slot, fault: AlgorithmFault, now: int) -> None:
        self.faults.append(fault)
        self.emergency()
        slot.state, slot.error, slot.tell = State.ERROR, fault.error, True
        self._put_state(slot)
        self._situate(slot)
        self._offer(slot)

    def emergency(self) -> None:
        """Everything ends at once, local outputs are safe; only a RESET leads out of ``serror``."""
        for slot in self._slots:
            self._cease(slot, State.IDLE)
        self._move(SlaveEvent.FAULT)

    # ---- feedback ----------------------------------------------------------------------------------

    def _offer(self, slot: _Slot) -> None:
        """A.FEEDBACK, when there is anything new and the link is free; else ``communicate`` sends it later."""
        if not slot.endpoint.ready:
            slot.tell = slot.tell or slot.algorithm.outputs() != slot.sent[:-2]
        elif slot.tell or slot.algorithm.outputs() != slot.sent[:-2]:
            self._feed(slot)
        slot.feed_at = slot.last + self._scan_ns

    def _feed(self, slot: _Slot) -> None:
        """Sends the values of now."""
        values = slot.algorithm.outputs()
        if not all(map(_sendable, values)):
            values = tuple(v if _sendable(v) else 0.0 for v in values)
            if not slot.error:
                slot.error = NOT_A_NUMBER
                slot.algorithm.safe()
                self._drop(slot, State.ERROR)
        slot.sent = *values, slot.error, int(slot.state)
        pids = (p.pid for p in slot.placed.feedback)
        slot.endpoint.send(slot.placed.aid, Command.UPDATE, adata_of(dict(zip(pids, slot.sent, strict=True)), slot.fed))
        slot.tell = False
        self._open |= slot.mask
        self._told(units.A_FEEDBACK, slot, self._now(), "" if slot.live else "end")

    def _put_state(self, slot: _Slot) -> None:
        """AFS."""
        address, low = bit(_AFS + 2 * slot.placed.slot)
        bits = int(slot.state) * low
        self.memory.bits.clear(address, 3 * low)
        self.memory.bits.set(address, bits)

    def _told(self, unit: str, slot: _Slot, now: int, detail: str = "") -> None:
        if self._note is not None:
            self._note(UnitEvent(now, self.name, unit, slot.placed.aid, detail))


_AFE, _AFS, _AD = bit(areas()["AFE"].base), areas()["AFS"].base, areas()["AD"].base


def _goes_on(old: _Slot, new: Placed, maker: Maker) -> bool:
    was = old.placed
    return ((was.slot, was.aid, was.ad, was.unit.upper(), was.parameters, was.feedback, was.local) ==
            (new.slot, new.aid, new.ad, new.unit.upper(), new.parameters, new.feedback, new.local)
            and same_body(old.maker.unit, maker.unit))


def _sendable(value: bool | int | float) -> bool:
    return not isinstance(value, float) or math.isfinite(value) and abs(value) < _F32


def _word(value: float, type_: str) -> bytes:
    """A parameter as it lies in AD."""
    return struct.pack({"f32": "f", "i32": "i"}.get(type_, "I"), value)
