"""Where every variable of one resource lives: cells of the namespace, or bits of a byte image.

All scalars of program instances and all globals are entries ("cells") of one namespace, which the
generated code reads and writes as module globals: the fastest general store that CPython has.
Located variables with the same address and type share one cell. Where addresses overlap in another
way (``%IX0.3`` and ``%IB0``, or INT and WORD at ``%QW0``) the variables are packed in a byte image.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ldc.expr import Place
from ldc.il.program import Program, Resource, Run, Unit
from ldc.symbols import Location, Variable
from ldc.types import BOOL, BYTE, DWORD, LWORD, WORD, Array, Elementary, Type, storage

BY_SIZE = {"X": BOOL, "B": BYTE, "W": WORD, "D": DWORD, "L": LWORD}
NOW, FIRST_SCAN = "_now", "_first_scan"
INTRINSIC = {"%NOW": NOW, "%FIRST_SCAN": FIRST_SCAN}


@dataclass(frozen=True, slots=True)
class Cell:
    """An entry of the namespace."""

    name: str


@dataclass(frozen=True, slots=True)
class Packed:
    """Bits of the byte image of an area, little-endian; ``type`` is a scalar or an array of scalars."""

    location: Location
    type: Type

    @property
    def name(self) -> str:
        """The namespace entry that holds the image."""
        return f"image_{self.location.area}"


Home = Cell | Packed


@dataclass(frozen=True, slots=True)
class Root:
    """A variable that has a path: ``path`` is its root name, ``hidden`` memories are no user's business."""

    path: str
    variable: Variable
    home: Home


@dataclass(frozen=True, slots=True)
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
    located = _located(program, part, units)
    homes = _homes([(at, type_) for at, type_ in located])
    direct: dict[str, Root] = {}
    for address, type_ in _direct_addresses(units.values()).items():
        at = Location.parse(address)
        direct[str(at)] = Root(str(at), Variable(str(at), type_, "global", location=at), homes[at, type_])

    def place(path: str, variable: Variable, name: str) -> Root:
        if variable.location is None:
            return Root(path, variable, Cell(name))
        return Root(path, variable, homes[variable.location, variable.type])

    globals_ = {v.name.upper(): place(v.name, v, f"g_{slot(v.name)}") for v in program.globals}
    programs = tuple(
        (run, {v.name.upper(): place(f"{run.name}.{v.name}", v, f"p{n}_{slot(v.name)}")
               for v in units[run.pou.upper()].variables if v.kind not in ("temp", "external")})
        for n, run in enumerate(part.runs))
    sizes = dict.fromkeys("IQM", 0)
    for home in homes.values():
        if isinstance(home, Packed):
            at = home.location
            sizes[at.area] = max(sizes[at.area], (_end(at, home.type) + 7) // 8)
    return Layout(units, part, globals_, direct, programs, sizes)


def _located(program: Program, part: Resource, units: dict[str, Unit]) -> list[tuple[Location, Type]]:
    found = [(v.location, v.type) for v in program.globals if v.location is not None]
    for run in part.runs:
        found += [(v.location, v.type) for v in units[run.pou.upper()].variables if v.location is not None]
    found += [(Location.parse(a), t) for a, t in _direct_addresses(units.values()).items()]
    return found


def _direct_addresses(units) -> dict[str, Type]:
    """The direct addresses in the code, canonical, each with the type that its size stands for."""
    found: dict[str, Type] = {}

    def see(operand: object) -> None:
        if isinstance(operand, Place):
            if operand.root[0] == "%" and operand.root not in INTRINSIC:
                at = Location.parse(operand.root)
                found[str(at)] = BY_SIZE[at.size]
            for step in operand.steps:
                for index in getattr(step, "indexes", ()):
                    see(getattr(index, "place", None))

    for unit in units:
        for rung in unit.rungs:
            for instr in rung.code:
                if instr.operand is not None:
                    see(instr.operand)
                for operand in instr.args:
                    see(operand)
                for _, operand in instr.outputs:
                    see(operand)
    return found


def _end(at: Location, type_: Type) -> int:
    """The bit after the last one that a variable covers."""
    return at.byte * 8 + at.bit + at.bits * (type_.count if isinstance(type_, Array) else 1)


def _homes(located: list[tuple[Location, Type]]) -> dict[tuple[Location, Type], Home]:
    """Sweeps over the bits of each area; a cluster of overlapping addresses is either one shared cell
    (all have one address, size and stored type) or packed."""
    homes: dict[tuple[Location, Type], Home] = {}
    order = sorted(set(located), key=lambda p: (p[0].area, p[0].byte * 8 + p[0].bit, p[0].bits, str(p[1])))
    cluster: list[tuple[Location, Type]] = []
    end = -1

    def close() -> None:
        same = len({(at, storage(t)) for at, t in cluster}) == 1
        for at, type_ in cluster:
            if same or not _packable(at, type_):
                unit = f"{at.area}_{at.size}{at.byte}" + (f"_{at.bit}" if at.size == "X" else "")
                homes[at, type_] = Cell(unit if same else f"{unit}_{len(homes)}")
            else:
                homes[at, type_] = Packed(at, type_)

    for at, type_ in order:
        start = at.byte * 8 + at.bit
        if cluster and (cluster[0][0].area != at.area or start >= end):
            close()
            cluster, end = [], -1
        cluster.append((at, type_))
        end = max(end, _end(at, type_))
    if cluster:
        close()
    return homes


def _packable(at: Location, type_: Type) -> bool:
    element = storage(type_.element if isinstance(type_, Array) else type_)
    return isinstance(element, Elementary) and element.bits == at.bits
