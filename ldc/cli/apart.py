"""Work that calls components in C and C++ runs in a process of its own: what they break is told, and stays
there."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from ldc import pipeline
from ldc.cli import sanitized
from ldc.cli.console import FULL, answered, silence_stdout
from ldc.components import host
from ldc.components.find import own_files
from ldc.components.project import Native
from ldc.diagnostics import Diagnostic, Diagnostics, Invalid
from ldc.il.external import Binding
from ldc.source import Span
from runtime.guard import HANG, Beat, Crash, guarded

_HANG_LATER = 10.0
"""Seconds without a scan after which a run hangs that had no component at its begin."""
_HANG_SANITIZED = 60.0
"""With sanitizers, which look for the lines of what they found while no scan goes on."""
_NO_ROOM = 74
"""How the process ends when what it writes has no room: the file it wrote is not whole (EX_IOERR)."""


def apart(result: pipeline.Compiled, bindings: tuple[Binding, ...], work: Callable[[Beat], int],
          arguments: Sequence[str], orderly: bool = False) -> int:
    """The status of the work. It may get components later, of which only that they break something is told.
    ``arguments``: of the command, for the report of a fault of ldc itself; ``orderly``: an interrupt from the
    keyboard is left to it. Raises Invalid for a crash, with the component and its line in C, and OSError when
    there is no room for what the work writes."""
    diagnostics = Diagnostics()
    handler = host.guard_library(diagnostics) if bindings else None
    if handler is None and bindings:
        raise Invalid(diagnostics)

    def watched(beat: Beat) -> int:
        try:
            if handler is not None:
                beat.watch([b.library for b in bindings], handler)
            status = answered("run", lambda: work(beat))
            sys.stdout.flush()
            return status
        except BrokenPipeError:
            raise  # ends the process as it ends any command
        except Exception as error:
            if isinstance(error, OSError) and error.errno in FULL:
                silence_stdout()
                return _NO_ROOM
            from ldc.cli.crash import reported  # loads what nobody hopes to need

            return reported(error, arguments)

    sys.stdout.flush()
    sys.stderr.flush()
    hang = _HANG_SANITIZED if sanitized.inside() else HANG if bindings else _HANG_LATER
    end = guarded(watched, hang, orderly=orderly)
    if isinstance(end, Crash):
        raise Invalid([_told(end, hang, result, bindings)])
    if end == _NO_ROOM:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    return end


def _told(crash: Crash, hang: float, result: pipeline.Compiled, bindings: tuple[Binding, ...]) -> Diagnostic:
    """A crash in words, at its line when that is known."""
    unit = next((b.unit for b in bindings if crash.library is not None and b.library == crash.library), None)
    native = next((n for n in result.natives if unit is not None and n.unit.name == unit), None)
    bag = Diagnostics()
    manifest = result.sources.manifest
    plant = manifest is not None and manifest.coordination.plant is not None
    if crash.hang and crash.library is None:
        bag.error("LD0847", f"a scan takes longer than {hang:g} seconds, outside of components: the run was "
                  "ended",
                  manifest.value_span("plant", "step") if plant else None, "so often the plant steps",
                  help="the steps of the plant are part of a scan: let them be fewer, or do less" if plant
                  else "`ldc bench` tells what a scan of the program takes")
        return next(iter(bag))
    name = f"component {native.component.name}" if native else "a component or the plant" if plant \
        else "a component"
    span = _span(crash, native) if native else None
    bag.error(
        "LD0805",
        f"{name} {crash.what}: the run was ended",
        span,
        "here" if crash.line else "called here",
        help="`ldc run --sanitize` tells more; nothing of the program runs on, outputs take their safe values"
        if not crash.hang
        else "bound every loop; a component is called in every scan",
    )
    return next(iter(bag))


def _span(crash: Crash, native: Native) -> Span:
    for source in own_files(native.component, Diagnostics()).values():
        if crash.line and Path(source.path).resolve() == Path(crash.file).resolve():
            return source.line_span(crash.line)
    return native.component.span("function", "sources")
