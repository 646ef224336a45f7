"""Master, slaves and plant in virtual time: a whole controller on one computer (SPEC 6.1,
docs/multiprocessor.md).

One scan of the master takes its period of virtual time, in which the slaves execute at theirs. What happens
in an instant: the plant steps; the master; the slaves by number; who has written flags of P wakes the one who
reads them. What has nothing to do is not activated: a slave whose algorithms rest costs nothing. """

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, MutableSequence, Sequence
from typing import TYPE_CHECKING, Protocol

from ldc.il.areas import areas
from ldc.il.coordination import Coordination, paths
from ldc.il.placement import NoRoom, Placed, placed, points
from ldc.records import record, replace
from runtime import spending
from runtime.cost import Cost
from runtime.faults import Fault, TaskOverdue
from runtime.field import Field
from runtime.machine import Machine
from runtime.master.findings import LinkFault, ScanOverdue
from runtime.master.part import MasterPart
from runtime.master.waiting import StepWaits
from runtime.master.wiring import Wiring
from runtime.online import findings
from runtime.online.controller import Controller, Loaded
from runtime.processors.invariants import Entry as Trace
from runtime.processors.invariants import Snapshot
from runtime.processors.states import Slave as State
from runtime.protocol.memory import Memory, Watched, allocate, shared_size, shared_words
from runtime.scheduler.report import Row, rows
from runtime.scheduler.scheduler import OVERRUNS, Scheduler
from runtime.scheduler.thread import NEVER, Entry, Thread, Work
from runtime.slave.algorithm import Maker
from runtime.slave.part import SlavePart
from runtime.timing import Executions
from runtime.units import UnitEvent

if TYPE_CHECKING:
    from runtime.retain_file import Entry as Retained


class Plant(Protocol):
    """What is simulated around the controller. It knows nothing but the field and the time, in ns. One that
    has a method ``connect(field)`` is given the field of each program that takes over: the same words, other
    points. One that has ``silences(number)`` tells which slaves do nothing now, as without power."""

    def step(self, now_ns: int, dt_ns: int) -> None: ...


class Events(Protocol):
    """Takes what units do; a list does."""

    def append(self, event: UnitEvent) -> object: ...


class _Slave:
    """A slave with its threads. ``due``: when its algorithms execute next, never while all rest;
    ``period_ns``: of its algorithms; ``off``: it has no power; ``of_master``, ``of_slave``: flags of P."""

    __slots__ = ("part", "due", "period_ns", "off", "emergency", "communication", "algorithm", "of_master",
                 "of_slave")

    def __init__(self, part: SlavePart, shared: bytearray, emergency: Work, communication: Work,
                 algorithm: Work, on_watchdog: Callable[[int], None]) -> None:
        self.part, self.period_ns, self.due, self.off = part, part.period_ns, NEVER, False
        self.of_master, self.of_slave = (_Flags(shared, side, part.number) for side in ("MPF", "SPF"))
        self.emergency = Thread("emergency", "emergency", None, emergency)
        self.communication = Thread("communication", "communication", None, communication)
        self.algorithm = Thread("algorithm", "algorithm", None, algorithm, on_watchdog=on_watchdog)


@record
class _Deployed:
    """What a program means for the parts: its algorithms in their places and how they are made, how modules
    work together, the points of the field. ``stays``: paths of the algorithms that go on from the program
    before."""

    machine: Machine
    placed: tuple[Placed, ...]
    makers: Mapping[str, Maker]
    coordination: Coordination
    field: Field
    stays: frozenset[str] = frozenset()


def _deployed(running: Loaded, before: _Deployed) -> _Deployed:
    program = running.machine.program
    names = [m.name for m in running.together.modules]
    try:
        algorithms = placed(program, names, before.placed)
    except NoRoom:  # what stays is in the way of what comes: all of them begin anew
        algorithms = placed(program, names)
    field = before.field.extended(points(program, algorithms, before.field.places))
    return _Deployed(running.machine, algorithms, running.makers, running.together, field)


def _from(before: _Deployed, after: _Deployed) -> _Deployed:
    """``after``, with what of ``before`` stays."""
    old = {p.path: p for p in before.placed}
    stays = frozenset(
        p.path for p in after.placed
        if p.path in old and replace(old[p.path], module=p.module, retain=p.retain) == p
        and before.makers[p.unit.upper()].same(after.makers[p.unit.upper()]))
    return replace(after, stays=stays)


class System:
    """``placed``: the algorithms of the program that ``runner`` executes, ``makers`` how they are made;
    ``slaves``: numbers of slaves that are there though they have none. ``events``: what units did; ``log``:
    of the scheduler; ``seen`` is told what the invariants of SPEC 5 ask for: snapshots, accesses to shared
    memory, what slaves took and executed. The time is that of the master's machine. ``cost``: what code,
    transfers and algorithms take, None: no time; ``watchdogs``: of its tasks, as of Executions;
    ``slave_watchdogs``: what the algorithms of a slave may take together, in ns by its number."""

    def __init__(self, runner: Machine | Controller, placed: Sequence[Placed], makers: Mapping[str, Maker],
                 coordination: Coordination, field: Field, *, slaves: Iterable[int] = (),
                 plant: Plant | None = None,
                 plant_ns: int = 1_000_000, wiring: Wiring | None = None,
                 events: Events | None = None, log: MutableSequence[Entry] | None = None,
                 seen: Callable[[Trace], None] | None = None, cost: Cost | None = None,
                 watchdogs: Mapping[str, int] | None = None,
                 slave_watchdogs: Mapping[int, int] | None = None) -> None:
        self.shared = bytearray(shared_size())
        self._silences = getattr(plant, "silences", None)
        self._kept: Mapping[str, Retained] = {}  # what algorithms had when it was saved last
        self._plant, self._plant_ns, self._plant_due = plant, plant_ns, NEVER if plant is None else 0
        self._scheduler = Scheduler((), log)
        note = None if events is None else events.append
        self._seen = seen
        machine = runner.machine if isinstance(runner, Controller) else runner
        self._began = machine.now_ns
        self._deployed = _Deployed(machine, tuple(placed), makers, coordination, field)
        # Programs that may take over: one that is expected, or the one before.
        self._ready: dict[bool, _Deployed] = {}
        self.master = MasterPart(runner, self._memory("master"), placed, coordination, note, self.now,
                                 on_emergency=self._stop_slaves, wiring=wiring, on_machine=self.follow)
        self._cost, self._slave_watchdogs = cost, slave_watchdogs or {}
        self._executions = None if cost is None else Executions(self.machine, watchdogs or {}, self.now)
        threads = self._emergency, self._communication, *_ = self._master_threads()
        self._slaves: list[_Slave] = []
        for number in sorted({*slaves, *(p.slave for p in placed)}):
            part = SlavePart(number, self._memory(f"slave{number}"), placed, makers, field, note, self.now,
                             seen=seen, scan_ns=self.machine.period_ns)
            self._slaves.append(self._slave(part))
        self._scheduler.add(threads)
        for slave in self._slaves:
            self._scheduler.add((slave.emergency, slave.communication, slave.algorithm))

    def _memory(self, processor: str) -> Memory:
        own = allocate(processor, self.shared)
        if self._seen is None:
            return own
        return replace(own, shared=Watched(own.shared, processor, "D", True, self._seen))

    @property
    def slaves(self) -> tuple[SlavePart, ...]:
        """In ascending order of their numbers."""
        return tuple(slave.part for slave in self._slaves)

    @property
    def machine(self) -> Machine:
        """The master's."""
        return self.master.machine

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Of tasks of the master, then of algorithms in IL on the slaves."""
        return (*self.machine.faults, *(error.fault for part in self.slaves for error in part.faults))

    @property
    def findings(self) -> tuple[Fault | LinkFault | ScanOverdue | StepWaits, ...]:
        """All that people are to be told when the run ends."""
        return (*self.faults, *self.master.told)

    def now(self) -> int:
        """The time in ns."""
        return self._began + self._scheduler.now_ns

    def expect(self, coming: Loaded) -> None:
        """Makes all ready for a program that may take over, beside the scans. Raises Invalid for algorithms of
        slaves that are not there (LD0864)."""
        after = _from(self._deployed, _deployed(coming, self._deployed))
        there = {slave.part.number for slave in self._slaves}
        for p in after.placed:
            if p.slave not in there:
                raise findings.refused(findings.no_slave(p.path, p.slave))
            if p.path not in after.stays:
                after.makers[p.unit.upper()](p, after.field)  # loads and declares what it needs, once
            for pin in (*p.parameters, *p.feedback[:-1]):
                coming.machine.symbols.find(f"{p.path}.{pin.variable}")
        coming.machine.find(paths(coming.together))
        self._ready[True] = after

    def follow(self) -> None:
        """Goes on with the program that the controller runs now, if it is another one: between two scans, or
        in one that a fault has ended. Algorithms that are in both go on executing."""
        running = self.master.runner.running
        if running.machine is self.machine:
            return
        before = self._deployed
        after = next((ready for ready in self._ready.values() if ready.machine is running.machine), None)
        if after is None:
            after = _from(before, _deployed(running, before))
        self._ready = {False: _from(after, before), True: after}
        for slave in self._slaves:
            slave.part.place(after.placed, after.makers, after.field)
            slave.period_ns = slave.part.period_ns
        connect = getattr(self._plant, "connect", None)
        if connect is not None:
            connect(after.field)
        self._deployed = after
        self.master.change(running.machine, after.placed, after.stays, after.coordination)

    def restore(self, kept: Mapping[str, Retained]) -> None:
        """Before the first scan: what algorithms have retained, by path, is put back. Raises ValueError when
        bytes are no value of their type."""
        self._kept = kept
        for slave in self._slaves:
            slave.part.restore(kept)

    def retained(self) -> Callable[[], list[Retained]]:
        """Copies what algorithms retain, between two scans; what it gives tells it."""
        entries = [entry for slave in self._slaves for entry in slave.part.retained()]
        self._kept = {entry.path: entry for entry in entries}
        return lambda: entries

    def rows(self) -> tuple[Row, ...]:
        """What became of the threads so far."""
        master = self.machine.program.resources[self.machine.resource].processor
        names = (master, *(f"slave{part.number}" for part in self.slaves))
        return tuple(row for name, threads in zip(names, self._scheduler.threads, strict=True)
                     for row in rows(name, threads, self._scheduler.now_ns))

    # ---- threads ---------------------------------------------------------------------------------

    def _master_threads(self) -> tuple[Thread, ...]:
        part = self.master

        def control(now: int) -> None:
            part.scan()
            if part.busy:
                self._scheduler.raise_event(self._communication)

        def control_in_pieces(now: int) -> Iterator[int]:
            for cost in part.pieces(self._executions.begin, self._began + now):
                if part.safety.late:
                    self._guard()
                yield cost
            if part.busy:
                self._scheduler.raise_event(self._communication)

        def served() -> None:
            for slave in self._slaves:
                if slave.of_master.changed() and slave.part.wanted:
                    self._scheduler.raise_event(slave.communication)

        def overdue(now: int) -> None:
            worst = max(scan.counts.worst, now - scan.released)
            if part.overdue(TaskOverdue(OVERRUNS, scan.period_ns, worst)):
                self._scheduler.raise_event(self._emergency)

        scan = Thread("control", "control", self.machine.period_ns,
                      control if self._executions is None else control_in_pieces, on_watchdog=overdue)
        return (Thread("emergency", "emergency", None, lambda now: part.safety.trip()),
                Thread("communication", "communication", None,
                       spending.communication(self._cost, part, served)),
                scan, Thread("customised", "customised", None, lambda now: part.customised()))

    def _slave(self, part: SlavePart) -> _Slave:
        def served() -> None:
            if slave.of_slave.changed():
                self._scheduler.raise_event(self._communication)
            if part.live and slave.due == NEVER:
                now = self._scheduler.now_ns
                slave.due = -(-now // slave.period_ns) * slave.period_ns
                if slave.due == now:
                    slave.due += slave.period_ns
                    self._scheduler.raise_event(slave.algorithm)

        def opened() -> None:
            self._scheduler.raise_event(slave.communication)

        def overdue(now: int) -> None:
            thread = slave.algorithm
            part.overdue(TaskOverdue(OVERRUNS, slave.period_ns, max(thread.counts.worst, now - thread.released)))
            opened()

        def powered(work: Work) -> Work:
            return work if self._silences is None else lambda now: None if slave.off else work(now)

        communication = spending.communication(self._cost, part, served)
        algorithm = spending.algorithms(self._cost, part, opened, self.now,
                                        self._slave_watchdogs.get(part.number))
        slave = _Slave(part, self.shared, powered(lambda now: part.emergency()), powered(communication),
                       powered(algorithm), overdue)
        return slave

    def _power(self) -> None:
        """Slaves that have no power do nothing; one that has it again begins anew."""
        for slave in self._slaves:
            before, slave.off = slave.off, self._silences(slave.part.number)
            if before and not slave.off:
                slave.part.restart(self._kept)
                slave.due = NEVER
                self._scheduler.raise_event(slave.communication)

    def _guard(self) -> None:
        """Activates the emergency thread when the emergency stop has become TRUE in the middle of a scan. A
        scan that takes no time has no middle: there it is looked at when a scan begins."""
        if self.master.safety.called():
            self._scheduler.raise_event(self._emergency)

    def _stop_slaves(self) -> None:
        for slave in self._slaves:
            self._scheduler.raise_event(slave.emergency)

    # ---- time ------------------------------------------------------------------------------------

    def scan(self) -> None:
        """One scan of the master, and what else happens until the next one. The scheduler is asked only when
        it has threads to execute."""
        scheduler, slaves, seen = self._scheduler, self._slaves, self._seen
        plant, plant_ns, began = self._plant, self._plant_ns, self._began
        beside = self._silences is not None or self._executions is not None
        lone = (len(slaves) == 1 and slaves[0].period_ns == plant_ns and not beside and seen is None
                and scheduler.log is None)
        if self._executions is not None:
            self.machine.latch()
            self._guard()
        end = scheduler.now_ns + self.machine.period_ns
        # What comes next: a step of the plant, a period of a slave, or what the scheduler has planned.
        due, soonest, planned = self._plant_due, self._soonest(), scheduler.next_ns
        while True:
            now = due if due < soonest else soonest
            if planned < now:
                now = planned
            if now >= end:
                break
            if lone and due == soonest < planned and slaves[0].part.live:
                self._in_step(slaves[0], min(planned, end))
                due, soonest, planned = self._plant_due, self._soonest(), scheduler.next_ns
                continue
            if due == now:
                plant.step(began + now, plant_ns)
                self._plant_due = due = now + plant_ns
                if beside:
                    self._beside(now)
                    soonest, planned = self._soonest(), scheduler.next_ns
            if soonest == now:
                for slave in slaves:
                    if slave.due == now:
                        if not slave.part.live:
                            slave.due = NEVER
                            continue
                        slave.due = now + slave.period_ns
                        scheduler.now_ns = now
                        if planned <= now:
                            scheduler.release(slave.algorithm)
                        elif scheduler.release_first(slave.algorithm):
                            planned = now
                soonest = self._soonest()
            if planned <= now:
                scheduler.run(now + 1)
                soonest, planned = self._soonest(), scheduler.next_ns
            if seen is not None:
                seen(self.snapshot(now))
        scheduler.now_ns = end
        if self._executions is not None:
            self.machine.end()

    def _in_step(self, slave: _Slave, until: int) -> None:
        """The instants before ``until`` in which the plant and the only slave both have something to do and
        nobody else has, nearly all of them, until a transfer is open."""
        scheduler, part, period, began = self._scheduler, slave.part, self._plant_ns, self._began
        step, execute, first = self._plant.step, part.execute_at, began + slave.due
        for now in range(first, began + until, period):
            step(now, period)
            scheduler.now_ns = now - began
            opened = execute(now)
            if opened or not part.live:
                break
        self._plant_due = slave.due = now - began + period
        scheduler.executed(slave.algorithm, (now - first) // period + 1)
        if opened:
            scheduler.raise_event(slave.communication)

    def _soonest(self) -> int:
        """When algorithms of a slave execute next."""
        if len(self._slaves) == 1:
            return self._slaves[0].due
        return min([slave.due for slave in self._slaves], default=NEVER)

    def _beside(self, now: int) -> None:
        """What follows a step of the plant at once: power of slaves, an emergency stop."""
        if self._silences is not None:
            self._power()
        if self._executions is not None:
            self._scheduler.run(now)
            self._guard()

    def snapshot(self, now: int) -> Snapshot:
        """What there is when everything of a moment is done. ``now``: its time of the scheduler."""
        safe, value = self.machine.safe_values(range(len(self.machine.layout.programs))), self.machine.value
        sides = [(s.part.number, s.of_master.words, s.of_slave.words) for s in self._slaves]
        raised = {(number, True, slot) for number, master, slave in sides for slot in _raised(master, slave)}
        raised |= {(number, False, slot)
                   for number, master, slave in sides for slot in _raised(slave, master)}
        open_ = {(p.placed.slave, to_slave, p.placed.slot) for p in self.master.proxies
                 for to_slave in (True, False) if not p.endpoint.idle}
        # A slave whose communication waits for its processor has not ended its side yet.
        waiting = {slave.part.number for slave in self._slaves if slave.communication.active}
        open_ |= {flag for flag in raised if flag[0] in waiting}
        return Snapshot(self._began + now, self.master.state,
                        tuple(State.ERROR if s.off else s.part.state for s in self._slaves),
                        tuple(0 if s.off else s.part.executing for s in self._slaves), self.master.estop,
                        all(value(symbol) == wanted for symbol, wanted in safe), frozenset(raised),
                        frozenset(open_))


class _Flags:
    """The words of flags of one side of a slave's transfers, and what they were when somebody looked last."""

    __slots__ = ("words", "_bytes", "_before")

    def __init__(self, shared: bytearray, area: str, number: int) -> None:
        place, first = areas()[area], shared_words(shared).first
        self._bytes = memoryview(shared)[place.first(number) - first :][: place.size]
        self.words, self._before = self._bytes.cast("I"), bytes(place.size)

    def changed(self) -> bool:
        """Since the call before: whether the other side has to look."""
        now = self._bytes.tobytes()
        before, self._before = self._before, now
        return now != before


def _raised(sender: memoryview, receiver: memoryview) -> list[int]:
    """The slots of a direction of which a flag is 1: those of its sender on one side, of its receiver on the
    other."""
    flags = sender[0] | sender[1] | sender[6] | receiver[2] | receiver[3] | receiver[4]
    return [slot for slot in range(32) if flags >> slot & 1]
