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
_RETAIN = {False: "", True: " RETAIN", None: " NON_RETAIN"}


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
        if value is None or value == default(type_):
            return ""
        return f" := {initial_text(value, type_, self.pins)}"

    def types(self, types: Iterable[Type]) -> Iterator[str]:
        """``TYPE`` … ``END_TYPE`` for all named types in ``types`` and inside of them, each after those
        that it needs; nothing when there are none."""
        named: dict[str, Type] = {}
        for type_ in types:
            _collect(type_, named)
        if not named:
            return
        yield "TYPE"
        for type_ in named.values():
            match type_:
                case Struct(name, fields):
                    yield f"    {name} : STRUCT"
                    width = max((len(f.name) for f in fields), default=0)
                    for f in fields:
                        initial = self.initial(f.initial, f.type)
                        yield f"        {f.name:<{width}} : {self.type_of(f.type)}{initial};"
                    yield "    END_STRUCT;"
                case Enum(name, values, default_):
                    first = next((n for n, v in values if v == default_), None)
                    suffix = f" := {first}" if first and values[0][1] != default_ else ""
                    yield f"    {name} : {enum_text(type_)}{suffix};"
                case Subrange(name):
                    yield f"    {name} : {subrange_text(type_)};"
        yield "END_TYPE"
        yield ""

    def variables(self, variables: Iterable[Variable], unit: str | None, indent: str = "") -> Iterator[str]:
        """VAR blocks in the order given, one per run of variables of one kind."""
        for (keyword, retain, constant, made), group in groupby(variables, _block_of):
            qualifiers = " CONSTANT" * constant + _RETAIN[retain]
            note = " (* made by ldc *)" if made else ""
            yield f"{indent}{keyword}{qualifiers}{note}"
            rows = self._declared(list(group), unit)
            width = max(len(name) for name, _ in rows)
            for name, v in rows:
                initial = "" if v.kind == "external" else self.initial(v.initial, v.type)
                yield f"{indent}    {name:<{width}} : {self.type_of(v.type)}{initial};"
            yield f"{indent}END_VAR"

    def _declared(self, variables: list[Variable], unit: str | None) -> list[tuple[str, Variable]]:
        """The names, with their addresses in a column of their own."""
        names = [self.names.globally(v.name) if unit is None else self.names.variable(unit, v.name)
                 for v in variables]
        at = [None if v.kind == "external" else v.location for v in variables]
        width = max((len(n) for n, place in zip(names, at) if place), default=0)
        return [(f"{name:<{width}} AT {place}" if place else name, v)
                for name, place, v in zip(names, at, variables)]

    def configuration(self, program: Program) -> Iterator[str]:
        """``CONFIGURATION`` … ``END_CONFIGURATION``.

        For compilers that keep all names in one space no instance is called like a POU (as ldc calls
        them by default), and nothing else like an instance: they get a suffix, ``conveyor_1``.
        """
        if not program.resources and not program.globals:
            return
        pous = set(self._units)
        instances = renamed((_last(r.name) for s in program.resources for r in s.runs), pous, suffix=True)
        taken = pous | {instances.get(n, n) for s in program.resources for r in s.runs
                        for n in (_last(r.name).upper(),)}
        taken = {n.upper() for n in taken} | {v.name.upper() for v in program.globals}
        resources = renamed((s.name for s in program.resources), taken, suffix=True)
        taken |= {resources.get(s.name.upper(), s.name).upper() for s in program.resources}
        name = _identifier(program.name) or "config"
        yield f"CONFIGURATION {renamed((name,), taken, suffix=True).get(name.upper(), name)}"
        yield from self.variables(program.globals, None, "    ")
        for resource in program.resources:
            yield from self._resource(resource, resources, instances)
        yield "END_CONFIGURATION"

    def _resource(self, resource: Resource, resources: dict[str, str],
                  instances: dict[str, str]) -> Iterator[str]:
        name = resources.get(resource.name.upper(), resource.name)
        yield f"    RESOURCE {name} ON {resource.processor}"
        for task in resource.tasks:
            yield f"        TASK {task.name} ({self._task(task)});"
        for run in resource.runs:
            instance, unit = _last(run.name), self._units.get(run.pou.upper())
            pou = self.names.pou(unit.name if unit else run.pou)
            yield f"        PROGRAM {instances.get(instance.upper(), instance)} WITH {run.task} : {pou};"
        yield "    END_RESOURCE"

    def _task(self, task: Task) -> str:
        parts = []
        if task.single is not None:
            parts.append(f"SINGLE := {self.names.place('', task.single)}")
        if task.interval is not None:
            parts.append(f"INTERVAL := {time_text(task.interval)}")
        return ", ".join((*parts, f"PRIORITY := {task.priority}"))


def _collect(type_: Type, named: dict[str, Type]) -> None:
    match type_:
        case Array(element=element):
            _collect(element, named)
        case Struct(name, fields) if name not in named:
            for field in fields:
                _collect(field.type, named)
            named[name] = type_
        case Enum(name) | Subrange(name) if name:
            named.setdefault(name, type_)


def _block_of(variable: Variable) -> tuple[str, bool | None, bool, bool]:
    made = variable.name.upper().startswith("_LDC_")
    keyword = "VAR" if made else _KEYWORD[variable.kind]
    return keyword, not made and variable.retain, variable.constant, made


def _last(path: str) -> str:
    return path.rsplit(".", 1)[-1]


def _identifier(name: str) -> str:
    """``name`` made an identifier of IEC 61131-3."""
    text = "".join(c if c.isascii() and c.isalnum() else "_" for c in name)
    parts = [p for p in text.split("_") if p]
    return "_" * (bool(parts) and parts[0][0].isdigit()) + "_".join(parts)
