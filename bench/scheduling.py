"""What the scheduler takes of the computer, and what it costs the virtual machine to stop between two rungs.

An activation: three processors, a control thread of 10 ms, polls and algorithms of 1 ms, all without cost.
A scan: 200 rungs, executed at once, by pieces, and by pieces under the scheduler. Batches alternate; what is
measured is time of the processor.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import _programs
import _tables

from ldc import pipeline
from ldc.backends.c import build
from ldc.diagnostics import Diagnostics
from ldc.il.layout import lay_out
from ldc.il.program import Program
from runtime.cost import Cost, Costs
from runtime.native import paced as native_paced
from runtime.native.library import Code
from runtime.scheduler.scheduler import Scheduler
from runtime.scheduler.thread import Thread
from runtime.timing import Timing
from runtime.vm import machine, paced

RUNGS, SCANS, BATCHES, MS = 200, 40, 15, 1_000_000


def nothing(now_ns: int) -> None:
    """A thread without anything to do."""


def activations(log: list | None) -> float:
    """Microseconds an activation."""
    def thread(kind: str, period_ns: int | None) -> Thread:
        return Thread(kind, kind, period_ns, nothing)

    master = [thread("communication", MS), thread("control", 10 * MS), thread("customised", None),
              thread("diagnostics", 100 * MS)]
    slaves = [[thread("communication", MS), thread("algorithm", MS)] for _ in range(2)]
    scheduler = Scheduler([master, *slaves], log)
    begin = time.process_time()
    scheduler.run(500 * MS)
    passed = time.process_time() - begin
    return passed * 1e6 / sum(t.counts.executions for threads in scheduler.threads for t in threads)


def built(program: Program, cost: Cost) -> Code:
    """Its native code, to be executed by pieces."""
    plan = build.planned(program, lay_out(program), 0, cost=Costs(program, cost).one)
    made = build.built(plan, Diagnostics())
    if made is None:
        raise SystemExit("no C compiler")
    return Code(made.path, made.plan.block, made.plan.map)


def scans(scan: Callable[[], None]) -> float:
    """Microseconds a scan."""
    begin = time.process_time()
    for _ in range(SCANS):
        scan()
    return (time.process_time() - begin) * 1e6 / SCANS


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder, "bench.ld")
        source.write_text(_programs.simple_rungs(RUNGS))
        program = pipeline.compile_paths([str(source)]).program
    cost = Cost(instruction=100)
    fast = built(program, cost)
    ways = {"at once": machine.Machine(program).scan, "by pieces": paced.Machine(program, cost=cost).scan,
            "native code by pieces": native_paced.Machine(program, native=fast, cost=cost).scan,
            "by pieces, time goes on": Timing(paced.Machine(program, cost=cost)).scan}
    took: dict[str, list[float]] = {name: [] for name in ways}
    bare, logged = [], []
    for _ in range(BATCHES):
        bare.append(activations(None))
        logged.append(activations([]))
        for name, scan in ways.items():
            took[name].append(scans(scan))
    _tables.show("An activation that costs nothing", ("", "us: median (min .. max)"),
                 [("without a log", _tables.spread(bare)), ("with a log", _tables.spread(logged))])
    base = min(took["at once"])
    rows = [(name, _tables.spread(values, 1), f"{min(values) / base:.1f}") for name, values in took.items()]
    _tables.show(f"A scan of {RUNGS} rungs", ("", "us: median (min .. max)", "least / least at once"), rows)


if __name__ == "__main__":
    main()
