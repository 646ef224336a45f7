"""Emergencies of a master whose scan takes time: between two rungs, by the watchdog; what is told then
(SPEC 6.1, rules R3 and R5)."""

from __future__ import annotations

from itertools import accumulate
from pathlib import Path

import pytest
from systems import Run, modules

from ldc.cli.main import main
from runtime.cost import Cost, Costs
from runtime.processors.invariants import Snapshot, i4
from runtime.processors.states import Master, Slave
from runtime.units import C_END

SAFETY = '[safety]\nestop = "estop"\nreset = "reset"\n'
BOTH = '[messages.both]\nfrom = "go"\nto = ["first", "second"]\n'
PLANT = '[plant]\nfile = "plant.py"\n'
MS = 1_000_000
COST = Cost(instruction=100_000)

STOPPER = """\
class Plant:
    def __init__(self, field, parameters, seed):
        self.estop, self.valve = field.writer("%IX0.7"), field.reader("%QX0.1")
        self.seen = []

    def step(self, now_ns, dt_ns):
        self.estop({begin} <= now_ns < {end})
        self.seen.append((now_ns, self.valve()))
"""


def stopped(folder: Path, begin: int, end: int = 10**12, engine: str = "vm", cost: Cost = COST) -> Run:
    """A project in which both axes move and the plant is about to make the emergency stop TRUE."""
    modules(folder, BOTH + SAFETY + PLANT)
    (folder / "plant.py").write_text(STOPPER.format(begin=begin, end=end))
    return Run(folder, engine, cost=cost).scans(2).scans(3, go=True)


def begins(run: Run) -> list[int]:
    """When the pieces of a scan begin, and the last ends, in ns after the begin of the scan."""
    program, costs = run.result.program, Costs(run.result.program, COST)
    runs = program.resources[0].runs
    return list(accumulate((c for r in runs for c in costs.rungs(program.unit(r.pou))), initial=0))


def first_safe(run: Run) -> Snapshot:
    return next(s for s in run.trace if isinstance(s, Snapshot) and s.estop and s.safe)


@pytest.mark.parametrize(("at", "engine"), [(51 * MS, "vm"), (53 * MS, "vm"), (56 * MS, "vm"),
                                            (53 * MS, "native")])
def test_an_emergency_stop_in_the_middle_of_a_scan_is_safe_at_the_next_rung(
        tmp_path: Path, at: int, engine: str) -> None:
    """A scan of more than 8 ms begins at 50 ms; outputs do not wait for its end, nor for that of the next."""
    run = stopped(tmp_path, at, engine=engine)
    pieces = begins(run)
    assert 8 * MS < pieces[-1] < 10 * MS and run.get("%QX0.1") and run.system.slaves[0].executing
    run.scans(1)
    seen = first_safe(run)
    boundary = next(50 * MS + piece for piece in pieces if 50 * MS + piece >= at)
    assert seen.time_ns == boundary and boundary - at < 3 * MS
    assert seen.master is Master.ERROR and seen.executing == (0, 0)
    assert seen.slaves == (Slave.ERROR, Slave.ERROR)
    (row,) = [row for row in run.system.rows() if (row.processor, row.task) == ("master", "emergency")]
    assert (row.executions, row.response_worst_us) == (1, (boundary - at) / 1000)
    valve = dict(run.system._plant._plant.seen)
    assert valve[at] and not valve[-(-boundary // MS) * MS + MS], "the plant sees it in its next step"
    later = [s for s in run.trace if isinstance(s, Snapshot) and s.time_ns >= boundary]
    assert len(later) > 3 and all(s.safe for s in later), "rungs that follow write nothing"
    assert i4(run.trace, 3 * MS) == [] and run.violations == []
    run.scans(3)
    assert not run.get("first.start") and not run.get("%QX0.1") and not run.get("%QX0.2")


@pytest.mark.parametrize("engine", ["vm", "native"])
def test_a_short_emergency_stop_is_kept_until_the_reset(tmp_path: Path, engine: str) -> None:
    """It is over when the next scan looks; what it began lasts."""
    run = stopped(tmp_path, 53 * MS, 55 * MS, engine).scans(4)
    assert run.system.master.state is Master.ERROR and not run.system.master.estop
    assert not run.get("%QX0.1") and run.system.slaves[0].state is Slave.ERROR
    run.scans(1, reset=True, go=False).scans(3, reset=False)
    assert run.system.master.state is Master.STOP
    assert [slave.state for slave in run.system.slaves] == [Slave.STOP, Slave.STOP]
    run.scans(8, go=True)
    assert run.get("%QX0.1") and run.get("%QX0.2") and run.system.slaves[1].executing
    assert run.violations == []


def test_between_two_scans_outputs_are_safe_at_once(tmp_path: Path) -> None:
    run = stopped(tmp_path, 59 * MS)
    assert begins(run)[-1] < 9 * MS
    run.scans(1)
    assert first_safe(run).time_ns == 59 * MS


def test_an_input_that_comes_while_a_scan_is_late(tmp_path: Path) -> None:
    """Inputs come with the ticks, also with one at which the scan before goes on."""
    cost = Cost(instruction=160_000)
    run = Run(modules(tmp_path, BOTH + SAFETY), cost=cost).scans(2).scans(1, go=True)
    pieces = [20 * MS + piece * 8 // 5 for piece in begins(run)]
    assert pieces[-1] > 33 * MS
    run.scans(1, estop=True)
    assert first_safe(run).time_ns == next(piece for piece in pieces if piece >= 30 * MS)
    assert run.violations == []


def test_a_force_holds_off_an_emergency_stop(tmp_path: Path) -> None:
    run = stopped(tmp_path, 53 * MS)
    run.machine.forces.add("estop", "FALSE")
    run.scans(3)
    assert run.system.master.state is Master.RUN and run.get("%QX0.1")
    run.machine.forces.remove("estop")
    run.scans(1)
    assert run.system.master.state is Master.ERROR and not run.get("%QX0.1")


def test_a_stop_that_the_ladder_computes(tmp_path: Path) -> None:
    """It counts from the rung that computes it."""
    folder = modules(tmp_path, BOTH + '[safety]\nestop = "panic"\nreset = "reset"\n')
    (folder / "io.ld").write_text((folder / "io.ld").read_text().replace(
        "END_VAR", "    panic : BOOL;\nEND_VAR"))
    second = folder / "second.ld"
    second.write_text(second.read_text().replace(
        "VAR\n    valve", "VAR_EXTERNAL\n    estop, panic : BOOL;\nEND_VAR\nVAR\n    valve").replace(
        "RUNG told", "RUNG alarm\n    [estop] (panic)\n\nRUNG told"))
    run = Run(folder, cost=COST).scans(2).scans(3, go=True)
    run.scans(1, estop=True)
    rung = [r.key for r in run.result.program.unit("second").rungs].index("alarm")
    own = len(run.result.program.unit("first").rungs)
    assert first_safe(run).time_ns == 50 * MS + begins(run)[own + rung + 1]
    assert run.violations == []


def test_three_late_scans_in_a_row_are_an_emergency(tmp_path: Path) -> None:
    """R3: outputs safe, `merror`, ALARM, LD0844 with the numbers; a reset leads back."""
    folder = modules(tmp_path, BOTH + SAFETY + '[messages.ALARM]\nclass = "system"\n'
                     'to = [{ module = "first", flag = "alarm", data = "number" }]\n')
    first = folder / "first.ld"
    first.write_text(first.read_text().replace("target : REAL := 10.0;",
                                               "target : REAL := 10.0; alarm : BOOL; number : UDINT;"))
    run = Run(folder, cost=Cost(instruction=150_000)).scans(2).scans(2, go=True)
    assert begins(run)[-1] * 1.5 > 12 * MS and run.system.findings == ()
    run.scans(8)
    assert run.system.master.state is Master.ERROR and not run.get("%QX0.1")
    assert [slave.state for slave in run.system.slaves] == [Slave.ERROR, Slave.ERROR]
    assert run.get("first.number") == 844 << 16
    (told,) = [found.diagnostic() for found in run.system.findings]
    assert told.code == "LD0844"
    assert told.message.startswith(
        "emergency in scan 5, at 50 ms: watchdog: 3 periods of 10 ms missed in a row")
    assert (C_END, 0, "") not in run.units(C_END)


def test_a_dead_slave_is_told_on_the_command_line(capsys, monkeypatch) -> None:
    monkeypatch.chdir(Path(__file__).parent / "errors" / "LD0845")
    assert main(["run", ".", "--scans", "10"]) == 0, "it is asked after 100 ms of silence only"
    assert main(["run", ".", "--scans", "30"]) == 1
    assert capsys.readouterr().err.count("error[LD0845]: slave1: it does not answer: `main.count`") == 1
