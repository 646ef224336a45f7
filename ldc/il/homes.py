"""Where located variables live: each its own cell, or bits of a byte image where addresses overlap.

Located variables with the same address and type share one cell. Where addresses overlap in another
way (``%IX0.3`` and ``%IB0``, or INT and WORD at ``%QW0``) they are packed in the byte image of their area.
"""

from __future__ import annotations

from collections.abc import Iterable

from ldc.expr import Place
from ldc.il.program import Program, Resource, Unit
from ldc.records import record
from ldc.symbols import Location
from ldc.types import BOOL, BYTE, DWORD, LWORD, WORD, Array, Elementary, Type, storage

BY_SIZE = {"X": BOOL, "B": BYTE, "W": WORD, "D": DWORD, "L": LWORD}
# Places that only library text names: the time of the execution, and whether it is the first scan.
INTRINSIC = ("%NOW", "%FIRST_SCAN")


@record
class Cell:
    """An entry of the namespace."""

    name: str


@record
class Packed:
    """Bits of the byte image of an area, little-endian; ``type`` is a scalar or an array of scalars."""

    location: Location
    type: Type

    @property
    def name(self) -> str:
        """The namespace entry that holds the image."""
        return f"image_{self.location.area}"


Home = Cell | Packed


def located(program: Program, part: Resource, units: dict[str, Unit]) -> list[tuple[Location, Type]]:
    found = [(v.location, v.type) for v in program.globals if v.location is not None]
    for run in part.runs:
        found += [(v.location, v.type) for v in units[run.pou.upper()].variables if v.location is not None]
    found += [(Location.parse(a), t) for a, t in direct_addresses(units.values()).items()]
    return found


def direct_addresses(units: Iterable[Unit]) -> dict[str, Type]:
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


def end_of(at: Location, type_: Type) -> int:
    """The bit after the last one that a variable covers."""
    return at.byte * 8 + at.bit + at.bits * (type_.count if isinstance(type_, Array) else 1)


def homes(located: list[tuple[Location, Type]]) -> dict[tuple[Location, Type], Home]:
    """Sweeps over the bits of each area; a cluster of overlapping addresses is either one shared cell
    (all have one address, size and stored type) or packed."""
    found: dict[tuple[Location, Type], Home] = {}
    order = sorted(set(located), key=lambda p: (p[0].area, p[0].byte * 8 + p[0].bit, p[0].bits, str(p[1])))
    cluster: list[tuple[Location, Type]] = []
    end = -1

    def close() -> None:
        same = len({(at, storage(t)) for at, t in cluster}) == 1
        for at, type_ in cluster:
            if same or not packable(at, type_):
                unit = f"{at.area}_{at.size}{at.byte}" + (f"_{at.bit}" if at.size == "X" else "")
                found[at, type_] = Cell(unit if same else f"{unit}_{len(found)}")
            else:
                found[at, type_] = Packed(at, type_)

    for at, type_ in order:
        start = at.byte * 8 + at.bit
        if cluster and (cluster[0][0].area != at.area or start >= end):
            close()
            cluster, end = [], -1
        cluster.append((at, type_))
        end = max(end, end_of(at, type_))
    if cluster:
        close()
    return found


def packable(at: Location, type_: Type) -> bool:
    element = storage(type_.element if isinstance(type_, Array) else type_)
    return isinstance(element, Elementary) and element.bits == at.bits
