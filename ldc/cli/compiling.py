"""Running the compiler for a command that goes on with its result."""

from __future__ import annotations

from ldc import pipeline
from ldc.cli.console import report
from ldc.diagnostics import Invalid, Severity
from ldc.manifest import Sources


def compiled(sources: Sources, options: pipeline.Options) -> pipeline.Compiled:
    """The compiled project; warnings are shown, notes are for `ldc check`. Raises Invalid when the sources are
    wrong."""
    result = pipeline.compile_project(sources, options)
    if result.diagnostics.has_errors:
        raise Invalid(result.diagnostics)
    report(d for d in result.diagnostics if d.severity is not Severity.NOTE)
    return result
