"""What `--retain` does for `ldc run`: values from the file at the start, saves of them (docs/retain.md)."""

from __future__ import annotations

import argparse
import errno
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from ldc import pipeline, unfinished
from ldc.cli.console import report, say
from ldc.cli.link import name_of
from ldc.diagnostics import Diagnostic, Diagnostics, Invalid
from ldc.manifest import Sources
from ldc.render import plural, visible
from runtime.machine import Machine
from runtime.retain import Identity, Leaf, leaves, restore
from runtime.retain_file import Kept, Store, unreachable
from runtime.retaining import Retaining

EVERY = 1_000_000_000
"""Time of the program between two saves when nothing says it, in nanoseconds."""
_SHOWN = 5


def begun(options: argparse.Namespace, sources: Sources, result: pipeline.Compiled, machine: Machine,
          path: Path, beside: Callable[[], None] | None) -> Retaining:
    """Gives the machine its retained values as `--start` says, and what saves them. ``beside``: scans do not
    wait for the disk. Raises Invalid when the file cannot be used; it is as it was then."""
    store, kept = Store(path), None
    unfinished.sweep(path.parent)  # of a run that was killed in a save
    found = Diagnostics()
    identity = Identity(name_of(sources), result.image.digest, lambda: result.image.layout.digest)
    if path.is_dir():
        raise Invalid([unreachable("write", path, OSError(errno.EISDIR, os.strerror(errno.EISDIR)))])
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise Invalid([unreachable("write", path, _reason(path.parent))])
    _check_ours(store)
    if options.start == "origin":
        try:
            store.delete()
        except OSError as error:
            raise Invalid([unreachable("delete", path, error)]) from error
    elif options.start == "cold":
        with suppress(Invalid):  # only to know which of the two files is whole: that one stays the longest
            store.load(Diagnostics())
    else:
        kept = store.load(found)
    remote = _remote(result)
    if kept is not None:
        _restore(machine, kept, remote, path, found)
    report(found)
    if not leaves(machine.layout) and not remote:
        say("note: no variable of the program is RETAIN")
    manifest = sources.manifest
    every = options.retain_every or (manifest.retain_every if manifest else None) or EVERY
    return Retaining(machine, identity, store, every, beside,
                     lambda error: report([unreachable("write", path, error)]),
                     kept={entry.path: entry for entry in kept.entries} if kept is not None else {})


@contextmanager
def used(path: Path) -> Iterator[None]:
    """The file belongs to this run until the block ends. Raises Invalid when another one has it."""
    with ExitStack() as stack:
        # Where no file can be made there is none to share: what follows tells why.
        with suppress(OSError):
            if not stack.enter_context(unfinished.alone(path.parent / f".{path.name}.lock")):
                raise Invalid([_in_use(path)])
        yield


def _in_use(path: Path) -> Diagnostic:
    found = Diagnostics()
    found.error("LD0865", f"another run saves to the retain file `{path}`",
                help="end that run, or name another file: what one of them saved, the other would replace")
    return next(iter(found))


def _remote(result: pipeline.Compiled) -> tuple[Leaf, ...]:
    """What algorithms retain on their slaves."""
    if not result.program.algorithms:
        return ()
    from ldc.cli.system import placement  # most projects have no slaves
    from runtime.slave.retained import of_program

    return of_program(result.program, placement(result))


def _check_ours(store: Store) -> None:
    """Raises Invalid when the name is that of something else, which no save may replace."""
    try:
        foreign = store.foreign
    except OSError as error:
        raise Invalid([unreachable("read", store.path, error)]) from error
    if foreign:
        found = Diagnostics()
        found.error("LD0860", f"`{store.path}` is no retain file: it was not written by a save",
                    help="name another file; if this one is a retain file that was damaged, put a copy of it "
                    "back, or delete it")
        raise Invalid(found)


def _reason(folder: Path) -> OSError:
    """Why nothing can be written to a folder."""
    number = errno.EACCES if folder.is_dir() else errno.ENOENT
    return OSError(number, os.strerror(number))


def _restore(machine: Machine, kept: Kept, remote: tuple[Leaf, ...], path: Path, found: Diagnostics) -> None:
    try:
        told = restore(machine, kept, remote)
    except ValueError as error:
        raise Invalid([_foreign(path, kept, str(error))]) from error
    if told.dropped and not told.kept:
        raise Invalid([_foreign(path, kept, "nothing in it fits the variables of this program")])
    if told.dropped:
        names = ", ".join(f"`{name}`" for name in told.dropped[:_SHOWN])
        more = f" and {len(told.dropped) - _SHOWN} more" if len(told.dropped) > _SHOWN else ""
        found.warning("LD0853", f"{plural(len(told.dropped), 'retained value')} of `{path}` "
                      f"{'is' if len(told.dropped) == 1 else 'are'} dropped: {names}{more}",
                      help="the program has no such variable, or has it of another type; keep a copy of the "
                      "file if the values matter")
    changed = ""
    if told.initialised or told.dropped:
        changed = f"; {len(told.initialised)} initialised, {len(told.dropped)} dropped"
    say(visible(f"retain: {plural(len(told.kept), 'value')} of scan {kept.scan} from {path.name}{changed}"))


def _foreign(path: Path, kept: Kept, why: str) -> Diagnostic:
    found = Diagnostics()
    found.error("LD0852", f"the retain file `{path}` is of another program, `{kept.name[:60]}`: {why}",
                help="name the file of this program, or begin with initial values: `--start cold` replaces "
                "it at the first save")
    return next(iter(found))
