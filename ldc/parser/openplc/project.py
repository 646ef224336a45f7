"""``project.json``: types, global variables, tasks, and in older files the POUs themselves.

Declarations in JSON are put together as the words of the same declarations in IEC 61131-3, each where it
stands, and read like these.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.findings import TooMany
from ldc.parser.foreign import Reading
from ldc.parser.openplc.declarations import Declarations
from ldc.parser.openplc.drawing import Drawings
from ldc.parser.openplc.known import FORMAT
from ldc.parser.openplc.pou import additions, drawn_pou, interface
from ldc.parser.openplc.types import plain_pou, plain_section, plain_type
from ldc.parser.openplc.values import JsonText, Value
from ldc.parser.plcopen.guarded import Pins
from ldc.parser.plcopen.structured import statements
from ldc.parser.plcopen import texts
from ldc.parser.reader import Reader
from ldc.records import replace
from ldc.source import SourceFile, Span

_NOT_LOGIC = ("servers", "remoteDevices", "debugVariables")
_MOST_PRIORITY = 65535


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """All that the project declares; POUs in files of their own are read with these."""
    reading = Reading(source, FORMAT, diagnostics)
    text = JsonText(reading, 0)
    if text.root is None:
        return ast.File(source, (), (), (), (), (), True)
    return _Project(reading, text, text.root.get("data") or text.root).file()


class _Project:
    """``pous``: the JSON of each POU, by where its name stands."""

    def __init__(self, reading: Reading, text: JsonText, data: Value) -> None:
        self.reading, self.text, self.data = reading, text, data
        self.declarations = Declarations(reading, text)
        self.pous = {}

    def file(self) -> ast.File:
        words = self.declarations
        resource = self.data.get("configuration", "resource")
        words.types(self.data.items("dataTypes"))
        words.section("VAR_GLOBAL", [*self.data.items("globalVariables"),
                                     *(resource.items("globalVariables") if resource is not None else ())])
        for pou in self.data.items("pous"):
            data = pou.get("data") or pou
            name = words.pou(pou.text("type"), data)
            if name is not None:
                self.pous[name] = data
        reader = Reader(words.tokens, self.reading.diagnostics)
        try:
            if words.tokens.types:
                reader.read()
        except TooMany:
            reader.units.lost = True
        configurations = (self._configuration(resource),) if resource is not None else ()
        for key in _NOT_LOGIC:
            value = self.data.get(key)
            if value is not None and value.data:
                self.reading.left_out(Span(self.reading.source, value.start, value.start + 1), f"`{key}`",
                                      "communication is set up where the program runs")
        pous = self._bodies(reader.pous)
        types = tuple(map(plain_type, reader.type_decls))
        shared = tuple(plain_section(words.noted(section)) for section in reader.globals)
        return ast.File(self.reading.source, pous, types, shared, tuple(c for c in configurations if c), (),
                        self.reading.lost or reader.units.lost, tuple(self.reading.remarks))

    # ---- bodies

    def _bodies(self, heads: list[ast.Pou]) -> tuple[ast.Pou, ...]:
        """The POUs with their bodies, and behind them the function blocks that their drawings need."""
        heads = [plain_pou(replace(h, var_blocks=tuple(map(self.declarations.noted, h.var_blocks))))
                 for h in heads]
        interfaces = {h.name.upper(): interface(h) for h in heads if h.kind == "FUNCTION_BLOCK"}
        made: dict[str, ast.Pou] = {}
        found = []
        for head in heads:
            data = self.pous.get(head.name_span.start)
            if data is not None:
                pou, *more = self._body(head, data, interfaces)
                found.append(replace(pou, title=" ".join(data.text("documentation").split())[:200] or None))
                made |= {m.name.upper(): m for m in more}
        return (*found, *made.values())

    def _body(self, pou: ast.Pou, data: Value, interfaces: dict[str, Pins]) -> tuple[ast.Pou, ...]:
        language, value = data.text("body", "language"), data.get("body", "value")
        if value is None:
            self.reading.malformed(pou.name_span, f"`{pou.name}` has no body")
        elif language in ("ld", "fbd"):
            more = additions(pou, interfaces)
            drawn = Drawings(self.reading, self.text, pou.name, more)
            return drawn_pou(pou, drawn.body(value), more, self.reading)
        elif language in ("st", "il") and isinstance(value.data, str):
            ending = f"{self.reading.source.path} ({pou.name}.{language})"
            span = Span(SourceFile(ending, value.data), 0, len(value.data))
            if language == "il":
                return (replace(pou, body=ast.TextBody("IL", span)),)
            return (replace(pou, body=statements(span, self.reading.diagnostics)),)
        else:
            self.reading.unsupported(pou.name_span, f"the body of `{pou.name}` in `{language[:40]}`",
                                     "write it in LD, FBD, ST or IL")
        return (pou,)

    # ---- tasks

    def _configuration(self, resource: Value) -> ast.Configuration | None:
        tasks = tuple(map(self._task, resource.items("tasks")))
        programs = tuple(map(self._instance, resource.items("instances")))
        if not tasks and not programs:
            return None
        span = self.text.span(resource)
        made = ast.Resource("Res0", "Res0", (), tuple(t for t in tasks if t), programs, span)
        return ast.Configuration("Config0", (), (made,), span)

    def _task(self, task: Value) -> ast.Task | None:
        span = self.text.span(task)
        name, interval = task.get("name"), task.get("interval")
        if task.text("triggering") == "Interrupt":
            self.reading.unsupported(self.text.content(name) if name else span,
                                     "a task that waits for an interrupt", "give the task an interval")
            return None
        level = min(max(task.number("priority"), 0), _MOST_PRIORITY)
        priority = ast.Literal(level, None, str(level), span)
        every = None
        if interval is not None and task.text("interval").strip():
            every = texts.expression(self.text.content(interval), self.reading.diagnostics)
        return ast.Task(texts.label(task.text("name"), "task"), every, None, priority, span)

    def _instance(self, instance: Value) -> ast.ProgramInstance:
        task = texts.label(instance.text("task"), "task") if instance.text("task") else None
        pou = instance.text("program")
        name = texts.label(instance.text("name"), pou)
        return ast.ProgramInstance(name, task, pou, self.text.span(instance))
