"""The customised program as frames of words (SPEC 4): what is in a buffer of ACPDD, and which step comes next
when another program takes its place.

A buffer: generation, number of steps, words of frames, CRC of all of that but itself; then the frames: module
| parameters << 8 | when << 16 | until << 24, and for each parameter its address in LCD | words << 16 and the
words themselves. ``when`` and ``until`` are places in the table of conditions, from 1; 0: none.
"""

from __future__ import annotations

import struct

from ldc.il.areas import areas
from ldc.il.coordination import Sequence
from ldc.records import record
from runtime.protocol.envelope import crc16
from runtime.protocol.memory import Watched, Words

STATE = 32
"""Bytes of ACPDD before the buffers."""

HEAD = 16
CONDITIONS = 255
PARAMETERS = 255
"""As many as a frame can count."""

_WORD = struct.Struct("<I")


class TooLong(ValueError):
    """A program does not fit a buffer, or has more conditions or parameters than frames can count."""


@record
class Frame:
    """``when``, ``until``: numbers of conditions, 0: none. ``parameters``: addresses in LCD with their
    words."""

    module: int
    when: int
    until: int
    parameters: tuple[tuple[int, bytes], ...]


def room() -> int:
    """Bytes of a buffer."""
    return (areas()["ACPDD"].size - STATE) // 2 & ~3


def buffer(number: int) -> int:
    """The address of buffer 0 or 1."""
    return areas()["ACPDD"].base + STATE + number * room()


def conditions(sequence: Sequence) -> tuple[str, ...]:
    """The paths that frames refer to, each once: ``start`` and those of the steps."""
    found = [path for step in sequence.steps for path in (step.when, step.until) if path]
    return tuple(dict.fromkeys([sequence.start, *found] if sequence.start else found))


def frames(sequence: Sequence, generation: int) -> bytes:
    """The program as the content of a buffer. Raises TooLong."""
    number = {path: n for n, path in enumerate(conditions(sequence), 1)} | {None: 0}
    if len(number) > CONDITIONS + 1:
        raise TooLong(f"{len(number) - 1} conditions, {CONDITIONS} are possible")
    made = bytearray()
    for place, step in enumerate(sequence.steps, 1):
        if len(step.parameters) > PARAMETERS:
            raise TooLong(f"step {place} sets {len(step.parameters)} parameters, {PARAMETERS} are possible")
        made += _WORD.pack(step.module | len(step.parameters) << 8 | number[step.when] << 16
                           | number[step.until] << 24)
        for parameter, value in step.parameters:
            data = struct.pack(parameter.form, value)
            made += _WORD.pack(parameter.address | len(data) // 4 << 16) + data
    if HEAD + len(made) > room():
        raise TooLong(f"{len(sequence.steps)} steps take {HEAD + len(made):,} bytes, {room():,} are there")
    head = struct.pack("<III", generation, len(sequence.steps), len(made) // 4)
    return head + _WORD.pack(crc16(bytes(made), crc16(head))) + made


def parsed(data: Words | Watched, number: int) -> tuple[Frame, ...] | None:
    """The frames of a buffer; None when they are not what was written there."""
    at = buffer(number)
    head = data.read(at, HEAD)
    _, steps, words, crc = struct.unpack("<IIII", head)
    if words * 4 > room() - HEAD:
        return None
    body = data.read(at + HEAD, words * 4)
    if crc16(body, crc16(head[:12])) != crc:
        return None
    found, at = [], 0
    for _ in range(steps):
        (word,) = _WORD.unpack_from(body, at)
        at += 4
        parameters = []
        for _ in range(word >> 8 & 0xFF):
            (where,) = _WORD.unpack_from(body, at)
            size = (where >> 16) * 4
            parameters.append((where & 0xFFFF, body[at + 4 : at + 4 + size]))
            at += 4 + size
        found.append(Frame(word & 0xFF, word >> 16 & 0xFF, word >> 24, tuple(parameters)))
    return tuple(found)


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
