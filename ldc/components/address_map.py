"""Which symbol lies where in the memory of one processor, and who may write it (SPEC 1.2, 1.3, 9.4).

`memory.toml` is the one source of the areas. A map is made for one processor and one build: its addresses
are those that the rewritten source of a component gets.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources

from ldc.types import BOOL, Type, storage

MACROS = ("PLC_M", "PLC_D", "LCD")
"""How C names memory: a bit of M, data of D, a parameter in the data area of the modules."""

PROCESSORS = ("master", "slave1", "slave2", "slave3", "slave4")


@dataclass(frozen=True, slots=True)
class Area:
    """One area of SPEC 1.2. ``space``: "M" (addresses are bits) or "D" (bytes); ``attribute``: "B" (every
    element is a bit) or "D" (every element has 4 bytes). ``size`` is in the unit of the space. ``base``:
    the first address, for slave 1 when the area is one of ``per_slave`` windows, ``stride`` apart."""

    name: str
    space: str
    attribute: str
    base: int
    size: int
    writer: str
    readers: tuple[str, ...]
    text: str
    stride: int = 0

    def first(self, slave: int = 1) -> int:
        """The first address, of the window of a slave 1 .. 4."""
        return self.base + (slave - 1) * self.stride


@dataclass(frozen=True, slots=True)
class Symbol:
    """A name that C may use. ``address`` is in the unit of its processor's memory (bytes, or words of 16
    bits on a word-addressed one); ``bit`` of a packed BOOL, None when it has bytes of its own."""

    name: str
    macro: str
    type: Type
    area: str
    address: int
    bit: int | None
    writers: frozenset[str]
    readers: frozenset[str]


@dataclass(frozen=True, slots=True)
class AddressMap:
    """The symbols that the components of one processor see, by macro and name in capitals.

    ``word_bits``: the bits of one address, 8, or 16 on targets whose char has 16 bits. ``base``: the C
    expression of the memory's begin that addresses are relative to, "" when they are absolute.
    """

    processor: str
    symbols: Mapping[tuple[str, str], Symbol]
    word_bits: int = 8
    base: str = "ldc_memory"

    def find(self, macro: str, name: str) -> Symbol | None:
        """The symbol of exactly this spelling: C tells letters apart."""
        found = self.symbols.get((macro, name.upper()))
        return found if found is not None and found.name == name else None

    def names(self, macro: str) -> list[str]:
        """For hints: all names of a macro."""
        return [s.name for (m, _), s in self.symbols.items() if m == macro]


def of_symbols(
    processor: str, symbols: Iterable[Symbol], word_bits: int = 8, base: str = "ldc_memory"
) -> AddressMap:
    return AddressMap(processor, {(s.macro, s.name.upper()): s for s in symbols}, word_bits, base)


def macro_of(type_: Type) -> str:
    """BOOL is reached in M, everything else in D."""
    return "PLC_M" if storage(type_) == BOOL else "PLC_D"


@cache
def areas() -> Mapping[str, Area]:
    """The areas of memory.toml by name."""
    text = (resources.files("ldc.components") / "memory.toml").read_text(encoding="utf-8")
    return {
        name: Area(name=name, **{**row, "readers": tuple(row["readers"])})
        for name, row in tomllib.loads(text)["areas"].items()
    }
