"""The envelope of a transfer, as it lies in a slot of shared memory (SPEC 2.4).

``u32 seq | u32 aid | u16 cmd | u16 attempt | u32 len | u32 crc | adata[len]``, little-endian; ``crc`` is the
CRC-16/MODBUS of the words before it and of adata, its upper half 0. adata: ``u32 pid | 4 bytes`` a parameter.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from functools import cache

HEAD = 20
"""Bytes before the data."""

LAST_SEQ = 0x7FFFFF
"""Numbers of transfers run from 1 to this and again from 1, so that an answer holds one beside its code. A
RESET has the number 0, and its ordinal as aid."""

_HEAD = struct.Struct("<IIHHII")


class Command(IntEnum):
    START = 1
    UPDATE = 2
    STOP = 3
    RESET = 4


@dataclass(frozen=True, slots=True)
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


@dataclass(frozen=True, slots=True)
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
    return 0x800000 | aid & 0x7FFFFF if cmd == Command.RESET else seq & 0xFFFFFF


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
def _by_two_bytes() -> tuple[int, ...]:
    """The register after two more bytes, by its exclusive or with them."""
    one = _by_one_byte()
    high = [value >> 8 for value in one]
    low = [value & 0xFF for value in one]
    return tuple(one[low[n & 0xFF] ^ n >> 8] ^ high[n & 0xFF] for n in range(0x10000))


def crc16(data: bytes, crc: int = 0xFFFF) -> int:
    """CRC-16/MODBUS: polynomial 0x8005 reflected, begun with 0xFFFF. ``crc``: that of what goes before."""
    table, pairs = _by_two_bytes(), len(data) // 2
    for pair in struct.unpack_from(f"<{pairs}H", data):
        crc = table[crc ^ pair]
    if len(data) % 2:
        crc = crc >> 8 ^ _by_one_byte()[(crc ^ data[-1]) & 0xFF]
    return crc


def encode(envelope: Envelope) -> bytes:
    """The bytes of a slot. The caller keeps ``len(adata)`` a multiple of 4 and within the slot."""
    e = envelope
    words = _HEAD.pack(e.seq, e.aid, e.cmd, e.attempt, len(e.adata), 0)
    crc = crc16(e.adata, crc16(words[: HEAD - 4]))
    return words[: HEAD - 4] + crc.to_bytes(4, "little") + e.adata


def head(slot: bytes) -> Head:
    """The first words of a slot of at least 20 bytes."""
    return Head(*_HEAD.unpack_from(slot))


def intact(head: Head, slot: bytes) -> bool:
    """The CRC is that of the bytes. ``head.len`` is a multiple of 4 and within the slot."""
    return head.crc == crc16(slot[HEAD : HEAD + head.len], crc16(slot[: HEAD - 4]))


def decode(head: Head, slot: bytes) -> Envelope:
    """The envelope of a slot that is ``intact``."""
    return Envelope(head.seq, head.aid, head.cmd, head.attempt, slot[HEAD : HEAD + head.len])
