"""`ldc draw`: rungs as text on the terminal, or as SVG."""

from __future__ import annotations

import argparse
import difflib
import shutil
import sys

from ldc.cli.console import Failure, UsageError, is_terminal, report, wants_color
from ldc.cli.inputs import read
from ldc.cli.output import write_result
from ldc.diagnostics import Diagnostics
from ldc.draw import Locator, notes_of, pins_from, pou_text, project_svg, rung_svg, rung_text
from ldc.model import resolve
from ldc.parser import ast, parse_file


def run(options: argparse.Namespace) -> int:
    """What parses is drawn, also when other parts have errors: a drawing helps to find them."""
    diagnostics = Diagnostics()
    sources = read([options.source])
    project = ast.Project(tuple(parse_file(file, diagnostics) for file in sources.files))
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
    elif not any(_rungs(project)):
        raise Failure("there is no rung to draw")
    elif options.svg:
        drawn = project_svg(
            [pou for file in project.files for pou in file.pous], comments=comments, **settings
        )
    else:
        ladders = [pou for file in project.files for pou in file.pous if isinstance(pou.body, ast.LadderBody)]
        drawn = "\n\n".join(pou_text(pou, comments=_inside(pou, comments), **settings) for pou in ladders)
    write_result(drawn, options.svg)
    return status


def _rungs(project: ast.Project):
    """POU, number from 1, rung."""
    for file in project.files:
        for pou in file.pous:
            if isinstance(pou.body, ast.LadderBody):
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
        if name in ((rung.name or "").upper(), str(number)) and pou_name in ("", pou.name.upper())
    ]
    if not found:
        names = {rung.name.upper(): rung.name for _, _, rung in _rungs(project) if rung.name}
        close = [names[key] for key in difflib.get_close_matches(name, names, 1)]
        hint = f"; did you mean `{close[0]}`?" if close else ""
        raise UsageError(f"no rung `{wanted}`{hint}")
    if len(found) > 1:
        places = ", ".join(f"{pou.name}.{rung.name or number}" for pou, number, rung in found)
        raise UsageError(f"`{wanted}` is in several POUs: {places}")
    return found[0]
