"""Where every variable of one resource lives: cells of the namespace, or bits of a byte image.

All scalars of program instances and all globals are entries ("cells") of one namespace, which the
generated code reads and writes as module globals: the fastest general store that CPython has.
Located variables with the same address and type share one cell. Where addresses overlap in another
way (``%IX0.3`` and ``%IB0``, or INT and WORD at ``%QW0``) the variables are packed in a byte image.
"""

from __future__ import annotations

from collections.abc import Iterator

from ldc.il.homes import Cell, Home, Packed, direct_addresses, end_of, homes, located
from ldc.il.program import Program, Resource, Run, Unit
from ldc.records import record
from ldc.symbols import Location, Variable

NOW, FIRST_SCAN = "_now", "_first_scan"
INTRINSIC = {"%NOW": NOW, "%FIRST_SCAN": FIRST_SCAN}


@record
class Root:
    """A variable that has a path: ``path`` is its root name, ``hidden`` memories are no user's business."""

    path: str
    variable: Variable
    home: Home


@record
class Layout:
    """``globals`` and ``programs`` (one table per program instance) are keyed by names in capitals;
    ``direct`` by canonical address, for addresses used without a declaration."""

    units: dict[str, Unit]
    resource: Resource
    globals: dict[str, Root]
    direct: dict[str, Root]
    programs: tuple[tuple[Run, dict[str, Root]], ...]
    image_bytes: dict[str, int]

    def roots(self) -> Iterator[Root]:
        """Every variable once, in declared order: globals, direct addresses, program instances."""
        yield from self.globals.values()
        yield from self.direct.values()
        for _, table in self.programs:
            yield from table.values()


def slot(name: str) -> str:
    """The Python name for an IEC name: in capitals, so it is no keyword; never a private or dunder name."""
    name = name.upper()
    if name.isascii() and name.isidentifier() and not name.startswith("__"):
        return name
    return "x" + "".join(c if c.isascii() and c.isalnum() else f"_{ord(c):x}_" for c in name)


def lay_out(program: Program, resource: int = 0) -> Layout:
    """Places for all variables that the resource runs with. Program instances do not share cells."""
    part = program.resources[resource]
    units = {u.name.upper(): u for u in program.units}
    places = homes(located(program, part, units))
    direct: dict[str, Root] = {}
    for address, type_ in direct_addresses(units.values()).items():
        at = Location.parse(address)
        direct[str(at)] = Root(str(at), Variable(str(at), type_, "global", location=at), places[at, type_])

    def place(path: str, variable: Variable, name: str) -> Root:
        if variable.location is None:
            return Root(path, variable, Cell(name))
        return Root(path, variable, places[variable.location, variable.type])

    globals_ = {v.name.upper(): place(v.name, v, f"g_{slot(v.name)}") for v in program.globals}
    programs = tuple(
        (run, {v.name.upper(): place(f"{run.name}.{v.name}", v, f"p{n}_{slot(v.name)}")
               for v in units[run.pou.upper()].variables if v.kind not in ("temp", "external")})
        for n, run in enumerate(part.runs))
    sizes = dict.fromkeys("IQM", 0)
    for home in places.values():
        if isinstance(home, Packed):
            at = home.location
            sizes[at.area] = max(sizes[at.area], (end_of(at, home.type) + 7) // 8)
    return Layout(units, part, globals_, direct, programs, sizes)
