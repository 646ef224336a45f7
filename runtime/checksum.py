"""The checksum of a state: one definition for every engine (DESIGN section 8, ``bench``).

SHA-256 over the canonical bytes of every scalar with state (hidden memories too, temporaries not) in
the order of their paths in capitals; the first 16 hexadecimal digits. Little-endian: BOOL one byte,
integers, bit strings, dates and times in their width, REAL and LREAL as IEEE 754 with one NaN
(0x7FC00000, 0x7FF8000000000000), enumerations as DINT, STRING as its length (32 bit) and bytes,
WSTRING as its length in UTF-16 code units (32 bit) and those units.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable
from struct import pack, unpack

from ldc.types import String, Type, storage
from runtime.symbols import Symbol


def of(symbols: Iterable[Symbol], value: Callable[[Symbol], object]) -> str:
    """The checksum of some symbols, of which ``value`` gives the values."""
    digest = hashlib.sha256()
    for symbol in sorted(symbols, key=lambda s: s.path.upper()):
        digest.update(canonical(value(symbol), symbol.type))
    return digest.hexdigest()[:16]


def canonical(value, type_: Type) -> bytes:
    """The canonical bytes of one value."""
    if isinstance(type_, String):
        data = value if isinstance(value, bytes) else value.encode("utf-16-le", "surrogatepass")
        return pack("<I", len(value) if isinstance(value, bytes) else len(data) // 2) + data
    base = storage(type_)
    if base.kind == "real":
        if value != value:
            return bytes.fromhex("0000c07f" if base.bits == 32 else "000000000000f87f")
        return pack("<f" if base.bits == 32 else "<d", value)
    if base.kind == "bool":
        return b"\1" if value else b"\0"
    return (value & (1 << base.bits) - 1).to_bytes(base.bits // 8, "little")


def value_of(data: bytes, at: int, type_: Type) -> tuple[object, int]:
    """The value whose canonical bytes begin at ``at``, and where they end; a string is cut to its length.
    Raises ValueError when there are too few bytes."""
    if isinstance(type_, String):
        wide = type_.name != "STRING"
        count = int.from_bytes(_bytes(data, at, 4), "little")
        raw = _bytes(data, at + 4, count * (2 if wide else 1))
        value = raw.decode("utf-16-le", "surrogatepass") if wide else raw
        return value[:type_.length], at + 4 + len(raw)
    base = storage(type_)
    size = max(base.bits // 8, 1)
    raw = _bytes(data, at, size)
    if base.kind == "real":
        return unpack("<f" if base.bits == 32 else "<d", raw)[0], at + size
    if base.kind == "bool":
        return raw != b"\0", at + size
    return int.from_bytes(raw, "little", signed=base.range[0] < 0), at + size


def _bytes(data: bytes, at: int, count: int) -> bytes:
    if at + count > len(data):
        raise ValueError(f"{len(data)} bytes are too few")
    return data[at:at + count]
