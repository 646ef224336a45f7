"""A slave that loses its power and has it again: in virtual time, as a plant says (SPEC 2.5, 5)."""

from __future__ import annotations

import json
from pathlib import Path

import native
import pytest
from systems import Run, modules

from runtime.processors.states import BEGUN_ANEW, Master, Slave
from runtime.protocol.check import Code
from runtime.units import C_END

ENGINES = pytest.mark.parametrize("engine", ["vm", pytest.param("native", marks=native.needs_gcc)])
TOML = ('[sequence]\nrepeat = false\nstart = "go"\nsteps = ["first"]\n'
        '[messages.half]\nfrom = "go"\nto = ["second"]\n[safety]\nestop = "estop"\nreset = "reset"\n'
        '[plant]\nfile = "plant.py"\nparameters = "plant.json"\n[run]\nperiod = "10ms"\n')
PLANT = """\
class Plant:
    def __init__(self, field, parameters, seed):
        self.times, self.silent = parameters["silent"], set()

    def step(self, now_ns, dt_ns):
        self.silent = {1} if any(a <= now_ns / 1e6 < b for a, b in self.times) else set()
"""


def started(folder: Path, engine: str, *silent: tuple[int, int]) -> Run:
    """slave1 has no power from ... to ... ms; both modules move from 20 ms on."""
    modules(folder, TOML)
    (folder / "plant.py").write_text(PLANT)
    (folder / "plant.json").write_text(json.dumps({"silent": silent}))
    return Run(folder, engine).scans(2).scans(4, go=True)


def told(run: Run) -> list[str]:
    return [found.diagnostic().code for found in run.system.findings]


@ENGINES
def test_a_slave_that_has_power_again_goes_on_after_a_reset(tmp_path: Path, engine: str) -> None:
    """It executes nothing by itself; its module stands, the other one does not notice."""
    run = started(tmp_path, engine, (60, 400))
    run.scans(34)
    slave, other = run.system.slaves
    stood = run.get("first.axis.position")
    assert run.get("first.axis.error") == Code.SILENT and 0.0 < stood < 10.0
    assert run.get("second.axis.position") == 10.0
    run.scans(5)
    assert slave.state is Slave.ERROR and not slave.executing and not slave.live
    assert run.get("first.axis.error") == BEGUN_ANEW and told(run) == ["LD0845", "LD0861"]
    assert run.system.master.state is Master.STOP and other.state is Slave.STOP
    run.scans(2, reset=True, go=False).scans(3, reset=False)
    assert slave.state is Slave.STOP
    run.scans(60, lambda r: r.units(C_END)[-1] == (C_END, 0, ""), go=True)
    assert run.get("first.axis.position") == 10.0
    assert told(run) == ["LD0845", "LD0861"] and run.violations == []


@ENGINES
def test_a_short_loss_of_power_is_found_when_it_ends(tmp_path: Path, engine: str) -> None:
    """Before anybody waits for an answer: the slave says so itself, and does not go on with what it did."""
    run = started(tmp_path, engine, (70, 73))
    run.scans(3)
    assert run.get("first.axis.error") == BEGUN_ANEW and told(run) == ["LD0861"]
    assert not run.get("first.start") and (C_END, 0, "abort") in run.units(C_END)
    stood = run.get("first.axis.position")
    run.scans(10)
    assert run.get("first.axis.position") == stood < 10.0
    run.scans(40, lambda r: r.get("second.axis.position") == 10.0)
    run.scans(2, reset=True, go=False).scans(2, reset=False)
    run.scans(60, lambda r: r.get("first.axis.position") == 10.0, go=True)
    assert run.violations == []


def test_a_reset_in_vain_is_told_once_more(tmp_path: Path) -> None:
    run = started(tmp_path, "vm", (60, 500))
    run.scans(30).scans(1, reset=True, go=False).scans(10, reset=False)
    assert told(run) == ["LD0845", "LD0845"]
    run.scans(10)
    assert told(run) == ["LD0845", "LD0845", "LD0861"]
    run.scans(1, reset=True).scans(3, reset=False)
    run.scans(60, lambda r: r.get("first.axis.position") == 10.0, go=True)


def test_what_is_retained_comes_back_as_it_was_saved(tmp_path: Path) -> None:
    """`way` of the axis is retained, its position is not."""
    modules(tmp_path, TOML)
    descriptor = tmp_path / "mover1.ldc.toml"
    descriptor.write_text(descriptor.read_text().replace(
        'name = "way", type = "REAL"', 'name = "way", retain = true, type = "REAL"'))
    (tmp_path / "plant.py").write_text(PLANT)
    (tmp_path / "plant.json").write_text(json.dumps({"silent": [(80, 85)]}))
    run = Run(tmp_path).scans(2).scans(5, go=True)

    def way() -> bytes:
        return next(entry.data for entry in run.system.retained()() if entry.path == "FIRST.AXIS.WAY")

    saved = way()
    assert saved != bytes(4)
    run.scans(10)
    assert way() == saved and run.get("first.axis.error") == BEGUN_ANEW
    again = run.system.slaves[0]
    assert next(s for s in again.retained() if s.path == "FIRST.AXIS.WAY").data == saved


@ENGINES
def test_a_slave_that_begins_without_power(tmp_path: Path, engine: str) -> None:
    run = started(tmp_path, engine, (0, 55))
    assert run.get("first.axis.position") == 0.0
    run.scans(20)
    assert run.get("first.axis.error") == BEGUN_ANEW
    run.scans(1, reset=True, go=False).scans(3, reset=False)
    run.scans(60, lambda r: r.get("first.axis.position") == 10.0, go=True)
    assert run.violations == []
