"""Configuration, resources, tasks and program instances as TC6 has them.

Other tools keep the names of POUs, tasks, resources and instances in one space and want an interval for every
task; where this project says otherwise, what it says is kept beside what is written (``tags.own_data``).
"""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element

from ldc.durations import duration_text
from ldc.export.plcopen.declarations import Notes, section, variable
from ldc.export.plcopen.tags import add, own_data
from ldc.free_names import claimed
from ldc.model.project import Model, Resource
from ldc.parser import ast
from ldc.parser.unparse import expr_text

_NAME = "config"
_Originals = dict[str, tuple[str, str]]
"""By attribute, what was written and what the project says."""


def configuration(
    parent: Element, files: Sequence[ast.File], model: Model, period: int, notes: Notes
) -> None:
    """What runs where. ``period``: nanoseconds between two scans, for tasks that run in every scan."""
    written = [c for file in files for c in file.configurations][:1]
    taken = {name.upper() for name in (*model.pous, *model.globals, *model.types)}
    made = add(parent, "configuration", name=_free(written[0].name if written else _NAME, taken))
    blocks = {r.name.upper(): r.var_blocks for c in written for r in c.resources}
    for resource in model.resources:
        _resource(made, resource, blocks.get(resource.name.upper(), ()), model, period, taken, notes)
    shared = [*(b for file in files for b in file.globals), *(b for c in written for b in c.var_blocks)]
    for block in shared:
        if block.kind == "VAR_GLOBAL":
            section(made, block, notes)
    completed = [v for block in shared if block.kind == "VAR_CONFIG" for v in block.variables]
    if completed:
        holder = add(made, "configVars")
        for declared in completed:
            variable(holder, declared, notes, "configVariable", "instancePathAndName")


def _resource(parent: Element, resource: Resource, blocks: Sequence[ast.VarBlock], model: Model, period: int,
              taken: set[str], notes: Notes) -> None:
    made, originals = _named(parent, "resource", resource.name, taken)
    for task in resource.tasks:
        single = None if task.single is None else expr_text(task.single)
        interval = f"T#{duration_text(period if task.interval is None else task.interval)}"
        row, changed = _named(made, "task", task.name, taken, priority=task.priority, single=single,
                              interval=interval if single is None else None)
        if task.interval is None and single is None:
            changed["interval"] = (interval, "")
        for run in resource.runs:
            if run.task.upper() == task.name.upper():
                signature = model.pous[run.pou].signature
                _keep(*_named(row, "pouInstance", run.name, taken,
                              typeName=signature.written or signature.name))
        _keep(row, changed)
    for block in blocks:
        section(made, block, notes)
    _keep(made, originals)
    kept = own_data(made, "placement")
    kept.set("processor", resource.processor)
    kept.set("programs", " ".join(run.name for run in resource.runs))


def _free(name: str, taken: set[str]) -> str:
    """The name, with a number when something else has it."""
    return claimed(name, taken, 1)


def _named(
    parent: Element, tag: str, name: str, taken: set[str], **attributes: object
) -> tuple[Element, _Originals]:
    written = _free(name, taken)
    made = add(parent, tag, name=written, **attributes)
    return made, {} if written == name else {"name": (written, name)}


def _keep(element: Element, originals: _Originals) -> None:
    if originals:
        holder = own_data(element, "originals")
        for attribute, (written, value) in originals.items():
            add(holder, "original", attribute=attribute, written=written, value=value)
