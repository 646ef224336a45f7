"""The fault that generated C left in its block of memory, as an error and places (docs/native.md,
"Memory")."""

from __future__ import annotations

from struct import unpack_from

from ldc.il.block import Block
from ldc.il.program import Unit
from ldc.library.faults import DivisionByZero
from runtime.faults import IndexOutOfRange, Place, WatchdogExpired

_FAULT, _INDEX, _DEPTH, _TRACE = 20, 24, 48, 56
_DIVISION, _SIGNED, _UNSIGNED = 1, 2, 3

Parts = tuple[tuple[str, tuple[int, ...]], ...]
"""For every driver by number the name of its POU and the first rung of each part."""


def read(block: Block, parts: Parts, memory: bytes | memoryview,
         limit: int) -> tuple[Exception, tuple[Place, ...]]:
    """The fault that a run ended in, and where: calls first. ``memory``: the begin of the block; ``limit``:
    of the watchdog."""
    kind, = unpack_from("<I", memory, _FAULT)
    index, low, high = unpack_from("<Qqq" if kind == _UNSIGNED else "<qqq", memory, _INDEX)
    depth, = unpack_from("<I", memory, _DEPTH)
    error: Exception = WatchdogExpired(limit)
    if kind == _DIVISION:
        error = DivisionByZero()
    elif kind in (_SIGNED, _UNSIGNED):
        error = IndexOutOfRange(index, low, high)
    places = []
    for at in range(depth // 2):
        rung, instruction, driver, part = unpack_from("<4I", memory, _TRACE + 16 * at)
        name, firsts = parts[driver]
        places.append(_place(block.units[name.upper()], firsts[part] + rung, instruction))
    return error, tuple(reversed(places))


def _place(unit: Unit, rung: int, instruction: int) -> Place:
    code = unit.rungs[rung]
    instr = code.code[instruction]
    return Place(unit.name, code.key, instruction, instr.element, instr.span or code.span)
