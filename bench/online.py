"""Online change of a large program: how long a swap holds up the scans, how late they are meanwhile, and how long an
edit takes to run.

Swaps: 5,000 rungs in 50 modules, every 10th rung with a timer, every 20th with a counter; the change inserts one more
module of ten rungs in the middle. 200 swaps, there and back, between scans. Edit to live: one contact of 5,000 random
rungs of six contacts is edited; from the changed text to the first scan that executes it, scans going on every 10 ms,
against gcc -O1 on the C that a person would write for these rungs (``_yardstick``).
"""

from __future__ import annotations

import gc
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import _programs
import _tables
import _yardstick

from ldc import pipeline
from ldc.cli import native
from ldc.il import image
from ldc.pipeline.memory import Memory
from runtime.machine import Machine
from runtime.native.machine import Machine as Native
from runtime.online.controller import Controller, Loaded, Staged, prepare
from runtime.online.loading import load, undisturbed
from runtime.online.wire import Stage
from runtime.vm.machine import Machine as Virtual

MODULES, RUNGS, SWAPS, SCANS, PERIOD, SEED = 50, 100, 200, 3, 10_000_000, 11


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


def compiled(folder: Path, running: Loaded | None = None) -> pipeline.Compiled:
    """The project, its rungs remembered in the folder."""
    previous = image.layout_of(running.image) if running else None
    options = pipeline.Options(keep=False, previous=previous, memory=Memory(folder / "memory.rungs"))
    result = pipeline.compile_paths([str(folder)], options)
    assert result.image is not None, list(result.diagnostics)[:3]
    return result


def made(folder: Path, engine: str) -> Loaded:
    """The project compiled and ready to run."""
    result = compiled(folder)
    machine: Machine
    if engine == "vm":
        machine = Virtual(result.program, 0, PERIOD)
    else:
        machine = Native(result.program, 0, PERIOD, native=native.loadable(native.artifact(result, 0)))
    return Loaded(machine, result.image.data, result.image.digest, ())


def message(folder: Path, engine: str, running: Loaded) -> Stage:
    """What a client sends for the project as it is now."""
    result = compiled(folder, running)
    sent = Stage(image=result.image.data, sources=[], base=running.digest, owner="bench")
    if engine == "native":
        built = native.artifact(result, 0, areas=dict(running.machine.plan.areas))
        sent.library, sent.areas = built.path.read_bytes(), dict(built.plan.block.areas)
        sent.parts = [(name, list(firsts)) for name, firsts in built.plan.map]
    return sent


def staged(sent: Stage, running: Loaded, folder: Path) -> Staged:
    with undisturbed():
        return prepare(running, load(sent, running.machine, folder), running.digest, "bench")


def timed(work) -> tuple[float, object]:
    """Milliseconds, and the result."""
    start = time.perf_counter()
    result = work()
    return (time.perf_counter() - start) * 1e3, result


def swaps(engine: str, folder: Path) -> list[str]:
    project(folder, False)
    old = made(folder, engine)
    controller = Controller(old)
    scans = [timed(controller.scan)[0] for _ in range(SCANS * SWAPS)]
    project(folder, True)
    controller.stage(staged(message(folder, engine, old), old, folder))
    pauses, tests, busy = [], [], []
    there, back = lambda: controller.test("bench", 10**12), lambda: controller.untest("bench")
    for n in range(SWAPS):
        begin = time.thread_time()
        pauses.append(timed((there, back)[n % 2])[0])
        busy.append((time.thread_time() - begin) * 1e3)
        tests += [timed(controller.scan)[0] for _ in range(SCANS)]
    missed = 2 * SCANS * SWAPS - controller.machine.scans
    assert not controller.machine.faults
    return [engine, f"{statistics.median(scans):.2f}", _tables.spread(pauses, 2), _tables.spread(busy, 2),
            f"{statistics.median(tests) / statistics.median(scans):.2f}", str(missed),
            _tables.verdict(max(busy), 10, False)]


def edit(engine: str, folder: Path) -> tuple[list[float], list[float]]:
    """Seconds of each step of an edit, and how late scans are meanwhile, in milliseconds."""
    main = folder / "main.ld"
    text = _programs.mixed_rungs(MODULES * RUNGS, SEED)
    main.write_text(text)
    (folder / "ldc.toml").write_text("")
    old = made(folder, engine)
    controller = Controller(old)
    at = text.index("[/", len(text) // 2)
    main.write_text(f"{text[:at]}[{text[at + 2:]}")
    gc.collect()
    gc.freeze()
    own, sent = timed(lambda: message(folder, engine, old))
    found: list[tuple[float, Staged]] = []
    thread = threading.Thread(target=lambda: found.append(timed(lambda: staged(sent, old, folder))))
    thread.start()
    late, due = [], time.perf_counter()
    while thread.is_alive():
        controller.scan()
        due += PERIOD / 1e9
        left = due - time.perf_counter()
        late.append(max(-left, 0.0) * 1e3)
        time.sleep(max(left, 0.0))
        due = max(due, time.perf_counter() - PERIOD / 1e9)
    (beside, change), = found
    controller.stage(change)
    live, _ = timed(lambda: (controller.test("bench"), controller.scan()))
    return [own / 1e3, beside / 1e3, live / 1e3], late


def by_hand(folder: Path) -> float:
    """Seconds of gcc -O1 on the same rungs as C."""
    source = folder / "by_hand.c"
    source.write_text(_yardstick.yardstick(MODULES * RUNGS, SEED))
    command = ["gcc", "-std=gnu11", "-O1", "-fPIC", "-shared", "-o", str(folder / "by_hand.so"), str(source)]
    return timed(lambda: subprocess.run(command, check=True))[0] / 1e3


def main() -> None:
    sys.setswitchinterval(0.0005)  # as a runtime does
    engines = sys.argv[1:] or ("vm", "native")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "p").mkdir()
        rows = [swaps(engine, folder / "p") for engine in engines]
        _tables.show(f"{SWAPS} swaps of one module in a program of {MODULES * RUNGS} rungs",
                     ("engine", "scan ms", "swap ms", "of processor time", "tested / scan", "scans missed", "asked"), rows,
                     "A test's scans keep the state before them, so that a fault can be undone. Asked is of the "
                     "longest swap, in processor time: other work on the machine is none of its.")
        hand = by_hand(folder)
        found = {engine: edit(engine, folder / "p") for engine in engines}
    rows = [["gcc -O1 of the C by hand", f"{hand:.1f}", "", "", "", "", ""]]
    for engine, (steps, late) in found.items():
        rows.append([engine, f"{sum(steps):.1f}", *(f"{step:.2f}" for step in steps), f"{max(late):.0f}",
                     f"{sum(steps) / hand:.2f}"])
    _tables.show(f"one edited contact of {MODULES * RUNGS} rungs, until it runs",
                 ("engine", "s", "client", "loaded", "swap, scan", "latest scan ms", "ratio"), rows,
                 "asked: at most 0.5 of gcc on the C by hand")


if __name__ == "__main__":
    main()
