"""What several commands share: reading their sources and running the compiler over them."""

from __future__ import annotations

from collections.abc import Sequence

from ldc import pipeline
from ldc.cli.console import report
from ldc.diagnostics import Diagnostics, Invalid
from ldc.manifest import Sources, find_sources


def read(paths: Sequence[str]) -> Sources:
    """The sources that the arguments mean. Raises Invalid when one cannot be read: what is left would only
    give findings about names that the missing file declares."""
    diagnostics = Diagnostics()
    sources = find_sources(paths, diagnostics)
    if diagnostics.has_errors:
        raise Invalid(diagnostics)
    return sources


def compiled(sources: Sources, options: pipeline.Options) -> pipeline.Compiled:
    """The compiled project; warnings are shown. Raises Invalid when the sources are wrong."""
    result = pipeline.compile_project(sources, options)
    if result.diagnostics.has_errors:
        raise Invalid(result.diagnostics)
    report(result.diagnostics)
    return result
