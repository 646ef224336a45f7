"""How generated code spells constants and names types; the types themselves: `ldc/il/c_types.py`."""

from __future__ import annotations

import math

from ldc.expr import Const
from ldc.library.values import to_real
from ldc.types import String, Type, is_scalar, storage


def is_string(type_: Type) -> bool:
    """Whether values of the type are given by the address of their length and characters."""
    return isinstance(type_, String)


def by_address(type_: Type) -> bool:
    """Whether a value is given by its address: strings, arrays and structures."""
    return is_string(type_) or not is_scalar(type_)


def suffix(type_: Type) -> str:
    """What functions of the runtime for the type end in: ``i16``, ``u64``, ``f32``."""
    kind = storage(type_)
    if kind.kind == "real":
        return f"f{kind.bits}"
    sign = "i" if kind.kind in ("int", "time") else "u"
    return f"{sign}{max(kind.bits, 8)}"


def width(type_: Type) -> int:
    """Bytes of one character of a string type."""
    return 1 if type_.name == "STRING" else 2


def literal(const: Const) -> str:
    """A constant that is no string, as a C expression of the value and type."""
    kind, value = storage(const.type), const.value
    if kind.kind == "real":
        return _real(to_real(value) if kind.bits == 32 else float(value), kind.bits)
    value = int(value)
    if kind.bits < 32:
        return str(value) if value >= 0 else f"({value})"
    if kind.bits == 32:
        if kind.kind != "int":
            return f"{value}u"
        return "(-2147483647 - 1)" if value == -1 << 31 else str(value) if value >= 0 else f"({value})"
    if kind.kind not in ("int", "time"):
        return f"UINT64_C({value})"
    if value == -1 << 63:
        return "INT64_MIN"
    return f"INT64_C({value})" if value >= 0 else f"(-INT64_C({-value}))"


def _real(value: float, bits: int) -> str:
    end = "f" if bits == 32 else ""
    if math.isnan(value):
        return f"__builtin_nan{end}(\"\")"
    if math.isinf(value):
        text = f"__builtin_inf{end}()"
    else:
        text = abs(value).hex() + end
    return f"(-{text})" if math.copysign(1.0, value) < 0 else text


def string_bytes(const: Const) -> bytes:
    """A constant string as it lies in memory."""
    raw = const.value if isinstance(const.value, bytes) else const.value.encode("utf-16-le", "surrogatepass")
    return (len(raw) // width(const.type)).to_bytes(2, "little") + raw
