"""`ldc compile`: the result of the compiler, or of one of its stages."""

from __future__ import annotations

import argparse
from collections.abc import Callable

from ldc import pipeline
from ldc.cli.compiling import compiled, native_code
from ldc.cli.console import OK, UsageError, say
from ldc.cli.dump import dump
from ldc.cli.inputs import read
from ldc.cli.output import write_result
from ldc.diagnostics import Diagnostics, Invalid
from ldc.graph.dump import graph_dot, graph_text, tree_text
from ldc.il.text import print_program
from ldc.model.eno_of_blocks import with_enables
from ldc.parser import ast, parse_files
from ldc.parser.statements import StatementBody


def run(options: argparse.Namespace) -> int:
    as_dot = options.format == "dot" or (options.format is None and (options.output or "").endswith(".dot"))
    if options.format and options.emit != "graph":
        raise UsageError("--format is for --emit graph")
    sources = read(options.sources)
    if options.emit == "ast":
        diagnostics = Diagnostics()
        files = parse_files(sources.files, diagnostics)
        if diagnostics.has_errors:
            raise Invalid(diagnostics)
        write_result(dump(ast.Project(files)), options.output)
        return OK
    result = compiled(
        sources,
        verify=not options.no_verify,
        keep=options.emit in ("graph", "tree"),
        max_paren_depth=options.max_paren_depth,
    )
    write_result(_emitted(result, options.emit, as_dot), options.output)
    if options.timings:
        _show_timings(result.timings)
    return OK


def _emitted(result: pipeline.Compiled, emit: str, as_dot: bool) -> str | bytes:
    match emit:
        case "il":
            return print_program(result.program)
        case "st":
            return _st_text(result)
        case "image":
            return result.image.data
        case "c":
            return _c_text(result)
        case "tree":
            return _each_rung(result, lambda build: tree_text(build.graph, build.tree))
    if as_dot:
        return "".join(
            graph_dot(build.graph).rstrip() + "\n" for builds in result.units.values() for build in builds
        )
    return _each_rung(result, lambda build: graph_text(build.graph, build.turns))


def _st_text(result: pipeline.Compiled) -> str:
    """Bodies that were written in Structured Text as they are, the others made from their IL."""
    from ldc.il.st_text import print_st
    from ldc.parser.write import written

    bodies = {}
    meant = with_enables(result.meant)
    for pou in (p for file in meant.files for p in file.pous if isinstance(p.body, StatementBody)):
        if pou.name.upper() not in result.components:
            bodies[pou.name.upper()] = written((pou,), "body.st", Diagnostics()).source.text
    # Of other names for types IL has what they stand for, but the bodies name them.
    names = [type_ for file in result.project.files for type_ in file.types
             if not isinstance(type_.type, ast.StructType | ast.EnumType | ast.SubrangeType)]
    text = print_st(result.program, bodies)
    types = written(names, "names.st", Diagnostics()).source.text if bodies else ""
    return f"{types}\n{text}" if types else text


def _c_text(result: pipeline.Compiled) -> str:
    """The C files of the program, one behind the other; what belongs to the library is left out."""
    from ldc.backends.c.build import planned  # these load jinja2 and the runtime
    from ldc.cli.starting import resource_to_run

    plan = planned(result.program, result.image.layout, resource_to_run(result), native_code(result))
    return "\n".join(f"/* ==== {file.name} */\n{file.text}" for file in plan.files if file.is_generated)


def _each_rung(result: pipeline.Compiled, text: Callable[[pipeline.RungBuild], str]) -> str:
    """POU by POU, an empty line before each rung."""
    parts = []
    for pou, builds in result.units.items():
        parts += [f"{pou}\n", *(f"\n{text(build).rstrip()}\n" for build in builds)]
    return "".join(parts)


def _show_timings(timings: dict[str, float]) -> None:
    total = sum(timings.values())
    for stage, seconds in timings.items():
        say(f"{stage:<12} {seconds * 1000:10.1f} ms {seconds / total if total else 0:6.0%}")
    say(f"{'all':<12} {total * 1000:10.1f} ms")
