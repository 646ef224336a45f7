"""Costs of transfers and of algorithms: delays, overruns and watchdogs of slaves in virtual time."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import native
import pytest
from systems import Run, modules, mover

from ldc.cli.main import main
from runtime.cost import Cost
from runtime.processors.states import Slave
from runtime.protocol.check import Algorithm, Parameter, Situation
from runtime.protocol.endpoint import Endpoint
from runtime.protocol.envelope import Command
from runtime.protocol.memory import shared_size, shared_words
from runtime.protocol.meter import Meter
from runtime.protocol.profile import Link, channel
from runtime.units import A_EXEC, A_START

pytestmark = native.needs_gcc

US = 1_000
SEQUENCE = '[sequence]\nrepeat = false\nstart = "go"\nsteps = ["first"]\n'


def rows(run: Run) -> dict:
    return {(row.processor, row.task): row for row in run.system.rows()}


def times(run: Run, unit: str) -> list[int]:
    """When events of a unit were on slave 1, in us."""
    return [e.time_ns // US for e in run.events if e.unit == unit and e.processor == "slave1"]


def at_20(tmp_path: Path, cost: Cost | None, engine: str = "vm") -> Run:
    """One axis that moves, 20 scans of 10 ms after the start."""
    tmp_path.mkdir(exist_ok=True)
    run = Run(modules(tmp_path, SEQUENCE, slaves=1), engine, ("first.axis.position",), cost=cost)
    return run.scans(2).scans(20, go=True)


def test_a_transfer_reaches_its_algorithm_when_both_sides_have_taken_their_time(tmp_path: Path) -> None:
    """START has 3 parameters: 5 + 6 words. The master writes for 144 us, the slave reads for as long (its
    feedback has 5 + 8 words); then its next period begins the algorithm."""
    cost = Cost(frame=100 * US, word=4 * US)
    free, run = at_20(tmp_path / "free", Cost()), at_20(tmp_path / "timed", cost)
    sent = next(e.time_ns // US for e in run.events if e.unit == "C.SEND")
    assert times(free, A_START)[0] == sent and times(run, A_START)[0] == sent + 1000
    slow = at_20(tmp_path / "slow", Cost(frame=500 * US, word=4 * US))
    assert times(slow, A_START)[0] == sent + 2000, "2 * 544 us are over in the second period"
    counts = rows(run)["slave1", "communication"]
    assert counts.response_worst_us == 152 and counts.utilisation_percent > 0
    assert rows(free)["slave1", "communication"].utilisation_percent == 0
    assert not run.violations


def test_every_frame_costs_both_of_its_sides_once() -> None:
    memory, known = shared_words(bytearray(shared_size())), Algorithm(7, (Parameter(1, "i32", -10, 10),))
    links = Link(channel(1, True)), Link(channel(1, False))
    ends = [Endpoint(memory, *pair, Situation({7: known})) for pair in (links, links[::-1])]
    meters, spent = [Meter(1000, 1), Meter(1000, 1)], [0, 0]
    for _ in range(5):
        ends[0].send(7, Command.START, known.packed((3,)))
        for _ in range(4):
            for n, end in enumerate(ends):
                end.poll()
                spent[n] += meters[n].cost(end)
    assert spent == [5 * 1007, 5 * 1007]


def test_algorithms_take_time_and_what_they_give_is_told_when_it_is_over(tmp_path: Path) -> None:
    run = at_20(tmp_path, Cost(algorithm=300 * US))
    row = rows(run)["slave1", "algorithm"]
    assert (row.response_worst_us, row.overruns, row.utilisation_percent > 1) == (300, 0, True)
    assert len(times(run, A_EXEC)) == row.executions
    fed = [e.time_ns // US for e in run.events if e.unit == "A.FEEDBACK"]
    assert fed and not run.violations
    by_unit = at_20(tmp_path / "unit", Cost(algorithm=300 * US, algorithms=(("MOVER1", 70 * US),)))
    assert rows(by_unit)["slave1", "algorithm"].response_worst_us == 70


def test_an_algorithm_that_is_pre_empted_by_transfers_keeps_its_periods(tmp_path: Path) -> None:
    """Transfers come in between: some periods begin or end late, none is left out."""
    run = at_20(tmp_path, Cost(algorithm=900 * US, frame=20 * US, word=US))
    row, executed = rows(run)["slave1", "algorithm"], times(run, A_EXEC)
    assert row.missed == 0 and row.preemptions > 0
    assert [t // 1000 for t in executed] == list(range(executed[0] // 1000, executed[-1] // 1000 + 1))


@pytest.mark.parametrize("engine", ["vm", "native"])
def test_a_slave_that_is_late_three_times_in_a_row_ends_all_that_it_executes(tmp_path: Path, engine: str
                                                                            ) -> None:
    run = at_20(tmp_path, Cost(algorithm=1500 * US), engine)
    row = rows(run)["slave1", "algorithm"]
    assert row.watchdogs == 1 and row.missed >= 3
    (slave,) = run.system.slaves
    assert slave.state is Slave.ERROR and not slave.live
    assert run.get("first.axis.error") == 844 and not run.get("first.valve")
    (fault,) = run.system.findings
    assert "3 periods of 1 ms missed in a row, up to 1.5 ms" in fault.diagnostic().message
    assert "first.axis on slave1" in fault.diagnostic().message
    assert not run.violations


@pytest.mark.parametrize("engine", ["vm", "native"])
def test_a_slave_has_a_watchdog_of_its_own(tmp_path: Path, engine: str) -> None:
    """It comes in the first period that lasts too long; what lasts as long as it may does not wake it."""
    cost = Cost(algorithm=900 * US)
    run = Run(modules(tmp_path, SEQUENCE + '[watchdogs]\nslave1 = "800us"\n', slaves=1), engine, cost=cost)
    run.scans(2).scans(20, go=True)
    (slave,) = run.system.slaves
    assert slave.state is Slave.ERROR and len(times(run, A_EXEC)) == 1
    assert run.get("first.axis.error") == 831 and not run.get("first.valve")
    (fault,) = run.system.findings
    assert fault.code == "LD0831" and "takes 0.9 ms, 0.8 ms are allowed" in fault.diagnostic().message
    assert "first.axis on slave1" in fault.diagnostic().message and not run.violations
    patient = Run(modules(tmp_path, SEQUENCE + '[watchdogs]\nslave1 = "900us"\n', slaves=1), engine, cost=cost)
    assert not patient.scans(2).scans(20, go=True).system.findings


def test_two_engines_take_the_same_time(tmp_path: Path) -> None:
    cost = Cost(instruction=5 * US, task=3 * US, frame=30 * US, word=US, algorithm=200 * US)
    one, two = (at_20(tmp_path / engine, cost, engine) for engine in ("vm", "native"))
    assert one.events == two.events and one.rows == two.rows
    assert one.system.rows() == two.system.rows()


# ---- ldc run

def project(folder: Path, cost: str) -> Path:
    modules(folder, SEQUENCE + f"[cost]\n{cost}", slaves=2)
    mover(folder, "MOVER2", 2, 500)
    (folder / "in.csv").write_text("scan,go\n0,0\n2,1\n")
    return folder


def test_a_run_tells_what_slaves_took(tmp_path: Path, capfd) -> None:
    folder = project(tmp_path, 'frame = "40us"\n[cost.algorithms]\nmover1 = "250us"\n')
    assert main(["run", str(folder), "--inputs", str(folder / "in.csv"), "--scans", "30", "--timing", "-",
                 "--trace", str(folder / "t.csv")]) == 0
    found = {(r["processor"], r["task"]): r for r in csv.DictReader(io.StringIO(capfd.readouterr().out))}
    assert found["slave1", "algorithm"]["response_worst_us"] == "290.0", "a frame comes in between"
    assert found["master", "communication"]["response_worst_us"] == "40.0"
    assert found["slave2", "algorithm"]["executions"] == "0"


def test_costs_that_are_no_times_are_told_where_they_stand(tmp_path: Path, capfd) -> None:
    folder = project(tmp_path, 'word = "0us"\nalgorithm = 5\n[cost.algorithms]\nMOVER1 = "fast"\n')
    assert main(["run", str(folder)]) == 1
    shown = capfd.readouterr().err
    assert shown.count("[LD0612]") == 3
