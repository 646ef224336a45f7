"""What algorithms retain on their slave (docs/retain.md): found, copied for a save, put back at a start.

It has the paths of the instance in the program, as if the master executed it. Inputs are not among it, for
START sends them, nor local pins: those have their safe values at a start.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from ldc.il.layout import type_hash
from ldc.il.placement import ERROR, Placed
from ldc.il.program import Program
from ldc.types import TIME, String, Type, storage
from runtime.layout import Layout, lay_out, slot
from runtime.retain import Leaf, Walk, entries, fitting
from runtime.retain_file import Entry
from runtime.slave.algorithm import Algorithm, Maker, makers
from runtime.symbols import Symbol, has_state

_CLOCK = "_LDC_CLOCK"
"""The name by which the time of an algorithm in IL is kept, which timers in it count with."""


def leaves(maker: Maker, placed: Placed, layout: Layout | None = None) -> tuple[Leaf, ...]:
    """What an algorithm retains. ``layout``: that of ``maker.program``, when it is there already."""
    layout = layout or lay_out(maker.program)
    ((_, variables),) = layout.programs
    (root,) = variables.values()
    walk, sent = Walk(layout, {}, {}), {pin.name.upper() for pin in placed.feedback} - {ERROR.upper()}
    local = {pin.name.upper() for pin in placed.local}
    found: list[Leaf] = []
    for v in maker.unit.variables:
        name = v.name.upper()
        held = name in sent if v.kind == "output" else v.kind != "input" and has_state(v)
        if held and name not in local:
            at = Symbol(f"{placed.path}.{v.name}", v.type, root.home, (slot(v.name),))
            found += walk.part(at, v.type, v.retained(placed.retain))
    if found and maker.unit.external is None:
        path = f"{placed.path}.{_CLOCK}"
        clock = Symbol(path, TIME, root.home)
        found.append(Leaf(path.upper(), TIME, type_hash(TIME, {}), (clock,)))
    return tuple(found)


def of_program(program: Program, placed: Iterable[Placed]) -> tuple[Leaf, ...]:
    """What all algorithms of a program retain, without making them."""
    made = makers(program)
    return tuple(leaf for p in placed for leaf in leaves(made[p.unit.upper()], p))


def saved(algorithm: Algorithm, found: Sequence[Leaf]) -> list[Entry]:
    """The values of now."""
    return entries(found, iter(algorithm.values(tuple(_symbols(found)))))


def put_back(algorithm: Algorithm, found: Sequence[Leaf], kept: Mapping[str, Entry]) -> None:
    """Saved values of the same path and type, before the first execution. Raises ValueError when bytes are no
    value of their type."""
    algorithm.put([pair for leaf, values in fitting(found, kept) if values is not None
                   for pair in zip(leaf.symbols, values, strict=True)])


def _symbols(found: Iterable[Leaf]) -> Iterator[Symbol]:
    return (symbol for leaf in found for symbol in leaf.symbols)


def room(found: Iterable[Leaf]) -> int:
    """Bytes that the entries take at most, as msgpack with a length before it; 0 for none."""
    sizes = [48 + len(leaf.path.encode()) + len(leaf.hash) + len(leaf.symbols) * _most(leaf.type)
             for leaf in found]
    return 16 + sum(sizes) if sizes else 0


def _most(type_: Type) -> int:
    """Bytes of a value at most."""
    if isinstance(type_, String):
        return 4 + type_.length * (1 if type_.name == "STRING" else 2)
    return max(storage(type_).bits // 8, 1)
