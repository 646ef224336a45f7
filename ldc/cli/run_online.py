"""`ldc run --online`: scans at their time, and a socket by which the program is changed meanwhile."""

from __future__ import annotations

import argparse
import io
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import BinaryIO

from ldc import pipeline
from ldc.cli import link, shipped
from ldc.cli import system as systems
from ldc.cli.attached import attached
from ldc.cli.compiling import locator
from ldc.cli.console import Failure, report, say
from ldc.cli.output import replacing
from ldc.cli.run import is_system, run_length, start, stimuli_of, watched
from ldc.cli.run_options import shows
from ldc.cli.watching import ChangeLines
from ldc.il.external import Binding
from ldc.manifest import Sources
from ldc.render import plural, visible
from runtime.machine import Machine
from runtime.online.audit import Audit
from runtime.online.checks import Limits
from runtime.online.controller import Controller, Loaded
from runtime.online.server import Busy, Server
from runtime.trace import Trace
from runtime.values import milliseconds

_SLICE = 0.02
"""Seconds between two looks at requests while the next scan is waited for."""

_SWITCH = 0.0005
"""Seconds that a thread which loads a program keeps the one that scans waiting."""

Observer = Trace | ChangeLines


def run(options: argparse.Namespace, sources: Sources, result: pipeline.Compiled, beat: Callable[[], None],
        file: BinaryIO | None = None, bindings: tuple[Binding, ...] = (),
        events: BinaryIO | None = None) -> int:
    """Scans until the asked number is over or a signal comes. ``beat`` is called after each,
    and while one is waited for. Further arguments as of an offline run."""
    sys.setswitchinterval(_SWITCH)
    machine = start(result, options.period, sources.manifest, options.engine, bindings)
    stimuli = stimuli_of(options.inputs, sources.manifest, machine)
    names = watched(options.watch, sources.manifest, machine)
    endless = not (options.scans or options.duration)
    scans = None if endless else run_length(options, stimuli, machine)
    loaded = Loaded(machine, result.image.data, result.image.digest, shipped.texts_of(sources),
                    systems.together(result))
    controller = Controller(loaded)
    with _observed(options, machine, names, file) as observer, \
            _served(options, sources, controller) as server, _ended() as ended, \
            attached(options, sources, result, machine, names, beside=True) as beside, \
            systems.recorded(options.events, events) as record:
        system = None
        if is_system(result) or options.events:
            system = systems.system(result, controller, bindings, record)
            beside.join(system)
            controller.expect = system.expect
            server.waits = lambda: waits.text if (waits := system.master.waits) is not None else ""
        scan = controller.scan if system is None else system.scan
        due = time.monotonic()
        while (scans is None or controller.machine.scans < scans) and not ended():
            if server.serve():
                if system is not None:
                    system.follow()
                stimuli = stimuli.follow(machine, controller.machine)
                machine = controller.machine
                observer.follow(machine)
                beside.follow(controller.running)
                server.values.follow(machine)
            left = due - time.monotonic()
            if left > 0 and not options.no_wait:
                time.sleep(min(left, _SLICE))
                beat()
                continue
            # Late scans are not made up for: two in a row would shorten no time of the plant.
            due = max(due, due - left - machine.period_ns / 1e9) + machine.period_ns / 1e9
            stimuli.apply(machine)
            scan()
            if controller.machine is not machine:  # a fault ended a test within the scan
                stimuli = stimuli.follow(machine, controller.machine)
                machine = controller.machine
                observer.follow(machine)
                beside.follow(controller.running)
                server.values.follow(machine)
            observer.sample()
            beside.scanned()
            server.values.scanned()
            beat()
    say(f"{plural(machine.scans, 'scan')}, {milliseconds(machine.now_ns)} ms of the program's time")
    findings = machine.faults if system is None else system.findings
    return report((found.diagnostic() for found in findings), locator(result))


@contextmanager
def _observed(options: argparse.Namespace, machine: Machine, names: tuple[str, ...], file: BinaryIO | None
              ) -> Iterator[Observer]:
    if options.trace is None:
        yield ChangeLines(machine, names if shows(options) else (), sys.stdout)
        return
    if options.trace == "-":
        yield Trace(machine, names, sys.stdout)
        return
    with replacing(Path(options.trace)) if file is None else nullcontext(file) as opened:
        text = io.TextIOWrapper(opened, encoding="utf-8", newline="")
        yield Trace(machine, names, text)
        text.flush()
        text.detach()


@contextmanager
def _served(options: argparse.Namespace, sources: Sources, controller: Controller) -> Iterator[Server]:
    """The socket, and the audit log beside it. Raises Failure when one of them cannot be made."""
    name = link.name_of(sources)
    path = link.socket_path(options.socket, name)
    log = Path(options.audit) if options.audit else link.state_folder() / f"{path.stem}.audit.jsonl"
    limits = Limits(sources.settings.image_bytes)
    try:
        audit = Audit(log, lambda text: say(f"ldc run: {visible(text)}"))
        server = Server(controller, path, name, audit, limits, lambda text: say(visible(text)))
    except Busy:
        raise Failure(f"a runtime has the socket `{path}` already: end it, or name another with --socket"
                      ) from None
    except OSError as error:
        raise Failure(f"cannot serve `{path}` with the log `{log}`: {error.strerror or error}") from error
    say(f"online: {path}, log {log}")
    try:
        yield server
    finally:
        server.close()
        audit.close()


@contextmanager
def _ended() -> Iterator[Callable[[], bool]]:
    """Whether SIGINT or SIGTERM came: the scan that runs then is the last one."""
    came: list[int] = []
    before = {number: signal.signal(number, lambda number, frame: came.append(number))
              for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
