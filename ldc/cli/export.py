"""`ldc export`: a project in the format of another tool."""

from __future__ import annotations

import argparse
from collections.abc import Iterable

from ldc import pipeline
from ldc.cli import imported
from ldc.cli.compiling import compiled
from ldc.cli.console import OK, Failure
from ldc.cli.inputs import read
from ldc.cli.output import write_result
from ldc.diagnostics import Diagnostics, Invalid
from ldc.export import plcopen
from ldc.manifest import Manifest, Sources
from ldc.parser import ast, format_of
from ldc.parser.format import format_file
from ldc.source import SourceFile

_PERIOD = 10_000_000
"""Nanoseconds between two scans when nothing says another time, as for `ldc run`."""


def run(options: argparse.Namespace) -> int:
    """What compiles is exported, from its canonical text."""
    sources = read(options.sources)
    first = compiled(sources, verify=False)
    if first.components:
        names = ", ".join(c.name for c in first.components.values())
        raise Failure(f"TC6 has no place for components: {names}; other tools would need them as blocks of theirs")
    diagnostics = Diagnostics()
    texts = tuple(_texts(first.project.files, diagnostics))
    if diagnostics.has_errors:
        raise Invalid(diagnostics)
    again = pipeline.compile_project(Sources(texts, sources.settings, sources.manifest),
                                     pipeline.Options(verify=False, keep=True))
    if again.diagnostics.has_errors:
        raise Invalid(again.diagnostics)
    graphs = {pou: [(build.rung, build.graph) for build in builds] for pou, builds in again.units.items()}
    manifest = sources.manifest
    xml = plcopen.export(again.project.files, again.model, graphs, manifest.name if manifest else "",
                         _period(manifest), diagnostics)
    if diagnostics.has_errors:
        raise Invalid(diagnostics)
    write_result(xml, options.output)
    return OK


def _texts(files: Iterable[ast.File], diagnostics: Diagnostics) -> Iterable[SourceFile]:
    """The canonical text of every file."""
    for file in files:
        if format_of(file.source) is None:
            yield SourceFile(file.source.path, format_file(file))
        else:
            yield from (text.source for text in imported.sources([file], diagnostics).values())


def _period(manifest: Manifest | None) -> int:
    return manifest.period if manifest is not None and manifest.period else _PERIOD
