"""A machine whose variables lie in one block of bytes (``ldc.il.block``): values by their places."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from struct import calcsize

from ldc.il import block
from ldc.il.block import Block, Spot
from ldc.il.homes import Home
from ldc.types import BOOL, Array, String, storage
from runtime import machine
from runtime.layout import Layout, Root, lay_out, slot
from runtime.places import row
from runtime.symbols import Symbol

FIRST_SCAN = 16

_FAR = 1 << 14
"""Bytes up to which looking at all between two variables is quicker than reading each."""


@dataclass(slots=True, eq=False)
class InBlock(machine.Machine):
    """What machines with a block share; ``memory`` is what ``_load`` made of ``plan``."""

    memory: memoryview = field(init=False, repr=False)
    plan: Block = field(init=False, repr=False)
    _roots: dict[Home, Spot] = field(init=False, repr=False)
    _spots: dict[Symbol, Spot] = field(init=False, repr=False)

    def _find_places(self, plan: Block) -> Layout:
        """The layout of the machine, whose variables lie as in ``plan``."""
        layout = lay_out(self.program, self.resource)
        self.plan, self._spots = plan, {}
        self._roots = {root.home: self._spot_of(root) for root in layout.roots()}
        return layout

    def place(self, root: Root) -> Spot:
        """Where a variable lies in ``memory``."""
        return self._roots[root.home]

    def _spot_of(self, root: Root) -> Spot:
        return self.plan.variable(root.path, root.variable)

    def spot(self, symbol: Symbol) -> Spot:
        """Where the scalar lies in ``memory``."""
        found = self._spots.get(symbol)
        if found is None:
            found = self._spots[symbol] = self._walk(symbol)
        return found

    def _walk(self, symbol: Symbol) -> Spot:
        plan = self.plan
        spot = self._roots[symbol.home]
        for key in symbol.keys:
            if isinstance(spot.type, Array):
                element = spot.type.element
                size = 1 if spot.bit is not None else plan.measure(element)
                spot = block.element_spot(spot, key, size, element)
            else:
                members = {slot(name): member for name, member in plan.members(spot.type).items()}
                offset, type_ = members[key]
                spot = Spot(spot.offset + offset, type_)
        if symbol.bit is not None:
            bit = symbol.bit % 8 if symbol.type == BOOL else None
            spot = Spot(spot.offset + symbol.bit // 8, symbol.type, bit)
        return spot

    def value(self, symbol: Symbol) -> object:
        return block.read(self.memory, self.spot(symbol))

    def assign(self, symbol: Symbol, value: object) -> None:
        block.write(self.memory, self.spot(symbol), value)

    def reader(self, symbols: Iterable[Symbol]) -> Callable[[], tuple]:
        """Values are made anew only when a byte between the first and the last of them has changed."""
        wanted, memory = tuple(symbols), self.memory
        spots = [self.spot(s) for s in wanted]
        begin = min((spot.offset for spot in spots), default=0)
        end = max((spot.offset + self.plan.measure(spot.type) for spot in spots), default=0)
        if end - begin > _FAR:
            return machine.Machine.reader(self, wanted)
        before: bytes | None = None
        values: tuple = ()
        unpack = _unpacker(spots, begin)

        def sample() -> tuple:
            nonlocal before, values
            now = memory[begin:end].tobytes()
            if now != before:
                before, values = now, tuple(map(self.value, wanted)) if unpack is None else unpack(now)
            return values

        return sample

    def writer(self, symbols: Iterable[Symbol]) -> Callable[[Sequence], None]:
        spots, memory = [self.spot(symbol) for symbol in symbols], self.memory

        def write(values: Sequence) -> None:
            for spot, value in zip(spots, values, strict=True):
                block.write(memory, spot, value)

        return write

    def _capture(self) -> object:
        return bytes(self.memory)

    def _put_back(self, kept: object) -> None:
        self.memory[:] = kept


def _unpacker(spots: Sequence[Spot], begin: int) -> Callable[[bytes], tuple] | None:
    """What makes values of the bytes from ``begin`` on at once, in the order of the spots; None when
    they are not all plain, or share bytes."""
    if any(spot.bit is not None or isinstance(spot.type, String) for spot in spots):
        return None
    kinds = [storage(spot.type) for spot in spots]
    places = [(spot.offset - begin, "?" if kind.kind == "bool" else block.code(kind)[1:])
              for spot, kind in zip(spots, kinds)]
    ascending = sorted(places)
    if any(at + calcsize(f"<{code}") > behind for (at, code), (behind, _) in zip(ascending, ascending[1:])):
        return None
    words, chosen = row(places, "<")
    return words.unpack_from if chosen is None else lambda data: chosen(words.unpack_from(data))
