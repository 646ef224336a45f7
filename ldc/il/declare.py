"""Declarations as IEC text: types, variables, the configuration."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import groupby

from ldc.il.literals import enum_text, initial_text, subrange_text, time_text, type_text
from ldc.il.names import Names, renamed
from ldc.il.program import Program, Resource, Task, Unit
from ldc.library import blocks
from ldc.symbols import Variable
from ldc.types import Array, Enum, Instance, Struct, Subrange, Type, Value, default

_KEYWORD = {"input": "VAR_INPUT", "output": "VAR_OUTPUT", "in_out": "VAR_IN_OUT", "local": "VAR",
            "hidden": "VAR", "temp": "VAR_TEMP", "external": "VAR_EXTERNAL", "global": "VAR_GLOBAL"}


class Declarations:
    """Prints declarations; knows the other POUs, whose pins may have initial values."""

    def __init__(self, names: Names, units: Iterable[Unit] = ()) -> None:
        self.names = names
        self._units = {u.name.upper(): u for u in units}

    def pins(self, pou: str) -> dict[str, Type]:
        """Types of the variables of a function block by name in capitals."""
        unit = self._units.get(pou.upper())
        if unit is not None:
            return {v.name.upper(): v.type for v in unit.variables}
        signature = blocks.signature(pou.upper())
        pins = (*signature.inputs, *signature.outputs, *signature.in_outs) if signature else ()
        return {p.name.upper(): p.type for p in pins}

    def type_of(self, type_: Type) -> str:
        match type_:
            case Instance(pou):
                unit = self._units.get(pou.upper())
                return self.names.pou(unit.name if unit else pou)
            case Array(bounds, Instance() as element):
                return type_text(Array(bounds, element)).replace(str(element), self.type_of(element))
        return type_text(type_)

    def initial(self, value: Value | None, type_: Type) -> str:
        """`` := value``, or nothing when it is what the type begins with anyway."""
        if value is None or isinstance(type_, Instance) and not value or value == default(type_):
            return ""
        return f" := {initial_text(value, type_, self.pins)}"

    def types(self, types: Iterable[Type]) -> Iterator[str]:
        """``TYPE`` … ``END_TYPE``; nothing when none has a name."""
        named = [t for t in types if isinstance(t, Struct | Enum | Subrange) and t.name]
        if not named:
            return
        yield "TYPE"
        for type_ in named:
            match type_:
                case Struct(name, fields):
                    yield f"    {name} : STRUCT"
                    width = max((len(f.name) for f in fields), default=0)
                    for f in fields:
                        yield f"        {f.name:<{width}} : {type_text(f.type)}{self.initial(f.initial, f.type)};"
                    yield "    END_STRUCT;"
                case Enum(name, values, initial):
                    first = next((n for n, v in values if v == initial), None)
                    suffix = f" := {first}" if first and values[0][1] != initial else ""
                    yield f"    {name} : {enum_text(type_)}{suffix};"
                case Subrange(name):
                    yield f"    {name} : {subrange_text(type_)};"
        yield "END_TYPE"
        yield ""

    def variables(self, variables: Iterable[Variable], unit: str | None, indent: str = "") -> Iterator[str]:
        """VAR blocks in the order given, one per run of variables of one kind."""
        for (keyword, retain, constant, made), group in groupby(variables, _block_of):
            qualifiers = " CONSTANT" * constant + " RETAIN" * retain
            note = " (* made by ldc *)" if made else ""
            yield f"{indent}{keyword}{qualifiers}{note}"
            rows = [(self._declared(v, unit), v) for v in group]
            width = max(len(name) for name, _ in rows)
            for name, v in rows:
                initial = "" if v.kind == "external" else self.initial(v.initial, v.type)
                yield f"{indent}    {name:<{width}} : {self.type_of(v.type)}{initial};"
            yield f"{indent}END_VAR"

    def _declared(self, variable: Variable, unit: str | None) -> str:
        name = variable.name
        name = self.names.globally(name) if unit is None else self.names.variable(unit, name)
        return f"{name} AT {variable.location}" if variable.location else name

    def configuration(self, program: Program) -> Iterator[str]:
        """``CONFIGURATION`` … ``END_CONFIGURATION``."""
        if not program.resources and not program.globals:
            return
        yield f"CONFIGURATION {_identifier(program.name) or 'config'}"
        yield from self.variables(program.globals, None, "    ")
        for resource in program.resources:
            yield from self._resource(resource, program)
        yield "END_CONFIGURATION"

    def _resource(self, resource: Resource, program: Program) -> Iterator[str]:
        yield f"    RESOURCE {resource.name} ON {resource.processor}"
        for task in resource.tasks:
            yield f"        TASK {task.name} ({self._task(task)});"
        instances = [run.name.rsplit(".", 1)[-1] for run in resource.runs]
        # An instance named like a POU, as ldc names them by default, confuses other compilers.
        fresh = renamed(instances, self._units, suffix=True)
        for run, instance in zip(resource.runs, instances):
            unit = self._units.get(run.pou.upper())
            pou = self.names.pou(unit.name if unit else run.pou)
            yield f"        PROGRAM {fresh.get(instance.upper(), instance)} WITH {run.task} : {pou};"
        yield "    END_RESOURCE"

    def _task(self, task: Task) -> str:
        parts = []
        if task.single is not None:
            parts.append(f"SINGLE := {self.names.place('', task.single)}")
        if task.interval is not None:
            parts.append(f"INTERVAL := {time_text(task.interval)}")
        return ", ".join((*parts, f"PRIORITY := {task.priority}"))


def _block_of(variable: Variable) -> tuple[str, bool, bool, bool]:
    made = variable.name.upper().startswith("_LDC_")
    keyword = "VAR" if made else _KEYWORD[variable.kind]
    return keyword, variable.retain and not made, variable.constant, made


def _identifier(name: str) -> str:
    """``name`` made an identifier of IEC 61131-3."""
    text = "".join(c if c.isascii() and c.isalnum() else "_" for c in name)
    parts = [p for p in text.split("_") if p]
    return "_" * (bool(parts) and parts[0][0].isdigit()) + "_".join(parts)
