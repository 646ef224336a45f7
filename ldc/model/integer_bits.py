"""Bit operators on integers, as other editors have them (docs/st.md): their bits are a bit string."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.model.values import AnyEnum, NetValue, Untyped, Value, converted, settle, unsigned
from ldc.records import record
from ldc.types import (
    BYTE,
    DINT,
    DWORD,
    INT,
    LINT,
    LWORD,
    SINT,
    UDINT,
    UINT,
    ULINT,
    USINT,
    WORD,
    Elementary,
    Enum,
    Type,
    storage,
)

_SHIFTS = frozenset(("SHL", "SHR", "ROL", "ROR"))
OPERATORS = frozenset(("AND", "OR", "XOR", "NOT")) | _SHIFTS
_STRINGS = {8: BYTE, 16: WORD, 32: DWORD, 64: LWORD}
_NUMBERS = {(t.kind, t.bits): t for t in (SINT, INT, DINT, LINT, USINT, UINT, UDINT, ULINT)}


@record
class Taken:
    """``args`` with bit strings in place of integers; ``number``: the largest of their types, which the
    result gets, unless it is a bit string as one of them is (``mixed``); ``told``: an integer is no
    literal."""

    args: tuple[Value, ...]
    number: Elementary
    mixed: bool
    told: bool


def taken(name: str, args: tuple[Value, ...], hint: Type | None, diagnostics: Diagnostics) -> Taken | None:
    """The arguments of an operator with the bits of the integers among them, in the largest of their sizes.
    Literals alone are of the integer type that is asked for. None when there is no integer, or what has no
    bits.

    SHR of a number with a sign is left out: some editors shift in zeros, others the sign.
    """
    operands = args[:1] if name in _SHIFTS else args
    if any(type(a) in (AnyEnum, NetValue) or type(a) is Untyped and isinstance(a.value, float)
           for a in operands):
        return None
    known = [a.type for a in operands if type(a) is not Untyped]
    types = [storage(t) for t in known or (hint,)]
    numbers = [t for t in types if isinstance(t, Elementary) and t.kind in ("int", "uint")]
    strings = [t for t in types if unsigned(t) is not None]
    if not numbers or len(numbers) + len(strings) < len(types):
        return None
    if any(isinstance(t, Enum) for t in (*known, hint)):
        return None
    number = max(numbers, key=lambda t: t.bits)
    if name == "SHR" and number.kind == "int" and known:
        return None
    bits = max((_STRINGS[number.bits], *strings), key=lambda t: t.bits)
    made = []
    for arg in operands:
        if type(arg) is Untyped:
            arg = settle(arg, bits if arg.value >= 0 else _NUMBERS["int", bits.bits], diagnostics)
            if arg is None:
                return None
        if unsigned(arg.type) is None:
            arg = converted(arg, _NUMBERS[storage(arg.type).kind, bits.bits])
        made.append(converted(arg, bits))
    return Taken((*made, *args[len(operands):]), number, bool(strings), bool(known))
