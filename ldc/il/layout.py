"""Where every symbol lies: offsets that stay when the program grows (DESIGN section 4).

Code holds no state; state lies in one data area per resource (``D``) and in the process images
(``I``, ``Q``, ``M``), found by symbol path. A compile that is given the previous layout keeps the
offset of every symbol whose type did not change.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable

from ldc.il.program import Program, Unit
from ldc.records import record
from ldc.symbols import Variable
from ldc.types import Array, Elementary, Enum, Instance, String, Struct, Subrange, Type, storage


@record
class Symbol:
    """``path`` in declared spelling; ``offset`` and ``size`` in bytes, ``bit`` for a bit of an image;
    ``type_hash`` changes with anything that would make stored bytes mean something else."""

    path: str
    type: Type
    area: str
    offset: int
    size: int
    type_hash: str
    retain: bool = False
    bit: int | None = None


@record
class Layout:
    symbols: tuple[Symbol, ...]
    size: int

    @property
    def digest(self) -> str:
        """SHA-256 of all paths, places and types."""
        rows = (f"{s.path.upper()}|{s.area}|{s.offset}|{s.bit}|{s.type_hash}|{s.retain}"
                for s in self.symbols)
        return hashlib.sha256("\n".join(sorted(rows)).encode()).hexdigest()


def lay_out(program: Program, previous: Layout | None = None) -> Layout:
    """Places every global and every variable of every program instance.

    Symbols of ``previous`` with the same path and type keep their place; others go behind the end,
    so that an added declaration moves nothing else.
    """
    units = {u.name.upper(): u for u in program.units}
    old = {s.path.upper(): s for s in previous.symbols if s.area == "D"} if previous else {}
    wanted = [(v.name, v) for v in program.globals]
    for resource in program.resources:
        for run in resource.runs:
            wanted += [(f"{run.name}.{v.name}", v) for v in state(units[run.pou.upper()])]
    end = previous.size if previous else 0
    symbols = []
    known: dict[Type, tuple[int, int, str]] = {}  # many instances have one type
    for path, variable in wanted:
        if variable.type not in known:
            known[variable.type] = *measure(variable.type, units), type_hash(variable.type, units)
        size, align, digest = known[variable.type]
        if variable.location is not None:
            place = variable.location
            bit = place.bit if place.size == "X" else None
            symbols.append(Symbol(path, variable.type, place.area, place.byte, size, digest,
                                  bool(variable.retain), bit))
            continue
        kept = old.get(path.upper())
        if kept is not None and kept.type_hash == digest:
            offset = kept.offset
        else:
            offset = -(-end // align) * align
            end = offset + size
        symbols.append(Symbol(path, variable.type, "D", offset, size, digest, bool(variable.retain)))
    return Layout(tuple(symbols), end)


def state(unit: Unit) -> tuple[Variable, ...]:
    """The variables of a POU that live from one execution to the next."""
    return tuple(v for v in unit.variables if v.kind not in ("temp", "external"))


def measure(type_: Type, units: dict[str, Unit]) -> tuple[int, int]:
    """Size and alignment in bytes. Strings: a 16-bit length, then the characters."""
    match type_:
        case Elementary(bits=bits):
            size = max(bits // 8, 1)
            return size, size
        case Enum() | Subrange():
            return measure(storage(type_), units)
        case String(name, length):
            return 2 + length * (1 if name == "STRING" else 2), 2
        case Array(element=element):
            size, align = measure(element, units)
            return size * type_.count, align
        case Struct(fields=fields):
            return _members([f.type for f in fields], units)
        case Instance(pou):
            return _members([v.type for v in state(units[pou.upper()])], units)


def _members(types: list[Type], units: dict[str, Unit]) -> tuple[int, int]:
    end, widest = 0, 1
    for type_ in types:
        size, align = measure(type_, units)
        end = -(-end // align) * align + size
        widest = max(widest, align)
    return -(-end // widest) * widest, widest


def type_hash(type_: Type, units: dict[str, Unit]) -> str:
    """Sixteen hex digits that tell types apart by what their bytes mean."""
    return hashlib.sha256(_describe(type_, units).encode()).hexdigest()[:16]


def _describe(type_: Type, units: dict[str, Unit]) -> str:
    describe: Callable[[Type], str] = lambda inner: _describe(inner, units)
    match type_:
        case Array(bounds, element):
            return f"array{bounds}of {describe(element)}"
        case Struct(fields=fields):
            return "struct(" + ",".join(f"{f.name.upper()}:{describe(f.type)}" for f in fields) + ")"
        case Enum(values=values):
            return f"enum{tuple((n.upper(), v) for n, v in values)}"
        case Subrange(base=base):
            return describe(base)
        case Instance(pou):
            rows = (f"{v.name.upper()}:{describe(v.type)}" for v in state(units[pou.upper()]))
            return f"instance {pou.upper()}(" + ",".join(rows) + ")"
    return str(type_)
