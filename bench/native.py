"""Native code against branch-free C written by hand: time of a scan, and time until it can be loaded.

The same random rungs (6 contacts, every 10th a TON, every 20th a CTU) as PLCopen XML and as C. Every round has new
rungs and an empty cache; each figure is the median of the ratios of its rounds. A scan is timed in C with all inputs
set at random before it; what both compute is compared.
"""

from __future__ import annotations

import os
import random
import re
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import _plcopen
import _programs
import _tables
import _yardstick
import cffi

ROUNDS, BATCHES, SCANS, ROWS = 3, 15, 2000, 64
SIZES = (1000, 5000)
BOUNDS = {1000: 5.0, 5000: 6.0}
GCC = ("gcc", "-std=gnu11", "-O1", "-fPIC", "-shared")
_DRIVER = """#include <stdint.h>
#include <string.h>
#include <time.h>
static double now(void) { struct timespec t; clock_gettime(CLOCK_MONOTONIC, &t); return t.tv_sec * 1e9 + t.tv_nsec; }
/* Nanoseconds of a scan of `plan` or, when that is 0, of `run`; with neither: of what surrounds it. */
double timed(void (*plan)(void *), int32_t (*run)(uint8_t *, uint32_t), uint8_t *memory, uint8_t *inputs,
             const uint8_t *drawn, long rows, long size, long scans) {
    double start = now();
    for (long i = 0; i < scans; i++) {
        memcpy(inputs, drawn + i % rows * size, size);
        *(int64_t *)memory += 10000000;
        if (plan) plan(memory); else if (run) run(memory, 0);
    }
    return (now() - start) / scans;
}
"""
_INTERFACE = """double timed(void (*)(void *), int32_t (*)(uint8_t *, uint32_t), uint8_t *, uint8_t *, const uint8_t *, long, long,
long); int32_t ldc_run(uint8_t *, uint32_t); uint64_t size(void); void scan(void *); uint8_t *inputs(void *);
uint8_t *results(void *);"""


def compiled(folder: Path, name: str, text: str) -> tuple[Path, float]:
    """A shared object of C by gcc -O1, and how many seconds that took."""
    source = folder / f"{name}.c"
    source.write_text(text)
    start = time.perf_counter()
    subprocess.run([*GCC, "-o", str(source.with_suffix(".so")), str(source)], check=True)
    return source.with_suffix(".so"), time.perf_counter() - start


def built(folder: Path, xml: Path) -> tuple[Path, float]:
    """``ldc build`` of an XML file as a process of its own, its cache in the folder; the shared object, seconds."""
    start = time.perf_counter()
    subprocess.run([str(Path(sys.executable).with_name("ldc")), "build", str(xml), "--target", "host", "-o",
                    str(folder / "build")], check=True, capture_output=True,
                   env={**os.environ, "XDG_CACHE_HOME": str(folder / "cache")})
    seconds = time.perf_counter() - start
    return next((folder / "build").glob("*.so")), seconds


def edited(text: str, dice: random.Random) -> str:
    """The XML with one contact turned from open to closed or back."""
    found = dice.choice(list(re.finditer(r'(<contact [^>]*negated=")(true|false)', text)))
    return text[:found.start(2)] + ("false" if found[2] == "true" else "true") + text[found.end(2):]


def scans(folder: Path, count: int, library: Path, by_hand: Path, dice: random.Random) -> list[tuple[float, float]]:
    """Nanoseconds of a scan, native and by hand, batch by batch."""
    import json

    ffi = cffi.FFI()
    ffi.cdef(_INTERFACE)
    driver = ffi.dlopen(str(compiled(folder, "driver", _DRIVER)[0]))
    native, plan = ffi.dlopen(str(library)), ffi.dlopen(str(by_hand))
    about = json.loads((folder / "build" / "native.json").read_text())
    memory = ffi.new("uint8_t[]", bytes.fromhex(about["initial"]))
    plant = ffi.new("uint8_t[]", plan.size())
    places = {path.rpartition(".")[2]: place["offset"] for path, place in about["variables"].items()}
    size = _programs.inputs_of(count)
    drawn = ffi.new("uint8_t[]", bytes(dice.getrandbits(1) for _ in range(ROWS * size)))
    own, other = memory + places["x0"], plan.inputs(plant)
    run, scan = ffi.addressof(native, "ldc_run"), ffi.addressof(plan, "scan")
    found = []
    for batch in range(BATCHES + 1):
        around = driver.timed(ffi.NULL, ffi.NULL, ffi.new("uint8_t[]", 8), own, drawn, ROWS, size, SCANS)
        one = driver.timed(ffi.NULL, run, memory, own, drawn, ROWS, size, SCANS) - around
        two = driver.timed(scan, ffi.NULL, plant, other, drawn, ROWS, size, SCANS) - around
        results = plan.results(plant)
        differ = [n for n in range(count) if memory[places[f"m{n}"]] != results[n]]
        assert not differ, f"rung {differ[0]} differs"
        if batch:  # the first warms up
            found.append((one, two))
    return found


def main(sizes: tuple[int, ...] = SIZES, rounds: int = ROUNDS) -> None:
    rows, notes = [], []
    scan_rows: list[list[float]] = [[], [], []]
    for count in sizes:
        building, again, hand = [], [], []
        for number in range(rounds):
            seed = random.SystemRandom().randrange(1 << 30)
            dice = random.Random(seed)
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                xml = folder / "plant.xml"
                text = _plcopen.plcopen_rungs(count, seed)
                xml.write_text(text)
                by_hand, seconds = compiled(folder, "by_hand", _yardstick.yardstick(count, seed))
                library, whole = built(folder, xml)
                if count == min(sizes):
                    pairs = scans(folder, count, library, by_hand, dice)
                    for kept, values in zip(scan_rows, (*zip(*pairs), [a / b for a, b in pairs])):
                        kept += values
                xml.write_text(edited(text, dice))
                _, edit = built(folder, xml)
            hand.append(seconds)
            building.append(whole)
            again.append(edit)
        ratio = statistics.median(b / h for b, h in zip(building, hand))
        after = statistics.median(a / h for a, h in zip(again, hand))
        rows += [[f"{count:,} rungs: gcc -O1 of the C by hand", _tables.spread(hand, 2, "s"), ""],
                 [f"{count:,} rungs: PLCopen XML to .so", _tables.spread(building, 2, "s"), f"{ratio:.2f}"],
                 [f"{count:,} rungs: one edited rung to .so", _tables.spread(again, 2, "s"), f"{after:.2f}"]]
        notes.append(f"build of {count:,}: {_tables.verdict(ratio, BOUNDS[count], False)}")
        if count == max(SIZES):
            notes.append(f"one edited rung of {count:,}: {_tables.verdict(after, 0.5, False)}")
    ratio = statistics.median(scan_rows[2])
    size = min(sizes)
    rows += [[f"{size:,} rungs: scan by hand", _tables.spread(scan_rows[1], 0, "ns"), ""],
             [f"{size:,} rungs: scan native", _tables.spread(scan_rows[0], 0, "ns"), f"{ratio:.2f}"]]
    notes.append(f"scan: {_tables.verdict(ratio, 1.25, False)}")
    _tables.show("native code against branch-free C by hand", ["what", "median (min .. max)", "ratio"], rows,
                 "\n".join(notes))


if __name__ == "__main__":
    # Sizes may be given, and how many rounds: bench/native.py 1000 1
    given = [int(text) for text in sys.argv[1:]]
    main(tuple(given[:-1]) or SIZES, given[-1] if given else ROUNDS)
