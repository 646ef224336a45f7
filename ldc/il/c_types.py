"""What an IEC type is in C, the same in headers, generated code and bindings (docs/components.md)."""

from __future__ import annotations

from functools import cache

from ldc.il.program import Unit
from ldc.symbols import Variable
from ldc.types import BOOL, Array, Elementary, Enum, String, Subrange, Type, storage

_DATES = ("date", "tod", "dt")

# What C and C++ reserve and IEC 61131-3 does not.
_RESERVED = frozenset(
    """
    alignas alignof and and_eq asm auto bitand bitor bool break case catch char class compl const constexpr
    const_cast continue decltype default delete do double dynamic_cast else enum explicit export extern false
    float for friend goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or
    or_eq private protected public register reinterpret_cast restrict return short signed sizeof static
    static_assert
    static_cast struct switch template this thread_local throw true try typedef typeid typename union unsigned
    using virtual void volatile wchar_t while xor xor_eq
""".split()
)


@cache
def c_type(type_: Type) -> str:
    """The C type that generated code computes a scalar with, which is no string."""
    kind: Elementary = storage(type_)
    if kind.kind == "real":
        return "float" if kind.bits == 32 else "double"
    sign = "" if kind.kind in ("int", "time") else "u"
    return f"{sign}int{max(kind.bits, 8)}_t"


def scalar(type_: Type) -> str | None:
    """The C type that an author knows one value by (TIME: nanoseconds), None when C has none for it here."""
    if not isinstance(type_, Enum | Subrange | Elementary) or storage(type_).kind in _DATES:
        return None
    return "bool" if storage(type_) == BOOL else c_type(type_)


def dimensions(type_: Type, flat: bool = False) -> list[int]:
    """How many elements each dimension of an array has in C, where every one begins at 0; none: no array.
    ``flat``: those of one ARRAY as one, the same bytes."""
    counts = []
    while isinstance(type_, Array):
        counts += [type_.count] if flat else [high - low + 1 for low, high in type_.bounds]
        type_ = type_.element
    return counts


def field(name: str, type_: Type, flat: bool = False) -> str | None:
    """The declaration of a member: ``float speed``, ``int16_t values[10]``, a string as
    ``struct { uint16_t length; char text[80]; } name``. None when the type cannot be a pin of C.
    ``flat``: as of `dimensions`."""
    sizes = "".join(f"[{count}]" for count in dimensions(type_, flat))
    while isinstance(type_, Array):
        type_ = type_.element
    if isinstance(type_, String):
        if type_.name != "STRING":
            return None
        return f"struct {{ uint16_t length; char text[{type_.length}]; }} {member(name)}{sizes}"
    plain = scalar(type_)
    return None if plain is None else f"{plain} {member(name)}{sizes}"


def member(name: str) -> str:
    """The name of a pin as a member in C."""
    return f"{name}_" if name in _RESERVED else name


def members(unit: Unit) -> dict[str, tuple[Variable, ...]]:
    """What the structures ``in``, ``out`` and ``state`` of a unit with native code hold (``External``). The
    power output is not among them when the IL around the native code makes it."""
    made = {i.operand.root.upper() for r in unit.rungs if r.key == "power" for i in r.code if i.op == "ST"}
    return {
        "in": tuple(v for v in unit.variables if v.kind == "input"),
        "out": tuple(v for v in unit.variables if v.kind == "output" and v.name.upper() not in made),
        "state": tuple(v for v in unit.variables if v.kind == "local"),
    }


def structure(name: str, variables: tuple[Variable, ...], flat: bool = False) -> str:
    """The members of one of these structures, as C declares it; ``flat``: as of `dimensions`. Raises
    ValueError for a type without C."""
    lines = []
    for v in variables:
        declared = field(v.name, v.type, flat)
        if declared is None:
            raise ValueError(f"{v.name}: {v.type} has no C type")
        lines.append(f"    {declared};")
    return "\n".join(["typedef struct {", *(lines or ["    uint8_t unused;"]), f"}} {name};"])
