"""Where the sources declare what a runtime refuses: it knows paths, not sources (docs/online.md)."""

from __future__ import annotations

import re
from collections.abc import Iterable

from ldc import pipeline
from ldc.diagnostics import Diagnostic, Label
from ldc.il.program import Program
from ldc.records import replace
from ldc.source import Span
from ldc.symbols import Variable
from ldc.types import Array, Instance


def placed(found: Iterable[Diagnostic], result: pipeline.Compiled) -> list[Diagnostic]:
    """The findings, those about a variable or a task at its declaration in the sources of ``result``."""
    made = []
    for diagnostic in found:
        span = None
        if diagnostic.about:
            span = _task(diagnostic.about, result) or _variable(diagnostic.about, result.program)
        made.append(diagnostic if span is None else replace(diagnostic, primary=Label(span, "declared here")))
    return made


def _task(name: str, result: pipeline.Compiled) -> Span | None:
    tasks = (task for resource in result.model.resources for task in resource.tasks)
    return next((task.span for task in tasks if task.name.upper() == name.upper()), None)


def _variable(path: str, program: Program) -> Span | None:
    """The declaration of a variable, or of the member of a block that the path leads to."""
    names = re.sub(r"\[[^\]]*\]", "", path).upper().split(".")
    units = {unit.name.upper(): unit for unit in program.units}
    runs = {run.name.upper(): run for resource in program.resources for run in resource.runs}
    variables = program.globals
    if names[0] in runs and len(names) > 1:
        variables = units[runs[names.pop(0)].pou.upper()].variables
    span = None
    for name in names:
        found = _named(variables, name)
        if found is None:
            break
        span, type_ = found.span or span, found.type
        while isinstance(type_, Array):
            type_ = type_.element
        if not isinstance(type_, Instance):
            break
        variables = units[type_.pou.upper()].variables
    return span


def _named(variables: Iterable[Variable], name: str) -> Variable | None:
    return next((variable for variable in variables if variable.name.upper() == name), None)
