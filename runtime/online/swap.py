"""Carrying the state from one machine to another of the same engine, as a plan says (DESIGN section 7).

What can be done before is done when the change is staged, beside the scans. In a virtual machine that is
most: a program that does not run has the values that the running one had some time ago, and only those that
are others now are copied between two scans. Native memory is copied as a few runs of bytes.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import compress
from operator import is_not

from ldc.records import record
from runtime.in_block import InBlock
from runtime.layout import Cell, Root
from runtime.machine import Machine
from runtime.online.migrate import Plan
from runtime.vm import machine as vm
from runtime.vm import memory
from runtime.vm.keeper import duplicate

Move = Callable[[], None]
_NEVER = object()


@record
class Moves:
    """``there``: from the running program to the staged one, what is new in that as at its start; ``back``:
    what both have. To be called between two scans."""

    there: Move
    back: Move


def moves(old: Machine, new: Machine, there: Plan, back: Plan) -> Moves:
    """Ways to and fro; ``new`` has not run, and nothing but these may write to it while it does not. The
    machines are of one engine. Objects (arrays, instances) belong to both afterwards; only one may run."""
    if isinstance(old, vm.Machine) and isinstance(new, vm.Machine):
        fresh = _fresh_cells(new, there)
        to, fro = _Cells(old, new, there), _Cells(new, old, back)
        to.mirror(fro)
        fro.mirror(to)
        to.ahead()
        return Moves(_move(old, new, there, to, fresh, fro.same), _move(new, old, back, fro, after=to.same))
    if isinstance(old, InBlock) and isinstance(new, InBlock):
        initial = bytes(new.memory)

        def fresh() -> None:
            new.memory[:] = initial

        return Moves(_move(old, new, there, _bytes(old, new, there), fresh),
                     _move(new, old, back, _bytes(new, old, back)))
    raise TypeError("state moves between machines of one engine")


def _move(old: Machine, new: Machine, plan: Plan, whole: Move, fresh: Move = lambda: None,
          after: Move = lambda: None) -> Move:
    parts, quiet = plan.parts, plan.quiet

    def move() -> None:
        old.latch()
        fresh()
        whole()
        after()
        for was, symbol in parts:
            new.assign(symbol, old.value(was))
        for symbol, value in quiet:
            new.assign(symbol, value)
        new.take_over(old)

    return move


# ---- the virtual machine ---------------------------------------------------------------------------------


class _Cells:
    """Copies entries of one namespace to another, those that changed since both had the same.

    A dictionary gives all its values in order many times faster than one by one by their names; the order is
    that of the first entry and stays.
    """

    def __init__(self, old: vm.Machine, new: vm.Machine, plan: Plan) -> None:
        self._source, self._target = old.code.namespace, new.code.namespace
        cells = {root.home.name: was.home.name for was, root in plan.whole if _in_cells(was, root)}
        self._others = [(was.home, root.home) for was, root in plan.whole if not _in_cells(was, root)]
        first: dict[str, str] = {}
        self._more = [(name, to) for to, name in cells.items() if first.setdefault(name, to) != to]
        self.pairs = [(name, first[name]) for name in self._source if name in first]
        self._names = [to for _, to in self.pairs]
        self._kept = [name in first for name in self._source]
        self._before: list[object] = [_NEVER] * len(self.pairs)
        self._odd: list[int] = []

    def mirror(self, other: _Cells) -> None:
        """``other`` goes the other way: when it has copied, both sides have the same, except for what does
        not go there and back between the same two names."""
        known = {(name, to) for to, name in other.pairs}
        self._odd = [number for number, pair in enumerate(self.pairs) if pair not in known]

    def ahead(self) -> None:
        """Copies all, while the source runs and the target does not."""
        self._before = self._values()
        self._target.update(zip(self._names, self._before))

    def __call__(self) -> None:
        source, target = self._source, self._target
        now = self._values()
        changed = list(map(is_not, now, self._before))
        target.update(zip(compress(self._names, changed), compress(now, changed)))
        for name, to in self._more:
            target[to] = source[name]
        for home, to in self._others:
            memory.write(target, to, memory.read(source, home))

    def same(self) -> None:
        """Both sides have the same now, and the source runs from now on."""
        self._before = self._values()
        for number in self._odd:
            self._before[number] = _NEVER

    def _values(self) -> list[object]:
        return list(compress(self._source.values(), self._kept))


def _in_cells(old: Root, new: Root) -> bool:
    return isinstance(old.home, Cell) and isinstance(new.home, Cell)


def _fresh_cells(new: vm.Machine, plan: Plan) -> Move:
    """Puts what is not copied whole back to what it is now."""
    namespace = new.code.namespace
    copied = {root.home.name for was, root in plan.whole if _in_cells(was, root)}
    names = {root.home.name for root in new.layout.roots()} - copied
    kept = [(name, duplicate(namespace[name])) for name in names]

    def fresh() -> None:
        for name, value in kept:
            if isinstance(value, bytearray):
                namespace[name][:] = value  # views look into it
            else:
                namespace[name] = duplicate(value)

    return fresh


# ---- native memory ---------------------------------------------------------------------------------------


def _bytes(old: InBlock, new: InBlock, plan: Plan) -> Move:
    """Variables that lie one behind the other in both blocks are copied together: with the offsets that a
    compile keeps these are a few long runs."""
    kept = {root.path: was for was, root in plan.whole}
    spots = [(new.place(root), root) for root in new.layout.roots()]
    runs: list[list[int]] = []  # begin in the old block, begin and end in the new one
    bits: list[tuple] = []
    joined = False
    for spot, root in sorted(spots, key=lambda pair: pair[0].offset):
        was = kept.get(root.path)
        if was is None:
            joined = False
            continue
        before = old.place(was)
        if spot.bit is not None or before.bit is not None:
            bits += zip(old.symbols.of(was, hidden=True), new.symbols.of(root, hidden=True), strict=True)
            joined = False
            continue
        end = spot.offset + new.plan.measure(spot.type)
        # No other variable of the new program lies between, so padding may be copied too.
        if joined and runs[-1][1] - runs[-1][0] == spot.offset - before.offset:
            runs[-1][2] = max(end, runs[-1][2])
        else:
            runs.append([before.offset, spot.offset, end])
        joined = True

    def move() -> None:
        source, target = old.memory, new.memory
        for begin, to, end in runs:
            target[to:end] = source[begin:begin + end - to]
        for was, symbol in bits:
            new.assign(symbol, old.value(was))

    return move
