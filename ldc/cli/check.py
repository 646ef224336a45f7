"""`ldc check`: everything that the compiler finds, for people or for machines."""

from __future__ import annotations

import argparse
import sys
from collections import Counter

from ldc import pipeline
from ldc.cli.compiling import coordinated, locator, progress
from ldc.cli.console import OK, WRONG, report, say
from ldc.diagnostics import Diagnostics
from ldc.manifest import Sources, find_sources
from ldc.render import plural
from ldc.reports import json_report, sarif_report


def run(options: argparse.Namespace) -> int:
    diagnostics = Diagnostics()
    sources = find_sources(options.sources, diagnostics)
    result = None
    if not diagnostics.has_errors:
        with progress() as tell:
            result = pipeline.compile_project(
                sources, pipeline.Options(verify=not options.no_verify, keep=False, progress=tell)
            )
        coordinated(result)
        diagnostics.extend(result.diagnostics)
    locate = locator(result) if result else None
    if options.format == "human":
        status = report(diagnostics, locate)
        if status == OK and result:
            say(_what_was_checked(sources, result))
        return status
    sys.stdout.write((json_report if options.format == "json" else sarif_report)(diagnostics, locate))
    return WRONG if diagnostics.has_errors else OK


def _what_was_checked(sources: Sources, result: pipeline.Compiled) -> str:
    """How much was read, and how many rungs were proved to be what is drawn, or only tested."""
    kinds = Counter(build.code.proof for builds in result.units.values() for build in builds)
    compared = [
        f"{kinds[kind]:,} {word}" for kind, word in (("proof", "proved"), ("check", "tested")) if kinds[kind]
    ]
    how = f" ({', '.join(compared)})" if compared else ""
    return f"checked {plural(len(sources.files), 'file')}, {plural(kinds.total(), 'rung')}{how}: no errors"
