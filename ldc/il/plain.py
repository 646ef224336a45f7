"""A program whose global variables have names that any compiler reads.

Variables of a program that others reach (``ldc.model.paths``) are globals with the path as their name,
``main.level``; printed they are ``main_level``.
"""

from __future__ import annotations

from ldc.expr import Place
from ldc.free_names import claimed
from ldc.il.program import Program, RungCode, Unit
from ldc.il.rename import renamed
from ldc.records import replace
from ldc.symbols import Variable


def has_paths(unit: Unit) -> bool:
    """Whether the unit uses such variables, or gives them to others."""
    return any("." in v.name for v in unit.variables) or any(
        isinstance(o, Place) and o.is_global and "." in o.root and o.root[0] != "%"
        for rung in unit.rungs for i in rung.code for o in (i.operand, *i.args, *(p for _, p in i.outputs)))


def without_paths(program: Program) -> Program:
    """The program with such names; itself when it has them already."""
    paths = [v.name for v in program.globals if "." in v.name]
    if not paths:
        return program
    taken = {v.name.upper() for v in program.globals} | {u.name.upper() for u in program.units}
    taken |= {v.name.upper() for u in program.units for v in u.variables}
    names: dict[str, str] = {}
    for path in paths:
        names[path.upper()] = claimed(path.replace(".", "_"), taken)

    def name_of(place: Place) -> str:
        return names.get(place.root.upper(), place.root) if place.is_global else place.root

    def own(code: RungCode) -> RungCode:
        return replace(code, code=tuple(renamed(i, name_of) for i in code.code))

    def declared(variables: tuple[Variable, ...]) -> tuple[Variable, ...]:
        return tuple(replace(v, name=names.get(v.name.upper(), v.name)) for v in variables)

    units = tuple(replace(unit, rungs=tuple(map(own, unit.rungs)), variables=declared(unit.variables))
                  for unit in program.units)
    return replace(program, units=units, globals=declared(program.globals))
