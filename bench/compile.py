"""Compile time per rung and memory, verification included, from 100 to 10,000 rungs.

Every compile is a process of its own (start-up not counted in the time per rung, since it is the
same for all sizes and is shown apart); sizes alternate, so that noise hits all of them.
"""

from __future__ import annotations

import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import _programs
import _tables

SIZES, ROUNDS = (100, 1000, 10_000), 3


def child(path: str) -> None:
    start = time.perf_counter()
    from ldc import pipeline

    loaded = time.perf_counter()
    result = pipeline.compile_paths([path], pipeline.Options(keep=False))
    done = time.perf_counter()
    assert result.image is not None, list(result.diagnostics)[:3]
    verdicts = {r.verdict.kind for rungs in result.units.values() for r in rungs}
    print(json.dumps({
        "start": loaded - start, "compile": done - loaded, "stages": result.timings,
        "verdicts": sorted(verdicts), "peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}))


def main() -> None:
    runs: dict[int, list[dict]] = {size: [] for size in SIZES}
    with tempfile.TemporaryDirectory() as folder:
        for size in SIZES:
            Path(folder, f"{size}.ld").write_text(_programs.mixed_rungs(size))
        for _ in range(ROUNDS):
            for size in SIZES:
                command = [sys.executable, __file__, "--child", str(Path(folder, f"{size}.ld"))]
                out = subprocess.run(command, check=True, capture_output=True, text=True)
                runs[size].append(json.loads(out.stdout))
    rows = []
    for size in SIZES:
        each = [r["compile"] / size * 1e3 for r in runs[size]]
        rows.append([f"{size:,}", _tables.spread(each, 3, "ms"),
                     f"{statistics.median(r['start'] for r in runs[size]) * 1e3:.0f} ms",
                     f"{max(r['peak'] for r in runs[size]):.0f} MB"])
    growth = statistics.median(
        (large["compile"] / SIZES[-1]) / (small["compile"] / SIZES[0])
        for small, large in zip(runs[SIZES[0]], runs[SIZES[-1]]))
    slowest = max(statistics.median(r["compile"] / size * 1e3 for r in runs[size]) for size in SIZES)
    peak = max(r["peak"] for r in runs[SIZES[-1]])
    _tables.show("text to verified image: 6 contacts a rung, every 10th a TON, every 20th a CTU",
                 ["rungs", "per rung: median (min .. max)", "import", "peak memory"], rows,
                 f"growth of the time per rung from {SIZES[0]} to {SIZES[-1]:,}: {growth:.2f} times, "
                 f"{_tables.verdict(growth, 1.3, False)}\n"
                 f"slowest: {slowest:.2f} ms a rung, {_tables.verdict(slowest, 2, False)}; "
                 f"memory {_tables.verdict(peak, 1000, False)} MB")
    stages = runs[SIZES[-1]][0]["stages"]
    total = sum(stages.values())
    _tables.show(f"where the time of {SIZES[-1]:,} rungs goes", ["stage", "per rung", "share"],
                 [[name, f"{seconds / SIZES[-1] * 1e6:.0f} us", f"{seconds / total:.0%}"]
                  for name, seconds in sorted(stages.items(), key=lambda item: -item[1])])


if __name__ == "__main__":
    child(sys.argv[2]) if sys.argv[1:2] == ["--child"] else main()
