"""The master of a system: one scan by its units, the communication with slaves, faults, emergency (SPEC 1 to
6).

A scan: C.FEEDBACK, C.START, C.LOGIC, C.SEND, C.END, C.BCAST, C.MSG. The feedback comes first, so that the
logic sees what communication has delivered since the scan before. Nothing here waits or knows a clock:
whoever owns the part calls it, in virtual time or in a process of its own. """

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence, Set

from ldc.il.areas import areas
from ldc.il.coordination import Coordination, Message, Subscriber
from ldc.il.placement import ERROR, Placed
from ldc.records import replace
from runtime import units
from runtime.faults import TaskOverdue
from runtime.machine import Machine, Schedule
from runtime.master.findings import WATCHDOG, LinkFault, ScanOverdue, SlaveAnew
from runtime.master.mail import Mail
from runtime.master.modules import Modules
from runtime.master.proxy import Proxy, Told
from runtime.master.safety import Safety
from runtime.master.sequence import Customised, Started
from runtime.master.standing import Standing
from runtime.master.waiting import LONG_NS, StepWaits, Waiting
from runtime.master.wiring import Wiring
from runtime.online.controller import Controller
from runtime.processors.states import SLAVE_FAULTS, Master
from runtime.protocol.endpoint import Endpoint
from runtime.protocol.envelope import Command
from runtime.protocol.memory import Memory
from runtime.units import UnitEvent

T_ACK_NS = 5_000_000
"""The least time after which a slave counts as silent."""


Finding = LinkFault | ScanOverdue | SlaveAnew | StepWaits
"""What people are to be told when the run ends, beside the faults of tasks."""

QUIET_NS = 100_000_000
"""How long an algorithm that executes may say nothing until its slave is asked whether it is there."""


class MasterPart:
    """``runner``: what executes scans, a machine or the controller of online changes. ``note`` is given the
    units as they are executed, None: nobody listens; ``now``: the time in ns. ``on_emergency`` is called when
    an emergency begins, for those who reach the slaves without P; ``on_machine`` when a scan has brought
    another machine, to call ``change``. ``wiring``: inputs and outputs that a plant is wired to.
    ``ready``: asked when somebody acknowledges, until it says TRUE: who has lost slaves brings them back.
    ``t_ack_ns``: after which a slave counts as silent. ``safety``: the state, and what the emergency thread
    does. ``findings``: what people are to be told when the run ends, in the order in which it happened."""

    def __init__(self, runner: Machine | Controller, memory: Memory, placed: Sequence[Placed],
                 coordination: Coordination, note: Callable[[UnitEvent], None] | None,
                 now: Callable[[], int], *,
                 on_emergency: Callable[[], None] = lambda: None, wiring: Wiring | None = None,
                 on_machine: Callable[[], None] = lambda: None, t_ack_ns: int = T_ACK_NS,
                 ready: Callable[[], bool] = lambda: True) -> None:
        self.runner, self.memory, self.coordination = runner, memory, coordination
        self.safety = Safety(on_emergency, wiring)
        self.findings: list[Finding] = []
        self._tell = _teller(note, now)
        self._on_machine, self._wiring = on_machine, wiring
        self._ready, self._wanted = ready, False
        self.machine = _machine(runner)
        # A tick is a scan: as many of them as last T_ack, and the one that has begun.
        self._periods = -(-t_ack_ns // self.machine.period_ns) + 1
        self._quiet = max(-(-QUIET_NS // self.machine.period_ns), 2)
        self.proxies = tuple(map(self._proxy, placed))
        self.modules = Modules(memory, coordination.modules, self.proxies)
        self.mail = Mail(memory, coordination.messages, self.modules)
        self._standing = Standing(memory, self.modules, self.proxies, self.mail, self._tell)
        self.customised_program: Customised | None = None
        self._waiting = Waiting()
        # Those with transfers to serve, as they began; those of each slave by its word of flags.
        self._open: dict[Proxy, None] = {}
        self._lines: tuple[tuple[int, list[tuple[int, Proxy]]], ...] = ()
        self._fresh: dict[int, Proxy] = {}
        self._scrubbed = -1
        # All pins that algorithms take, read at once; which of them are whose.
        self._read: Callable[[], tuple] = tuple
        self._before: tuple | None = None
        self._pins: list[tuple[Proxy, int, int]] = []
        self._bind(self.machine)
        if coordination.sequence is not None:
            self.customised_program = Customised(memory, self._reader)
            self.customised_program.stage(coordination.sequence)

    def _proxy(self, placed: Placed) -> Proxy:
        return Proxy(placed, self.memory, self._periods, self._quiet)

    def change(self, machine: Machine, placed: Sequence[Placed], stays: Set[str],
               together: Coordination) -> None:
        """Goes on with another program (online change), between two scans of which the slaves know already.
        ``stays``: the paths of algorithms that are the same ones and go on executing."""
        known = {proxy.placed.path.upper(): proxy for proxy in self.proxies}
        proxies = []
        for new in placed:
            proxy = known.get(new.path.upper())
            if proxy is not None and new.path in stays:
                proxy.placed = new
                proxies.append(known.pop(new.path.upper()))
            else:
                proxies.append(self._proxy(new))
        for gone in known.values():
            gone.give_up()
            self._standing.request(gone)
        modules, mail = self.modules, self.mail
        self.proxies, self.coordination = tuple(proxies), together
        self.modules = Modules(self.memory, together.modules, self.proxies)
        self.modules.take_over(modules)
        self.mail = Mail(self.memory, together.messages, self.modules)
        self._standing = Standing(self.memory, self.modules, self.proxies, self.mail, self._tell)
        self._bind(machine)
        self.mail.take_over(mail)
        self._change_sequence(together)

    def _change_sequence(self, together: Coordination) -> None:
        running = self.customised_program
        if together.sequence is None:
            if running is not None:
                running.reset()
            self.customised_program = None
        elif running is None:
            self.customised_program = Customised(self.memory, self._reader)
            self.customised_program.stage(together.sequence)
        else:
            indices = {module.name.upper(): module.index for module in together.modules}
            running.change(together.sequence, indices, self._reader)

    def _reader(self, path: str) -> Callable[[], bool]:
        symbol, machine = self.machine.symbols.find(path), self.machine
        return lambda: bool(machine.value(symbol))

    def _bind(self, machine: Machine) -> None:
        self.machine = machine
        lines: dict[int, list[tuple[int, Proxy]]] = {}
        for proxy in self.proxies:
            into = proxy.endpoint.into.channel
            lines.setdefault(into.running, []).append((into.mask, proxy))
        self._lines = tuple(lines.items())
        self._open = {proxy: None for proxy in self.proxies if not proxy.endpoint.idle}
        self._pins, symbols = [], []
        for proxy in self.proxies:
            proxy.bind(machine)
            self._pins.append((proxy, len(symbols), len(symbols) + len(proxy.pins)))
            symbols += proxy.pins
        self._read, self._before = machine.reader(symbols), None
        self.modules.bind(machine)
        self.mail.bind(machine)
        if self._wiring is not None:
            self._wiring.bind(machine)
        self.safety.bind(machine, self.coordination)

    @property
    def state(self) -> Master:
        """As SPEC 5 has it."""
        return self.safety.state

    @property
    def estop(self) -> bool:
        """The emergency stop is TRUE, as far as the master knows."""
        return self.safety.estop

    # ---- control thread --------------------------------------------------------------------------

    def scan(self) -> None:
        """One scan."""
        self._begin()
        self.runner.scan()
        self._end()

    def pieces(self, execution: Callable[[Schedule, int], Iterator[int]], now_ns: int) -> Iterator[int]:
        """One scan of code that takes time, piece by piece, and what each cost in ns. Whoever counts the
        scans ends that of the machine. ``execution``: of a task; ``now_ns``: what timers see."""
        self._begin()
        machine, safety = self.machine, self.safety
        for pieces in [execution(schedule, now_ns) for schedule in machine.begin()]:
            for cost in pieces:
                if safety.held:
                    safety.force()  # an emergency may have begun between two rungs
                yield cost
        machine.settle()
        self._end()

    def _begin(self) -> None:
        self._tick()
        if self._fresh:
            self._feedback()
        if self._wiring is not None:
            self._wiring.before()
        self.machine.latch()
        self._look()
        if self._sequence_goes_on:
            for event in self.customised_program.control():
                if isinstance(event, Started):
                    for address in event.addresses:
                        self.modules.give(event.module, address)
                else:
                    self.mail.raise_system("RECIPE_CHANGED", event.generation)
        for life in self.modules.started():
            self._tell(units.C_START, life.module.index)
            self.mail.raise_system("START_MODULE", life.module.index)

    def _tick(self) -> None:
        """A period of P. One of those without a transfer gets it too, in turns."""
        proxies, open_ = self.proxies, self._open
        if not proxies:
            return
        self._scrubbed = (self._scrubbed + 1) % len(proxies)
        scrubbed = proxies[self._scrubbed]
        for proxy in proxies:
            if proxy.executing or proxy is scrubbed or proxy in open_:
                told = proxy.tick(proxy is scrubbed or proxy in open_)
                if told is not None:
                    self._learn(proxy, told)
        if not scrubbed.endpoint.idle:
            open_[scrubbed] = None

    def _feedback(self) -> None:
        fresh, self._fresh = self._fresh, {}
        for proxy in fresh.values():
            detail = proxy.take()
            if detail is not None:
                self._tell(units.C_FEEDBACK, proxy.placed.aid, detail)
            if detail == "end":
                self._standing.request(proxy)
                self.mail.raise_system("ALG_DONE", proxy.placed.aid)
            if proxy.error in SLAVE_FAULTS:
                self._standing.slave_fails(proxy)

    def _end(self) -> None:
        self._tell(units.C_LOGIC)
        if _machine(self.runner) is not self.machine:
            self._on_machine()
        self.mail.fall()
        if self.safety.late:
            self._look()
        else:
            self._stand()
        self._send()
        for life in self.modules.ended():
            self._tell(units.C_END, life.module.index)
            self.mail.raise_system("STOP_MODULE", life.module.index)
        for message, outcome in self.mail.broadcast():
            self._tell(units.C_BCAST, message.flag - _MSGF, outcome.value)
        self.mail.handle(self._handled)
        self.safety.work(self.modules.working or any(proxy.executing for proxy in self.proxies))
        if self.modules.stand:
            self.modules.force()
        if self.safety.held:
            self.safety.force()
        if self._wiring is not None:
            self._wiring.after()

    def _handled(self, message: Message, to: Subscriber) -> None:
        self._tell(units.C_MSG, message.flag - _MSGF)

    def _send(self) -> None:
        """C.SEND: what the logic wants of algorithms."""
        now = self._read()
        changed, self._before = now != self._before, now
        for proxy, first, end in self._pins:
            if changed or proxy.raw is None:
                proxy.look(now[first:end])
            if proxy.command is not None:
                command = proxy.send()
                if command is not None:
                    self._open[proxy] = None
                    self._sent(proxy, command)

    def _sent(self, proxy: Proxy, command: Command) -> None:
        life = self.modules.executes(proxy) if command is Command.START else None
        if life is not None:
            self._tell(units.C_START, life.module.index)
        self._tell(units.C_SEND, proxy.placed.aid, command.name)
        self._standing.request(proxy)

    @property
    def busy(self) -> bool:
        """There are transfers to serve."""
        return bool(self._open)

    # ---- customised thread -----------------------------------------------------------------------

    def customised(self) -> None:
        """The customised program, in the rest of a scan."""
        if self._sequence_goes_on:
            self.customised_program.execute()
            self._waiting.look(self.customised_program, self.machine.now_ns)

    @property
    def waits(self) -> StepWaits | None:
        """What the sequence waits for."""
        if self.customised_program is None:
            return None
        waits = self._waiting.told(self.customised_program, self.machine.now_ns, not self._sequence_goes_on)
        return waits if waits is None else replace(waits, errors=self._errors())

    def _errors(self) -> tuple[tuple[str, int], ...]:
        symbols = self.machine.find(f"{proxy.placed.path}.{ERROR}" for proxy in self.proxies)
        return tuple((symbol.path, value) for symbol in symbols if (value := self.machine.value(symbol)))

    @property
    def told(self) -> tuple[Finding, ...]:
        """What people are to be told when the run ends: ``findings``, and the steps that have waited long."""
        waits, long = self.waits, dict(self._waiting.long)
        if waits is not None and waits.what.number > 0 and waits.waited_ns > LONG_NS:
            long[waits.what] = waits
        return *self.findings, *long.values()

    @property
    def _sequence_goes_on(self) -> bool:
        """There is one, and nothing stands after a fault: what would be the next step is not to be had."""
        return (self.customised_program is not None and self.safety.state is not _ERROR
                and not self.modules.stand)

    # ---- communication thread --------------------------------------------------------------------

    def communicate(self) -> None:
        """Serves the transfers of all algorithms as far as they go now."""
        self._find_open()
        for proxy in tuple(self._open):
            self._serve(proxy)

    def serving(self) -> Iterator[Endpoint]:
        """``communicate`` for a master whose transfers take time: each ``next`` serves one algorithm."""
        self._find_open()
        for proxy in tuple(self._open):
            self._serve(proxy)
            yield proxy.endpoint

    def _find_open(self) -> None:
        """The transfers that slaves have begun are open too."""
        load = self.memory.shared.load
        for address, line in self._lines:
            begun = load(address)
            if begun:
                for mask, proxy in line:
                    if begun & mask:
                        self._open[proxy] = None

    def _serve(self, proxy: Proxy) -> None:
        told = proxy.poll()
        if told is not None:
            self._learn(proxy, told)
        if proxy.endpoint.rests:
            self._open.pop(proxy, None)

    def _learn(self, proxy: Proxy, told: Told) -> None:
        if told is Told.FEEDBACK:
            self._fresh[proxy.placed.aid] = proxy
        elif told is Told.STOPPED:
            self._standing.request(proxy)
        elif told is Told.FAULT:
            self.findings.append(self._standing.link_fails(proxy, self.machine))
        elif told is Told.ANEW:
            found = self._standing.begins_anew(proxy, self.machine)
            if found is not None:
                self.findings.append(found)

    # ---- emergency -------------------------------------------------------------------------------

    def overdue(self, error: TaskOverdue) -> bool:
        """The watchdog of the control thread: whether the emergency thread is to end everything, as nothing
        has done that yet (SPEC 6.1 R3)."""
        if self.state is Master.ERROR:
            return False
        self.findings.append(ScanOverdue(error, self.machine.scans, self.machine.now_ns))
        self.safety.demand(WATCHDOG)
        return True

    def _look(self) -> None:
        self._wanted = self.safety.look() or self._wanted
        self._stand()
        if self._wanted and self._ready():
            self._wanted = False
            self.reset()

    def _stand(self) -> None:
        """Ends what an emergency ends, once it has begun."""
        if self.safety.causes:
            causes = self.safety.taken()
            if causes:
                self._standing.everything(causes)

    def reset(self) -> None:
        """Acknowledges faults, by a person; nothing happens while the emergency lasts. Links that stand are
        made new, slaves in `serror` leave it, modules can be started again; the sequence begins anew."""
        if self.estop:
            return
        stood, renewed = self.safety.acknowledge(), self._standing.release()
        if self.customised_program is not None and (stood or renewed):
            self.customised_program.reset()
        self._open |= dict.fromkeys(renewed)


def _teller(note: Callable[[UnitEvent], None] | None, now: Callable[[], int]
            ) -> Callable[[str, int, str], None]:
    """Gives units of the master to whoever listens."""
    def tell(unit: str, index: int = 0, detail: str = "") -> None:
        if note is not None:
            note(UnitEvent(now(), "master", unit, index, detail))

    return tell


def _machine(runner: Machine | Controller) -> Machine:
    return runner.machine if isinstance(runner, Controller) else runner


_MSGF = areas()["MSGF"].base
_ERROR = Master.ERROR
