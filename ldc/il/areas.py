"""The areas of memory of master and slaves: where they lie, who writes and who reads them (SPEC 1.2, 1.3).

`memory.toml` beside this module is the one source of the table; compiler and runtime take it from here.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from ldc.records import record

SLAVES = 4
"""As many slaves as the shared memory has windows for."""

MASTER = "master"

PAGE = 0x1000
"""Bytes of shared memory that one processor is given to write (rule W1)."""

PROCESSORS = (MASTER, *(f"slave{n}" for n in range(1, SLAVES + 1)))


@record
class Area:
    """One area of SPEC 1.2. ``space``: "M" (addresses are bits) or "D" (bytes); ``attribute``: "B" (every
    element is a bit) or "D" (every element has 4 bytes). ``size`` is in the unit of the space. ``base``:
    the first address, for slave 1 when the area is one of windows that lie ``stride`` apart."""

    name: str
    space: str
    attribute: str
    base: int
    size: int
    writer: str
    readers: tuple[str, ...]
    text: str
    stride: int = 0

    @property
    def shared(self) -> bool:
        """It lies in the memory that master and slaves share."""
        return self.stride > 0

    def first(self, slave: int = 1) -> int:
        """The first address, of the window of a slave 1 .. 4."""
        return self.base + (slave - 1) * self.stride

    def window(self, address: int) -> int | None:
        """Whose window holds an address: a slave 1 .. 4, 1 for an area without windows, None: none of it."""
        for slave in range(1, SLAVES + 1 if self.shared else 2):
            if self.first(slave) <= address < self.first(slave) + self.size:
                return slave
        return None


@cache
def areas() -> Mapping[str, Area]:
    """The areas of memory.toml by name."""
    import tomllib  # slow to load, and few programs ask for areas

    text = Path(__file__).with_name("memory.toml").read_text(encoding="utf-8")
    return {
        name: Area(name=name, **{**row, "readers": tuple(row["readers"])})
        for name, row in tomllib.loads(text)["areas"].items()
    }


@cache
def shared_range() -> tuple[int, int]:
    """The first address of the shared memory and the one behind its last, in whole pages of 4 KiB."""
    shared = [area for area in areas().values() if area.shared]
    end = max(area.first(SLAVES) + area.size for area in shared)
    return min(area.base for area in shared), -(-end // PAGE) * PAGE


def slips(table: Iterable[Area]) -> list[str]:
    """What is wrong with a table of areas, in words: overlap, alignment, writer, a page with two writers."""
    found, placed, pages = [], {}, {}
    for area in table:
        if area.writer not in (MASTER, "slave") or area.writer not in area.readers:
            found.append(f"{area.name}: writer {area.writer} is no processor that reads it")
        if area.space == "D" and (area.base % 4 or area.size % 4 or area.stride % 4):
            found.append(f"{area.name}: base, size and stride of data are multiples of 4")
        if area.size <= 0 or area.shared and area.stride < area.size:
            found.append(f"{area.name}: a window holds {area.stride or area.size} of {area.size}")
        for slave in range(1, SLAVES + 1 if area.shared else 2):
            first = area.first(slave)
            owner = "shared" if area.shared else area.writer
            placed.setdefault((owner, area.space), []).append((first, first + area.size, area.name))
            if area.shared:
                for page in range(first // PAGE, (first + area.size - 1) // PAGE + 1):
                    other, writer = pages.setdefault(page, (area.name, area.writer))
                    if writer != area.writer:
                        found.append(f"{area.name}: {other} in the same page has another writer")
    for ranges in placed.values():
        ranges.sort()
        for (_, end, name), (first, _, other) in zip(ranges, ranges[1:], strict=False):
            if first < end:
                found.append(f"{other}: overlaps {name}")
    return found
