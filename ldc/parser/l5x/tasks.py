"""Tasks: periodic ones by their rate, the continuous one in every scan."""

from __future__ import annotations

from ldc.parser import ast
from ldc.parser.l5x.writer import Context
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.texts import time_literal
from ldc.source import Span

_LEAST_URGENT = 16
_NANOSECONDS = 1_000_000


def configurations(
    controller: Node, programs: dict[str, str], context: Context,
) -> tuple[ast.Configuration, ...]:
    """None when the file tells no tasks (an export of parts): then every program runs in every scan.
    ``programs``: our names by theirs in capitals."""
    nodes = [n for group in controller.all("Tasks") for n in group.all("Task")]
    if not nodes or not programs:
        return ()
    tasks, runs, scheduled = [], [], set()
    for node in nodes:
        task = _task(node, context)
        if task is None:
            continue
        listed = [n for group in node.all("ScheduledPrograms") for n in group.all("ScheduledProgram")]
        names = [n.get("Name").upper() for n in listed]
        for place, name in zip(listed, names, strict=True):
            if name not in programs:
                context.reading.malformed(place.span, f"there is no program `{place.get('Name')[:40]}`",
                                          help="export the controller with all of its programs")
            elif name not in scheduled:
                scheduled.add(name)
                span = place.attribute("Name")
                run = context.names.fresh(f"run_{programs[name]}")
                runs.append(ast.ProgramInstance(run, task.name if task.interval else None, programs[name],
                                                span))
        if task.interval and names:
            tasks.append(task)
    if not runs:
        return ()
    span = controller.attribute("Name") if controller.get("Name") else controller.span
    name = context.names.fresh(controller.get("Name") or "controller")
    resource = ast.Resource(context.names.fresh("resource"), "master", (), tuple(tasks), tuple(runs), span)
    return (ast.Configuration(name, (), (resource,), span),)


def _task(node: Node, context: Context) -> ast.Task | None:
    name, span, kind = node.get("Name"), node.attribute("Name"), node.get("Type").upper()
    if kind == "EVENT":
        context.reading.unsupported(node.span, f"event task {name}", "make it periodic")
        return None
    interval = None
    if kind == "PERIODIC":
        interval = _rate(node.get("Rate"), node.attribute("Rate"))
        if interval is None:
            context.reading.malformed(node.attribute("Rate"), f"task {name} has no rate",
                                      help="give it in milliseconds")
            return None
    priority = node.number("Priority", 10)
    if not 0 <= priority < _LEAST_URGENT:
        priority = _LEAST_URGENT - 1
    literal = ast.Literal(priority, None, str(priority), span)
    return ast.Task(context.names.name(name, span, f"task {name.upper()}"), interval, None, literal, span)


def _rate(text: str, span: Span) -> ast.Expr | None:
    try:
        value = round(float(text) * _NANOSECONDS)
    except (ValueError, OverflowError):
        return None
    return time_literal(value, span) if 0 < value < 1 << 62 else None
