"""Names for the printed text: no variable, label or POU may be a word of IL for other compilers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ldc.expr import Const, Expr, FieldStep, IndexStep, Load, Place
from ldc.il.program import OPCODES, Unit
from ldc.parser.lexer import SOFT
from ldc.symbols import Variable
from ldc.types import Array, Instance, Struct, Type

IL_WORDS = frozenset(op for op in OPCODES if op.isalpha()) - {"LABEL", "FN", "EXT", "ACT"} | SOFT


def renamed(names: Iterable[str], clashes: Iterable[str], taken: Iterable[str] = (),
            suffix: bool = False) -> dict[str, str]:
    """By capitals, ``_name`` (``_name2`` …), with ``suffix`` ``name_1`` (``name_2`` …), for each of
    ``names`` that is among ``clashes`` (in capitals)."""
    names, clashes = list(names), set(clashes)
    bad = {n.upper() for n in names} & clashes
    if not bad:
        return {}
    used = clashes | {n.upper() for n in (*names, *taken)}
    result: dict[str, str] = {}
    for name in names:
        if name.upper() not in bad or name.upper() in result:
            continue
        fresh, count = f"{name}_1" if suffix else f"_{name}", 1
        while fresh.upper() in used:
            count += 1
            fresh = f"{name}_{count}" if suffix else f"_{name}{count}"
        used.add(fresh.upper())
        result[name.upper()] = fresh
    return result


class Names:
    """How POUs, globals and the variables of every POU are called in the printed text. The pins of
    standard blocks (``R`` of a counter) keep their names: they are the standard's."""

    def __init__(self, units: Iterable[Unit] = (), globals: Iterable[Variable] = ()) -> None:
        units, globals = tuple(units), tuple(globals)
        self._pous = renamed([u.name for u in units], IL_WORDS)
        self._globals = renamed([v.name for v in globals], IL_WORDS)
        self._variables = {u.name.upper(): self._of_unit(u) for u in units}
        self._types = {u.name.upper(): {v.name.upper(): v.type for v in u.variables} for u in units}
        self._global_types = {v.name.upper(): v.type for v in globals}
        self._any = bool(self._pous or self._globals or any(self._variables.values()))

    def _of_unit(self, unit: Unit) -> dict[str, str]:
        if unit.standard:
            return {}
        own = [v.name for v in unit.variables if v.kind != "external"]
        externals = {v.name.upper(): self._globals[v.name.upper()] for v in unit.variables
                     if v.kind == "external" and v.name.upper() in self._globals}
        result = renamed(own, IL_WORDS, externals.values()) | externals
        if unit.kind == "FUNCTION" and unit.name.upper() in self._pous:
            result[unit.name.upper()] = self._pous[unit.name.upper()]
        return result

    def pou(self, name: str) -> str:
        return self._pous.get(name.upper(), name)

    def variable(self, unit: str, name: str) -> str:
        """A variable or pin of the POU ``unit``."""
        return self._variables.get(unit.upper(), {}).get(name.upper(), name)

    def globally(self, name: str) -> str:
        return self._globals.get(name.upper(), name)

    def place(self, unit: str, place: Place) -> str:
        """A place as text; in the usual case, nothing renamed, that is ``str(place)``."""
        return self._walk(unit, place) if self._any else str(place)

    def _walk(self, unit: str, place: Place) -> str:
        key = place.root.upper()
        if place.is_global:
            text, type_ = self.globally(place.root), self._global_types.get(key)
        else:
            text, type_ = self.variable(unit, place.root), self._types.get(unit.upper(), {}).get(key)
        for step in place.steps:
            match step:
                case FieldStep(name):
                    name, type_ = self._field(type_, name)
                    text += f".{name}"
                case IndexStep(indexes):
                    text += f"[{', '.join(self._index(unit, i) for i in indexes)}]"
                    type_ = type_.element if isinstance(type_, Array) else None
                case _:
                    text += f".{step.bit}"
        return text

    def _field(self, type_: Type | None, name: str) -> tuple[str, Type | None]:
        match type_:
            case Instance(pou):
                types: Mapping[str, Type] = self._types.get(pou.upper(), {})
                return self.variable(pou, name), types.get(name.upper())
            case Struct():
                field = type_.field(name)
                return name, field.type if field else None
        return name, None

    def _index(self, unit: str, index: Expr) -> str:
        match index:
            case Load(place):
                return self._walk(unit, place)
            case Const(value):
                return str(value)
        return "..."
