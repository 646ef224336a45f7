"""Which symbol lies where in the memory of one processor, and who may write it (SPEC 1.2, 1.3, 9.4).

The areas themselves are in `ldc/il/memory.toml`. A map is made for one processor and one build: its addresses
are those that the rewritten source of a component gets.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from ldc.il.areas import areas
from ldc.records import record
from ldc.symbols import Variable
from ldc.types import BOOL, Array, Elementary, Enum, Subrange, Type, storage

MACROS = ("PLC_M", "PLC_D", "LCD")
"""How C names memory: a bit of M, data of D, a parameter in the data area of the modules."""

_MASTER = frozenset(("master",))


@record
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


@record
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


def placed(processor: str, wanted: Iterable[tuple[str, Type, str]], word_bits: int = 8) -> AddressMap:
    """Symbols (name, type, area) one behind the other in their areas, at absolute logical addresses: map of
    a processor whose memory is that of SPEC 1.3. On a word-addressed one an address is that of a word.

    A slave has its own windows of the shared areas. Raises ValueError when an area is full, or unknown.
    """
    slave = int(processor[-1]) if processor[-1].isdigit() else 1
    used: dict[str, int] = {}
    symbols = []
    for name, type_, area_name in wanted:
        area = areas().get(area_name)
        if area is None:
            raise ValueError(f"there is no area {area_name}")
        bits = area.space == "M"
        count = type_.count if isinstance(type_, Array) else 1
        element = type_.element if isinstance(type_, Array) else type_
        # Attribute D: an element has 4 bytes; wider values and arrays take several.
        size = count if bits else -(-count * max(1, storage(element).bits // 8) // 4) * 4
        start = used.get(area_name, 0)
        used[area_name] = start + size
        if start + size > area.size:
            raise ValueError(f"area {area_name} is full: `{name}` does not fit")
        at = area.first(slave) + start
        unit = word_bits if bits else word_bits // 8
        owner = "master" if area.writer == "master" else f"slave{slave}"
        readers = frozenset(f"slave{slave}" if r == "slave" else r for r in area.readers)
        macro = "LCD" if area_name == "LCD" else f"PLC_{area.space}"
        symbols.append(
            Symbol(
                name,
                macro,
                type_,
                area_name,
                at // unit,
                at % unit if bits else None,
                frozenset((owner,)),
                readers,
            )
        )
    return of_symbols(processor, symbols, word_bits, base="")


def nameable(globals_: Iterable[Variable]) -> Iterator[tuple[Variable, Type]]:
    """The globals that C can name, each with the type of its elements: no variables of programs."""
    for v in globals_:
        element = v.type
        while isinstance(element, Array):
            element = element.element
        if "." not in v.name and isinstance(element, Elementary | Enum | Subrange):
            yield v, element


def global_symbol(variable: Variable, element: Type, address: int, bit: int | None = None) -> Symbol:
    """A global of the master; inputs and constants have no writer."""
    fixed = variable.constant or variable.location is not None and variable.location.area == "I"
    macro = macro_of(element)
    return Symbol(variable.name, macro, variable.type, macro[-1], address, bit,
                  frozenset() if fixed else _MASTER, _MASTER)


def macro_of(type_: Type) -> str:
    """BOOL is reached in M, everything else in D."""
    return "PLC_M" if storage(type_) == BOOL else "PLC_D"
