"""What goes on beside the scans of `ldc run`: retain, forces, a trace ring (docs/retain.md,
docs/commissioning.md)."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ldc import pipeline
from ldc.cli.console import UsageError, say
from ldc.cli.output import write_result
from ldc.diagnostics import Invalid
from ldc.il import image as il_image
from ldc.manifest import Sources
from ldc.render import plural, visible
from runtime import value_findings as findings
from runtime.machine import Machine
from runtime.ring import Ring
from runtime.symbols import UnknownSymbol

if TYPE_CHECKING:
    from runtime.online.controller import Loaded
    from runtime.retaining import Retaining, Slaves

BEFORE, AFTER = 100, 200
"""Rows of a trace ring when nothing says it."""


@dataclass(slots=True)
class Attached:
    """``scanned`` is called after every scan, ``follow`` when another program goes on."""

    machine: Machine
    retaining: Retaining | None = None
    ring: Ring | None = None

    def scanned(self) -> None:
        if self.retaining is not None:
            self.retaining.scanned()
        if self.ring is not None:
            self.ring.sample()

    def join(self, slaves: Slaves) -> None:
        """Before the first scan: algorithms of slaves retain too."""
        if self.retaining is not None:
            self.retaining.join(slaves)

    def follow(self, running: Loaded) -> None:
        self.machine = running.machine
        if self.retaining is not None:
            self.retaining.follow(running.machine, running.digest,
                                  lambda: il_image.layout_of(running.image).digest)
        if self.ring is not None:
            self.ring.follow(running.machine)


def _file_of(options: argparse.Namespace, sources: Sources) -> Path | None:
    """The retain file that is asked for, else that of the project. Raises UsageError for options that need
    one."""
    manifest = sources.manifest
    if options.retain == "":
        raise UsageError("--retain names no file")
    if options.retain:
        return Path(options.retain)
    if manifest and manifest.retain:
        return manifest.folder / manifest.retain
    for name, value in (("--retain-every", options.retain_every), ("--start", options.start)):
        if value:
            raise UsageError(f"{name} goes with --retain FILE, or with `retain` under [run] in ldc.toml")
    return None


@contextmanager
def attached(options: argparse.Namespace, sources: Sources, result: pipeline.Compiled, machine: Machine,
             names: Sequence[str], beside: Callable[[], None] | None = None) -> Iterator[Attached]:
    """Before the first scan: retained values, then forces. After the last: a save, the ring's file, and which
    forces are still there. ``names``: what is watched; ``beside``: scans have their time, and do not wait for
    the disk; it is called by the thread that does.

    Raises UsageError, Invalid (LD0850 to LD0860, LD0865) and Failure for what cannot be.
    """
    check(options)
    path = _file_of(options, sources)
    with ExitStack() as stack:
        retaining = None
        if path:
            from ldc.cli.retention import begun, used  # most runs keep nothing

            stack.enter_context(used(path))
            retaining = begun(options, sources, result, machine, path, beside)
        with _beside(options, machine, names, path, retaining) as made:
            yield made


@contextmanager
def _beside(options: argparse.Namespace, machine: Machine, names: Sequence[str], path: Path | None,
            retaining: Retaining | None) -> Iterator[Attached]:
    try:
        force(machine, options.force)
        ring = Ring(machine, names, options.trigger, _or(options.before, BEFORE), _or(options.after, AFTER)) \
            if options.ring else None
        made = Attached(machine, retaining, ring)
        yield made
    except BaseException:
        if retaining is not None:
            retaining.abandon()  # a scan may have been cut: what was saved at a boundary stays
        raise
    if retaining is not None:
        try:
            retaining.close()
        except OSError as error:
            from runtime.retain_file import unreachable

            raise Invalid([unreachable("write", path, error)]) from error
    if made.ring is not None:
        _write(made.ring, options.ring)
    rows = made.machine.forces.rows
    if rows:
        say(visible("still forced: " + ", ".join(f"{row.path} = {row.shown}" for row in rows)))


def check(options: argparse.Namespace) -> None:
    """Raises UsageError for options that mean nothing together."""
    if options.ring and not options.trigger:
        raise UsageError('--ring needs --trigger, as in --trigger "motor rises"')
    alone = {"--trigger": options.trigger, "--before": options.before, "--after": options.after}
    for name, value in alone.items():
        if value is not None and not options.ring:
            raise UsageError(f"{name} goes with --ring OUT.csv")


def _or(value: int | None, default: int) -> int:
    return default if value is None else value


def listed(text: str) -> tuple[str, ...]:
    """What stands between commas, but those in the brackets of an index."""
    return tuple(name.strip() for name in re.split(r",(?![^\[]*\])", text) if name.strip())


def force(machine: Machine, text: str | None) -> None:
    """``a=1,b=2``. Raises Invalid (LD0855) with all that cannot be."""
    against = []
    for part in listed(text or ""):
        path, sign, value = (one.strip() for one in part.partition("="))
        try:
            if not sign:
                raise ValueError("a force is written `path=value`")
            machine.forces.add(path, value)
        except (UnknownSymbol, ValueError) as error:
            against.append(findings.no_value("force", path, error))
    if against:
        raise Invalid(against)


def _write(ring: Ring, target: str) -> None:
    if ring.event is None:
        why = "its variable is gone" if ring.lost else "the trigger did not come"
        say(f"ring: {why}, nothing is written")
        return
    write_result(ring.csv(), target)
    early = "" if ring.done else ", the run ended early"
    say(f"ring: triggered in scan {ring.event}, {plural(len(ring.rows), 'row')}{early}")
