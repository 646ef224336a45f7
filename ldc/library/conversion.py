"""Type conversions ``*_TO_**``, ``*_TRUNC_**`` and BCD (IEC 61131-3, 2nd edition, table 22).

What overflows, what is rounded and in which unit times count is defined in docs/semantics.md.
"""

from __future__ import annotations

from collections.abc import Callable
from struct import Struct

from ldc.library.generic import short_name
from ldc.library.numeric import TRUNCATE
from ldc.library.table import Function, Shape
from ldc.library.text import print_value, read_value
from ldc.library.values import DAY, MILLISECOND, SECOND, normaliser, saturate
from ldc.types import (
    BOOL, BYTE, DATE, DINT, DT, DWORD, INT, LINT, LREAL, LWORD, REAL, SINT, STRING, TIME, TOD, UDINT,
    UINT, ULINT, USINT, WORD, WSTRING, Elementary, String, Type, default, storage,
)


GROUP = "22 conversion"
TYPES = (BOOL, SINT, INT, DINT, LINT, USINT, UINT, UDINT, ULINT, REAL, LREAL, BYTE, WORD, DWORD, LWORD,
         TIME, DATE, TOD, DT, STRING, WSTRING)
_INTEGERS = ("int", "uint", "bits")
_TRANSFERS = {("REAL", "DWORD"), ("DWORD", "REAL"), ("LREAL", "LWORD"), ("LWORD", "LREAL")}
KEPT = frozenset(f"{a}_TO_{b}" for a, b in _TRANSFERS)
"""Conversions that keep the bits, though their names are like those that convert a number."""
_TIMES = {("dt", "date"), ("dt", "tod"), ("date", "dt"), ("tod", "time"), ("time", "tod")}
# One of an integer is so many of the stored unit.
_SCALE = {"time": MILLISECOND, "tod": MILLISECOND, "dt": SECOND}


def exists(source: Type, target: Type) -> bool:
    """Whether there is a conversion between two different elementary types."""
    if isinstance(source, String) or isinstance(target, String):
        return source.name != target.name
    a, b = source.kind, target.kind
    if source == target:
        return False
    if a in _SCALE or b in _SCALE or "date" in (a, b):
        other = b if a in _SCALE or a == "date" else a
        return (a, b) in _TIMES or other in _INTEGERS or (other == "real" and "time" in (a, b))
    return True


def convert(source: Type, target: Type) -> Callable:
    """One value of ``source`` as ``target``; the pair must exist."""
    source, target = storage(source), storage(target)
    if isinstance(source, String):
        return _from_text(source, target)
    if isinstance(target, String):
        wide, length = target.name == "WSTRING", target.length
        if wide:
            return lambda v: print_value(v, source)[:length]
        return lambda v: print_value(v, source).encode("latin-1")[:length]
    if (source.name, target.name) in _TRANSFERS:
        return _transfer(source, target)
    if target.kind == "bool":
        return lambda v: v != 0
    return _number(source, target)


def _number(source: Elementary, target: Elementary) -> Callable:
    a, b, fit = source.kind, target.kind, normaliser(target)
    if (a, b) in _TIMES:
        by = {"date": lambda v: v // DAY, "tod": lambda v: v % DAY, "dt": lambda v: fit(v * DAY)}
        return by.get(b, lambda v: v)
    if a == "real":
        return _from_real(target)
    if b == "real":
        if a == "time":
            return lambda v: fit(float(v) / 1e6)
        return lambda v: fit(float(v))
    if a == "date":
        return lambda v: fit(v * (DAY // SECOND))
    if b == "date":
        return lambda v: fit(v // (DAY // SECOND))
    if a in _SCALE:
        unit = _SCALE[a]
        return lambda v: fit(v // unit if v >= 0 else -(-v // unit))
    if b in _SCALE:
        unit = _SCALE[b]
        return lambda v: fit(v * unit)
    return lambda v: fit(int(v))


def _from_real(target: Elementary) -> Callable:
    if target.kind == "real":
        return normaliser(target)
    low, high = target.range
    if target.kind == "time":
        return lambda v: saturate(v * 1e6, low, high)
    return lambda v: saturate(v, low, high)


def _transfer(source: Elementary, target: Elementary) -> Callable:
    """The bit pattern, as the 3rd edition has it (table 25)."""
    codes = {"REAL": "<f", "DWORD": "<I", "LREAL": "<d", "LWORD": "<Q"}
    pack, unpack = Struct(codes[source.name]).pack, Struct(codes[target.name]).unpack
    return lambda v: unpack(pack(v))[0]


def _from_text(source: String, target: Type) -> Callable:
    wide = source.name == "WSTRING"
    if isinstance(target, String):
        length = target.length
        if wide:
            return lambda v: v.encode("latin-1", "replace")[:length]
        return lambda v: v.decode("latin-1")[:length]
    nothing = default(target)

    def read(value):
        found = read_value(value if wide else value.decode("latin-1"), target)
        return nothing if found is None else found

    return read


def _from_bcd(types: tuple[Type, ...], result: Type) -> Callable:
    fit = normaliser(result)

    def value_of(pattern: int) -> int:
        digits = f"{pattern:x}"
        return fit(int(digits)) if digits.isdigit() else 0

    return value_of


def _to_bcd(types: tuple[Type, ...], result: Type) -> Callable:
    bound = 10 ** (result.bits // 4)
    return lambda value: int(str(value % bound), 16)


def _row(source: Type, target: Type) -> Function:
    result = target.name
    if isinstance(source, String) and isinstance(target, String):
        result = "wide" if target.name == "WSTRING" else "narrow"
    return Function(f"{short_name(source)}_TO_{short_name(target)}", ("IN",),
                    (Shape((source.name,), result),), lambda types, out: convert(types[0], out), GROUP)


def _bcd_rows() -> tuple[Function, ...]:
    rows = []
    for bits in (BYTE, WORD, DWORD, LWORD):
        for number in (USINT, UINT, UDINT, ULINT):
            rows += [
                Function(f"{bits.name}_BCD_TO_{number.name}", ("IN",), (Shape((bits.name,), number.name),),
                         _from_bcd, GROUP, "0 when a digit is above 9; wraps"),
                Function(f"{number.name}_TO_BCD_{bits.name}", ("IN",), (Shape((number.name,), bits.name),),
                         _to_bcd, GROUP, "the last digits that fit"),
            ]
    return tuple(rows)


CONVERSIONS = tuple(_row(a, b) for a in TYPES for b in TYPES if exists(a, b))
TRUNCATIONS = tuple(
    Function(f"{a.name}_TRUNC_{b.name}", ("IN",), (Shape((a.name,), b.name),), TRUNCATE, GROUP,
             "fraction cut off; saturates, NaN gives 0")
    for a in (REAL, LREAL) for b in (SINT, INT, DINT, LINT, USINT, UINT, UDINT, ULINT))
BCD = _bcd_rows()
ENUMERATIONS = tuple(
    Function(f"ENUM_TO_{b.name}", ("IN",), (Shape(("ANY_ENUM",), b.name),),
             lambda types, out: convert(types[0], out), GROUP, "the number of the value; wraps")
    for b in (SINT, INT, DINT, LINT, USINT, UINT, UDINT, ULINT))
FUNCTIONS = CONVERSIONS + TRUNCATIONS + BCD + ENUMERATIONS
