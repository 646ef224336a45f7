"""Which outputs a program writes, and the safe values that they take when its task stops."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics, Invalid
from ldc.expr import Place
from ldc.il.program import STORES, Program, Unit
from ldc.symbols import Location
from ldc.types import blocks_in, default
from runtime.layout import Layout
from runtime.symbols import Symbol, Symbols, UnknownSymbol
from runtime.values import coerce

Safe = dict[tuple, tuple[Symbol, object]]
"""By place: what it is, and its value."""


def declared_safe(program: Program, symbols: Symbols) -> Safe:
    """The declared safe values (``Program.safe``) by where they belong; those of other resources are left
    out. Raises Invalid (LD0804) when a value does not fit its output."""
    declared: Safe = {}
    diagnostics = Diagnostics()
    for path, value in program.safe:
        try:
            symbol = symbols.find(path)
            declared[symbol.place] = symbol, coerce(value, symbol.type)
        except UnknownSymbol:
            continue
        except ValueError as error:
            diagnostics.error("LD0804", f"the safe value of `{path}` does not fit: {error}",
                              help=f"give a value of {symbol.type} under [safe] in ldc.toml")
    if len(diagnostics):
        raise Invalid(diagnostics)
    return declared


def safe_states(declared: Safe, layout: Layout, symbols: Symbols,
                runs: tuple[int, ...]) -> list[tuple[Symbol, object]]:
    """The outputs (%Q) that program instances ``runs`` write, each with its safe value: the declared one,
    else FALSE or 0."""
    written: set[tuple[int | None, str]] = set()
    for number in runs:
        _written(layout, layout.units[layout.programs[number][0].pou.upper()], number, written, set())
    found = []
    for number, name in written:
        if number is not None:
            root = layout.programs[number][1].get(name)
        elif name[0] == "%":
            root = layout.direct.get(str(Location.parse(name)))
        else:
            root = layout.globals.get(name)
        if root is not None and root.variable.location is not None and root.variable.location.area == "Q":
            found += symbols.of(root)
    wholes = [declared.get(s.place, (s, default(s.type))) for s in found]
    places = {(s.home, s.keys) for s in found}
    parts = [row for row in declared.values() if row[0].part and (row[0].home, row[0].keys) in places]
    return wholes + parts  # of an output with safe bits the others are those of the whole


def _written(layout: Layout, unit: Unit, number: int | None, found: set[tuple[int | None, str]],
             seen: set[str]) -> None:
    """Roots that the unit stores to; in function blocks and functions only globals matter."""
    external = {v.name.upper() for v in unit.variables if v.kind == "external"}
    for rung in unit.rungs:
        for instr in rung.code:
            places = [place for _, place in instr.outputs]
            if instr.op in STORES:
                places.append(instr.operand)
            for place in places:
                _add(place, number, external, found)
            if instr.op == "FN":
                _enter(layout, instr.name.upper(), found, seen)
    for variable in unit.variables:
        for pou in blocks_in(variable.type):
            _enter(layout, pou.upper(), found, seen)


def _add(place: Place, number: int | None, external: set[str], found: set[tuple[int | None, str]]) -> None:
    name = place.root.upper()
    if place.is_global or name in external:
        found.add((None, name))
    elif number is not None:
        found.add((number, name))


def _enter(layout: Layout, name: str, found: set[tuple[int | None, str]], seen: set[str]) -> None:
    unit = layout.units.get(name)
    if unit is not None and name not in seen:
        seen.add(name)
        _written(layout, unit, None, found, seen)
