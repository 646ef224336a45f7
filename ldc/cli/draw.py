"""`ldc draw`: rungs as text on the terminal, or as SVG."""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Iterator

from ldc.cli.console import Failure, UsageError, is_terminal, report, say, wants_color
from ldc.cli.inputs import read
from ldc.cli.output import write_result
from ldc.diagnostics import Diagnostics
from ldc.draw import (
    Locator,
    chart_text,
    ladders_of,
    notes_of,
    pins_from,
    pou_text,
    project_svg,
    rung_svg,
    rung_text,
)
from ldc.model import resolve
from ldc.parser import ast, parse_files
from ldc.parser.sfc import SfcBody
from ldc.similar import similar


def run(options: argparse.Namespace) -> int:
    """What parses is drawn, also when other parts have errors: a drawing helps to find them."""
    diagnostics = Diagnostics()
    sources = read([options.source])
    project = ast.Project(parse_files(sources.files, diagnostics))
    # Which pins a block has is all that a drawing needs to know of the model; `ldc check` is for the rest.
    signatures = resolve(project, Diagnostics(), sources.settings).signatures
    status = report(diagnostics, Locator(project.files, pins_from(signatures)))
    comments = tuple(comment for file in project.files for comment in file.comments)
    settings = {"pins_of": pins_from(signatures)}
    if not options.svg:
        # As wide as the terminal, in colour when it has any.
        width = max(60, shutil.get_terminal_size((100, 24)).columns) if is_terminal(sys.stdout) else 100
        settings |= {"width": width, "colour": wants_color(sys.stdout)}
    if options.rung:
        pou, number, rung = _find(project, options.rung)
        draw = rung_svg if options.svg else rung_text
        drawn = draw(rung, number=number, notes=notes_of(pou, comments), **settings)
    elif not any(_rungs(project)) and (options.svg or not any(map(_is_chart, _pous(project)))):
        if options.svg or status or not any(_pous(project)):
            raise Failure("there is no rung to draw")
        say("there is no rung to draw: all bodies are texts")
        return status
    elif options.svg:
        drawn = project_svg(
            [pou for file in project.files for pou in file.pous], comments=comments, **settings
        )
    else:
        drawn = "\n\n".join(_text(pou, comments, settings) for pou in _pous(project)
                            if _is_chart(pou) or ladders_of(pou))
    write_result(drawn, options.svg)
    return status


def _pous(project: ast.Project) -> Iterator[ast.Pou]:
    return (pou for file in project.files for pou in file.pous)


def _is_chart(pou: ast.Pou) -> bool:
    return isinstance(pou.body, SfcBody)


def _text(pou: ast.Pou, comments: tuple[ast.Comment, ...], settings: dict) -> str:
    """A ladder, or a chart with its ladders."""
    drawn = [chart_text(pou, settings["width"])] if _is_chart(pou) else []
    drawn += (pou_text(one, comments=_inside(one, comments), **settings) for one in ladders_of(pou))
    return "\n\n".join(drawn)


def _rungs(project: ast.Project):
    """POU, number from 1, rung."""
    for whole in _pous(project):
        for pou in ladders_of(whole):
            for number, rung in enumerate(pou.body.rungs, 1):
                yield pou, number, rung


def _inside(pou: ast.Pou, comments: tuple[ast.Comment, ...]) -> tuple[ast.Comment, ...]:
    span = pou.span
    return tuple(
        c for c in comments if c.span.source is span.source and span.start <= c.span.start < span.end
    )


def _find(project: ast.Project, wanted: str) -> tuple[ast.Pou, int, ast.Rung]:
    """The rung of that name or number; `POU.name` tells which when several POUs have it."""
    pou_name, _, name = wanted.upper().rpartition(".")
    found = [
        (pou, number, rung)
        for pou, number, rung in _rungs(project)
        if name in ((rung.name or "").upper(), str(number))
        and pou_name in ("", pou.name.upper(), pou.name.upper().partition(".")[0])
    ]
    if not found:
        names = {rung.name.upper(): rung.name for _, _, rung in _rungs(project) if rung.name}
        close = [names[key] for key in similar(name, names, 1)]
        hint = f"; did you mean `{close[0]}`?" if close else ""
        raise UsageError(f"no rung `{wanted}`{hint}")
    if len(found) > 1:
        places = ", ".join(f"{pou.name}.{rung.name or number}" for pou, number, rung in found)
        raise UsageError(f"`{wanted}` is in several POUs: {places}")
    return found[0]
