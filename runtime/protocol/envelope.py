"""The envelope of a transfer, as it lies in a slot of shared memory (SPEC 2.4).

``u32 seq | u32 aid | u16 cmd | u16 attempt | u32 len | u32 crc | adata[len]``, little-endian; ``crc`` is the
CRC-16/MODBUS of the words before it and of adata, its upper half 0. adata: ``u32 pid | 4 bytes`` a parameter.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from functools import cache, lru_cache

from ldc.records import record

HEAD = 20
"""Bytes before the data."""

LAST_SEQ = 0x7FFFFF
"""Numbers of transfers run from 1 to this and again from 1, so that an answer holds one beside its code. A
RESET has the number 0, and its ordinal as aid."""

_HEAD = struct.Struct("<IIHHII")
_WORDS = struct.Struct("<IIHHI")


class Command(IntEnum):
    START = 1
    UPDATE = 2
    STOP = 3
    RESET = 4


_RESET = Command.RESET


@record
class Envelope:
    """``cmd`` is any u16, a Command if the sender is sound. ``aid``: of an algorithm; of a RESET its
    ordinal."""

    seq: int
    aid: int
    cmd: int
    attempt: int
    adata: bytes = b""

    def content(self) -> tuple[int, int, int, bytes]:
        """What a further attempt repeats."""
        return self.seq, self.aid, self.cmd, self.adata


@record
class Head:
    """The words before the data as they stand in a slot, not checked."""

    seq: int
    aid: int
    cmd: int
    attempt: int
    len: int
    crc: int


def successor(seq: int) -> int:
    """The number of the transfer after this one."""
    return seq + 1 if seq < LAST_SEQ else 1


def token(seq: int, aid: int, cmd: int) -> int:
    """What an answer calls an envelope, in 24 bits: the number of a transfer, the ordinal of a RESET. Never
    that of memory that was not written yet."""
    return 0x800000 | aid & 0x7FFFFF if cmd == _RESET else seq & 0xFFFFFF


@cache
def _by_one_byte() -> tuple[int, ...]:
    """What a byte leaves of the register, by its exclusive or with the lower half."""
    found = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
        found.append(value)
    return tuple(found)


@cache
def _folds(bits: int) -> tuple[tuple[int, int, int, int], ...]:
    """How a polynomial of so many coefficients becomes one of 32 with the same remainder by x^15 + x + 1: how
    many go each time, their mask, and by how much those that they are added to lie higher."""
    found = []
    while bits > 32:
        squares = [1 << n for n in range(bits.bit_length())]
        count, s = max((min(bits - 15 * s, 14 * s, bits - 32), s) for s in squares)
        found.append((count, (1 << count) - 1, 14 * s, 15 * s))
        bits -= count
    return tuple(found)


_FACTOR = 0xC001
"""x^15 + x + 1, the highest coefficient in the lowest bit."""


@lru_cache(maxsize=64)  # sender and receiver of one process ask for the same
def crc16(data: bytes, crc: int = 0xFFFF) -> int:
    """CRC-16/MODBUS: polynomial 0x8005 reflected, begun with 0xFFFF. ``crc``: that of what goes before.

    The polynomial is (x + 1)(x^15 + x + 1). The remainder by the first factor is the parity. The second one
    divides x^15s + x^s + 1 for s = 1, 2, 4, 8 and so on, since squares have no mixed terms: up to 14 s of the
    highest coefficients are added to lower ones at once, and a few operations on long integers do what a
    table does byte by byte. The first bit of the data, the integer's lowest, is the highest coefficient.
    """
    rest = int.from_bytes(data, "little") ^ crc
    parity = rest.bit_count()
    for count, mask, a, b in _folds(8 * len(data) + 16):
        low = rest & mask
        rest = (rest ^ low << a ^ low << b) >> count
    crc, table = rest & 0xFFFF, _by_one_byte()
    for _ in data[:2]:
        crc = crc >> 8 ^ table[crc & 0xFF]
    crc ^= rest >> 16
    return crc ^ _FACTOR if crc.bit_count() + parity & 1 else crc


def encode(envelope: Envelope) -> bytes:
    """The bytes of a slot. The caller keeps ``len(adata)`` a multiple of 4 and within the slot."""
    e = envelope
    words = _WORDS.pack(e.seq, e.aid, e.cmd, e.attempt, len(e.adata))
    return words + crc16(words + e.adata).to_bytes(4, "little") + e.adata


def head(slot: bytes) -> Head:
    """The first words of a slot of at least 20 bytes."""
    return Head(*_HEAD.unpack_from(slot))


def intact(head: Head, slot: bytes) -> bool:
    """The CRC is that of the bytes. ``head.len`` is a multiple of 4 and within the slot."""
    return head.crc == crc16(slot[: HEAD - 4] + slot[HEAD : HEAD + head.len])


def decode(head: Head, slot: bytes) -> Envelope:
    """The envelope of a slot that is ``intact``."""
    return Envelope(head.seq, head.aid, head.cmd, head.attempt, slot[HEAD : HEAD + head.len])
