"""Configurations, resources, tasks and program instances (PLCopen TC6 XML, instances)."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.free_names import claimed
from ldc.parser import ast
from ldc.parser.plcopen import findings, interface, kept, texts
from ldc.parser.plcopen.document import Node
from ldc.records import replace

_UNITS = {"ns": 1, "us": 1_000, "µs": 1_000, "ms": 1_000_000, "s": 1_000_000_000}
_MOST_PRIORITY = 65535


def configuration(node: Node, diagnostics: Diagnostics) -> ast.Configuration:
    resources = _apart([resource(child, diagnostics) for child in node.all("resource")])
    name = texts.label(node.get("name"), "configuration")
    blocks = interface.var_blocks(node, diagnostics) + interface.config_vars(node, diagnostics)
    return ast.Configuration(name, blocks, resources, node.whole)


def _apart(resources: list[ast.Resource]) -> tuple[ast.Resource, ...]:
    """Resources whose instances of programs have different names: in TC6 each resource has names of its own.
    An instance that is called like one of another resource gets the name of its resource before its own."""
    seen: set[str] = set()
    found = []
    for one in resources:
        programs = tuple(
            replace(program, name=f"{one.name}_{program.name}") if program.name.upper() in seen else program
            for program in one.programs)
        seen.update(program.name.upper() for program in one.programs)
        found.append(replace(one, programs=programs))
    return tuple(found)


def resource(node: Node, diagnostics: Diagnostics) -> ast.Resource:
    """A resource; it is the processor of its name."""
    tasks, programs = [], []
    names = {child.get("name").strip().upper() for child in node.all("task")}
    for child in node.all("task"):
        if child.get("name").strip():
            name = texts.label(kept.original(child, "name"), "task")
        else:
            name = claimed("unnamed", names)
        tasks.append(_task(child, name, diagnostics))
        programs += _programs(child, name)
    programs += _programs(node, None)
    name = texts.label(kept.original(node, "name"), "resource")
    blocks = interface.var_blocks(node, diagnostics)
    processor, order = kept.placement(node)
    programs.sort(key=lambda program: order.get(program.name.upper(), len(order)))
    return ast.Resource(name, processor or name, blocks, tuple(tasks), tuple(programs), node.whole)


def running(
    configurations: tuple[ast.Configuration, ...], pous: tuple[ast.Pou, ...], diagnostics: Diagnostics
) -> tuple[ast.Configuration, ...]:
    """The configurations; when none of them runs a program, the first one runs all, in its first task."""
    programs = [pou for pou in pous if pou.kind == "PROGRAM"]
    resources = [resource for found in configurations for resource in found.resources]
    if not configurations or not programs or any(resource.programs for resource in resources):
        return configurations
    first = configurations[0]
    own = first.resources or (ast.Resource("resource", "resource", (), (), (), first.span),)
    tasks = own[0].tasks
    task = tasks[0].name if tasks else None
    made = tuple(ast.ProgramInstance(pou.name, task, pou.name, pou.name_span) for pou in programs)
    findings.nothing_runs(diagnostics, resources[0].span if resources else first.span, len(programs), task)
    return (replace(first, resources=(replace(own[0], programs=made), *own[1:])), *configurations[1:])


def _task(node: Node, name: str, diagnostics: Diagnostics) -> ast.Task:
    interval = texts.duration(node, "interval", diagnostics)
    if interval is not None and not kept.original(node, "interval"):
        interval = None  # one was written for the sake of other tools
    elif interval is None:
        settings = next(node.descendants("TaskSettings"), None)
        if settings is not None:
            unit = _UNITS.get(settings.get("IntervalUnit"), 1_000_000)
            interval = texts.time_literal(settings.number("Interval") * unit, settings.span)
    single = None
    if node.get("single").strip().startswith("@"):
        message = f"the task `{name}` waits for an event of the system"
        findings.unsupported(diagnostics, node.attribute("single"), message, "no variable",
                             "give it an interval, or a variable that starts it")
    elif node.get("single").strip():
        single = texts.expression(node.attribute("single"), diagnostics)
    if isinstance(single, ast.Literal):
        single = None
    level = min(max(node.number("priority"), 0), _MOST_PRIORITY)
    priority = ast.Literal(level, None, str(level), node.attribute("priority"))
    return ast.Task(name, None if single is not None else interval, single, priority, node.span)


def _programs(node: Node, task: str | None) -> list[ast.ProgramInstance]:
    """``typeName`` is empty in some exports (the instance then has the name of its program), and is called
    ``type`` in old ones; some editors write instances beside the tasks and name their task."""
    found = []
    for child in node.all("pouInstance", "programInstance"):
        pou = child.get("typeName").strip() or child.get("type").strip() or child.get("name").strip()
        of = task or child.get("taskName").strip() or None
        found.append(ast.ProgramInstance(texts.label(kept.original(child, "name"), pou), of, pou, child.span))
    return found
