"""`ldc run --target`: firmware in QEMU, shown as any other run is."""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from ldc.cli import firmware
from ldc.cli.compiling import compiled, locator
from ldc.cli.console import Failure, UsageError, report, say
from ldc.cli.inputs import read
from ldc.cli.starting import displayed, resource_to_run, run_length, stimuli_of, watched
from ldc.render import plural
from runtime.firmware.machine import BrokenTrace
from runtime.values import milliseconds


def run(options: argparse.Namespace) -> int:
    """Status 1 when a task was stopped by a fault; the scans after it are still run and traced."""
    if options.engine == "native" or options.sanitize:
        raise UsageError("--target runs firmware: --engine and --sanitize are for runs on this computer")
    board, room = firmware.chosen(options.target, options.board)
    sources = read(options.sources)
    result = compiled(sources, called_on=options.target)
    machine = firmware.machine(result, resource_to_run(result), options.period, sources.manifest)
    stimuli = stimuli_of(options.inputs, sources.manifest, machine)
    names = watched(options.watch, sources.manifest, machine.symbols)
    scans = run_length(options, stimuli, machine)
    plan = firmware.planned(machine, result, board, room)
    with tempfile.TemporaryDirectory(prefix="ldc-") as folder:
        made = firmware.built(plan, Path(folder), "firmware")
        firmware.run(machine, made, names, scans, stimuli)
    try:
        with displayed(options, machine, names, None) as (scan, sample):
            for _ in range(scans):
                scan()
                sample()
    except BrokenTrace as error:
        raise Failure(f"the trace of the firmware is broken: {error}") from error
    length = milliseconds(scans * machine.period_ns)
    say(f"{plural(scans, 'scan')} on {board.name}, {length} ms of virtual time")
    return report((fault.diagnostic() for fault in machine.faults), locator(result))
