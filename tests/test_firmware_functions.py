"""Every standard function gives on a Cortex-M3 what the library says, on values at the edges."""

from __future__ import annotations

import math
import random
from pathlib import Path

import pytest
from test_library_machine import GROUPS
from test_native_functions import program_of, wanted

from ldc.backends.firmware import plan, qemu, tools
from ldc.backends.firmware.board import known
from ldc.backends.firmware.plan import TaskPlan
from ldc.components import toolchain
from ldc.diagnostics import Diagnostics
from ldc.il import block
from ldc.il.layout import lay_out
from ldc.library import functions
from ldc.types import LREAL
from runtime.firmware.machine import Machine
from runtime.stimuli import Stimuli
from runtime.values import coerce

MISSING = ", ".join(t.command for t in (toolchain.ARM_GCC, toolchain.QEMU_ARM) if toolchain.find(t) is None)
pytestmark = pytest.mark.skipif(bool(MISSING), reason=f"{MISSING} not installed: script/bootstrap --with-arm")
SCANS = 8
BOARD = known()["mps2-an385"]


@pytest.mark.parametrize("group", GROUPS)
def test_firmware_computes_what_the_library_means(group: str, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(plan, "FLAGS", tuple("-O0" if flag == "-Os" else flag for flag in plan.FLAGS))
    dice = random.Random(group)
    found, program = program_of(group)
    memory = block.make(program, lay_out(program))
    machine = Machine(program, 0, 1, block=memory, parts=())
    results = machine.find([f"q{at}" for at in range(len(found))])
    rows, expected = {}, []
    for scan in range(SCANS):
        row, line = [], []
        for at, call in enumerate(found):
            values, result = wanted(call, functions.meaning(call.name, call.parameters, call.result), dice)
            symbols = machine.find([f"a{at}_{n}" for n in range(len(values))])
            row += [(s, coerce(v, s.type)) for s, v in zip(symbols, values, strict=True)]
            line.append((call, values, result))
        rows[scan] = tuple(row)
        expected.append(line)
    tasks = [TaskPlan(s.task.name, 0, s.task.watchdog, s.runs, None, ()) for s in machine.schedules]
    made = plan.plan(memory, BOARD, 1, tasks)
    machine.parts = made.code.map
    diagnostics = Diagnostics()
    firmware = tools.build(made, tmp_path, "functions", diagnostics)
    assert firmware is not None, [d.message for d in diagnostics]
    job = machine.job(SCANS, results, Stimuli(rows))
    trace = qemu.run(BOARD, [firmware.images[0].elf], job, 60, diagnostics)
    assert trace is not None, [d.message for d in diagnostics]
    machine.replay(trace)
    for line in expected:
        machine.scan()
        assert not machine.faults
        for symbol, (call, values, result) in zip(results, line, strict=True):
            given = machine.value(symbol)
            # The functions of LREAL are those of newlib: the last bit may be another one.
            near = call.result == LREAL and given != result and math.isclose(given, result, rel_tol=4e-16)
            assert near or repr(given) == repr(result), (call.name, *map(str, call.parameters), *values)
