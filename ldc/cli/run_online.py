"""`ldc run --online`: scans at their time, and a socket by which the program is changed meanwhile."""

from __future__ import annotations

import argparse
import io
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from ldc import pipeline
from ldc.cli import link, settled, shipped
from ldc.cli import system as systems
from ldc.cli.attached import Attached, attached
from ldc.cli.compiling import locator
from ldc.cli.console import Failure, report, say
from ldc.cli.output import replacing
from ldc.cli.starting import run_length, start, stimuli_of, watched
from ldc.cli.run_options import shows
from ldc.cli.watching import ChangeLines
from ldc.il.external import Binding
from ldc.manifest import Sources
from ldc.render import plural, visible
from runtime.machine import Machine
from runtime.online import loading
from runtime.online.audit import Audit
from runtime.online.checks import Limits
from runtime.online.controller import Controller, Loaded
from runtime.online.server import Busy, Server
from runtime.realtime import processes
from runtime.slave.algorithm import makers
from runtime.trace import Trace
from runtime.values import milliseconds

if TYPE_CHECKING:
    from ldc.cli.realtime import Processes
    from runtime.master.part import MasterPart

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
    names = watched(options.watch, sources.manifest, machine.symbols)
    endless = not (options.scans or options.duration)
    scans = None if endless else run_length(options, stimuli, machine)
    follows = options.watch is None and shows(options)
    settings = {**settled.fixed(sources.manifest, watch=not follows), **settled.told(options)}
    loaded = Loaded(machine, result.image.data, result.image.digest, shipped.texts_of(sources),
                    together := systems.together(result), makers(result.program, bindings),
                    watch := loading.watched(machine, names) if follows else None,
                    loading.settings_digest(together, watch))
    controller = Controller(loaded)
    affinity = os.sched_getaffinity(0)

    def ordinary() -> None:
        if options.realtime:  # a thread of a processor has its priority
            processes.ordinary(affinity)

    with _observed(options, machine, names, file) as observer, processes.interrupted() as ended, \
            attached(options, sources, result, machine, names, beside=ordinary) as beside, \
            systems.recorded(options.events, events) as record, \
            _executed(options, result, controller, bindings, record, beside, beat, ended) as whole, \
            _served(options, sources, controller, ordinary, settings) as server:
        server.waits = lambda: waits.text if (waits := whole.master.waits) is not None else ""
        controller.expect = whole.expect

        def followed() -> None:
            """Another program goes on."""
            nonlocal machine, stimuli
            stimuli = stimuli.follow(machine, controller.machine)
            machine = controller.machine
            if follows:
                observer.follow(machine, controller.running.watch)
            else:
                observer.follow(machine)
            beside.follow(controller.running)
            server.values.follow(machine)

        if whole.processes is not None:
            whole.processes.begin()
        while (scans is None or controller.machine.scans < scans) and not ended() and not whole.over:
            if server.serve():
                with server.following():
                    whole.follow()
                    followed()
            if not whole.due():
                continue
            stimuli.apply(machine)
            before = machine.scans
            whole.scan()
            if controller.machine is not machine:  # a fault ended a test within the scan
                followed()
            if machine.scans == before:  # the run was ended while it waited
                break
            observer.sample()
            beside.scanned()
            server.values.scanned()
            beat()
    if options.realtime:
        from ldc.cli import run_realtime

        return run_realtime.told(options, result, whole.processes, machine, beat)
    say(f"{plural(machine.scans, 'scan')}, {milliseconds(machine.now_ns)} ms of the program's time")
    return report((found.diagnostic() for found in whole.findings()), locator(result))


@dataclass(slots=True)
class _Whole:
    """What executes scans: ``due`` waits a little, and tells whether it is time for one. ``over``: there is
    nothing to control any more. ``processes``: those of a run in real time."""

    scan: Callable[[], None]
    due: Callable[[], bool]
    follow: Callable[[], None]
    expect: Callable[[Loaded], None]
    findings: Callable[[], Iterable]
    master: MasterPart
    processes: Processes | None = None

    @property
    def over(self) -> bool:
        return self.processes is not None and self.processes.loop.over


@contextmanager
def _executed(options: argparse.Namespace, result: pipeline.Compiled, controller: Controller,
              bindings: tuple[Binding, ...], record: systems.EventFile | None, beside: Attached,
              beat: Callable[[], None], ended: Callable[[], bool]) -> Iterator[_Whole]:
    """In a process for each processor, or in virtual time at the pace of the clock; threads may be made when
    it has been entered. Always with what makes a system: another program may bring messages, a sequence."""
    if options.realtime:
        from ldc.cli.realtime import Processes  # loads what virtual time does not need

        made = Processes(result, controller, bindings, beat, record.append if record else None, beside.join)
        made.loop.until(ended)
        try:
            yield _Whole(made.loop.scan, lambda: True, made.follow, made.expect,
                         lambda: made.loop.findings, made.master, made)
        finally:
            made.finish()
        return
    due = _Clock(controller, options.no_wait, beat).due
    system = systems.system(result, controller, bindings, record)
    beside.join(system)
    yield _Whole(system.scan, due, system.follow, system.expect, lambda: system.findings, system.master)


class _Clock:
    """Scans at their time. Late ones are not made up for: two in a row would shorten no time of the plant."""

    def __init__(self, controller: Controller, hurries: bool, beat: Callable[[], None]) -> None:
        self._controller, self._hurries, self._beat = controller, hurries, beat
        self._next = time.monotonic()

    def due(self) -> bool:
        now, period = time.monotonic(), self._controller.machine.period_ns / 1e9
        if now < self._next and not self._hurries:
            time.sleep(min(self._next - now, _SLICE))
            self._beat()
            return False
        self._next = max(self._next, now - period) + period
        return True


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
def _served(options: argparse.Namespace, sources: Sources, controller: Controller,
            ordinary: Callable[[], None], settings: Mapping[str, str]) -> Iterator[Server]:
    """The socket, and the audit log beside it. ``ordinary``: what its threads begin with. Raises Failure when
    one of them cannot be made."""
    name = link.name_of(sources)
    path = link.socket_path(options.socket, name)
    log = Path(options.audit) if options.audit else link.state_folder() / f"{path.stem}.audit.jsonl"
    limits = Limits(sources.settings.image_bytes)
    try:
        audit = Audit(log, lambda text: say(f"ldc run: {visible(text)}"))
        server = Server(controller, path, name, audit, limits, lambda text: say(visible(text)),
                        ordinary, settings)
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
