"""Changes of a block of memory as words of 32 bits: how firmware is told of values (``ldc_change`` in
``ldc/backends/firmware/runtime/scan.c``).

A change is the offset in the block, the size in bytes, and those bytes filled up to whole words; or the
offset and ``BITS`` with a mask in the lowest byte and the new bits in the next one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from struct import unpack

from ldc.il import block
from ldc.il.block import Spot
from ldc.il.layout import measure
from ldc.types import String, Value

BITS = 0x8000_0000
LONGEST = 128
"""Bytes of one change; longer data are several."""


def words(values: Iterable[tuple[Spot, Value]]) -> Iterator[int]:
    """The changes that write scalars to their places, in order."""
    for spot, value in values:
        if spot.bit is not None:
            yield from (spot.offset, BITS | 1 << spot.bit | bool(value) << spot.bit + 8)
        else:
            yield from piece(spot.offset, encoded(spot, value))


def count(found: list[int]) -> int:
    """How many changes some words are."""
    at = number = 0
    while at < len(found):
        at += 2 + (0 if found[at + 1] & BITS else -(-found[at + 1] // 4))
        number += 1
    return number


def encoded(spot: Spot, value: Value) -> bytes:
    """What a scalar writes at a place that is no single bit: of a string its length and characters only."""
    data = bytearray(measure(spot.type, {})[0])
    block.write(data, Spot(0, spot.type), value)
    if isinstance(spot.type, String):
        wide = spot.type.name != "STRING"
        return bytes(data[:2 + int.from_bytes(data[:2], "little") * (2 if wide else 1)])
    return bytes(data)


def piece(offset: int, data: bytes) -> Iterator[int]:
    """The changes that write ``data``."""
    for at in range(0, len(data), LONGEST):
        part = data[at:at + LONGEST]
        yield from (offset + at, len(part))
        yield from unpack(f"<{-(-len(part) // 4)}I", part + bytes(-len(part) % 4))


def from_zero(data: bytes) -> Iterator[int]:
    """The changes that make ``data`` of a block that is all zero."""
    at = 0
    while at < len(data):
        if not data[at]:
            at += 1
            continue
        end = at + 1
        # The head of a change costs eight bytes: shorter gaps are written.
        while end < len(data) and any(data[end:end + 8]):
            end += 1
        yield from piece(at, data[at:end])
        at = end
