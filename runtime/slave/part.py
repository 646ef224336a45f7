"""A slave as a part: its memory, its algorithms and their states, without a clock or a thread of its own.

``communicate`` is its communication thread (level 1): it serves the transfers of its slots. ``execute`` is
its algorithm thread (level 2): it executes what is due (SPEC 6.1). Whoever has them runs them in virtual or
in real time, one after the other. The part touches its own memory, its words of the shared memory and the
field.

An algorithm executes from START until one of these:

- an execution without power has changed neither its outputs nor its state: AFS = done, feedback;
- ``error`` is not 0 after an execution (800 to 899, which only faults are, become 15), or an output is a
  number that cannot be sent: AFS = error, feedback;
- STOP, or RESET of its link: it ends at once, AFS = idle, and nothing is fed back;
- a fault in its IL: AFS = error, feedback with the number of the fault (801 for LD0801), and the slave goes
  to ``serror``: all other algorithms end at once. So they do in an emergency, or when a link fails.

A slave that has been without power, or is a new process, begins in ``serror`` too (``restart``), and says so
by RESET of its own direction; all START are answered by an error until its master makes the links new.

RESET of any link leads out of ``serror``; the algorithm with the fault begins with its initial state then.
Until that a START is taken, and answered by AFS = error. Whatever ends at once or with an error, its local
outputs get their initial values. What has ended takes a further UPDATE without doing anything: its master may
not know yet.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from math import gcd
from typing import TYPE_CHECKING

from ldc.il.areas import PROCESSORS, areas
from ldc.il.placement import Placed
from ldc.records import replace
from runtime import units
from runtime.faults import Fault as RunFault
from runtime.faults import Place, TaskOverdue, TaskTooLong, describe
from runtime.field import Field
from runtime.processors.invariants import Executed, Took
from runtime.processors.states import (
    ALGORITHM,
    BEGUN_ANEW,
    SLAVE,
    SLAVE_FAULTS,
    AlgorithmEvent,
    Slave,
    SlaveEvent,
    follow,
)
from runtime.processors.states import Algorithm as State
from runtime.protocol.check import Situation
from runtime.protocol.endpoint import Endpoint
from runtime.protocol.envelope import Command, Envelope
from runtime.protocol.memory import Memory
from runtime.protocol.profile import U_STAR, Link, Profile, channel
from runtime.protocol.receiver import Delivered
from runtime.protocol.sender import Fault
from runtime.slave.algorithm import NOT_A_NUMBER, NO_ERROR, AlgorithmFault, Maker
from runtime.slave.slot import Slot, executing
from runtime.units import UnitEvent

if TYPE_CHECKING:
    from runtime.retain_file import Entry

_TICK = 1_000_000
"""Nanoseconds of a period of P."""

_FLAGS = areas()["SPF"]


class SlavePart:
    """``placed``: the algorithms of the project, of which those of slave ``number`` are taken; ``makers`` by
    names of units in capitals (``algorithm.makers``). ``note`` is given the units as they are executed,
    ``seen`` what invariants ask for; None: nobody listens. ``now``: the time in ns. ``scan_ns``: of the
    master, which begins its scans at multiples of it; feedback goes out no more often. ``ack_periods``:
    milliseconds without an answer until a transfer is repeated, and until flags of the master that stay 1
    are a failure.

    ``live``: what executes or is about to: as long as there is something, ``execute`` is to be called every
    ``period_ns``. ``faults``: of IL, in their order, each with the algorithm as its task and the scan of the
    master. Raises what makers raise.
    """

    def __init__(self, number: int, memory: Memory, placed: Sequence[Placed], makers: Mapping[str, Maker],
                 field: Field, note: Callable[[UnitEvent], None] | None, now: Callable[[], int], *,
                 scan_ns: int, seen: Callable[[Took | Executed], None] | None = None,
                 ack_periods: int = 5, profile: Profile = U_STAR) -> None:
        self.number, self.name, self.memory, self.field = number, PROCESSORS[number], memory, field
        self.state = Slave.STOP
        self.faults: list[AlgorithmFault] = []
        self._note, self._seen, self._now, self._scan_ns = note, seen, now, scan_ns
        self._watched, self._scan_end = note is not None or seen is not None, 0
        self._profile, self._ack_periods = profile, ack_periods
        self._running = channel(number, True).running
        self._slots: list[Slot] = []
        self.live: tuple[Slot, ...] = ()
        self._open = self._looked_at = self._tick_at = 0
        self.place(placed, makers)

    # ---- which algorithms there are ----------------------------------------------------------------

    def place(self, placed: Sequence[Placed], makers: Mapping[str, Maker], field: Field | None = None
              ) -> None:
        """Another placement, between two periods: an algorithm that has its place, its pins and its body
        still goes on with its state; others end at once, and new ones are made. ``field``: with all their
        points."""
        self.field = field or self.field
        before = {slot.placed.path.upper(): slot for slot in self._slots}
        found = []
        for p in (p for p in placed if p.slave == self.number):
            old, maker = before.get(p.path.upper()), makers[p.unit.upper()]
            if old is not None and old.goes_on(p, maker):
                old.placed, old.period_ns, old.leaves = p, p.period_ns, None
                found.append(before.pop(p.path.upper()))
            else:
                found.append((p, maker))
        for gone in before.values():
            self._cease(gone)
            self._open &= ~gone.mask
        self._slots = [slot if isinstance(slot, Slot) else self._made(*slot) for slot in found]

    def _made(self, p: Placed, maker: Maker) -> Slot:
        out, into = (
            Link(channel(p.slave, to_slave, p.slot, p.size), self._profile, ack_periods=self._ack_periods,
                 clear_periods=self._ack_periods)
            for to_slave in (False, True))
        return Slot(p, maker, self.field, Endpoint(self.memory.shared, out, into, Situation()), self.memory)

    # ---- what is retained ----------------------------------------------------------------------------

    def retained(self) -> list[Entry]:
        """What the algorithms retain, as a save has it: between two periods."""
        return [entry for slot in self._slots for entry in self._saved(slot)]

    def _saved(self, slot: Slot) -> list[Entry]:
        from runtime.slave import retained  # most projects retain nothing on slaves

        if slot.leaves is None:
            slot.leaves = retained.leaves(slot.maker, slot.placed)
        return retained.saved(slot.algorithm, slot.leaves)

    def restore(self, kept: Mapping[str, Entry]) -> None:
        """Puts back what was saved, by path, before the first START. Raises ValueError when bytes are no
        value of their type."""
        from runtime.slave import retained

        for slot in self._slots:
            retained.put_back(slot.algorithm, retained.leaves(slot.maker, slot.placed), kept)

    def restart(self, kept: Mapping[str, Entry]) -> None:
        """Begins anew where another one has lost its power or its process, and nothing of it is known but
        what it retained: ``kept``, by path."""
        for at in range(_FLAGS.first(self.number), _FLAGS.first(self.number) + _FLAGS.size, 4):
            self.memory.shared.store(at, 0)
        self.live = ()
        self._slots = [self._made(slot.placed, slot.maker) for slot in self._slots]
        if kept:
            self.restore(kept)
        self.state = follow(SLAVE, Slave.STOP, (SlaveEvent.FAULT,))
        self._open = 0
        for slot in self._slots:
            slot.error = BEGUN_ANEW
            slot.execute_flag(False)
            slot.enter(State.ERROR)
            slot.endpoint.reset()
            self._open |= slot.mask

    @property
    def period_ns(self) -> int:
        """The greatest period in which all algorithms can be executed in time; 0 without any."""
        return gcd(*(slot.placed.period_ns for slot in self._slots))

    @property
    def executing(self) -> int:
        """AFE: the algorithms that execute, a bit a slot."""
        return executing(self.memory)

    @property
    def waiting(self) -> bool:
        """A transfer of this slave is open: the master has not taken it yet."""
        return self._open != 0

    @property
    def wanted(self) -> bool:
        """A transfer is open, on this side or by the master."""
        return self._open != 0 or self.memory.shared.load(self._running) != 0

    # ---- communication, level 1 --------------------------------------------------------------------

    def communicate(self) -> bool:
        """Serves the transfers of this slave as far as they go on now. Whether there was anything to do, so
        that the master may have to do something too."""
        pending, ticks = self._pending()
        if not pending:
            return False
        for slot in self._slots:
            if slot.mask & pending:
                self._serve(slot, ticks)
        return True

    def serving(self) -> Iterator[Endpoint]:
        """``communicate`` for a slave whose transfers take time: each ``next`` serves one algorithm."""
        pending, ticks = self._pending()
        for slot in tuple(self._slots):
            if slot.mask & pending and slot in self._slots:
                self._serve(slot, ticks)
                yield slot.endpoint

    def _pending(self) -> tuple[int, bool]:
        """The slots that have something to do, and whether a period of P has passed."""
        pending, ticks, now = self.memory.shared.load(self._running) | self._open, False, self._now()
        if now >= self._tick_at:
            self._tick_at, ticks = now + _TICK, True
            pending |= self._looked_after()
        return pending, ticks

    def _looked_after(self) -> int:
        """One idle slot a period gets its tick, so that flags that were disturbed do not stay; its mask when
        that has made work."""
        if not self._slots:
            return 0
        self._looked_at = (self._looked_at + 1) % len(self._slots)
        slot = self._slots[self._looked_at]
        end = slot.endpoint
        if not end.idle:
            return slot.mask
        end.tick()
        return 0 if end.rests else slot.mask

    def _serve(self, slot: Slot, ticks: bool) -> None:
        end = slot.endpoint
        events = end.tick() if ticks and slot.mask & self._open else ()
        while True:
            for event in (*events, *end.poll()):
                match event:
                    case Delivered(envelope, values):
                        self._take(slot, envelope, values)
                    case Fault():
                        self._link_fails(slot)
            if not slot.tell or not end.ready:
                break
            self._feed(slot)
            events = ()
        # Who has begun to send is looked for every time.
        self._open = self._open & ~slot.mask if end.rests else self._open | slot.mask

    def _take(self, slot: Slot, envelope: Envelope, values: tuple[float, ...]) -> None:
        if envelope.cmd == Command.RESET:
            self._reset(slot)
            return
        if self._seen is not None:
            self._seen(Took(self.number, envelope.seq, slot.placed.aid, envelope.cmd))
        if envelope.cmd == Command.STOP:
            self._cease(slot)
            return
        slot.take(envelope.seq, values)
        if envelope.cmd == Command.START and self.state is Slave.ERROR:
            slot.enter(State.ERROR)
            slot.tell = True
        elif envelope.cmd == Command.START:
            slot.live, slot.begun, slot.due, slot.error = True, False, 0, 0
            slot.enter(slot.state)
            self.live += slot,
            self._move(SlaveEvent.START)

    def _move(self, *events: SlaveEvent) -> None:
        self.state = follow(SLAVE, self.state, events)

    def _reset(self, slot: Slot) -> None:
        """The master begins the link anew. After ``serror`` errors are forgotten."""
        self._cease(slot)
        slot.error = 0
        if self.state is Slave.ERROR:
            self._move(SlaveEvent.RESET)
            for other in self._slots:
                if other.faulty:
                    self._made_anew(other)
                if other.state is State.ERROR:
                    other.error = 0
                    other.enter(follow(ALGORITHM, other.state, (AlgorithmEvent.CLEAR,)))

    def _made_anew(self, slot: Slot) -> None:
        """After a fault, as in a warm restart: initial values but for what is retained."""
        kept = {entry.path: entry for entry in self._saved(slot)}
        slot.algorithm, slot.faulty = slot.maker(slot.placed, self.field), False
        if kept:
            from runtime.slave import retained

            retained.put_back(slot.algorithm, slot.leaves, kept)

    def _link_fails(self, slot: Slot) -> None:
        """The master does not take the feedback: nobody watches what is executed here."""
        slot.endpoint.reset()
        self.emergency()

    # ---- execution, level 2 ------------------------------------------------------------------------

    def execute(self) -> bool:
        """A period of each algorithm that is due. Whether a transfer is open then, so that ``communicate``
        has something to do."""
        return self.execute_at(self._now())

    def execute_at(self, now: int) -> bool:
        """``execute`` for those who know the time."""
        for slot in self.live:
            if now < slot.due:
                continue
            if slot.fresh:
                if not slot.begun:
                    self._begin(slot, now)
                slot.deframe()
                self._told(units.A_DEFRAME, slot, now)
            elapsed, slot.last = now - slot.last, now
            slot.due = due = slot.due + slot.period_ns
            if due <= now:
                slot.due = due = now + slot.period_ns - (now - due) % slot.period_ns
            if self._watched:
                self._told(units.A_EXEC, slot, now)
                if self._seen is not None:
                    self._seen(Executed(self.number, slot.seq, slot.placed.aid))
            algorithm = slot.algorithm
            try:
                goes_on = algorithm.execute(elapsed)
            except AlgorithmFault as fault:
                self._fault(slot, fault)
                break  # that has ended all
            if algorithm.error or not goes_on:
                self._ends(slot)
            elif due >= self._scan_end:
                self._scan_end = now - now % self._scan_ns + self._scan_ns
                if due >= self._scan_end and not slot.tell:
                    # The last execution before the next scan: its logic sees what is at most a period old.
                    slot.tell = algorithm.outputs() != slot.sent
            if slot.tell and slot.endpoint.ready:
                self._feed(slot)
        return self._open != 0

    def due(self) -> list[Placed]:
        """The algorithms that ``execute`` would execute now."""
        now = self._now()
        return [slot.placed for slot in self.live if now >= slot.due]

    def overdue(self, error: TaskOverdue | TaskTooLong) -> None:
        """The watchdog of the algorithm thread: what executes ends as by a fault (SPEC 6.1 R3)."""
        if self.live:
            slot, (code, message, help_) = self.live[0], describe(error)
            place = Place(slot.placed.unit, "", -1)
            self._fault(slot, AlgorithmFault(RunFault(code, message, help_, "", place, (), 0, 0)))

    def _begin(self, slot: Slot, now: int) -> None:
        """A.START. Where code takes time it may be later than the begin of the period."""
        slot.begun = slot.tell = True
        slot.due, slot.last = now - now % self.period_ns, now
        slot.execute_flag(True)
        slot.enter(follow(ALGORITHM, slot.state, (AlgorithmEvent.CLEAR, AlgorithmEvent.BEGIN)))
        self._move(SlaveEvent.START, SlaveEvent.EXECUTES)
        self._told(units.A_START, slot, now)

    def _end(self, slot: Slot, event: AlgorithmEvent) -> None:
        """A.END; its feedback says so."""
        self._drop(slot, follow(ALGORITHM, slot.state, (event,)))
        slot.tell = True
        self._told(units.A_END, slot, self._now())

    def _ends(self, slot: Slot) -> None:
        """By itself."""
        error = slot.algorithm.error
        if error:
            self._error(slot, NO_ERROR if error in SLAVE_FAULTS else error)
        else:
            self._end(slot, AlgorithmEvent.DONE)

    def _error(self, slot: Slot, error: int) -> None:
        slot.error = error
        slot.algorithm.safe()
        self._end(slot, AlgorithmEvent.FAULT)

    def _drop(self, slot: Slot, state: State) -> None:
        """It executes no more."""
        slot.live = slot.begun = slot.tell = False
        self.live = tuple(other for other in self.live if other is not slot)
        slot.execute_flag(False)
        slot.enter(state)
        if not self.executing:
            self._move(SlaveEvent.ENDED, SlaveEvent.START if self.live else SlaveEvent.STOP)

    def _cease(self, slot: Slot) -> None:
        """It ends at once, and its local outputs are safe."""
        live = slot.live
        self._drop(slot, State.IDLE)
        if live:
            slot.algorithm.safe()
            self._told(units.A_END, slot, self._now(), "stop")

    def _fault(self, slot: Slot, fault: AlgorithmFault) -> None:
        now = self._now()
        fault.fault = replace(fault.fault, task=f"{slot.placed.path} on {self.name}",
                              scan=now // self._scan_ns, now_ns=now)
        self.faults.append(fault)
        slot.faulty = True
        self._error(slot, fault.error)
        for other in self._slots:
            if other.live:
                self._cease(other)
        self._move(SlaveEvent.FAULT)
        if slot.endpoint.ready:
            self._feed(slot)

    def emergency(self) -> None:
        """Everything ends at once, local outputs are safe; only a RESET leads out of ``serror``."""
        for slot in self._slots:
            self._cease(slot)
        self._move(SlaveEvent.FAULT)

    # ---- feedback ----------------------------------------------------------------------------------

    def _feed(self, slot: Slot) -> None:
        """A.FEEDBACK: the values of now, as soon as the link is free."""
        values = slot.feedback()
        if values is None:
            if slot.live:
                self._error(slot, NOT_A_NUMBER)
            elif not slot.error:
                slot.error = NOT_A_NUMBER
                slot.enter(State.ERROR)
            values = slot.sent or tuple(0 for _ in slot.placed.feedback[:-2])
        slot.endpoint.send(slot.placed.aid, Command.UPDATE, slot.message(values))
        slot.tell = False
        self._open |= slot.mask
        self._told(units.A_FEEDBACK, slot, self._now(), "" if slot.live else "end")

    def _told(self, unit: str, slot: Slot, now: int, detail: str = "") -> None:
        if self._note is not None:
            self._note(UnitEvent(now, self.name, unit, slot.placed.aid, detail))
