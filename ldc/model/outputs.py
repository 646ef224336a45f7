"""Outputs with an address: a warning where two variables share bits of the output image."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.model import declaration_findings as findings
from ldc.model.project import Model
from ldc.symbols import Variable


def check_overlaps(model: Model, diagnostics: Diagnostics) -> None:
    """Warn about every %Q variable that overlaps one that begins before it. O(n log n)."""
    placed: list[tuple[int, int, int, Variable]] = []
    scopes = [model.globals, *(pou.variables for pou in model.pous.values())]
    for scope in scopes:
        for variable in scope.values():
            location = variable.location
            if location is not None and location.area == "Q" and variable.kind != "external":
                start = location.byte * 8 + location.bit
                placed.append((start, len(placed), start + location.extent, variable))
    placed.sort(key=lambda p: p[:2])
    reach, furthest = 0, None
    for start, _, end, variable in placed:
        if furthest is not None and start < reach:
            findings.overlapping_outputs(diagnostics, variable.span, variable.name, str(variable.location),
                                         furthest.name, furthest.span)
        if end > reach:
            reach, furthest = end, variable
