"""L, the customised program: a sequence of modules that the customised thread executes (SPEC 4, docs/messages.md).

The program lies in ACPDD as frames, words that the customised thread reads, in one of two buffers. For each
step it offers the frame (``cb`` := 1); the control thread copies the parameters to LCD, sets the start bit and
confirms (``ca`` := 1); cb := 0; ca := 0. Then the customised thread waits until the module has ended.

A new program goes into the other buffer. The control thread makes it the active one at a boundary: while no
step is offered or runs. What remains of a cycle then follows the module that ended last (``following``).

ACPDD: 8 words of state, then the buffers. A buffer: generation, number of steps, words, CRC of the rest; then
the frames: module | parameters << 8 | when << 16 | until << 24, and for each parameter its address in LCD | words
<< 16 and the words themselves. ``when`` and ``until`` are places in the table of conditions, from 1. What the
real L does beyond this is not known: it is only cited in the papers.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from enum import IntEnum

from ldc.il.areas import areas
from ldc.il.coordination import Sequence
from runtime.protocol.envelope import crc16
from runtime.protocol.memory import Memory, bit

_ACTIVE, _SEEN, _PHASE, _STEP, _ENDED, _MODULE, _CYCLES, _STAGED = range(0, 32, 4)
_STATE = 32
_HEAD = 16
_WORD = struct.Struct("<I")

Reader = Callable[[], bool]


class Phase(IntEnum):
    """Of the customised thread. IDLE: no cycle runs; NEXT: the next step waits for its condition; OFFERED: the
    control thread has to take it; RUNNING: its module is in work; DONE: without ``repeat``, the one cycle is
    over and ``start`` has to fall."""

    IDLE = 0
    NEXT = 1
    OFFERED = 2
    RUNNING = 3
    DONE = 4


BOUNDARY = (Phase.IDLE, Phase.NEXT, Phase.DONE)
"""When a new program may become the active one."""


class TooLong(ValueError):
    """A program does not fit a buffer of ACPDD, or has more than 255 conditions."""


def room() -> int:
    """Bytes of a buffer."""
    return (areas()["ACPDD"].size - _STATE) // 2 & ~3


def conditions(sequence: Sequence) -> tuple[str, ...]:
    """The paths that frames refer to, each once: ``start`` and those of the steps."""
    found = [path for step in sequence.steps for path in (step.when, step.until) if path]
    return tuple(dict.fromkeys([sequence.start, *found] if sequence.start else found))


def frames(sequence: Sequence, generation: int) -> bytes:
    """The program as the content of a buffer. Raises TooLong."""
    number = {path: n for n, path in enumerate(conditions(sequence), 1)} | {None: 0}
    made = bytearray()
    if len(number) <= 256:
        for step in sequence.steps:
            made += _WORD.pack(step.module | len(step.parameters) << 8 | number[step.when] << 16
                               | number[step.until] << 24)
            for parameter, value in step.parameters:
                data = struct.pack(parameter.form, value)
                made += _WORD.pack(parameter.address | len(data) // 4 << 16) + data
    if len(number) > 256 or _HEAD + len(made) > room():
        raise TooLong(f"a sequence of {len(sequence.steps)} steps, {len(made)} bytes, {len(number) - 1} conditions")
    head = struct.pack("<III", generation, len(sequence.steps), len(made) // 4)
    return head + _WORD.pack(crc16(bytes(made), crc16(head))) + made


def following(old: Sequence, ended: int, new: Sequence) -> int:
    """The number of the step of ``new`` that comes after ``ended`` steps of ``old``: the one behind the step
    that ended last; when that is gone, the next one of the old order that is still there; when all are, none
    of this cycle. A step is known by its module, and by its turn among the steps of that module."""
    if ended == 0:
        return 0
    places = {key: place for place, key in enumerate(_keys(new))}
    keys = _keys(old)
    if keys[ended - 1] in places:
        return places[keys[ended - 1]] + 1
    return next((places[key] for key in keys[ended:] if key in places), len(new.steps))


def _keys(sequence: Sequence) -> list[tuple[str, int]]:
    turns: dict[str, int] = {}
    keys = []
    for step in sequence.steps:
        name = step.name.upper()
        turns[name] = turns.get(name, 0) + 1
        keys.append((name, turns[name]))
    return keys
