"""Random drawings and statements, and every sample: native code does what the virtual machine does."""

from __future__ import annotations

import json
from pathlib import Path

import native
import pytest
import strategies
import test_engines
import test_samples
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from statements import programs

from ldc.cli.main import main
from runtime.vm.machine import Machine

pytestmark = native.needs_gcc
# Every example is compiled by gcc.
few = settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=16)


def alike(text: str, stimuli: list[dict[str, object]], path: str = "random.ld") -> None:
    result = test_engines.compiled(text, path)
    shallow = test_engines.compiled(text, path, max_paren_depth=0, verify=False)
    machines = [Machine(result.program, period_ns=test_engines.PERIOD),
                native.machine(result.program, test_engines.PERIOD),
                native.machine(shallow.program, test_engines.PERIOD)]
    for values in stimuli:
        told = []
        for machine in machines:
            for name, value in values.items():
                machine.set(name, value)
            machine.scan()
            told.append([f.message for f in machine.faults])
        # Of two faults in one expression the first in the order of instructions is told: parentheses matter.
        assert told[0] == told[1], text
        assert bool(told[0]) == bool(told[2]), text
        one, two, three = ({path: repr(machine.get(path)) for path, _ in machine.paths()} for machine in machines)
        assert one == two == three, text
        # Their temporaries and hidden memories differ where parentheses were taken out, states do not.
        assert machines[0].checksum() == machines[1].checksum(), text


@few
@given(strategies.programs(), st.lists(test_engines.booleans, min_size=1, max_size=6))
def test_networks_of_contacts_and_coils(text: str, stimuli: list) -> None:
    alike(text, stimuli)


@few
@given(test_engines.rungs, st.lists(test_engines.changes, min_size=1, max_size=6))
def test_blocks_values_and_jumps(lines: list[str], stimuli: list) -> None:
    body = "".join(f"RUNG r{n}\n    {line}\n" for n, line in enumerate(lines))
    alike(f"{test_engines.MINE}{test_engines.DECLARATIONS}{body}RUNG last [a0] (q3)\nEND_PROGRAM\n", stimuli)


@few
@given(programs, st.integers(-5, 5))
def test_statements(text: str, start: int) -> None:
    alike(text, [{"i0": start}, {}, {}], "main.st")


@test_samples.samples
def test_samples_give_their_traces(folder: Path, tmp_path: Path) -> None:
    assert main(["run", str(folder), "--engine", "native", "--trace", str(tmp_path / "trace.csv")]) == 0
    assert (tmp_path / "trace.csv").read_text() == (folder / "expected.csv").read_text()


@test_samples.samples
def test_random_inputs_end_in_the_same_state_on_both_engines(folder: Path, capsys: pytest.CaptureFixture) -> None:
    states = []
    for engine in ("vm", "native"):
        assert main(["bench", str(folder), "--engine", engine, "--stimulus", "random", "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert found["engine"] == engine
        states.append((found["state"], found["scans"]))
    assert states[0] == states[1]
