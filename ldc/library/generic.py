"""Generic types (ANY_NUM ...) and implicit widening (IEC 61131-3: 2nd edition 2.3.2, 3rd edition 6.6.1.6)."""

from __future__ import annotations

from collections.abc import Iterable

from ldc.types import (
    BYTE, DINT, DWORD, INT, LINT, LREAL, LWORD, REAL, SINT, UDINT, UINT, ULINT, USINT, WORD,
    Elementary, Enum, String, Subrange, Type, storage,
)

_TEMPORAL = frozenset(("time", "date", "tod", "dt"))
_NUMBERS = frozenset(("int", "uint", "real"))
# The kinds of value that a generic type stands for; "aggregate" is all that is not scalar.
GENERIC: dict[str, frozenset[str]] = {
    "ANY_INT": frozenset(("int", "uint")),
    "ANY_REAL": frozenset(("real",)),
    "ANY_NUM": _NUMBERS,
    "ANY_MAGNITUDE": _NUMBERS | {"time"},
    "ANY_BIT": frozenset(("bool", "bits")),
    "ANY_STRING": frozenset(("string",)),
    "ANY_ENUM": frozenset(("enum",)),
    "ANY_ELEMENTARY": _NUMBERS | _TEMPORAL | {"bool", "bits", "string"},
    "ANY_SCALAR": _NUMBERS | _TEMPORAL | {"bool", "bits", "string", "enum"},
    "ANY": _NUMBERS | _TEMPORAL | {"bool", "bits", "string", "enum", "aggregate"},
}
WORDS = {
    "ANY_INT": "an integer", "ANY_REAL": "a REAL or LREAL", "ANY_NUM": "a number",
    "ANY_ENUM": "an enumeration", "ANY_MAGNITUDE": "a number or a TIME", "ANY_BIT": "a BOOL or a bit string",
    "ANY_STRING": "a string",
    "ANY_ELEMENTARY": "a value of an elementary type", "ANY_SCALAR": "a single value", "ANY": "a value",
}

# From small to wide: the first one that every type widens to is the common type.
_ORDER = (USINT, SINT, UINT, INT, UDINT, DINT, ULINT, LINT, REAL, LREAL, BYTE, WORD, DWORD, LWORD)
_WIDER: dict[str, frozenset[str]] = {
    source: frozenset(targets.split()) for source, targets in {
        "SINT": "INT DINT LINT REAL LREAL", "INT": "DINT LINT REAL LREAL", "DINT": "LINT LREAL",
        "USINT": "UINT UDINT ULINT INT DINT LINT REAL LREAL", "UINT": "UDINT ULINT DINT LINT REAL LREAL",
        "UDINT": "ULINT LINT LREAL", "REAL": "LREAL",
        "BYTE": "WORD DWORD LWORD", "WORD": "DWORD LWORD", "DWORD": "LWORD",
    }.items()
}
_SHORT = {"TIME_OF_DAY": "TOD", "DATE_AND_TIME": "DT"}


def kind(type_: Type) -> str:
    """The kind of a type: that of ``Elementary``, or string, enum, aggregate."""
    match type_:
        case Elementary():
            return type_.kind
        case String():
            return "string"
        case Subrange():
            return type_.base.kind
        case Enum():
            return "enum"
    return "aggregate"


def is_temporal(type_: Type) -> bool:
    """Whether the type is TIME, DATE, TIME_OF_DAY or DATE_AND_TIME."""
    return kind(type_) in _TEMPORAL


def widens(source: Type, target: Type) -> bool:
    """Whether a value of ``source`` may stand where ``target`` is asked for, without a word.

    True for equal types, for strings of the same character size (cut when they are stored) and for
    widening without loss (3rd edition, figure 12); a subrange counts as its base. Never for BOOL to
    bits, LINT to LREAL, signed to unsigned, or an enumeration to anything else.
    """
    if source == target:
        return True
    if isinstance(source, Subrange):
        source = source.base
    if isinstance(target, Subrange):
        target = target.base
    if isinstance(source, Elementary) and isinstance(target, Elementary):
        return source == target or target.name in _WIDER.get(source.name, ())
    return isinstance(source, String) and isinstance(target, String) and source.name == target.name


def common(types: Iterable[Type]) -> Type | None:
    """The smallest type that all ``types`` widen to; of strings the longest; None when there is none."""
    found = [t.base if isinstance(t, Subrange) else t for t in types]
    first = found[0]
    if all(t == first for t in found):
        return first
    if all(isinstance(t, String) and t.name == first.name for t in found):
        return max(found, key=lambda t: t.length)
    return next((t for t in _ORDER if all(widens(f, t) for f in found)), None)


def short_name(type_: Type) -> str:
    """The name of a scalar type inside a function name: ``TOD`` ``DT`` ``STRING`` ``INT``."""
    name = storage(type_).name
    return _SHORT.get(name, name)


def conversion(source: Type, target: Type) -> str:
    """The function from ``source`` to ``target``: ``INT_TO_DINT``, ``ENUM_TO_INT``; MOVE when both are
    stored alike."""
    left, right = short_name(source), short_name(target)
    if isinstance(source, Enum) and not isinstance(target, Enum):
        left = "ENUM"
    return "MOVE" if left == right else f"{left}_TO_{right}"
