"""Areas of memory as 32-bit words over any buffer, and the rule that each word has one writer (SPEC 1.3, W1).

A buffer is a bytearray, an mmap, the ``buf`` of a ``multiprocessing.shared_memory.SharedMemory``: whatever
has bytes that can be written. Words are in the byte order of the machine, as C on the same machine has them.

Stores of one processor become visible to the others in the order in which they were made on machines with
total store order (x86). Elsewhere Python has no barrier to give; there the sequence is for C, and what a
reader may see torn, the check of an envelope finds.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence

from ldc.il.areas import MASTER, PROCESSORS, SLAVES, Area, areas, shared_range
from ldc.records import record


class _Numbers(dict):
    """The number of the word at each address that was asked for."""

    def __init__(self, first: int) -> None:
        self._first = first

    def __missing__(self, address: int) -> int:
        at = address - self._first
        if at & 3 or at < 0:
            raise IndexError(f"{address:#x} is no word of this memory")
        return self.setdefault(address, at >> 2)


class Words:
    """The words of a buffer. Addresses are byte addresses, multiples of 4; ``first``: that of the buffer's
    begin. What is no word of it raises IndexError."""

    __slots__ = ("_bytes", "_words", "_number", "first")

    def __init__(self, buffer: bytearray | memoryview, first: int = 0) -> None:
        self._bytes = memoryview(buffer).cast("B")
        self._words = self._bytes.cast("I")
        self._number = _Numbers(first)
        self.first = first

    def load(self, address: int) -> int:
        return self._words[self._number[address]]

    def store(self, address: int, value: int) -> None:
        self._words[self._number[address]] = value

    def test(self, address: int, mask: int) -> bool:
        """Whether any bit of the mask is 1."""
        return self._words[self._number[address]] & mask != 0

    def search(self, addresses: Sequence[int], mask: int) -> int:
        """``test`` of words one after the other: the place of the first that has a bit of the mask, how many
        they are when none has."""
        words, number, place = self._words, self._number, 0
        for address in addresses:
            if words[number[address]] & mask:
                break
            place += 1
        return place

    def set(self, address: int, mask: int) -> None:
        """Makes the bits of the mask 1. Only the one writer of a word may, so that reading it before is
        safe."""
        self._words[self._number[address]] |= mask

    def clear(self, address: int, mask: int) -> None:
        """Makes the bits of the mask 0; as ``set``."""
        self._words[self._number[address]] &= ~mask

    def read(self, address: int, size: int) -> bytes:
        """A copy of ``size`` bytes. They may be of different moments."""
        at = self._number[address] * 4
        return self._bytes[at : at + size].tobytes()

    def write(self, address: int, data: bytes) -> None:
        at = self._number[address] * 4
        self._bytes[at : at + len(data)] = data

    def close(self) -> None:
        """Lets the buffer go, which can be closed then."""
        self._words.release()
        self._bytes.release()


def bit(number: int) -> tuple[int, int]:
    """Address and mask of a bit of M."""
    return number // 32 * 4, 1 << number % 32


@record
class Memory:
    """What one processor reaches: its own bits (M) and data (D), and the shared memory."""

    processor: str
    bits: Words | Watched
    data: Words | Watched
    shared: Words | Watched


def shared_size() -> int:
    """The bytes of the shared memory."""
    first, end = shared_range()
    return end - first


def shared_words(buffer: bytearray | memoryview) -> Words:
    """The shared memory over a buffer of at least ``shared_size`` bytes, at its addresses of SPEC 1.3."""
    return Words(buffer, shared_range()[0])


def allocate(processor: str, shared: bytearray | memoryview) -> Memory:
    """Memory of a processor, all its own bytes 0, over a shared buffer."""
    return Memory(processor, Words(bytearray(_local_size(processor, "M"))),
                  Words(bytearray(_local_size(processor, "D"))), shared_words(shared))


def _role(processor: str) -> str:
    return MASTER if processor == MASTER else "slave"


def _local(processor: str, space: str) -> list[Area]:
    return [a for a in areas().values() if a.space == space and not a.shared and a.writer == _role(processor)]


def _local_size(processor: str, space: str) -> int:
    end = max((area.base + area.size for area in _local(processor, space)), default=0)
    return end if space == "D" else -(-end // 32) * 4


class ForeignAccess(Exception):
    """A processor touches a word that it may not read, or may not write."""


@record
class Access:
    """``kind``: ``load``, ``store``, ``set``, ``clear``; ``value``: the bits or the bytes concerned."""

    processor: str
    kind: str
    area: str
    address: int
    value: int | bytes


@record
class _Range:
    first: int
    end: int
    name: str
    writer: str
    readers: frozenset[str]


class Watched:
    """Words that a processor may touch only as memory.toml says; ``seen`` gets every access that is allowed.

    ``space``: "D", or "M" for words of bits. Raises ForeignAccess.
    """

    __slots__ = ("_words", "_processor", "_ranges", "_starts", "_seen")

    def __init__(self, words: Words, processor: str, space: str = "D", shared: bool = False,
                 seen: Callable[[Access], None] | None = None) -> None:
        self._words, self._processor, self._seen = words, processor, seen
        self._ranges = _ranges(processor, space, shared)
        self._starts = [r.first for r in self._ranges]

    def _check(self, kind: str, address: int, size: int, value: int | bytes) -> None:
        found = bisect_right(self._starts, address) - 1
        if found < 0 or address + size > self._ranges[found].end:
            raise ForeignAccess(f"{self._processor}: {address:#x} is in no area")
        area = self._ranges[found]
        if kind == "load" and self._processor not in area.readers:
            raise ForeignAccess(f"{self._processor} may not read {area.name} at {address:#x}")
        if kind != "load" and self._processor != area.writer:
            raise ForeignAccess(
                f"{self._processor} may not write {area.name} of {area.writer} at {address:#x}")
        if self._seen is not None:
            self._seen(Access(self._processor, kind, area.name, address, value))

    def load(self, address: int) -> int:
        self._check("load", address, 4, 0)
        return self._words.load(address)

    def store(self, address: int, value: int) -> None:
        self._check("store", address, 4, value)
        self._words.store(address, value)

    def test(self, address: int, mask: int) -> bool:
        self._check("load", address, 4, mask)
        return self._words.test(address, mask)

    def search(self, addresses: Sequence[int], mask: int) -> int:
        return next((n for n, address in enumerate(addresses) if self.test(address, mask)), len(addresses))

    def set(self, address: int, mask: int) -> None:
        self._check("set", address, 4, mask)
        self._words.set(address, mask)

    def clear(self, address: int, mask: int) -> None:
        self._check("clear", address, 4, mask)
        self._words.clear(address, mask)

    def read(self, address: int, size: int) -> bytes:
        self._check("load", address, size, b"")
        return self._words.read(address, size)

    def write(self, address: int, data: bytes) -> None:
        self._check("store", address, len(data), data)
        self._words.write(address, data)


def watch(memory: Memory, seen: Callable[[Access], None] | None = None) -> Memory:
    """The same memory with every access checked."""
    return Memory(memory.processor, Watched(memory.bits, memory.processor, "M", False, seen),
                  Watched(memory.data, memory.processor, "D", False, seen),
                  Watched(memory.shared, memory.processor, "D", True, seen))


def _ranges(processor: str, space: str, shared: bool) -> list[_Range]:
    found, scale = [], 8 if space == "M" else 1
    if shared:
        for area in (a for a in areas().values() if a.shared):
            for slave in range(1, SLAVES + 1):
                name = {MASTER: MASTER, "slave": PROCESSORS[slave]}
                first = area.first(slave)
                found.append(_Range(first, first + area.size, area.name, name[area.writer],
                                    frozenset(name[reader] for reader in area.readers)))
    else:
        own = frozenset((processor,))
        found = [_Range(a.base // scale, (a.base + a.size) // scale, a.name, processor, own)
                 for a in _local(processor, space)]
    return sorted(found, key=lambda r: r.first)
