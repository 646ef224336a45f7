"""Running the compiler for a command that goes on with its result."""

from __future__ import annotations

import gc
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache

from ldc import pipeline
from ldc.cli.console import is_terminal, report
from ldc.components import pace
from ldc.diagnostics import Diagnostics, Invalid, Locate, Severity
from ldc.il.external import Binding
from ldc.il.layout import Layout
from ldc.manifest import Sources
from ldc.parser import format_of
from ldc.pipeline.memory import Memory, memory_of

_QUIET = 0.5
"""Seconds after which a person wants to know how far it is."""
_WORTH = 20_000
"""Characters of a project from which on its rungs are remembered."""


def compiled(
    sources: Sources, *, verify: bool = True, keep: bool = False, max_paren_depth: int | None = None,
    previous: Layout | None = None, called_on: str | None = None,
) -> pipeline.Compiled:
    """The compiled project; warnings are shown, notes are for `ldc check`. `called_on`: a target that calls
    all components; which ones would have a pace of their own is told.

    The settings are those of `pipeline.Options`. Raises Invalid when the sources are wrong.
    """
    with progress() as tell:
        options = pipeline.Options(max_paren_depth=max_paren_depth, verify=verify, keep=keep,
                                   previous=previous,
                                   progress=tell, algorithms=called_on is None,
                                   memory=None if keep else memory_for(sources))
        result = pipeline.compile_project(sources, options)
    coordinated(result)
    gc.freeze()  # it lives as long as the command: the collector need not walk it again and again
    if result.diagnostics.has_errors:
        raise Invalid(result.diagnostics, locator(result))
    shown = Diagnostics()
    shown.extend(d for d in result.diagnostics if d.severity is not Severity.NOTE)
    if called_on is not None and sources.manifest is not None:
        slaves = pace.slaves(sources.manifest.processors)
        pace.called(result.components.values(), slaves, called_on, shown)
    report(shown, locator(result))
    return result


def coordinated(result: pipeline.Compiled) -> None:
    """Adds what is wrong with how the modules work together to the findings."""
    manifest = result.sources.manifest
    if manifest is not None and manifest.coordination:
        from ldc.cli.coordinate import coordination  # most projects say nothing of it

        coordination(result, result.diagnostics)


def memory_for(sources: Sources) -> Memory | None:
    """What is remembered of a project whose ladder text is large enough for it to pay."""
    if sum(len(file.text) for file in sources.files if format_of(file) is None) < _WORTH:
        return None
    return memory_of(str(sources.manifest.folder) if sources.manifest else sources.files[0].path)


def locator(result: pipeline.Compiled) -> Locate:
    """Finds what is wrong in the drawings of a project."""

    @cache
    def found() -> Locate:
        from ldc.draw import Locator, pins_from  # slow to load, and most compiles have nothing to show

        return Locator(result.project.files, pins_from(result.model.signatures))

    return lambda span, style: found()(span, style)


def native_code(result: pipeline.Compiled) -> tuple[Binding, ...]:
    """The libraries of the components in C and C++, compiled now or before. Raises Invalid when they cannot
    be."""
    if not result.natives:
        return ()
    from ldc.cli import sanitized
    from ldc.components import host  # slow to load, and most projects have no such component

    diagnostics = Diagnostics()
    globals_ = tuple(result.model.globals.values())
    sanitize = sanitized.inside()
    built = [host.build(native, globals_, diagnostics, sanitize) for native in result.natives]
    if diagnostics.has_errors:
        raise Invalid(diagnostics)
    report(diagnostics)
    return tuple(binding for binding in built if binding is not None)


@contextmanager
def progress() -> Iterator[Callable[[int, int], None] | None]:
    """What tells on a terminal how many rungs are done; None elsewhere. The line is gone afterwards."""
    if not is_terminal(sys.stderr):
        yield None
        return
    due = time.monotonic() + _QUIET
    shown = False

    def tell(done: int, total: int) -> None:
        nonlocal due, shown
        if (now := time.monotonic()) >= due:
            due, shown = now + 0.1, True
            sys.stderr.write(f"\rcompiling: {done:,} of {total:,} rungs")
            sys.stderr.flush()

    try:
        yield tell
    finally:
        if shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
