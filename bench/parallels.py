"""A series of 40 two-way parallels in one rung, against 40 and 80 contacts in series: it has 2^40 paths, of
which none may be walked.

The kinds alternate; each is compiled as a program of many such rungs, verification included. No two rungs have
the same contacts negated, so that each is compiled by itself.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import _tables
from ldc import pipeline

RUNGS, LENGTH, ROUNDS = 100, 40, 5
INPUTS = 2 * LENGTH


def program(items: Sequence[str]) -> str:
    """``items``: contacts and branches in series; ``[.x1]`` is a contact that is closed in some rungs."""
    lines = ["PROGRAM bench", "VAR"]
    lines += [f"    x{n} AT %IX{n // 8}.{n % 8} : BOOL;" for n in range(INPUTS)]
    lines += [f"    q{n} : BOOL;" for n in range(RUNGS)]
    lines.append("END_VAR")
    for n in range(RUNGS):
        network = (item.replace(".", "/" if n >> k % 7 & 1 else "") for k, item in enumerate(items))
        lines.append(f"RUNG {' '.join(network)} (q{n})")
    return "\n".join([*lines, "END_PROGRAM", ""])


def series(length: int) -> list[str]:
    return [f"[.x{n}]" for n in range(length)]


KINDS = {
    f"{LENGTH} contacts": series(LENGTH),
    f"{2 * LENGTH} contacts": series(2 * LENGTH),
    f"{LENGTH} two-way parallels": [f"{{ [.x{2 * n}] | [x{2 * n + 1}] }}" for n in range(LENGTH)],
}


def main() -> None:
    times: dict[str, list[float]] = {name: [] for name in KINDS}
    with tempfile.TemporaryDirectory() as folder:
        paths = {name: Path(folder, f"{n}.ld") for n, name in enumerate(KINDS)}
        for name, path in paths.items():
            path.write_text(program(KINDS[name]))
        for turn in range(ROUNDS + 1):
            for name, path in paths.items():
                start = time.perf_counter()
                result = pipeline.compile_paths([str(path)], pipeline.Options(keep=False))
                if turn:  # the first round warms up
                    times[name].append((time.perf_counter() - start) / RUNGS * 1e3)
                assert result.image is not None, list(result.diagnostics)
    few, many, wide = times.values()
    ratio, even = (statistics.median(w / s for w, s in zip(wide, other)) for other in (few, many))
    _tables.show(f"{RUNGS} rungs of 40 two-way parallels: time per rung, text to verified image",
                 ["rung", "median (min .. max)"],
                 [[name, _tables.spread(values, 2, "ms")] for name, values in times.items()],
                 f"parallels / {LENGTH} contacts: {ratio:.2f}, {_tables.verdict(ratio, 4, False)}\n"
                 f"parallels / {2 * LENGTH} contacts, as many as they have: {even:.2f}, "
                 f"{_tables.verdict(even, 2, False)}")


if __name__ == "__main__":
    main()
