"""`ldc export`: a project in the format of another tool."""

from __future__ import annotations

import argparse
from collections.abc import Iterable

from ldc import pipeline
from ldc.cli import imported
from ldc.cli.compiling import compiled
from ldc.cli.console import OK
from ldc.cli.inputs import read
from ldc.cli.output import write_result
from ldc.diagnostics import Diagnostics, Invalid
from ldc.export import plcopen
from ldc.manifest import Manifest, Sources
from ldc.parser import ast, format_of
from ldc.parser.format import format_file
from ldc.source import SourceFile, Span

_PERIOD = 10_000_000
"""Nanoseconds between two scans when nothing says another time, as for `ldc run`."""


def run(options: argparse.Namespace) -> int:
    """What compiles is exported, from its canonical text."""
    sources = read(options.sources)
    first = compiled(sources, verify=False)
    diagnostics = Diagnostics()
    _no_components(first, diagnostics)
    if diagnostics.has_errors:
        raise Invalid(diagnostics)
    texts = tuple(_texts(first.project.files, diagnostics))
    if diagnostics.has_errors:
        raise Invalid(diagnostics)
    again = pipeline.compile_project(Sources(texts, sources.settings, sources.manifest),
                                     pipeline.Options(verify=False, keep=True))
    if again.diagnostics.has_errors:
        raise Invalid(again.diagnostics)
    graphs = {pou: [(build.rung, build.graph) for build in builds] for pou, builds in again.units.items()}
    manifest = sources.manifest
    xml = plcopen.export(again.meant.files, again.model, graphs, manifest.name if manifest else "",
                         _period(manifest))
    write_result(xml, options.output)
    return OK


def _no_components(result: pipeline.Compiled, diagnostics: Diagnostics) -> None:
    """Report the components of a program, at the first variable of each (one in a structure: at its
    descriptor)."""
    places: dict[str, Span] = {}
    for file in result.project.files:
        blocks = [*file.globals, *(block for pou in file.pous for block in pou.var_blocks)]
        for variable in (variable for block in blocks for variable in block.variables):
            type_ = variable.type
            while isinstance(type_, ast.ArrayType):
                type_ = type_.element
            if isinstance(type_, ast.NamedType):
                places.setdefault(type_.name.upper(), type_.span)
    help = "TC6 has POUs only: write a function block of this name, or leave out what uses it"
    for key, component in result.components.items():
        diagnostics.error("LD0660", f"`{component.name}` cannot be exported: it is a component",
                          places.get(key, Span(component.source, 0, 0)), "no POU of the project", help=help)


def _texts(files: Iterable[ast.File], diagnostics: Diagnostics) -> Iterable[SourceFile]:
    """The canonical text of every file."""
    for file in files:
        if format_of(file.source) is None:
            yield SourceFile(file.source.path, format_file(file))
        else:
            yield from (text.source for text in imported.sources([file], diagnostics).values())


def _period(manifest: Manifest | None) -> int:
    return manifest.period if manifest is not None and manifest.period else _PERIOD
