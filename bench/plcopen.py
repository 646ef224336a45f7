"""PLCopen XML to IL text and image, verified: whole processes of ``ldc compile``, start-up included.

Sizes alternate, so that noise hits all of them; the growth exponent is log(T large / T small) over
log(large / small): 1 is linear.
"""

from __future__ import annotations

import math
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

import _plcopen
import _tables

SIZES, ROUNDS = (1000, 5000), 3


def measured(command: list[str]) -> tuple[float, float, float, str]:
    """Seconds on the wall and of processor time, peak megabytes and standard error of a process."""
    with tempfile.TemporaryFile() as said:
        start = time.perf_counter()
        child = os.posix_spawn(command[0], command, os.environ,
                               file_actions=[(os.POSIX_SPAWN_DUP2, said.fileno(), 2)])
        _, status, usage = os.wait4(child, 0)
        seconds = time.perf_counter() - start
        said.seek(0)
        text = said.read().decode()
    assert status == 0, text
    return seconds, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, text


def main() -> None:
    times: dict[int, list[float]] = {size: [] for size in SIZES}
    busy: dict[int, list[float]] = {size: [] for size in SIZES}
    peaks: dict[int, float] = dict.fromkeys(SIZES, 0.0)
    stages = ""
    with tempfile.TemporaryDirectory() as folder:
        for size in SIZES:
            Path(folder, f"{size}.xml").write_text(_plcopen.plcopen_rungs(size))
        for _ in range(ROUNDS):
            for size in SIZES:
                seconds, processor, peak, stages = measured(
                    [str(Path(sys.executable).with_name("ldc")), "compile", str(Path(folder, f"{size}.xml")),
                     "--timings", "-o", str(Path(folder, "out.il"))])
                times[size].append(seconds)
                busy[size].append(processor)
                peaks[size] = max(peaks[size], peak)
    small, large = SIZES
    growth = statistics.median(math.log(b / a) / math.log(large / small)
                               for a, b in zip(times[small], times[large]))
    slowest = max(statistics.median(times[size]) / size * 1e3 for size in SIZES)
    _tables.show("PLCopen XML to IL text and image, verified: 6 contacts a rung, every 10th a TON, "
                 "every 20th a CTU; median (min .. max)",
                 ["rungs", "a rung, start-up counted", "processor time", "process", "memory"],
                 [[f"{size:,}", _tables.spread([t / size * 1e3 for t in times[size]], 3, "ms"),
                   _tables.spread([t / size * 1e3 for t in busy[size]], 3, "ms"),
                   f"{statistics.median(times[size]):.2f} s", f"{peaks[size]:.0f} MB"] for size in SIZES],
                 f"growth exponent: {growth:.2f}, {_tables.verdict(growth, 1.1, False)}\n"
                 f"slowest: {slowest:.2f} ms a rung, {_tables.verdict(slowest, 1.2, False)}; "
                 f"memory {_tables.verdict(peaks[large], 500, False)} MB")
    rows = [line.split() for line in stages.splitlines()]
    _tables.show(f"where the time of {large:,} rungs goes", ["stage", "per rung", "share"],
                 [[" ".join(row[:-3]), f"{float(row[-3]) / large * 1e3:.0f} us", row[-1]]
                  for row in rows[:-1]])


if __name__ == "__main__":
    main()
