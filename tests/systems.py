"""Projects with slaves, written into a folder, and what is seen of them while they run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

import pauses
import pytest

from ldc import pipeline
from ldc.cli import system as systems
from ldc.cli.compiling import native_code
from ldc.cli.starting import start
from runtime.cost import Cost
from runtime.machine import Machine
from runtime.processors.invariants import Entry, violations
from runtime.system import System
from runtime.units import UnitEvent

REAL_TIME = [pytest.mark.real_time, pytest.mark.xdist_group("real time"),
             pytest.mark.flaky(reruns=pauses.TRIES - 1, reruns_delay=1)]
"""Of tests that run in real time: they claim the same processors of the computer, so they go one after the
other, and they measure it too: one that fails is tried again, which the summary tells, and is skipped at last
when the computer paused each time (``tests/conftest.py``)."""

MOVER_C = """\
#include "{low}.h"

void {low}(const {low}_in *in, {low}_out *out, {low}_state *state, uint32_t dt_us)
{{
    float step = in->speed * (float)dt_us * 1e-6f, rest = in->target - out->position;
    if (in->enable && rest != 0.0f) {{
        out->position = rest > step ? out->position + step : rest < -step ? out->position - step : in->target;
        state->way += step;
    }}
    out->there = in->enable && out->position == in->target;
    if (in->target == 66.0f)
        out->error = 42;
}}
"""

MOVER = """\
[component]
name = "{name}"
id = "test.{low}"
[requires]
inputs = [{{ name = "target", type = "REAL", unit = "mm", min = -100.0, max = 100.0 }}]
[provides]
power = "there"
outputs = [{{ name = "there", type = "BOOL" }}, {{ name = "position", type = "REAL", unit = "mm" }}]
[properties]
parameters = [{{ name = "speed", type = "REAL", unit = "mm/s", value = 100.0 }}]
state = [{{ name = "way", type = "REAL", unit = "mm" }}]
[function]
language = "c"
entry = "{low}"
sources = ["{low}.c"]
processor = "slave{slave}"
period_us = {period}
"""

DIVIDER = """\
[component]
name = "DIVIDER"
id = "test.divider"
[requires]
inputs = [{ name = "share", type = "DINT" }]
[provides]
outputs = [{ name = "count", type = "DINT" }, { name = "part", type = "DINT" }]
[function]
language = "st"
sources = ["divider.st"]
processor = "slave1"
period_us = 2000
"""

MODULE = """\
PROGRAM {name}
VAR_INPUT
    start  : BOOL;
    target : REAL := 10.0;
END_VAR
VAR_OUTPUT
    done : BOOL;
    half : BOOL;
END_VAR
VAR
    valve   AT %QX0.{number} : BOOL;
    axis    : {mover};
    arrived : BOOL;
END_VAR

RUNG move
    [start] [/arrived] (valve) <axis: {mover}(target := target)> (S arrived)

RUNG rest
    [/start] (R arrived)

RUNG told
    [arrived] (done)

RUNG middle
    [start] [axis.position > 5.0] (half)
END_PROGRAM
"""

IO = """\
VAR_GLOBAL
    go     AT %IX0.0 : BOOL;
    reset  AT %IX0.6 : BOOL;
    estop  AT %IX0.7 : BOOL;
END_VAR
"""


def mover(folder: Path, name: str, slave: int, period_us: int = 1000) -> None:
    """A component that moves to its target, in C, executed by a slave."""
    given = {"name": name, "low": name.lower(), "slave": slave, "period": period_us}
    (folder / f"{name.lower()}.ldc.toml").write_text(MOVER.format(**given))
    (folder / f"{name.lower()}.c").write_text(MOVER_C.format(**given))


def modules(folder: Path, toml: str, slaves: int = 2, period_us: int = 1000) -> Path:
    """Modules `first`, `second`, ..., each with an axis of its own on slave1, slave2, ..."""
    names = ("first", "second", "third", "fourth")[:slaves]
    listed = ", ".join(f'"{name}"' for name in names)
    processors = "\n".join(f'slave{n} = "slave"' for n in range(1, slaves + 1))
    (folder / "ldc.toml").write_text(
        f'[project]\nmodules = [{listed}]\n[processors]\nmaster = "master"\n{processors}\n{toml}')
    (folder / "io.ld").write_text(IO)
    for number, name in enumerate(names, 1):
        mover(folder, f"MOVER{number}", number, period_us)
        (folder / f"{name}.ld").write_text(MODULE.format(name=name, mover=f"MOVER{number}", number=number))
    return folder


class Run:
    """A project that runs: ``trace`` for the invariants, ``events`` of units, ``rows`` of watched
    variables."""

    def __init__(self, folder: Path, engine: str = "vm", watch: tuple[str, ...] = (),
                 seen: bool = True, cost: Cost | None = None) -> None:
        self.result = pipeline.compile_paths([str(folder)])
        assert not self.result.diagnostics.has_errors, list(self.result.diagnostics)
        bindings = native_code(self.result)
        self.machine: Machine = start(self.result, None, self.result.sources.manifest, engine, bindings,
                                      cost)
        self.events: list[UnitEvent] = []
        self.trace: list[Entry] = []
        self.system: System = systems.system(
            self.result, self.machine, bindings, self.events, self.trace.append if seen else None, cost)
        self.watch, self.rows = watch, []

    def scans(self, count: int, until: Callable[[Run], bool] | None = None,
              **inputs: Mapping[str, object]) -> Run:
        """Sets inputs, then runs ``count`` scans, or fewer: until something is so."""
        for path, value in inputs.items():
            self.machine.set(path, value)
        for _ in range(count):
            self.system.scan()
            self.rows.append([self.system.machine.get(path) for path in self.watch])
            if until is not None and until(self):
                return self
        assert until is None, "it did not happen"
        return self

    def get(self, path: str) -> object:
        return self.system.machine.get(path)

    @property
    def violations(self) -> list[str]:
        return violations(self.trace, self.machine.period_ns)

    def units(self, *names: str) -> list[tuple[str, int, str]]:
        """Unit, index and detail of the events of some units, in order."""
        return [(e.unit, e.index, e.detail) for e in self.events if e.unit in names]
