"""The injection machine in virtual time: how much faster than time it runs, how soon its first scan is over.

7 modules of ladder every 10 ms, of 5 axes in C the one that moves every 1 ms, a plant every 1 ms. Asked:
50 virtual seconds a second on vm, the first scan within 0.5 s of the process's start (components compiled
before). All in time of the processor.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import _tables

SAMPLE = Path(__file__).resolve().parents[1] / "samples" / "injection_machine"
sys.path.insert(0, str(SAMPLE))
import runs  # noqa: E402

SPEED, START, SCANS, STEPS, BATCHES = 50.0, 0.5, 1600, 10_000, 5


def speeds(engine: str) -> list[float]:
    """Virtual seconds a second of the processor, of batches of two cycles each."""
    whole, _, _ = runs.system(runs.machine("slave"), "machine", 1, engine, watch=False)
    found = []
    for _ in range(BATCHES):
        begin = time.process_time()
        for _ in range(SCANS):
            whole.scan()
        found.append(SCANS * 0.01 / (time.process_time() - begin))
    return found


class Points(dict):
    """A field of plain values."""

    def reader(self, path: str):
        self.setdefault(path, 0.0)
        return lambda: self[path]

    def readers(self, paths: list[str]):
        each = [self.reader(path) for path in paths]
        return lambda: tuple([read() for read in each])

    def writer(self, path: str):
        return lambda value: self.__setitem__(path, value)


def plant_alone(reference: float) -> list[float]:
    """Microseconds a step of the plant while the clamp has a reference."""
    found, now, points = [], 0, Points()
    parameters = json.loads((SAMPLE / "plant.json").read_text())
    plant = runs.machine("slave").plant.Plant(points, parameters, 1)
    points["clamp.axis.reference"] = reference
    for _ in range(BATCHES):
        begin = time.process_time()
        for _ in range(STEPS):
            now += 1_000_000
            plant.step(now, 1_000_000)
        found.append((time.process_time() - begin) / STEPS * 1e6)
    return found


def starts() -> list[float]:
    """Seconds of a process that runs one scan and ends, and of its child."""
    command = [sys.executable, "-m", "ldc.cli", "run", str(SAMPLE), "--scans", "1", "--trace", os.devnull]
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    found = []
    for _ in range(BATCHES + 1):
        before = os.times()
        subprocess.run(command, check=True, capture_output=True, env=environment)
        after = os.times()
        found.append(sum(after[2:4]) - sum(before[2:4]))  # of children: user, system
    return found[1:]


def main() -> None:
    rows = []
    for engine in ("vm", "native"):
        found = speeds(engine)
        rows.append([f"virtual s a second, {engine}", _tables.spread(found, 1),
                     _tables.verdict(max(found), SPEED, at_least=True) if engine == "vm" else ""])
    for name, reference in (("at rest", 0.0), ("while an axis moves", 0.01)):
        rows.append([f"a step of the plant {name} (us)", _tables.spread(plant_alone(reference)), ""])
    found = starts()
    rows.append(["process to the end of one scan (s)", _tables.spread(found),
                 _tables.verdict(min(found), START, at_least=False)])
    _tables.show("injection machine", ("", "median (min .. max)", "asked"), rows,
                 "Time of the processor; the verdict is on the best batch: others use the machine too.")


if __name__ == "__main__":
    main()
