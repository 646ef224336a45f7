"""The states of an online change: running, staged, testing (DESIGN section 7).

Pure: no clock, no thread, no socket. Whoever owns it calls ``between`` and ``scan`` in turn, and the actions
only between two scans. Time is that of the machine, in nanoseconds.

    running --stage--> staged --test--> testing --commit--> running (the new program)
                       staged <--untest, time over-- testing
    running <--cancel-- staged, testing;  running <--fault-- testing

A test that ends goes back to the program before, with the state of that moment, by the same migration: what
both programs have goes on, and what only the old one has stands as it was when the test began. A fault in a
test is undone: the scan is run again, by the program before, from the state in which it began.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from ldc.il.coordination import Coordination
from ldc.records import record
from runtime.faults import Fault
from runtime.machine import Machine
from runtime.online import checks, findings, migrate, swap
from runtime.online.checks import Limits
from runtime.online.migrate import Plan
from runtime.slave.algorithm import Maker
from runtime.value_findings import force_lost

TEST_NS = 60_000_000_000
"""How long a test runs when nothing says it."""

Sources = tuple[tuple[str, str], ...]
"""Path relative to the project, and text."""


@dataclass(frozen=True, slots=True, eq=False)
class Loaded:
    """A program ready to run: its machine, image (bytes, and SHA-256 of what runs) and sources. ``together``:
    how its modules work together; ``makers``: how its algorithms are made, by unit; ``watch``: what is
    shown while it runs, as people call it and by its full path; None: whatever was before. ``settings``:
    SHA-256 of what comes with a program beside its code (``loading.settings_digest``)."""

    machine: Machine
    image: bytes
    digest: str
    sources: Sources
    together: Coordination = Coordination()
    makers: Mapping[str, Maker] = field(default_factory=dict)
    watch: tuple[tuple[str, str], ...] | None = None
    settings: str = ""


@record
class Staged:
    """A program that may take over, from ``old``, and the ways of the state to and fro."""

    old: Loaded
    new: Loaded
    plan: Plan
    moves: swap.Moves
    owner: str


@record
class Event:
    """Something that happened to the running program. ``digest``: what runs from now on."""

    action: str
    scan: int
    now_ns: int
    digest: str
    owner: str = ""
    detail: str = ""
    faults: tuple[Fault, ...] = ()


def prepare(old: Loaded, new: Loaded, base: str, owner: str, limits: Limits = Limits()) -> Staged:
    """Checks a change and makes all ready for it; may run while ``old`` does. ``base``: the digest of the
    program that the change was made for. Raises Invalid with all that is against it (LD0820 to LD0823)."""
    if base != old.digest:
        raise findings.refused(findings.stale(base, old.digest))
    before, after = old.machine.layout, new.machine.layout
    plan = migrate.plan(before, after)
    against = [*plan.refusals, *checks.tasks(before, after, old.machine.period_ns),
               *checks.memory(new.machine.program, after, limits)]
    if against:
        raise findings.refused(*against)
    moves = swap.moves(old.machine, new.machine, plan, migrate.plan(after, before))
    return Staged(old, new, plan, moves, owner)


@dataclass(slots=True, eq=False)
class Controller:
    """``running``: what executes scans now. ``note`` is told every event; ``expect``, beside the scans, what
    may run later. ``swaps`` counts how often another program began to run."""

    running: Loaded
    note: Callable[[Event], None] = lambda event: None
    expect: Callable[[Loaded], None] = lambda coming: None
    staged: Staged | None = None
    deadline_ns: int | None = None
    swaps: int = field(default=0, init=False)

    @property
    def machine(self) -> Machine:
        return self.running.machine

    @property
    def state(self) -> str:
        """running, staged or testing."""
        if self.staged is None:
            return "running"
        return "staged" if self.deadline_ns is None else "testing"

    # ---- scans -----------------------------------------------------------------------------------

    def between(self) -> None:
        """To be called between two scans: ends a test whose time is over."""
        if self.deadline_ns is not None and self.machine.now_ns >= self.deadline_ns:
            owner = self.staged.owner
            self._back()
            self._tell("reverted", owner, "nobody committed the test in its time")

    def scan(self) -> None:
        """One scan. A fault in a test brings the program before back, which runs this scan instead."""
        machine = self.machine
        if self.deadline_ns is None:
            machine.scan()
            return
        kept = machine.checkpoint()
        machine.scan()
        faults = tuple(machine.faults[len(kept.faults):])
        if faults:
            machine.restore(kept)
            owner = self.staged.owner
            self._back()
            self._drop()
            self._tell("reverted", owner, faults[0].sentence, faults)
            self.machine.scan()

    # ---- actions ---------------------------------------------------------------------------------

    def stage(self, staged: Staged) -> None:
        """Takes what ``prepare`` made; another one of the same owner is replaced."""
        if self.state == "testing":
            raise findings.refused(findings.out_of_turn(
                "stage a program", "a test is running", "commit it, or end it with untest or cancel"))
        self.free_for(staged.owner)
        if staged.old is not self.running:
            raise findings.refused(findings.stale(staged.old.digest, self.running.digest))
        self._holds(staged.new.machine)
        self._drop()
        self.staged = staged
        self._tell("staged", staged.owner, staged.new.digest)

    def test(self, owner: str, limit_ns: int = TEST_NS) -> None:
        """The staged program runs from the next scan on, for ``limit_ns`` at most."""
        staged = self._mine("test", owner)
        if self.deadline_ns is not None:
            raise findings.refused(findings.out_of_turn("test", "the test is running already",
                                                        "commit it, or end it with untest"))
        self._holds(staged.new.machine)
        staged.moves.there()
        self._run(staged.new)
        self.deadline_ns = self.machine.now_ns + limit_ns
        self._tell("testing", owner)

    def untest(self, owner: str) -> None:
        """The program before runs again; the other one stays staged."""
        self._testing("untest", owner)
        self._back()
        self._tell("untested", owner)

    def commit(self, owner: str) -> None:
        """The program in test stays; the one before is gone."""
        self._testing("commit", owner)
        self.staged.old.machine.close()
        self.staged, self.deadline_ns = None, None
        self._tell("committed", owner)

    def cancel(self, owner: str, force: bool = False) -> None:
        """Nothing is staged any more; a test ends. ``force``: whoever staged it."""
        if self.staged is None:
            raise findings.refused(findings.nothing_staged("cancel"))
        if not force:
            self.free_for(owner)
        if self.deadline_ns is not None:
            self._back()
        self._drop()
        self._tell("cancelled", owner)

    def free_for(self, owner: str) -> None:
        """Raises Invalid when somebody else has staged a program."""
        if self.staged is not None and self.staged.owner != owner:
            raise findings.refused(findings.in_other_hands("another client has staged a program"))

    # ---- parts of them ---------------------------------------------------------------------------

    def _mine(self, action: str, owner: str) -> Staged:
        if self.staged is None:
            raise findings.refused(findings.nothing_staged(action))
        self.free_for(owner)
        return self.staged

    def _testing(self, action: str, owner: str) -> None:
        self._mine(action, owner)
        if self.deadline_ns is None:
            raise findings.refused(findings.out_of_turn(action, "no test is running",
                                                        "start one with `ldc online test`"))

    def _holds(self, machine: Machine) -> None:
        """Raises Invalid (LD0856) when something is forced that another program does not have."""
        lost = self.machine.forces.lost(machine)
        if lost:
            raise findings.refused(*(force_lost(*row) for row in lost))

    def _back(self) -> None:
        for path, *_ in self.machine.forces.lost(self.staged.old.machine):
            self._tell("unforced", self.staged.owner, f"{path} is not in the program before")
        self.staged.moves.back()
        self._run(self.staged.old)
        self.deadline_ns = None

    def _drop(self) -> None:
        if self.staged is not None:
            self.staged.new.machine.close()
        self.staged, self.deadline_ns = None, None

    def _run(self, program: Loaded) -> None:
        self.running = program
        self.swaps += 1

    def _tell(self, action: str, owner: str, detail: str = "", faults: tuple[Fault, ...] = ()) -> None:
        self.note(Event(action, self.machine.scans, self.machine.now_ns, self.running.digest, owner, detail,
                        faults))

