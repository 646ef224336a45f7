"""The data types of IEC 61131-3 (2nd edition, table 10 and 12), as values.

BOOL is 0/1, bit strings are unsigned integers, TIME is a signed 64-bit count of nanoseconds,
DATE counts days since 1970-01-01, TIME_OF_DAY nanoseconds since midnight, DATE_AND_TIME
nanoseconds since 1970-01-01; strings are bytes (Latin-1), WSTRING is text.
"""

from __future__ import annotations

from collections.abc import Iterator

from ldc.records import field, record

Scalar = bool | int | float | bytes | str


@record
class Elementary:
    """An elementary type. ``kind``: bool bits int uint real time date tod dt; ``bits``: width."""

    name: str
    kind: str
    bits: int

    def __str__(self) -> str:
        return self.name

    @property
    def range(self) -> tuple[int, int]:
        """Least and greatest value of an integer-like type."""
        if self.kind in ("int", "time"):
            return -(1 << self.bits - 1), (1 << self.bits - 1) - 1
        return 0, (1 << self.bits) - 1


@record
class String:
    """STRING[length] or WSTRING[length]; longer values are cut."""

    name: str = "STRING"
    length: int = 80

    def __str__(self) -> str:
        return f"{self.name}[{self.length}]"


@record
class Array:
    """ARRAY [lo..hi, ...] OF element; bounds are inclusive."""

    bounds: tuple[tuple[int, int], ...]
    element: Type

    def __str__(self) -> str:
        return f"ARRAY [{', '.join(f'{a}..{b}' for a, b in self.bounds)}] OF {self.element}"

    @property
    def count(self) -> int:
        total = 1
        for low, high in self.bounds:
            total *= high - low + 1
        return total


@record
class Field:
    """A member of a structure; ``initial`` overrides the initial value of its type."""

    name: str
    type: Type
    initial: Value | None = None


@record
class Struct:
    name: str
    fields: tuple[Field, ...]

    def __str__(self) -> str:
        return self.name

    def field(self, name: str) -> Field | None:
        key = name.upper()
        return next((f for f in self.fields if f.name.upper() == key), None)


@record
class Enum:
    """Named values; stored as DINT. ``initial`` is the first value unless declared otherwise. ``base``: the
    integer or bit string that is written behind the values."""

    name: str
    values: tuple[tuple[str, int], ...]
    initial: int = 0
    base: Elementary | None = field(default=None, compare=False)

    def __str__(self) -> str:
        return self.name or f"({', '.join(f'{name} := {number}' for name, number in self.values)})"


@record
class Subrange:
    """A range of an integer type; arithmetic is that of ``base``."""

    name: str
    base: Elementary
    low: int
    high: int

    def __str__(self) -> str:
        return self.name or f"{self.base}({self.low}..{self.high})"


@record
class Instance:
    """An instance of a function block (standard or of the project), by POU name in capitals."""

    pou: str

    def __str__(self) -> str:
        return self.pou


Type = Elementary | String | Array | Struct | Enum | Subrange | Instance
# Initial values: a scalar, or per element/field: tuple for an array (flat, row-major),
# tuple of (field name, value) pairs for a structure or an instance.
Value = Scalar | tuple

BOOL = Elementary("BOOL", "bool", 1)
SINT, INT, DINT, LINT = (Elementary(n, "int", b) for n, b in
                         (("SINT", 8), ("INT", 16), ("DINT", 32), ("LINT", 64)))
USINT, UINT, UDINT, ULINT = (Elementary(n, "uint", b) for n, b in
                             (("USINT", 8), ("UINT", 16), ("UDINT", 32), ("ULINT", 64)))
REAL, LREAL = Elementary("REAL", "real", 32), Elementary("LREAL", "real", 64)
BYTE, WORD, DWORD, LWORD = (Elementary(n, "bits", b) for n, b in
                            (("BYTE", 8), ("WORD", 16), ("DWORD", 32), ("LWORD", 64)))
TIME = Elementary("TIME", "time", 64)
DATE = Elementary("DATE", "date", 32)
TOD = Elementary("TIME_OF_DAY", "tod", 64)
DT = Elementary("DATE_AND_TIME", "dt", 64)
STRING, WSTRING = String("STRING"), String("WSTRING")

ELEMENTARY: dict[str, Elementary | String] = {
    t.name: t for t in (BOOL, SINT, INT, DINT, LINT, USINT, UINT, UDINT, ULINT, REAL, LREAL,
                        BYTE, WORD, DWORD, LWORD, TIME, DATE, TOD, DT, STRING, WSTRING)
} | {"TOD": TOD, "DT": DT}


def storage(type_: Type) -> Type:
    """The elementary type that a scalar is stored as: subranges as their base, enumerations as DINT."""
    if isinstance(type_, Subrange):
        return type_.base
    return DINT if isinstance(type_, Enum) else type_


def numbered(type_: Type) -> Elementary | None:
    """The bit string or integer that values of the type are, whose bits and parts have numbers; None for
    other types."""
    base = storage(type_)
    counts = isinstance(base, Elementary) and base.kind in ("bits", "int", "uint")
    known = counts and not isinstance(type_, Enum)
    return base if known else None


def is_scalar(type_: Type) -> bool:
    """Whether a value of the type fits one IL operand (everything but arrays, structures, instances)."""
    return not isinstance(type_, Array | Struct | Instance)


def blocks_in(type_: Type) -> Iterator[str]:
    """The function blocks (capitals) that a value of the type holds instances of, or is one of; not those
    inside of these."""
    match type_:
        case Instance(pou):
            yield pou
        case Array(element=element):
            yield from blocks_in(element)
        case Struct(fields=fields):
            for member in fields:
                yield from blocks_in(member.type)


def holds_blocks(type_: Type) -> bool:
    """Whether there are instances in a value of the type: such values have an identity and are not copied."""
    return next(blocks_in(type_), None) is not None


def default(type_: Type) -> Value:
    """The initial value that the standard gives when none is declared (2.4.3.2)."""
    match type_:
        case Elementary(kind="real"):
            return 0.0
        case Elementary(kind="bool"):
            return False
        case Elementary():
            return 0
        case String(name="STRING"):
            return b""
        case String():
            return ""
        case Enum():
            return type_.initial
        case Subrange():
            return type_.low if not type_.low <= 0 <= type_.high else 0
        case Array():
            return (default(type_.element),) * type_.count
        case Struct():
            return tuple((f.name, default(f.type) if f.initial is None else f.initial)
                         for f in type_.fields)
        case Instance():
            return ()
