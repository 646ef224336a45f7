"""Scan time of the VM against pyrung, the other PLC that runs ladder in Python.

Both execute 200 rungs of (a AND b OR c) AND NOT d; all 800 inputs are set at random before every scan,
through the way that each offers for it, and the setting is timed with the scan. Batches alternate, so
that the ratio does not depend on how busy the machine is; the outputs of both are compared.
"""

from __future__ import annotations

import random
import statistics
import tempfile
import time
from pathlib import Path

import _programs
import _tables

RUNGS, SCANS, BATCHES = 200, 30, 15
NAMES = [f"{name}{n}" for n in range(RUNGS) for name in "abcd"]


def vm():
    """How an input is named, a scan with inputs, and how output n is read."""
    from ldc import pipeline
    from runtime.vm.machine import Machine

    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "bench.ld")
        source.write_text(_programs.simple_rungs(RUNGS))
        program = pipeline.compile_paths([str(source)]).program
    machine = Machine(program)
    cells = {name: symbol.home.name for name, symbol in zip(NAMES, machine.find(NAMES), strict=True)}

    def scan(values: dict[str, bool]) -> None:
        machine.feed((values, ()))
        machine.scan()

    return cells.get, scan, lambda n: machine.get(f"q{n}")


def pyrung():
    """The same of pyrung, used as its documentation shows."""
    import pyrung as pr

    tags = {name: pr.Bool(name) for name in NAMES}
    outputs = [pr.Bool(f"q{n}") for n in range(RUNGS)]
    with pr.Program(strict=False) as logic:
        for n in range(RUNGS):
            a, b, c, d = (tags[f"{name}{n}"] for name in "abcd")
            with pr.rung(pr.Or(pr.And(a, b), c), ~d):
                pr.out(outputs[n])
    plc = pr.PLC(logic)

    def scan(values: dict[str, bool]) -> None:
        plc.patch(values)
        plc.step()

    return str, scan, lambda n: plc.state.tags.get(f"q{n}", False)


def main() -> None:
    rng = random.Random(1)
    engines = {"ldc vm": vm(), "pyrung": pyrung()}
    times: dict[str, list[float]] = {name: [] for name in engines}
    for batch in range(BATCHES + 1):
        drawn = [[rng.random() < 0.5 for _ in NAMES] for _ in range(SCANS)]
        for name, (key, scan, _) in engines.items():
            stimuli = [dict(zip(map(key, NAMES), values)) for values in drawn]
            start = time.perf_counter()
            for values in stimuli:
                scan(values)
            if batch:  # the first batch warms up
                times[name].append((time.perf_counter() - start) / SCANS / RUNGS * 1e6)
        for n in range(RUNGS):
            assert len({bool(read(n)) for _, _, read in engines.values()}) == 1, f"q{n} differs"
    ratio = statistics.median(p / v for p, v in zip(times["pyrung"], times["ldc vm"]))
    rows = [[name, _tables.spread(values, 3, "us")] for name, values in times.items()]
    rows.append(["pyrung / ldc vm", f"{ratio:.0f}"])
    _tables.show(f"{RUNGS} rungs of (a AND b OR c) AND NOT d, all inputs random: time per rung and scan",
                 ["engine", "median (min .. max)"], rows,
                 f"ratio, median of {BATCHES} paired batches: {_tables.verdict(ratio, 40, True)}")


if __name__ == "__main__":
    main()
