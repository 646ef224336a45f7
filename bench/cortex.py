"""Firmware against branch-free C written by hand, on the same Cortex-M3: instructions and flash for a
contact.

Both are in one image, compiled with the same flags (-Os). QEMU counts instructions (``-icount``: SysTick goes
by them); all inputs are set at random before each scan, and all results are compared. New random rungs in
every round. """

from __future__ import annotations

import random
import re
import statistics
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import _programs
import _tables
import _yardstick

from ldc import pipeline
from ldc.backends.c.emit import File
from ldc.backends.firmware import qemu, report
from ldc.cli import firmware
from ldc.components import toolchain
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile

COUNT, ROUNDS, SCANS, BOUND = 1000, 3, 20, 1.3
# An instruction takes 2^7 ns of virtual time, a tick of the 25 MHz board 40 ns.
SHIFT, TICKS = 7, 128 / 40
_MAIN = """#include "firmware.h"
extern uint8_t *inputs(void *plant), *results(void *plant);
extern void scan(void *plant);
extern uint64_t size(void);
static const uint32_t places[] = {{ {places} }};
static uint64_t plant[{words}];
static uint32_t dice = {seed}u;
#define SYSTICK ((volatile uint32_t *)0xE000E010u)

static uint32_t random_bit(void) {{
    dice ^= dice << 13;
    dice ^= dice >> 17;
    dice ^= dice << 5;
    return dice >> 31;
}}

void ldc_on_fault(uint32_t task) {{ (void)task; ldc_exit(9); }}

static void nothing(uint8_t *m) {{ (void)m; }}

/* Ticks of a call; the function is called by its address in all three cases. */
static uint32_t timed(void (*volatile what)(uint8_t *), uint8_t *argument) {{
    SYSTICK[2] = 0;
    uint32_t begin = SYSTICK[2];
    what(argument);
    return (begin - SYSTICK[2]) & 0xFFFFFF;
}}

static void ours(uint8_t *m) {{ ldc_run(m, 0); }}
static void by_hand(uint8_t *m) {{ scan(m); }}

int ldc_job(void) {{
    if (size() > sizeof plant) ldc_exit(10);
    SYSTICK[1] = 0xFFFFFF;
    SYSTICK[0] = 5;
    int64_t now = 0;
    for (int n = 0; n < {scans}; n++) {{
        for (int i = 0; i < {inputs}; i++)
            ldc_block[{first} + i] = inputs(plant)[i] = (uint8_t)random_bit();
        LDC_SYSTEM(ldc_block)->now = now;
        *(int64_t *)plant = now;
        uint32_t empty = timed(nothing, ldc_block);
        uint32_t one = timed(ours, ldc_block) - empty, two = timed(by_hand, (uint8_t *)plant) - empty;
        ldc_puts("scan ");
        ldc_put_hex(one);
        ldc_puts(" ");
        ldc_put_hex(two);
        ldc_puts("\\n");
        for (int i = 0; i < {count}; i++)
            if (ldc_block[places[i]] != results(plant)[i]) ldc_exit(11);
        now += 10000000;
    }}
    ldc_exit(0);
}}
"""


def measured(count: int, seed: int) -> tuple[list[tuple[float, float]], tuple[int, int], int]:
    """Instructions of each scan and bytes of flash, ours and by hand; how many contacts there are."""
    source = SourceFile("bench.ld", _programs.mixed_rungs(count, seed))
    result = pipeline.compile_project(Sources((source,), Settings(), None), pipeline.Options(verify=False))
    machine = firmware.machine(result, 0, None, None)
    board, _ = firmware.chosen("cortex-m3", "mps2-an385")
    plan = firmware.planned(machine, result, board, None)
    at = {path.rpartition(".")[2]: machine.spot(machine.find([path])[0]).offset for path, _ in machine.paths()
          if re.fullmatch(r"\w+\.[mx]\d+", path)}
    inputs = _programs.inputs_of(count)
    text = _MAIN.format(places=", ".join(str(at[f"m{n}"]) for n in range(count)), count=count, inputs=inputs,
                        words=(40 * count + inputs) // 8 * 3, seed=seed | 1, scans=SCANS, first=at["x0"])
    image = plan.images[0]
    kept = [file for file in image.files if file.name != "job.c"]
    files = (*kept, File("bench.c", text, f"bench {text}"),
             File("by_hand.c", made := _yardstick.yardstick(count, seed), f"by hand {made}"))
    plan = replace(plan, images=(replace(image, files=files),))
    with tempfile.TemporaryDirectory() as folder:
        built = firmware.built(plan, Path(folder), "bench").images[0]
        sizes = report.of_files(built)
        names = {file.name for file in plan.code.files} - {"ldc_runtime.c", "main.c"}
        flash = sum(sizes.get(name, 0) for name in names)
        command = [*qemu.command(toolchain.find(toolchain.QEMU_ARM), board), "-icount", f"shift={SHIFT}",
                   "-kernel", str(built.elf)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60,
                              stdin=subprocess.DEVNULL)
    if done.returncode:
        raise SystemExit(f"the firmware ended with {done.returncode}: {done.stdout[-300:]}")
    found = re.findall(r"scan (\w+) (\w+)", done.stdout)
    pairs = [(int(one, 16) / TICKS, int(two, 16) / TICKS) for one, two in found]
    blocks = [rung.block[0] for rung in _programs.mixed(count, seed) if rung.block is not None]
    contacts = 6 * count + blocks.count("CTU")
    return pairs[1:], (flash, sizes["by_hand.c"]), contacts


def main(count: int = COUNT, rounds: int = ROUNDS) -> None:
    scans: list[list[float]] = [[], [], []]
    bytes_: list[list[float]] = [[], [], []]
    for _ in range(rounds):
        pairs, (flash, by_hand), contacts = measured(count, random.SystemRandom().randrange(1 << 30))
        for one, two in pairs:
            for kept, value in zip(scans, (one / contacts, two / contacts, one / two), strict=True):
                kept.append(value)
        for kept, value in zip(bytes_, (flash / contacts, by_hand / contacts, flash / by_hand), strict=True):
            kept.append(value)
    rows = [[f"{what}: {who}", _tables.spread(values[n]), "" if n else f"{statistics.median(values[2]):.2f}"]
            for what, values in (("instructions a contact", scans), ("bytes of flash a contact", bytes_))
            for n, who in ((0, "firmware"), (1, "C by hand"))]
    notes = [f"{what}: {_tables.verdict(statistics.median(values[2]), BOUND, False)}"
             for what, values in (("instructions", scans), ("flash", bytes_))]
    _tables.show(f"firmware for Cortex-M3 against branch-free C by hand, {count:,} rungs",
                 ["what", "median (min .. max)", "ratio"], rows, "\n".join(notes))


if __name__ == "__main__":
    # How many rungs and rounds may be given: bench/cortex.py 200 1
    main(*map(int, sys.argv[1:3]))
