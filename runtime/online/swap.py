"""Carrying the state from one machine to another of the same engine, as a plan says (DESIGN section 7).

All that can be done before is done when the change is staged; what is left for the moment between two scans
is copying: of names in a virtual machine, of a few runs of bytes in native memory.
"""

from __future__ import annotations

from collections.abc import Callable
from operator import itemgetter

from runtime.in_block import InBlock
from runtime.layout import NOW, Cell, Root
from runtime.machine import Machine
from runtime.online.migrate import Plan
from runtime.vm import machine as vm
from runtime.vm import memory

Move = Callable[[], None]


def mover(old: Machine, new: Machine, plan: Plan) -> Move:
    """Copies all that is kept from ``old`` to ``new``, and silences new edge memories. The machines are
    of one engine. Objects (arrays, instances) belong to both afterwards; only one of them may run."""
    if isinstance(old, vm.Machine) and isinstance(new, vm.Machine):
        whole = _cells(old, new, plan)
    elif isinstance(old, InBlock) and isinstance(new, InBlock):
        whole = _bytes(old, new, plan)
    else:
        raise TypeError("state moves between machines of one engine")
    parts, quiet = plan.parts, plan.quiet

    def move() -> None:
        old.latch()
        whole()
        for was, symbol in parts:
            new.assign(symbol, old.value(was))
        for symbol, value in quiet:
            new.assign(symbol, value)
        new.take_over(old)

    return move


def _cells(old: vm.Machine, new: vm.Machine, plan: Plan) -> Move:
    source, target = old.code.namespace, new.code.namespace
    names = [(was.home.name, root.home.name) for was, root in plan.whole if _in_cells(was, root)]
    # itemgetter gives a tuple only for several names; the time is the same in both programs anyway.
    read = itemgetter(NOW, NOW, *(name for name, _ in names))
    entries = (NOW, NOW, *(name for _, name in names))
    others = [(was.home, root.home) for was, root in plan.whole if not _in_cells(was, root)]

    def move() -> None:
        target.update(zip(entries, read(source), strict=True))
        for home, to in others:
            memory.write(target, to, memory.read(source, home))

    return move


def _in_cells(old: Root, new: Root) -> bool:
    return isinstance(old.home, Cell) and isinstance(new.home, Cell)


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
