"""Master and slaves in virtual time: cases one and two of the papers, faults, emergency, the same bytes each
time (SPEC 2.5, 5, 6.3)."""

from __future__ import annotations

from pathlib import Path

import pytest
import systems
from systems import Run, modules

from runtime.processors.cases import CASE_ONE, CASE_TWO, violations
from runtime.processors.states import Master, Slave
from runtime.protocol.check import Code
from runtime.units import A_END, A_EXEC, A_START, C_BCAST, C_END, C_FEEDBACK, C_SEND, C_START

ENGINES = pytest.mark.parametrize("engine", ["vm", "native"])
SAFETY = '[safety]\nestop = "estop"\nreset = "reset"\n'
ONE = '[sequence]\nrepeat = false\nstart = "go"\nsteps = ["first", "second"]\n' + SAFETY
TWO = ('[sequence]\nrepeat = false\nstart = "go"\nsteps = ["first"]\n'
       '[messages.half]\nfrom = "first.half"\nto = ["second"]\n' + SAFETY)
WATCH = ("first.start", "first.done", "first.axis.position", "second.start", "second.axis.position", "%QX0.1")


def through(run: Run) -> bool:
    return run.units(C_END)[-2:] != [] and len(run.units(C_END)) == 2


@ENGINES
def test_case_one(tmp_path: Path, engine: str) -> None:
    """Two modules one behind the other, each with an algorithm on a slave of its own."""
    run = Run(modules(tmp_path, ONE), engine).scans(2).scans(100, through, go=True)
    roles = {"module 1": 0, "module 2": 1, "algorithm 1": 1, "algorithm 2": 2}
    assert violations(CASE_ONE, run.events, roles) == []
    assert run.violations == []
    assert (run.get("first.axis.position"), run.get("second.axis.position")) == (10.0, 10.0)


@ENGINES
def test_case_two(tmp_path: Path, engine: str) -> None:
    """A message of the first module starts the second while the first still moves."""
    run = Run(modules(tmp_path, TWO), engine).scans(2).scans(100, through, go=True)
    message = run.units(C_BCAST)[0][1]
    roles = {"module 1": 0, "module 2": 1, "algorithm 1": 1, "algorithm 2": 2, "message": message}
    assert violations(CASE_TWO, run.events, roles) == []
    assert run.violations == []


def test_vm_and_native_and_another_run_give_the_same(tmp_path: Path) -> None:
    folder = modules(tmp_path, TWO)
    runs = [Run(folder, engine, WATCH).scans(2).scans(60, go=True) for engine in ("vm", "vm", "native")]
    assert runs[0].rows == runs[1].rows == runs[2].rows
    assert runs[0].events == runs[1].events == runs[2].events
    assert runs[0].trace == runs[1].trace == runs[2].trace
    assert runs[0].rows[-1][2] == 10.0


@ENGINES
def test_an_emergency_ends_everything_in_a_period_and_a_reset_leads_back(tmp_path: Path, engine: str) -> None:
    run = Run(modules(tmp_path, ONE), engine, WATCH).scans(2).scans(8, go=True)
    assert run.get("%QX0.1") and run.system.slaves[0].executing
    moved = run.get("first.axis.position")
    run.scans(1, estop=True)
    assert run.system.master.state is Master.ERROR
    assert [slave.state for slave in run.system.slaves] == [Slave.ERROR, Slave.ERROR]
    assert not run.get("%QX0.1") and not run.system.slaves[0].executing
    run.scans(5, reset=True).scans(2, reset=False)
    assert run.system.master.state is Master.ERROR, "not while the emergency lasts"
    run.scans(5, estop=False)
    assert run.system.master.state is Master.ERROR and not run.get("%QX0.1")
    assert [slave.state for slave in run.system.slaves] == [Slave.ERROR, Slave.ERROR]
    assert run.get("first.axis.position") == pytest.approx(moved, abs=2.0)
    run.scans(1, reset=True, go=False)
    assert run.system.master.state is Master.STOP
    run.scans(3, reset=False)
    assert [slave.state for slave in run.system.slaves] == [Slave.STOP, Slave.STOP]
    run.scans(100, through, go=True)
    assert run.get("second.axis.position") == 10.0
    assert run.violations == []


@ENGINES
def test_a_slave_that_does_not_answer_ends_its_module_and_no_other(tmp_path: Path, engine: str) -> None:
    """T_ack, retries, P_FAULT; outputs of that module safe; the others run on; a reset leads back."""
    toml = ('[sequence]\nrepeat = false\nstart = "go"\nsteps = ["first"]\n'
            '[messages.half]\nfrom = "first.half"\nto = ["second"]\n'
            '[messages.P_FAULT]\nclass = "system"\n'
            'to = [{ module = "third", flag = "fault", data = "what" }]\n'
            '[safe]\n"%QX0.1" = true\n' + SAFETY)
    folder = modules(tmp_path, toml, slaves=3)
    third = folder / "third.ld"
    third.write_text(third.read_text().replace(
        "target : REAL := 10.0;", "target : REAL := 10.0; fault : BOOL; what : UDINT;").replace(
        "    arrived : BOOL;", "    arrived : BOOL;\n    faults  : CTU;").replace(
        "RUNG move", "RUNG count\n    [fault] <faults: CTU(PV := 100)>\n\nRUNG move"))
    run = Run(folder, engine)
    silent = run.system.slaves[0]
    run.scans(2).scans(8, go=True)
    assert silent.state is Slave.RUN
    silent.communicate, silent.execute = (lambda: False), (lambda: None)
    run.scans(40, lambda r: (C_END, 0, "abort") in r.units(C_END))
    run.scans(40)
    assert sorted(run.units(C_END)) == [(C_END, 0, "abort"), (C_END, 1, "")]
    assert run.get("first.axis.error") == Code.SILENT and run.get("%QX0.1") is True
    assert not run.get("first.start")
    assert run.get("second.axis.position") == 10.0
    run.scans(3)
    assert run.get("third.faults.CV") == 1 and run.get("third.what") == Code.SILENT << 16 | 1
    assert run.units(C_SEND)[-1][0] == C_SEND
    assert not run.machine.faults
    (told,) = [found.diagnostic() for found in run.system.findings]
    assert told.code == "LD0845"
    assert told.message.startswith("slave1: it does not answer: `first.axis` was ended in scan ")


def test_an_error_of_an_algorithm_is_told_and_ends_it(tmp_path: Path) -> None:
    run = Run(modules(tmp_path, ONE)).scans(2)
    run.machine.set("first.target", 66.0)
    run.scans(10, go=True)
    assert run.get("first.axis.error") == 42
    assert (A_END, 1, "") in run.units(A_END) and run.units(A_START) == [(A_START, 1, "")]
    assert run.system.slaves[0].state is Slave.STOP and run.system.master.state is Master.RUN
    assert run.violations == []


def test_a_component_cannot_pretend_a_fault_of_its_slave(tmp_path: Path) -> None:
    """801 is LD0801, of IL on the slave: a component that sets it is told as 15, and others go on."""
    folder = modules(tmp_path, "".join(f'[messages.go{n}]\nfrom = "go"\nto = ["{name}"]\n'
                                       for n, name in enumerate(("first", "second"))))
    source = folder / "mover1.c"
    source.write_text(source.read_text().replace("error = 42", "error = 801"))
    run = Run(folder).scans(2)
    run.machine.set("first.target", 66.0)
    run.scans(10, go=True)
    assert run.get("first.axis.error") == 15 and run.get("second.axis.error") == 0
    assert [slave.state for slave in run.system.slaves] == [Slave.STOP, Slave.RUN]
    assert run.get("first.start") and run.violations == [] and run.system.findings == ()


def test_what_is_out_of_range_is_neither_started_nor_sent(tmp_path: Path) -> None:
    run = Run(modules(tmp_path, ONE)).scans(2)
    run.machine.set("first.target", 1000.0)
    run.scans(10, go=True)
    assert run.get("first.axis.error") == 7 and run.units(C_SEND) == []
    run.machine.set("first.target", 10.0)
    run.scans(5)
    assert run.units(C_SEND) == [(C_SEND, 1, "START")] and run.get("first.axis.error") == 0
    run.machine.set("first.target", 1000.0)
    before = run.get("first.axis.position")
    run.scans(3)
    assert run.get("first.axis.error") == 7 and run.units(C_SEND) == [(C_SEND, 1, "START")]
    assert run.get("first.axis.position") > before, "it goes on with what it was given before"
    run.machine.set("first.target", 8.0)
    run.scans(20, through_first)
    assert run.get("first.axis.position") == 8.0
    assert run.violations == []


def through_first(run: Run) -> bool:
    return run.units(C_END) != []


def test_a_fault_of_il_on_a_slave_ends_all_that_it_executes(tmp_path: Path) -> None:
    """The slave is in `serror`; the module of the other algorithm, which was not told, stands too."""
    folder = modules(tmp_path, '[safety]\nreset = "reset"\n', slaves=1)
    (folder / "divider.ldc.toml").write_text(systems.DIVIDER)
    (folder / "divider.st").write_text(
        "FUNCTION_BLOCK DIVIDER\npart := 100 / share; count := count + 1;\nEND_FUNCTION_BLOCK\n")
    manifest = folder / "ldc.toml"
    manifest.write_text(manifest.read_text().replace('"first"]', '"first", "parts"]'))
    (folder / "parts.ld").write_text(
        "PROGRAM parts\nVAR\n    share : DINT := 5;\n    one : DIVIDER;\n    lamp AT %QX1.0 : BOOL;\n"
        "END_VAR\nVAR_EXTERNAL\n    go : BOOL;\nEND_VAR\n"
        "RUNG\n    [go] <one: DIVIDER(share := share)> (lamp)\nEND_PROGRAM\n")
    first = folder / "first.ld"
    external = "VAR_EXTERNAL\n    go : BOOL;\nEND_VAR\nVAR\n    valve"
    first.write_text(first.read_text().replace("VAR\n    valve", external)
                     .replace("[start]", "[go]").replace("[/start]", "[/go]").replace("    start  : BOOL;\n", ""))
    run = Run(folder).scans(2).scans(5, go=True)
    assert run.get("parts.one.part") == 20 and run.get("%QX1.0") and run.system.slaves[0].executing == 0b11
    run.machine.set("parts.share", 0)
    run.scans(3)
    assert run.get("parts.one.error") == 801 and [f.code for f in run.system.faults] == ["LD0801"]
    assert run.system.slaves[0].state is Slave.ERROR and run.system.slaves[0].executing == 0
    assert not run.get("%QX1.0") and not run.get("%QX0.1")
    run.machine.set("parts.share", 4)
    run.scans(3)
    assert run.system.slaves[0].state is Slave.ERROR
    run.scans(2, go=False).scans(2, reset=True).scans(5, go=True, reset=False)
    assert run.get("parts.one.part") == 25 and run.get("parts.one.error") == 0
    assert run.get("%QX1.0") and run.system.slaves[0].executing == 0b11
    assert run.violations == []


def test_four_slaves_at_once(tmp_path: Path) -> None:
    toml = "".join(f'[messages.go{n}]\nfrom = "go"\nto = ["{name}"]\n'
                   for n, name in enumerate(("first", "second", "third", "fourth")))
    run = Run(modules(tmp_path, toml, slaves=4)).scans(2).scans(5, go=True)
    assert [slave.state for slave in run.system.slaves] == [Slave.RUN] * 4
    run.scans(100, lambda r: len(r.units(C_END)) == 4)
    assert [run.get(f"{n}.axis.position") for n in ("first", "second", "third", "fourth")] == [10.0] * 4
    assert len(run.units(A_EXEC)) > 4 * 90 and run.units(C_START) == [(C_START, n, "") for n in range(4)]
    assert run.system.master.state is Master.STOP
    assert run.violations == []


@pytest.mark.parametrize("period_us", [1000, 2000, 3000, 10_000])
def test_the_logic_sees_feedback_that_is_at_most_a_slave_period_old(tmp_path: Path, period_us: int) -> None:
    """A scan is 10 ms; also when the period of the slave is no part of it."""
    run = Run(modules(tmp_path, ONE, period_us=period_us)).scans(2).scans(9, go=True)
    ages, executed = [], 0
    for event in run.events:
        if event.unit == A_EXEC:
            executed = event.time_ns
        elif event.unit == C_FEEDBACK:
            ages.append(event.time_ns - executed)
    assert len(ages) >= 7 and max(ages) <= period_us * 1000 and min(ages) > 0


def test_feedback_is_not_more_frequent_than_the_scan(tmp_path: Path) -> None:
    run = Run(modules(tmp_path, ONE)).scans(2).scans(9, go=True)
    assert 6 <= len(run.units(C_FEEDBACK)) <= 9
