"""The processes of a run in real time: made, started, ended; what of them is retained, and what a change of
the program finds (docs/realtime.md)."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Mapping

from ldc import pipeline
from ldc.cli import lateness, system
from ldc.cli.compiling import locator
from ldc.cli.console import OK, report, say
from ldc.cli.plant import Plant
from ldc.cli.starting import is_system
from ldc.diagnostics import Invalid
from ldc.il.external import Binding
from ldc.il.placement import NoRoom, Placed, placed, points
from ldc.records import replace
from runtime.field import Field, field_size
from runtime.machine import Machine
from runtime.master.part import MasterPart
from runtime.master.wiring import Wiring
from runtime.online import findings
from runtime.online.controller import Controller, Loaded
from runtime.protocol.memory import allocate
from runtime.realtime import processes
from runtime.realtime.board import Board
from runtime.realtime.lateness import Figures
from runtime.realtime.master import COMING_NS, MasterLoop, Watched
from runtime.realtime.pace import Pace
from runtime.realtime.slave import run_plant, run_slave, slave_period
from runtime.realtime.spare import Spare
from runtime.retain_file import Entry
from runtime.slave.algorithm import makers
from runtime.slave.part import SlavePart
from runtime.slave.retained import leaves, room
from runtime.units import UnitEvent

_ACK_MS = 100
"""T_ack: an ordinary process may have to wait for others as long, a virtual computer for its host."""

_ATTEMPTS = 3
"""How often a transfer is tried (SPEC 2.5); a slave that did nothing for as long has been given up."""

_LEAD_NS = 20_000_000
"""Between the moment at which all processes are there and the first period of all."""


class Processes:
    """Of a run. ``runner``: what executes scans; ``join`` is given this before the processes are made, to put
    back what algorithms retain. ``loop``: of the master, which is this process; ``affinity``: where it ran
    before. ``began_ns``: the time of the program at the first scan."""

    def __init__(self, result: pipeline.Compiled, runner: Machine | Controller, bindings: tuple[Binding, ...],
                 beat: Callable[[], None], note: Callable[[UnitEvent], None] | None,
                 join: Callable[[Processes], None]) -> None:
        machine = runner.machine if isinstance(runner, Controller) else runner
        said, self._locate = system.together(result), locator(result)
        self._runner, self._machine, self._placed = runner, machine, system.placement(result)
        self._beat = beat
        manifest = result.sources.manifest
        self._watchdogs = manifest.watchdogs if manifest is not None else {}
        self._makers = made = makers(result.program, bindings)
        places = points(result.program, self._placed)
        slaves = sorted({p.slave for p in self._placed})
        kept = [room(leaf for p in self._placed if p.slave == n
                     for leaf in leaves(made[p.unit.upper()], p)) for n in slaves]
        self._names = ["master", *(f"slave{n}" for n in slaves), *(["plant"] if said.plant else [])]
        self._board = board = Board(field_size(places), len(self._names), [0, *kept])
        self._field = field = Field(board.field, places)
        plant = Plant(said.plant, field) if said.plant is not None else None
        wired = sorted(field.asked - {pin.path.upper() for p in self._placed for pin in p.local})
        self.affinity = os.sched_getaffinity(0)
        self._seats = processes.cpus(1 + len(slaves))
        refused = processes.claim(self._seats[0])
        for text in refused:
            say(f"note: {text}")
        self._periods = [machine.period_ns]
        self._pace = Pace(machine.period_ns, board.lateness(0))
        self._parts: dict[int, tuple[SlavePart, Pace]] = {}
        self._others: list[Watched] = []
        self._spare: Spare | None = None
        self._over = self._failed = False
        try:
            for number, slave in enumerate(slaves, 1):
                self._parts[number] = self._part(slave, number)
            join(self)
            for number, (part, _) in self._parts.items():
                if board.keeps(number):
                    board.keep(number, 0, part.retained())
                self._others.append(self._slave(number))
            if plant is not None:
                self._periods.append(said.plant.step_ns)
                self._others.append(self._plant(plant, len(self._names) - 1))
            if slaves:
                works = {n: (self._names[n], self._work(n, anew=True)) for n in self._parts}
                self._spare = Spare(works, lambda: processes.ordinary(self.affinity))
        except BaseException:
            self.finish()
            raise
        part = None
        if note is not None or is_system(result) or isinstance(runner, Controller):  # changes may need it
            part = MasterPart(runner, allocate("master", board.shared), self._placed, said, note,
                              lambda: self._pace.now_ns, on_emergency=board.emergency,
                              wiring=Wiring(field, wired), on_machine=self.follow,
                              t_ack_ns=_ACK_MS * 1_000_000, ready=lambda: self.loop.ready())
        self.master = part
        self.loop = MasterLoop(runner, part, board, self._pace, self._others, self._spare,
                               lambda text: say(f"note: {text}"), beat)

    def begin(self) -> None:
        """To be called before the first scan: all periods begin when all processes are there, since one that
        the computer keeps waiting meanwhile would be given up at once."""
        end = time.monotonic_ns() + COMING_NS
        while time.monotonic_ns() < end and any(
                each.child.look() is None and not self._board.arrived(each.number) for each in self._others):
            self._beat()
            time.sleep(0.001)
        start = time.monotonic_ns() + _LEAD_NS
        self._pace.begin(start)
        self._board.begin(start)

    # ---- slaves and plant ------------------------------------------------------------------------

    def _part(self, slave: int, number: int) -> tuple[SlavePart, Pace]:
        period_ns = slave_period(self._placed, slave)
        pace = Pace(period_ns, self._board.lateness(number))
        self._periods.append(period_ns)
        memory = allocate(f"slave{slave}", self._board.shared)
        return SlavePart(slave, memory, self._placed, self._makers, self._field, None, lambda: pace.now_ns,
                         scan_ns=self._machine.period_ns, ack_periods=_ACK_MS), pace

    def _work(self, number: int, anew: bool = False) -> Callable[[], int]:
        part, pace = self._parts[number]

        def work() -> int:
            processes.claim(self._seats[number])
            run_slave(part, self._board, number, pace, _ATTEMPTS * _ACK_MS * 1_000_000, anew,
                      self._watchdogs.get(part.number))
            return report((error.fault.diagnostic() for error in part.faults), self._locate)

        return work

    def _slave(self, number: int) -> Watched:
        child = processes.start(self._names[number], self._work(number))
        return Watched(child, number, self._parts[number][0].number)

    def _plant(self, plant: Plant, number: int) -> Watched:
        pace = Pace(self._periods[number], self._board.lateness(number))

        def work() -> int:
            processes.give_back(self.affinity)
            try:
                run_plant(plant.step, self._board, number, pace)
            except Invalid as error:
                return report(error.diagnostics)
            return OK

        return Watched(processes.start(self._names[number], work), number, None)

    def finish(self) -> None:
        """Ends the processes; this one is an ordinary one again."""
        early = [each for each in self._others if each.child.look() is not None]
        self._board.stop()
        late = list(self._spare.close(self._beat).values()) if self._spare is not None else []
        processes.finish([*(each.child for each in self._others), *late], self._beat)
        processes.give_back(self.affinity)
        self._over = True
        self._failed = bool(early) or any(each.child.status for each in self._others)

    # ---- what is retained ------------------------------------------------------------------------

    def restore(self, kept: Mapping[str, Entry]) -> None:
        """Before the processes are made. Raises ValueError when bytes are no value of their type."""
        for part, _ in self._parts.values():
            part.restore(kept)

    def retained(self) -> Callable[[], list[Entry]]:
        """Asks all slaves; what it gives waits for them, T_ack at most: of one that says nothing, what it
        said last counts."""
        board = self._board
        asked = [number for number in self._parts if board.keeps(number)]
        save = board.saves if self._over else board.save()

        def wait() -> list[Entry]:
            end = time.monotonic() + _ACK_MS / 1000
            while (any(board.saved(n) != save for n in asked) and not self._over
                   and time.monotonic() < end):
                time.sleep(0.001)
            return [entry for number in asked for entry in board.kept(number)]

        return wait

    # ---- another program -------------------------------------------------------------------------

    def expect(self, coming: Loaded) -> None:
        """Beside the scans: whether a program may take over. Slaves go on with what they have, so its
        algorithms have to be the same. Raises Invalid (LD0862)."""
        names = [module.name for module in coming.together.modules]
        try:
            after = placed(coming.machine.program, names, self._placed)
        except NoRoom as error:
            raise findings.refused(findings.other_algorithms([error.path])) from None
        before, coming_by_path = ({p.path.upper(): p for p in all_} for all_ in (self._placed, after))
        changed = [p.path for path, p in {**before, **coming_by_path}.items()
                   if not self._goes_on(before.get(path), coming_by_path.get(path), coming)]
        if changed:
            raise findings.refused(findings.other_algorithms(changed))

    def _goes_on(self, old: Placed | None, new: Placed | None, coming: Loaded) -> bool:
        return (old is not None and new is not None and replace(new, module=old.module) == old
                and self._makers[old.unit.upper()].same(coming.makers[new.unit.upper()]))

    def follow(self) -> None:
        """Goes on with the program that the controller runs now, if it is another one."""
        running = self._runner.running
        if running.machine is self._machine:
            return
        self._machine = running.machine
        names = [module.name for module in running.together.modules]
        after = placed(running.machine.program, names, self._placed)
        self._placed = after
        self.master.change(running.machine, after, {p.path for p in after}, running.together)

    # ---- at the end ------------------------------------------------------------------------------

    @property
    def broken(self) -> bool:
        """A process was lost, or has failed."""
        return self._failed or self.loop.lost

    @property
    def passed_ns(self) -> int:
        """The real time that the scans took."""
        return self._pace.now_ns + self._pace.period_ns

    def processors(self) -> list[lateness.Processor]:
        """What each process has noted of its periods."""
        figures: Iterable[Figures] = (self._board.lateness(n).figures() for n in range(len(self._names)))
        return [lateness.Processor(*row) for row in zip(self._names, self._periods, figures, strict=True)]
