"""The sources that a command line names, read before anything is done with them."""

from __future__ import annotations

from collections.abc import Sequence

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
