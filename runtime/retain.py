"""RETAIN variables: which they are, their values at the start and at a save (docs/retain.md).

A variable is retained when its section says so, with all that is in it; in a function block each section can
say it for itself, and NON_RETAIN leaves out what the instance would keep. Values are known by path and type.
"""

from __future__ import annotations

import hashlib
import struct
from collections.abc import Callable, Iterable, Iterator, Mapping
from time import sleep

from ldc.il import block
from ldc.il.layout import type_hash
from ldc.records import record
from ldc.types import Array, Instance, String, Struct, Subrange, Type, is_scalar, storage
from runtime.checksum import canonical, value_of
from runtime.in_block import InBlock
from runtime.layout import Cell, Layout, Root, slot
from runtime.machine import Machine
from runtime.retain_file import Entry, Kept
from runtime.symbols import Key, Symbol, has_state, indexes
from runtime.vm import machine as vm
from runtime.vm.keeper import duplicate
from runtime.vm.memory import get

_AT_ONCE = 256


@record
class Leaf:
    """A scalar, or an array of scalars, that is retained. ``type``: of one scalar; ``hash``: of it all."""

    path: str
    type: Type
    hash: str
    symbols: tuple[Symbol, ...]


@record
class Restored:
    """Paths by what became of them, on the master or a slave."""

    kept: tuple[str, ...]
    initialised: tuple[str, ...]
    dropped: tuple[str, ...]


def leaves(layout: Layout) -> tuple[Leaf, ...]:
    """All that is retained, in declared order. Linear in the number of scalars."""
    walk = Walk(layout, {}, {})
    return tuple(leaf for root in layout.roots() if not root.variable.constant
                 for leaf in walk.root(root))


@record
class Walk:
    """Finds what is retained in a part of a layout. ``hashes``, ``known``: of types seen so far."""

    layout: Layout
    hashes: dict[Type, str]
    known: dict[Type, bool]

    def root(self, root: Root) -> Iterator[Leaf]:
        location = root.variable.location
        area = location.area if location else ""
        yield from self.part(Symbol(root.path, root.variable.type, root.home, (), None, area),
                             root.variable.type, bool(root.variable.retain))

    def part(self, at: Symbol, type_: Type, retain: bool) -> Iterator[Leaf]:
        """``at``: path and place of the part; depth is that of its type."""
        if not retain and not self.some(type_):
            return
        if is_scalar(type_):
            yield self.leaf(at, type_, type_, (at,))
        elif isinstance(type_, Array):
            if is_scalar(type_.element):
                all_of = tuple(self.inside(at, "", n, type_.element) for n in range(type_.count))
                yield self.leaf(at, type_, type_.element, all_of)
                return
            for n, index in enumerate(indexes(type_)):
                yield from self.part(self.inside(at, f"[{index}]", n, type_.element), type_.element, retain)
        elif isinstance(type_, Struct):
            for f in type_.fields:
                yield from self.part(self.inside(at, f".{f.name}", slot(f.name), f.type), f.type, retain)
        else:
            for v in self.layout.units[type_.pou.upper()].variables:
                if has_state(v):
                    inside = self.inside(at, f".{v.name}", slot(v.name), v.type)
                    yield from self.part(inside, v.type, v.retained(retain))

    def some(self, type_: Type) -> bool:
        """Whether a part says for itself that it is retained: only variables of function blocks do."""
        while isinstance(type_, Array):
            type_ = type_.element
        if type_ not in self.known:
            inner = ()
            if isinstance(type_, Instance):
                inner = self.layout.units[type_.pou.upper()].variables
            members = type_.fields if isinstance(type_, Struct) else ()
            self.known[type_] = any(v.retain or self.some(v.type) for v in inner if has_state(v)) or any(
                self.some(f.type) for f in members)
        return self.known[type_]

    def inside(self, at: Symbol, more: str, key: Key, type_: Type) -> Symbol:
        return Symbol(at.path + more, type_, at.home, (*at.keys, key), None, at.area)

    def leaf(self, at: Symbol, whole: Type, one: Type, symbols: tuple[Symbol, ...]) -> Leaf:
        if whole not in self.hashes:
            self.hashes[whole] = type_hash(whole, self.layout.units)
        return Leaf(at.path.upper(), one, self.hashes[whole], symbols)


# ---- saving ------------------------------------------------------------------------------------------


@record
class Identity:
    """Whose values they are; see ``Kept``. ``layout`` is asked for when a save is made."""

    name: str
    program: str
    layout: Callable[[], str]


Take = Callable[[], Callable[[], list[Entry]]]
"""Copies values between two scans; what it gives makes entries of them, in any thread."""


def saver(machine: Machine, identity: Identity, slaves: Take = lambda: list
          ) -> Callable[[], Callable[[], Kept]]:
    """A function that copies what is retained, quickly and between two scans; what it gives makes the save
    of it, in any thread. ``slaves``: what algorithms there retain; of a pin that both sides have theirs
    counts."""
    found = leaves(machine.layout)
    copy = _copier(machine, tuple(symbol for leaf in found for symbol in leaf.symbols))

    def take() -> Callable[[], Kept]:
        scan, now, values, others = machine.scans, machine.now_ns, copy(), slaves()

        def make() -> Kept:
            more, layout = others(), identity.layout()
            kept = {entry.path: entry for entry in (*entries(found, _by_the_way(values())), *more)}
            if more:
                rows = "".join(f"{entry.path}|{entry.type}\n" for entry in more)
                layout = hashlib.sha256(f"{layout}\n{rows}".encode()).hexdigest()
            return Kept(identity.name, identity.program, layout, scan, now, list(kept.values()))

        return make

    return take


def _copier(machine: Machine, symbols: tuple[Symbol, ...]) -> Callable[[], Callable[[], Iterator]]:
    """Native memory is copied as it is, of the virtual machine the objects that hold the values."""
    if isinstance(machine, InBlock):
        spots = [machine.spot(symbol) for symbol in symbols]

        def take() -> Callable[[], Iterator]:
            data = bytes(machine.memory)
            return lambda: (block.read(data, spot) for spot in spots)

    elif isinstance(machine, vm.Machine) and all(isinstance(s.home, Cell) for s in symbols):
        namespace, names = machine.code.namespace, tuple({s.home.name: None for s in symbols})

        def take() -> Callable[[], Iterator]:
            cells = {name: duplicate(namespace[name]) for name in names}
            return lambda: (get(cells, symbol) for symbol in symbols)

    else:

        def take() -> Callable[[], Iterator]:
            values = machine.sample(symbols)
            return lambda: iter(values)

    return take


def _by_the_way(values: Iterator) -> Iterator:
    """The same values; now and then another thread may go on, which has scans to run."""
    for number, value in enumerate(values):
        if number % _AT_ONCE == 0:
            sleep(0)
        yield value


def entries(found: Iterable[Leaf], values: Iterator) -> list[Entry]:
    """The values of all scalars of some leaves, in their order, as they are saved."""
    rows = []
    for leaf in found:
        part = [next(values) for _ in leaf.symbols]
        kind = None if isinstance(leaf.type, String) else storage(leaf.type)
        if kind is None or kind.kind == "real" or len(part) == 1:
            data = b"".join(canonical(value, leaf.type) for value in part)
        else:
            data = struct.pack(f"<{len(part)}{block.code(kind)[1]}", *part)
        rows.append(Entry(leaf.path, leaf.hash, data))
    return rows


# ---- at the start ------------------------------------------------------------------------------------


def restore(machine: Machine, kept: Kept, slaves: Iterable[Leaf] = ()) -> Restored:
    """Puts saved values into a machine before its first scan. The program's time goes on where it was, so
    that timers that are retained keep what has elapsed. ``slaves``: what algorithms there retain, which take
    it from the same entries.

    Raises ValueError, and leaves the machine as it was, when bytes are no value of their type.
    """
    saved = {entry.path: entry for entry in kept.entries}
    own, others = (list(fitting(found, saved)) for found in (leaves(machine.layout), slaves))
    became = {leaf.path: part is not None for leaf, part in (*own, *others)}
    for leaf, part in own:
        if part is not None:
            for symbol, value in zip(leaf.symbols, part, strict=True):
                machine.assign(symbol, value)
    machine.now_ns = kept.now_ns
    return Restored(tuple(path for path, good in became.items() if good),
                    tuple(path for path, good in became.items() if not good),
                    tuple(path for path in saved if not became.get(path)))


def fitting(found: Iterable[Leaf], saved: Mapping[str, Entry]) -> Iterator[tuple[Leaf, list[object] | None]]:
    """Leaves with their saved values, None for what has none of its type. Raises ValueError when bytes are no
    value of their type."""
    for leaf in found:
        entry = saved.get(leaf.path)
        yield leaf, None if entry is None or entry.type != leaf.hash else _values(entry, leaf)


def _values(entry: Entry, leaf: Leaf) -> list[object] | None:
    """None when a subrange does not hold them any more: its bounds are no part of the hash."""
    found, at = [], 0
    for _ in leaf.symbols:
        value, at = value_of(entry.data, at, leaf.type)
        found.append(value)
    if at != len(entry.data):
        raise ValueError(f"{leaf.path} has {len(entry.data)} bytes, {at} are its values")
    type_ = leaf.type
    fits = not isinstance(type_, Subrange) or all(type_.low <= value <= type_.high for value in found)
    return found if fits else None
