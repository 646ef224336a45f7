"""Where algorithms execute and how their data pass: slave, slot, ids of parameters (SPEC 1.3, 2.4).

An algorithm is an instance of a unit with a ``Pace``. On the master it is a proxy, on its slave the unit of
the same name in ``Program.algorithms``. Both sides build on what is computed here, so nothing of it is sent.
All functions are pure, and the same program gives the same placement.

A slot n of 128 bytes, or of a multiple of that, begins n times its size behind the begin of SMD and MSD; n is
also its bit in the words of flags. Slots of different sizes share one window where neither bytes nor bits
overlap, and an instance that is added moves no other.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping, Sequence

from ldc.il.layout import state
from ldc.il.program import Program, Resource, Unit
from ldc.records import record, replace
from ldc.symbols import Variable
from ldc.types import Array, Elementary, Instance, Scalar, Struct, Subrange, Type, default, is_scalar, storage

BLOCK, BLOCKS, HEAD, WORDS = 128, 32, 20, 1024
"""Bytes of a block, blocks of a window, bytes of an envelope before its data, words of AD."""

ENABLE, ERROR, FED_ERROR = "enable", "error", "_ldc_error"
"""The pins that start an algorithm and tell what is wrong with it; the variable of a proxy that keeps the
latter between scans, for its own checks write the pin."""


@record
class PlacedPin:
    """A pin that is sent. ``variable``: what holds it in the proxy, "" for AFS, which is no variable.
    ``type``: f32, i32, u32 or bool32. ``low`` and ``high``: what P checks, as the type rounds it."""

    name: str
    variable: str
    type: str
    pid: int
    low: float = -math.inf
    high: float = math.inf


@record
class LocalPin:
    """A pin that is wired on the slave: a point of the field. ``output``: the algorithm writes it.
    ``initial``: what an output has before the first START, and after whatever ends the algorithm at once.
    ``low`` and ``high``: what is checked; ``limits``: what its type holds."""

    name: str
    path: str
    type: str
    output: bool
    initial: Scalar
    low: float = -math.inf
    high: float = math.inf
    limits: tuple[float, float] = (-math.inf, math.inf)


@record
class Placed:
    """An algorithm in its place.

    ``path``: of the instance, with the name of its program. ``module``: the index of that program among the
    modules, None for an instance elsewhere. ``slave``: 1 .. 4; ``slot``: 0 .. 31 of it, ``blocks`` times 128
    bytes long; ``ad``: the byte of AD where its parameters begin, that of pid 1. ``parameters``: to the
    slave, ``enable`` first when the component has it. ``feedback``: outputs, then ``error``, last AFS
    (``processors.states``). ``retain``: its instance is retained, with what its body holds on the slave.
    """

    path: str
    unit: str
    module: int | None
    slave: int
    slot: int
    blocks: int
    aid: int
    ad: int
    period_ns: int
    parameters: tuple[PlacedPin, ...]
    feedback: tuple[PlacedPin, ...]
    local: tuple[LocalPin, ...]
    retain: bool = False

    @property
    def size(self) -> int:
        """Bytes of its slot."""
        return BLOCK * self.blocks

    @property
    def enabled(self) -> bool:
        """It has the pin ``enable``; one without executes from its START until a STOP."""
        return bool(self.parameters) and self.parameters[0].name == ENABLE


@record
class Point:
    """A word of the field: its index there, the type of what is in it (f32, i32, u32, bool32), and what the
    declared type holds."""

    index: int
    type: str
    low: float = -math.inf
    high: float = math.inf


class NoRoom(Exception):
    """A slave has no slot for an algorithm: the window is full."""

    def __init__(self, path: str, unit: str, slave: int, blocks: int) -> None:
        self.path, self.unit, self.slave, self.blocks = path, unit, slave, blocks
        super().__init__(f"slave{slave} has no slot of {blocks} blocks for {path}")


def same_body(one: Unit, other: Unit) -> bool:
    """Whether two units do the same on the same variables, wherever they were written: an algorithm that goes
    on over an online change keeps its state."""
    def bare(unit: Unit) -> tuple:
        return unit.rungs, unit.external, tuple(replace(v, span=None) for v in unit.variables)

    return bare(one) == bare(other)


def transfer_type(type_: Type) -> str | None:
    """What a value is as a parameter of P or a point of the field; None when it is not sent."""
    kind = storage(type_)
    if not isinstance(kind, Elementary) or kind.kind != "real" and kind.bits > 32:
        return None
    return {"bool": "bool32", "real": "f32", "int": "i32", "uint": "u32", "bits": "u32"}.get(kind.kind)


def limits(type_: Type) -> tuple[float, float]:
    """What a variable of a type that is sent holds."""
    if isinstance(type_, Subrange):
        return type_.low, type_.high
    kind = storage(type_)
    return (-math.inf, math.inf) if kind.kind == "real" else (0, 1) if kind.kind == "bool" else kind.range


def placed(program: Program, modules: Sequence[str] = (), previous: Sequence[Placed] = ()
           ) -> tuple[Placed, ...]:
    """The algorithms of a program in its order, by aid when there is no placement before. ``modules``: names
    of programs by their index; () for all in the order in which they run. An instance of ``previous`` that is
    still there and has the same pins keeps slot and aid. Raises NoRoom."""
    if not program.algorithms:
        return ()
    part = _part(program)
    units = {u.name.upper(): u for u in program.units}
    bodies = {u.name.upper(): u for u in program.algorithms}
    numbers = {name.upper(): n for n, name in enumerate(modules or (run.name for run in part.runs))}
    before = {p.path.upper(): p for p in previous}
    wanted = []
    for path, unit, retain in _instances(program, part, units):
        module = numbers.get(path.partition(".")[0].upper())
        fresh = replace(_unplaced(path, unit, bodies[unit.name.upper()], module), retain=retain)
        old = before.get(path.upper())
        wanted.append((fresh, old if old is not None and _alike(old, fresh) else None))
    rooms = {slave: _Room() for slave in range(1, 5)}
    taken = set()
    for _, old in wanted:
        if old is not None:
            rooms[old.slave].keep(old)
            taken.add(old.aid)
    free = iter(n for n in range(1, len(wanted) + len(taken) + 1) if n not in taken)
    return tuple(_put(fresh, rooms[fresh.slave], free) if old is None
                 else replace(fresh, slot=old.slot, aid=old.aid, ad=old.ad) for fresh, old in wanted)


def points(program: Program, algorithms: Sequence[Placed], previous: Mapping[str, Point] = {}
           ) -> dict[str, Point]:
    """The points of the field by path in capitals: local pins of algorithms, and located variables of the
    areas I and Q by address and by path. Those of ``previous`` keep their words unless their type has
    changed: who still writes the old word then does no harm."""
    wanted = [((pin.path,), pin.type, *pin.limits) for p in algorithms for pin in p.local]
    located: dict[tuple[str, str], tuple[list[str], list[tuple[float, float]]]] = {}
    units = {u.name.upper(): u for u in program.units}
    part = _part(program)
    named = [(v.name, v) for v in program.globals]
    named += [(f"{run.name}.{v.name}", v) for run in part.runs for v in units[run.pou.upper()].variables]
    for path, v in named:
        type_ = transfer_type(v.type) if is_scalar(v.type) else None
        if v.location is not None and v.location.area in "IQ" and type_ is not None:
            names, holds = located.setdefault((str(v.location), type_), ([], []))
            names.append(path)
            holds.append(limits(v.type if v.location.area == "I" else storage(v.type)))
    wanted += [((address, *names), type_, max(low for low, _ in holds), min(high for _, high in holds))
               for (address, type_), (names, holds) in located.items()]
    found = dict(previous)
    end = max((point.index for point in previous.values()), default=-1) + 1
    for names, type_, low, high in wanted:
        keys = [name.upper() for name in names]
        known = (found[key] for key in keys if key in found)
        point = next((p for p in known if (p.type, p.low, p.high) == (type_, low, high)), None)
        if point is None:
            point, end = Point(end, type_, low, high), end + 1
        found.update(dict.fromkeys(keys, point))
    return found


def _part(program: Program) -> Resource:
    """The processor that is run: the first one that has a program."""
    return next((r for r in program.resources if r.runs), program.resources[0])


_Found = tuple[str, Unit, bool]
"""Path and proxy of an algorithm, and whether it is retained."""


def _instances(program: Program, part: Resource, units: dict[str, Unit]) -> Iterator[_Found]:
    """Every algorithm: those of program instances, then global ones."""
    known: dict[Type, bool] = {}
    for run in part.runs:
        for v in state(units[run.pou.upper()]):
            yield from _within(f"{run.name}.{v.name}", v.type, units, known, bool(v.retain))
    for v in program.globals:
        yield from _within(v.name, v.type, units, known, bool(v.retain))


def _members(type_: Type, units: dict[str, Unit], retain: bool) -> Iterator[tuple[str, Type, bool]]:
    """The parts of a value: how a path goes on, the type there, and whether it is retained."""
    match type_:
        case Array(bounds, element):
            rows = [""]
            for low, high in bounds:
                rows = [f"{row}{',' * bool(row)}{index}" for row in rows for index in range(low, high + 1)]
            yield from ((f"[{row}]", element, retain) for row in rows)
        case Struct(fields=fields):
            yield from ((f".{f.name}", f.type, retain) for f in fields)
        case Instance(pou):
            yield from ((f".{v.name}", v.type, v.retained(retain)) for v in state(units[pou.upper()]))


def _within(path: str, type_: Type, units: dict[str, Unit], known: dict[Type, bool], retain: bool
            ) -> Iterator[_Found]:
    if not _holds(type_, units, known):
        return
    unit = units[type_.pou.upper()] if isinstance(type_, Instance) else None
    if unit is not None and unit.pace is not None:
        yield path, unit, retain
        return
    for step, inner, kept in _members(type_, units, retain):
        yield from _within(path + step, inner, units, known, kept)


def holds_algorithm(type_: Type, program: Program) -> bool:
    """Whether a slave executes something in a value of the type."""
    return _holds(type_, {unit.name.upper(): unit for unit in program.units}, {})


def _holds(type_: Type, units: dict[str, Unit], known: dict[Type, bool]) -> bool:
    """Whether a value of the type has an algorithm in it; each type is looked into once."""
    found = known.get(type_)
    if found is None:
        if isinstance(type_, Array):
            found = _holds(type_.element, units, known)
        elif isinstance(type_, Instance) and units[type_.pou.upper()].pace is not None:
            found = True
        else:
            found = any(_holds(inner, units, known) for _, inner, _ in _members(type_, units, False))
        known[type_] = found
    return found


def _unplaced(path: str, proxy: Unit, body: Unit, module: int | None) -> Placed:
    ranges = {name.upper(): (low, high) for name, low, high in proxy.pace.ranges}
    pins = {v.name.upper() for v in proxy.variables}
    given = [_pin(v, n, ranges) for n, v in enumerate(_of(proxy, "input"), 1)]
    made = {i.operand.root.upper() for r in proxy.rungs if r.key == "power" for i in r.code if i.op == "ST"}
    back = [v for v in _of(proxy, "output") if v.name.upper() not in made and v.name != ERROR]
    fed = [_pin(v, n, {}) for n, v in enumerate(back, 1)]
    fed.append(PlacedPin(ERROR, FED_ERROR, "u32", len(fed) + 1, 0, 0xFFFF))
    fed.append(PlacedPin("AFS", "", "u32", len(fed) + 1, 0, 3))
    local = tuple(_local(v, path, ranges) for v in body.variables
                  if v.kind in ("input", "output") and v.name.upper() not in pins)
    blocks = -(-(HEAD + 8 * max(len(given), len(fed))) // BLOCK)
    return Placed(path, proxy.name, module, proxy.pace.slave, -1, blocks, 0, 0, proxy.pace.period,
                  tuple(given), tuple(fed), local)


def _of(unit: Unit, kind: str) -> list[Variable]:
    return [v for v in unit.variables if v.kind == kind]


_Ranges = Mapping[str, tuple[float | None, float | None]]


def _bounds(v: Variable, ranges: _Ranges) -> tuple[float, float]:
    """What the value has to be in: what is declared, and what the type holds."""
    low, high = ranges.get(v.name.upper(), (None, None))
    kind = storage(v.type)
    if kind.kind == "real":
        return (-math.inf if low is None else _f32(low), math.inf if high is None else _f32(high))
    least, most = kind.range if kind.kind != "bool" else (0, 1)
    return least if low is None else max(low, least), most if high is None else min(high, most)


def _f32(value: float) -> float:
    """Rounded as a REAL is, so that what is within a bound still is when both are rounded."""
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        return math.copysign(math.inf, value)


def _pin(v: Variable, pid: int, ranges: _Ranges) -> PlacedPin:
    return PlacedPin(v.name, v.name, transfer_type(v.type), pid, *_bounds(v, ranges))


def _local(v: Variable, path: str, ranges: _Ranges) -> LocalPin:
    initial = default(storage(v.type)) if v.initial is None else v.initial
    return LocalPin(v.name, f"{path}.{v.name}", transfer_type(v.type), v.kind == "output", initial,
                    *_bounds(v, ranges), limits(v.type))


class _Room:
    """What is taken of a slave: bits of flags, blocks of its windows, words of AD."""

    def __init__(self) -> None:
        self.slots: set[int] = set()
        self.blocks: set[int] = set()
        self.words: set[int] = set()

    def slot(self, blocks: int) -> int | None:
        """The first slot of that size that is free."""
        return next((n for n in range(BLOCKS // blocks)
                     if n not in self.slots and self.blocks.isdisjoint(_blocks(n, blocks))), None)

    def word(self, count: int) -> int | None:
        """The first of ``count`` words of AD in a row that are free."""
        return next((n for n in range(WORDS - count + 1)
                     if self.words.isdisjoint(range(n, n + count))), None)

    def keep(self, p: Placed) -> None:
        self.slots.add(p.slot)
        self.blocks.update(_blocks(p.slot, p.blocks))
        self.words.update(range(p.ad // 4, p.ad // 4 + len(p.parameters)))


def _blocks(slot: int, blocks: int) -> range:
    return range(slot * blocks, (slot + 1) * blocks)


def _alike(old: Placed, new: Placed) -> bool:
    return (old.unit.upper(), old.slave, old.blocks, old.parameters, old.feedback) == (
        new.unit.upper(), new.slave, new.blocks, new.parameters, new.feedback)


def _put(fresh: Placed, room: _Room, free: Iterator[int]) -> Placed:
    slot, word = room.slot(fresh.blocks), room.word(len(fresh.parameters))
    if slot is None or word is None:
        raise NoRoom(fresh.path, fresh.unit, fresh.slave, fresh.blocks)
    put = replace(fresh, slot=slot, aid=next(free), ad=4 * word)
    room.keep(put)
    return put
