"""Random drawings and statements: firmware does what the virtual machine does, value by value, fault by fault."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
import test_engines
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from statements import programs

from ldc.cli import firmware
from ldc.components import toolchain
from runtime.stimuli import Stimuli
from runtime.values import coerce
from runtime.vm.machine import Machine

MISSING = ", ".join(t.command for t in (toolchain.ARM_GCC, toolchain.QEMU_ARM) if toolchain.find(t) is None)
pytestmark = pytest.mark.skipif(bool(MISSING), reason=f"{MISSING} not installed: script/bootstrap --with-arm")
# Every example is compiled and run in QEMU.
few = settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=8)


def alike(text: str, stimuli: list[dict[str, object]], path: str = "random.ld") -> None:
    result = test_engines.compiled(text, path)
    machine = Machine(result.program, period_ns=test_engines.PERIOD)
    other = firmware.machine(result, 0, test_engines.PERIOD, None)
    names = [path for path, _ in machine.paths()]
    rows = {scan: tuple((s, coerce(value, s.type)) for name, value in values.items() for s in other.find([name]))
            for scan, values in enumerate(stimuli)}
    on, _ = firmware.chosen("cortex-m3", None)
    with tempfile.TemporaryDirectory() as folder:
        made = firmware.built(firmware.planned(other, result, on, None), Path(folder), "random")
        firmware.run(other, made, names, len(stimuli), Stimuli(rows))
    for values in stimuli:
        for name, value in values.items():
            machine.set(name, value)
        machine.scan()
        other.scan()
        assert [f.message for f in machine.faults] == [f.message for f in other.faults], text
        assert [f.place for f in machine.faults] == [f.place for f in other.faults], text
        one, two = ({name: repr(m.get(name)) for name in names} for m in (machine, other))
        assert one == two, text
    assert machine.checksum() == other.checksum(), text


@few
@given(test_engines.rungs, st.lists(test_engines.changes, min_size=1, max_size=6))
def test_blocks_values_and_jumps(lines: list[str], stimuli: list) -> None:
    body = "".join(f"RUNG r{n}\n    {line}\n" for n, line in enumerate(lines))
    alike(f"{test_engines.MINE}{test_engines.DECLARATIONS}{body}RUNG last [a0] (q3)\nEND_PROGRAM\n", stimuli)


@few
@given(programs, st.integers(-5, 5))
def test_statements(text: str, start: int) -> None:
    alike(text, [{"i0": start}, {}, {}], "main.st")
