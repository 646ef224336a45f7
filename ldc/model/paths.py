"""Variables of a program that others reach by its name: ``PLC_PRG.level`` (docs/ladder.md).

The standard keeps programs to themselves (3rd edition, 6.6.1.7); many editors do not. A variable that is
reached is a global variable with the path as its name, which the program itself uses as VAR_EXTERNAL. For
this the program must be there once.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import lru_cache
from pathlib import PurePosixPath

from ldc.model.chart_names import ACTION, STEP
from ldc.model.names import PREFIX
from ldc.model.project import Model, Pou
from ldc.parser import ast, sfc
from ldc.patterns import Pattern
from ldc.records import is_record, replace
from ldc.source import SourceFile, Span
from ldc.symbols import Variable

_REACHED = ("local", "input", "output", "external")
_PATH = Pattern(
    r"\(\*.*?\*\)|//[^\r\n]*|'(?:[^'$\n]|\$.)*'|\"(?:[^\"$\n]|\$.)*\""
    r"|([A-Za-z_]\w*)\s*\.\s*([A-Za-z_]\w*)", re.DOTALL)


def programs(model: Model) -> dict[str, str]:
    """The programs (capitals) by all names that they have: their own and those of their instances."""
    own = {key: key for key, pou in model.pous.items() if pou.signature.kind == "PROGRAM"}
    return own | {run.name.upper(): run.pou for resource in model.resources for run in resource.runs}


def with_paths(model: Model) -> Model:
    """The model with the variables that are reached as globals. Which cannot be is told where it is used."""
    names = programs(model)
    made: dict[str, Pou] = {}
    shared = dict(model.globals)
    for program, key in _used(model, names):
        pou = made.get(program, model.pous[program])
        run, variable = run_of(model, program), pou.variables.get(key)
        if run is None or variable is None or variable.kind == "external" or not _can_be(pou, variable):
            continue
        path = f"{run}.{variable.name}"
        shared[path.upper()] = replace(variable, name=path, kind="global")
        initial = variable.initial if variable.constant else None
        outside = replace(variable, name=path, kind="external", initial=initial, retain=False)
        made[program] = replace(pou, variables={**pou.variables, key: outside})
    lists = frozenset(map(list_of, model.globals.values()))
    return replace(model, pous=model.pous | made, globals=shared, programs=names, lists=lists)


def run_of(model: Model, program: str) -> str | None:
    """The name of the only instance of a program, when there is one processor; None otherwise."""
    runs = [run.name for resource in model.resources for run in resource.runs if run.pou == program]
    return runs[0] if len(runs) == 1 and len(model.resources) == 1 else None


def reached(model: Model, program: str, key: str) -> Variable | None:
    """The global that a variable of a program is."""
    run, variable = run_of(model, program), model.pous[program].variables.get(key)
    if run is None or variable is None or variable.kind != "external":
        return None
    return model.globals.get(variable.name.upper())


def why_not(model: Model, program: str, key: str) -> str:
    """Why a variable of a program is not reached."""
    pou = model.pous[program]
    runs = [run.name for resource in model.resources for run in resource.runs if run.pou == program]
    variable = pou.variables.get(key)
    if not runs:
        return f"no task runs {pou.name}"
    if len(runs) > 1:
        return f"{pou.name} runs as {' and '.join(runs[:4])}"
    if len(model.resources) > 1:
        return "the programs run on several processors"
    if pou.signature.action(key):
        return f"an action of {pou.name}, which only {pou.name} calls"
    if variable is None:
        return f"{pou.name} has no such variable"
    if variable.kind == "temp":
        return "a VAR_TEMP, which is there while its program runs only"
    return "an input with an edge" if variable.kind == "input" else "kept by the chart"


def list_of(variable: Variable) -> str:
    """The name of the list of a global variable: that of its file, in capitals."""
    return "" if variable.span is None else PurePosixPath(variable.span.source.path).stem.upper()


def _can_be(pou: Pou, variable: Variable) -> bool:
    if variable.kind not in _REACHED or any(edge.input.name == variable.name for edge in pou.edges):
        return False
    return variable.type not in (STEP, ACTION) and not variable.name.upper().startswith(PREFIX)


def _used(model: Model, names: dict[str, str]) -> Iterator[tuple[str, str]]:
    """The programs and variables (capitals) that bodies of other POUs name by a path."""
    words = [f"{name}{dot}" for name in names for dot in (".", " ")]
    sources: dict[SourceFile, bool] = {}
    for key, pou in model.pous.items():
        source = pou.body.span.source
        if source not in sources:
            text = source.text.upper()
            sources[source] = any(word in text for word in words)
        if not sources[source]:
            continue
        for first, second in paths_in(pou):
            program = names.get(first)
            hidden = first in pou.variables or first in model.globals
            if program is not None and program != key and not hidden:
                yield program, second


def paths_in(pou: Pou | ast.Pou) -> Iterator[tuple[str, str]]:
    """What stands before and behind the first point of a path, in capitals."""
    stack: list[object] = list(sfc.parts_of(pou))
    if isinstance(pou.body, sfc.SfcBody):
        stack.append(pou.body)
    while stack:
        node = stack.pop()
        if isinstance(node, ast.TextBody):
            at = node.span
            found = _PATH.finditer(at.source.text, at.start, at.end)
            yield from ((match[1].upper(), match[2].upper()) for match in found if match[1])
        elif type(node) is ast.Member and type(node.base) is ast.Name:
            yield node.base.name.upper(), node.name.upper()
        elif isinstance(node, tuple):
            stack += node
        elif is_record(node) and not isinstance(node, Span):
            stack += (getattr(node, name) for name in fields_of(type(node)))


@lru_cache(maxsize=None)
def fields_of(kind: type) -> tuple[str, ...]:
    """The fields of a node that may hold others."""
    return tuple(name for name in kind.__match_args__ if name not in ("span", "name_span"))
