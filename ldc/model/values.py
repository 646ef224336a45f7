"""Literals and their types: what a value without a type becomes where a type is asked for.

A literal without a prefix, and arithmetic on such literals, has no type until its context gives it
one (DESIGN section 2); it is kept as ``Untyped`` and computed exactly until then.
"""

from __future__ import annotations

import struct

from ldc.diagnostics import Diagnostics
from ldc.expr import Apply, Const, Expr, Load, nodes
from ldc.library import functions
from ldc.model import type_findings as findings
from ldc.parser import ast
from ldc.records import record
from ldc.source import Span
from ldc.types import (
    BOOL,
    DINT,
    ELEMENTARY,
    INT,
    LINT,
    REAL,
    STRING,
    UDINT,
    UINT,
    ULINT,
    USINT,
    WSTRING,
    Elementary,
    Enum,
    Instance,
    Scalar,
    String,
    Subrange,
    Type,
    holds_blocks,
    storage,
)


@record
class Untyped:
    """A number whose context decides its type."""

    value: int | float
    span: Span


@record
class AnyEnum:
    """The name of a value that several enumerations have; the context decides which is meant."""

    name: str
    choices: tuple[tuple[Enum, int], ...]
    span: Span


@record
class NetValue:
    """What a net of the rung brings to a pin; None: its type is not known."""

    type: Type | None


Value = Const | Load | Apply | Untyped | AnyEnum


def single(value: float) -> float:
    """Rounded to the 32 bits of a REAL; OverflowError when it is too large."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def natural(value: int | float) -> Elementary:
    """The type that a number has when nothing decides: INT, or the least wider one that holds it; REAL."""
    if isinstance(value, float):
        return REAL
    for type_ in (INT, DINT, LINT):
        if type_.range[0] <= value <= type_.range[1]:
            return type_
    return ULINT


def fits(value: int | float, type_: Type) -> bool:
    """Whether an untyped number can become a value of the type without a conversion function."""
    base = storage(type_)
    if isinstance(type_, Enum) or not isinstance(base, Elementary):
        return False
    if base.kind == "real":
        return True
    if isinstance(value, float) or base.kind not in ("bool", "int", "uint", "bits"):
        return False
    low, high = (type_.low, type_.high) if isinstance(type_, Subrange) else base.range
    return low <= value <= high


def settle(
    value: Untyped | AnyEnum, type_: Type | None, diagnostics: Diagnostics, what: str = ""
) -> Const | None:
    """Give an undecided value the type that is asked for, or its natural one."""
    if type(value) is AnyEnum:
        return _settle_enum(value, type_, diagnostics)
    number, span = value.value, value.span
    if type_ is None:
        type_ = natural(number)
    base = storage(type_)
    if isinstance(type_, Enum) and isinstance(number, int) and fits(number, DINT):
        findings.enumerated(diagnostics, span, natural(number), type_)
        return Const(number, type_ if any(number == known for _, known in type_.values) else DINT, span)
    kind = base.kind if isinstance(base, Elementary) and not isinstance(type_, Enum) else ""
    if kind == "real":
        try:
            return Const(single(number) if base == REAL else float(number), base, span)
        except OverflowError:
            findings.does_not_fit(diagnostics, span, shown(number), base)
            return None
    if kind not in ("bool", "int", "uint", "bits") or isinstance(number, float):
        findings.mismatch(diagnostics, span, type_, natural(number), what)
        return None
    if not fits(number, type_):
        findings.does_not_fit(diagnostics, span, shown(number), type_)
        return None
    return Const(bool(number) if kind == "bool" else number, base, span)


def shown(number: int | float) -> str:
    """A number for a message: huge ones are cut."""
    text = str(number) if not isinstance(number, int) or abs(number) < 1 << 256 else "this number"
    return text


def _settle_enum(value: AnyEnum, type_: Type | None, diagnostics: Diagnostics) -> Const | None:
    for enum, number in value.choices:
        if enum == type_:
            return Const(number, enum, value.span)
    names = " and ".join(str(enum) for enum, _ in value.choices)
    findings.bad_enum_value(diagnostics, value.span, f"`{value.name}` is a value of {names}", "which one?",
                            f"write `{value.choices[0][0]}#{value.name}`")
    return None


def literal(node: ast.Literal, named: Type | None, diagnostics: Diagnostics) -> Value | None:
    """A literal; ``named`` is the type of the project that its prefix names, if it does."""
    value = node.value
    if node.type is None:
        if isinstance(value, bytes):
            return Const(value, STRING if len(value) <= 80 else String("STRING", len(value)), node.span)
        if isinstance(value, str):
            return Const(value, WSTRING if len(value) <= 80 else String("WSTRING", len(value)), node.span)
        if isinstance(value, bool):
            return Const(value, BOOL, node.span)
        return Untyped(value, node.span)
    type_ = named or ELEMENTARY.get(node.type)
    if type_ is None:
        findings.unknown_type_prefix(diagnostics, node.span, node.type)
        return None
    if isinstance(type_, String):
        return Const(value, type_ if len(value) <= 80 else String(type_.name, len(value)), node.span)
    if isinstance(type_, Elementary) and type_.kind in ("time", "date", "tod", "dt"):
        low, high = type_.range
        if not low <= value <= high:
            findings.does_not_fit(diagnostics, node.span, node.text, type_)
            return None
        return Const(value, type_, node.span)
    return settle(Untyped(value if isinstance(value, float) else int(value), node.span), type_, diagnostics)


def same(a: Type, b: Type) -> bool:
    """Whether values of the two types are interchangeable: a subrange counts as its base, the length
    of a string does not matter (what is too long is cut)."""
    if a is b or a == b:
        return True
    if isinstance(a, Subrange):
        a = a.base
    if isinstance(b, Subrange):
        b = b.base
    if isinstance(a, String) and isinstance(b, String):
        return a.name == b.name
    return a == b


def storable(source: Type, target: Type) -> bool:
    """Whether a value of ``source`` may be stored in a place of ``target``, converted if need be."""
    if same(source, target):
        return True
    if isinstance(source, Enum) or isinstance(target, Enum):
        return False
    left, right = storage(source), storage(target)
    return isinstance(left, Elementary) and isinstance(right, Elementary) and functions.widens(left, right)


def coerce(
    value: Value, wanted: Type | None, diagnostics: Diagnostics, span: Span, what: str = ""
) -> Expr | None:
    """The value in the type that is asked for, implicit widening made explicit; None after an error."""
    if type(value) is Untyped or type(value) is AnyEnum:
        return settle(value, wanted, diagnostics, what)
    got = value.type
    if got is wanted and type(got) is Elementary:
        return value
    if wanted is None or got is wanted or same(got, wanted):
        if isinstance(value, Const) and wanted is not None and not const_fits(value.value, wanted):
            findings.does_not_fit(diagnostics, span, "this constant", wanted)
            return None
        if holds_blocks(got):
            is_one = isinstance(got, Instance)
            findings.not_a_value(
                diagnostics, span, f"an instance of {got} is no value" if is_one
                else f"{findings.described(got)} holds function blocks and is not copied",
                "this is a function block" if is_one else "an instance stays where it is declared",
                "name one of its outputs, `instance.pin`; a VAR_IN_OUT takes the whole" if is_one else
                "copy the members that are values")
            return None
        return value
    if storable(got, wanted):
        return converted(value, storage(wanted), span)
    counted = as_number(value, wanted)
    if counted is not None:
        findings.counted(diagnostics, span, got, wanted)
        return counted
    counted = enumerated(value, wanted)
    if counted is not None:
        if not isinstance(wanted, Enum) or all(n.type != wanted for n in nodes(value)):  # told at `state + 1`
            findings.enumerated(diagnostics, span, got, wanted)
        return counted
    findings.mismatch(diagnostics, span, wanted, got, what)
    return None


def unsigned(type_: Type) -> Elementary | None:
    """The unsigned number of the size of a bit string; None for other types."""
    base = storage(type_)
    if not isinstance(base, Elementary) or base.kind != "bits":
        return None
    return {8: USINT, 16: UINT, 32: UDINT, 64: ULINT}[base.bits]


def as_number(value: Expr, wanted: Type) -> Expr | None:
    """A bit string as the unsigned number that it is in other editors, where the number fits; or the other
    way round. None when it does not fit, or when neither is a bit string."""
    if isinstance(value.type, Enum) or isinstance(wanted, Enum):
        return None
    source, target = storage(value.type), storage(wanted)
    here, there = unsigned(source), unsigned(target)
    if (here is None) == (there is None) or not isinstance(target, Elementary):
        return None
    if here is not None:
        if target.kind not in ("int", "uint") or target is not here and not functions.widens(here, target):
            return None
        made = type(value) is Apply and value.op == functions.conversion(here, source)  # of such a number
        number = value.args[0] if made else converted(value, here)
        return converted(number, target, value.span)
    if not isinstance(source, Elementary) or source.kind != "uint":
        return None
    if source is not there and not functions.widens(source, there):
        return None
    return converted(converted(value, there), target, value.span)


def counting(type_: Enum) -> Elementary:
    """The number that a value of an enumeration counts as where the context does not tell: the type that is
    written behind the values, INT, or DINT when INT does not hold them all."""
    if type_.base is not None:
        return unsigned(type_.base) or type_.base
    least, greatest = INT.range
    return INT if all(least <= number <= greatest for _, number in type_.values) else DINT


def enumerated(value: Expr, wanted: Type) -> Expr | None:
    """A value of an enumeration as a number that holds all its values; or a number as a value of one, which
    is stored as DINT. None when it does not fit, or when neither or both are enumerations."""
    source, target = value.type, storage(wanted)
    if isinstance(wanted, Enum) == isinstance(source, Enum):
        return None
    if isinstance(wanted, Enum):
        base = storage(source)
        if not isinstance(base, Elementary) or base.kind not in ("int", "uint", "bits"):
            return None
        if base is DINT or functions.widens(base, DINT):
            return converted(value, DINT)
        return as_number(value, DINT)
    if not isinstance(target, Elementary) or target.kind not in ("int", "uint", "bits"):
        return None
    least, greatest = (wanted.low, wanted.high) if isinstance(wanted, Subrange) else target.range
    numbers = (value.value,) if isinstance(value, Const) else tuple(number for _, number in source.values)
    if not all(least <= number <= greatest for number in numbers):
        return None
    through = unsigned(target) or target
    return converted(converted(value, through), target, value.span)


def as_index(value: Expr) -> Expr | None:
    """A value of an enumeration or a bit string as the number that counts elements; None of others."""
    if isinstance(value.type, Enum):
        return converted(value, counting(value.type))
    own = unsigned(value.type)
    return None if own is None else as_number(value, own)


def const_fits(value: Scalar, type_: Type) -> bool:
    """Whether a constant of the right kind keeps the limits that its target declares."""
    if isinstance(type_, Subrange):
        return type_.low <= value <= type_.high
    return not isinstance(type_, String) or len(value) <= type_.length


def converted(value: Expr, target: Elementary, span: Span | None = None) -> Expr:
    """The value as one of ``target``: by a function where it is another type, which of a constant is computed
    here. An enumeration converts by its name, a subrange counts as its base."""
    source = value.type if isinstance(value.type, Enum) else storage(value.type)
    if source == target:
        return value
    name, span = functions.conversion(source, target), span or value.span
    if isinstance(value, Const):
        return Const(functions.meaning(name, (source,), target)(value.value), target, span)
    return Apply(name, (value,), target, span)
