"""Master and slaves in virtual time: cases one and two of the papers, faults, emergency, the same bytes each time
(SPEC 2.5, 5, 6.3)."""

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
