"""Online change of a large program: how long the swap holds up the scans, and how long an edit takes to run.

5,000 rungs in 50 modules, every 10th rung with a timer, every 20th with a counter; the change inserts one more
module of ten rungs in the middle. 200 swaps, there and back, between scans; the reference of a pause is the longest
scan of the same program without any change. Edit to live: from changed sources to the first scan, compile included,
against compiling and starting the new program alone.
"""

from __future__ import annotations

import gc
import statistics
import sys
import tempfile
import time
from pathlib import Path

import _tables

from ldc import pipeline
from ldc.cli import native
from ldc.il import image
from runtime.machine import Machine
from runtime.native.machine import Machine as Native
from runtime.online.controller import Controller, Loaded, prepare
from runtime.vm.machine import Machine as Virtual

MODULES, RUNGS, SWAPS, SCANS = 50, 100, 200, 3


def module(name: str, rungs: int, first: int) -> str:
    """A program of its own inputs and outputs."""
    variables, lines = [], []
    for n in range(rungs):
        bit = first + n
        variables += [f"a{n} AT %IX{bit // 8}.{bit % 8} : BOOL;", f"q{n} AT %QX{bit // 8}.{bit % 8} : BOOL;",
                      f"b{n}, c{n}, d{n} : BOOL;"]
        block = ""
        if n % 10 == 0:
            variables.append(f"t{n} : TON;")
            block = f"<t{n}: TON(PT := T#1s)> "
        elif n % 20 == 5:
            variables.append(f"k{n} : CTU;")
            block = f"<k{n}: CTU(PV := 1000)> "
        lines.append(f"RUNG r{n}\n{{ [a{n}] [/b{n}] | [P c{n}] | [q{n}] }} [/d{n}] {block}(q{n})")
    return "\n".join([f"PROGRAM {name}", "VAR", *variables, "END_VAR", *lines, "END_PROGRAM", ""])


def project(folder: Path, inserted: bool) -> None:
    names = [f"m{n}" for n in range(MODULES)]
    texts = [module(name, RUNGS, n * RUNGS) for n, name in enumerate(names)]
    texts.append(module("more", 10, MODULES * RUNGS))
    order = [*names[: MODULES // 2], "more", *names[MODULES // 2:]] if inserted else names
    (folder / "main.ld").write_text("\n".join(texts))
    listed = ", ".join(f'"{name}"' for name in order)
    (folder / "ldc.toml").write_text(f'[project]\nname = "bench"\nmodules = [{listed}]\n')


def made(folder: Path, engine: str, running: Loaded | None = None) -> Loaded:
    """The project compiled and ready to run."""
    previous = image.load(running.image).layout if running else None
    result = pipeline.compile_paths([str(folder)], pipeline.Options(keep=False, previous=previous))
    machine: Machine
    if engine == "vm":
        machine = Virtual(result.program)
    else:
        areas = dict(running.machine.plan.areas) if running else None
        machine = Native(result.program, native=native.loadable(native.artifact(result, 0, areas=areas)))
    return Loaded(machine, result.image.data, result.image.digest, ())


def timed(work) -> tuple[float, object]:
    """Milliseconds, and the result."""
    start = time.perf_counter()
    result = work()
    return (time.perf_counter() - start) * 1e3, result


def measure(engine: str, folder: Path) -> list[str]:
    project(folder, False)
    old = made(folder, engine)
    controller = Controller(old)
    scans = [timed(controller.scan)[0] for _ in range(SCANS * SWAPS)]
    project(folder, True)
    to_live, change = timed(lambda: prepare(old, made(folder, engine, old), old.digest, "bench"))
    controller.stage(change)
    gc.collect()
    gc.freeze()
    pauses, tests = [], []
    there, back = lambda: controller.test("bench", 10**12), lambda: controller.untest("bench")
    for n in range(SWAPS):
        pauses.append(timed((there, back)[n % 2])[0])
        tests += [timed(controller.scan)[0] for _ in range(SCANS)] if n % 2 == 0 else []
    alone, _ = timed(lambda: made(folder, engine))
    assert controller.machine.scans == SCANS * SWAPS + SCANS * SWAPS // 2 and not controller.machine.faults
    middle = statistics.median(scans)
    return [engine, f"{middle:.2f}", f"{max(scans):.2f}", _tables.spread(pauses, 2), f"{max(pauses) / middle:.2f}",
            f"{statistics.median(tests) / middle:.2f}", f"{to_live / alone:.2f}"]


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        rows = [measure(engine, Path(folder)) for engine in sys.argv[1:] or ("vm", "native")]
    _tables.show(f"{SWAPS} swaps of one module in a program of {MODULES * RUNGS} rungs",
                 ("engine", "scan ms", "longest", "swap ms", "longest / scan", "tested / scan", "edit to live / start"), rows,
                 "A test's scans keep the state before them, so that a fault can be undone.")


if __name__ == "__main__":
    main()
