"""What operators and functions of the library are in C (docs/semantics.md has their meaning).

``scalar`` gives an expression; ``text`` gives calls that write a string into a buffer. Every row of
``ldc.library`` is here; ``tests/test_native_functions.py`` compares all of them with their meaning.
"""

from __future__ import annotations

from itertools import pairwise

from ldc.backends.c.ctypes import is_string, suffix, width
from ldc.il.c_types import c_type
from ldc.library.time import ALIASES
from ldc.types import LREAL, REAL, Elementary, String, Type, storage

_SIGNS = {"AND": "&", "OR": "|", "XOR": "^", "ADD": "+", "SUB": "-", "MUL": "*"}
_LOGIC = ("AND", "OR", "XOR")
_COMPARE = {"GT": ">", "GE": ">=", "EQ": "==", "NE": "!=", "LE": "<=", "LT": "<"}
_MATH = ("SQRT", "LN", "LOG", "EXP", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN")
_INTEGERS = ("int", "uint", "bits", "bool")
_TIMED = {"ADD_TIME": "ADD", "ADD_TOD_TIME": "ADD", "ADD_DT_TIME": "ADD", "SUB_TIME": "SUB",
          "SUB_DATE_DATE": "SUB", "SUB_TOD_TIME": "SUB", "SUB_TOD_TOD": "SUB", "SUB_DT_TIME": "SUB",
          "SUB_DT_DT": "SUB", "MULTIME": "MUL", "DIVTIME": "DIV"}
DIVISIONS = ("DIV", "MOD", "DIVTIME")
# Strings among these are chosen by address; all other functions that give a string need a buffer.
CHOICES = ("SEL", "MUX", "MIN", "MAX", "LIMIT", "MOVE")

Args = list[tuple[str, Type]]


def scalar(op: str, args: Args, result: Type) -> str:
    """The C expression of a pure function; the divisor of a division was tested before."""
    if op in _LOGIC and len(args) == 2:
        return f"({args[0][0]} {_SIGNS[op]} {args[1][0]})"
    op = ALIASES.get(op, op)
    op = _TIMED.get(op, op)
    texts = [text for text, _ in args]
    first = args[0][1]
    if op in _COMPARE:
        return _compared(op, args)
    if op == "NOT":
        return f"!{texts[0]}" if storage(first).kind == "bool" else cast(f"~{texts[0]}", result)
    if op in CHOICES:
        return _chosen(op, args)
    if op in _SIGNS or op in DIVISIONS or op in ("NEG", "ABS"):
        return _folded(op, args, result)
    if op in _MATH:
        return cast(f"ldc_{op.lower()}({texts[0]})", result)
    if op == "EXPT":
        return cast(f"ldc_expt({texts[0]}, {texts[1]})", result)
    if op in ("SHL", "SHR", "ROL", "ROR"):
        bits = storage(first).bits
        return cast(f"ldc_{op.lower()}({texts[0]}, {_count(args[1], 'u')}, {bits})", result)
    if op == "LEN":
        return f"ldc_len({texts[0]})"
    if op == "FIND":
        return f"(int16_t)ldc_find({texts[0]}, {texts[1]}, {width(first)})"
    if op == "CONCAT_DATE_TOD":
        return f"((uint64_t){texts[0]} * LDC_DAY + {texts[1]})"
    if "_TRUNC_" in op or op == "TRUNC":
        return _from_real(texts[0], storage(result), "trunc")
    if "BCD" in op:
        bits = storage(first if "_BCD_TO_" in op else result).bits
        return cast(f"ldc_{'from' if '_BCD_TO_' in op else 'to'}_bcd({texts[0]}, {bits // 4})", result)
    if "TO_" in op:
        return converted(texts[0], storage(first), storage(result))
    raise KeyError(op)


def cast(text: str, type_: Type) -> str:
    """The expression brought to the width of its type."""
    return f"(({c_type(type_)})({text}))"


def _compared(op: str, args: Args) -> str:
    def one(left: str, right: str) -> str:
        if is_string(args[0][1]):
            return f"(ldc_compare({left}, {right}, {width(args[0][1])}) {_COMPARE[op]} 0)"
        return f"({left} {_COMPARE[op]} {right})"

    pairs = [one(a, b) for (a, _), (b, _) in pairwise(args)]
    return pairs[0] if len(pairs) == 1 else f"({' & '.join(pairs)})"


def _chosen(op: str, args: Args) -> str:
    texts = [text for text, _ in args]
    if op == "MOVE":
        return texts[0]
    if op == "SEL":
        return f"({texts[0]} ? {texts[2]} : {texts[1]})"
    if op == "MUX":
        made = texts[-1]
        for number in range(len(texts) - 2, 0, -1):
            test = f"{texts[0]} <= {number - 1}"
            made = f"({test} ? {texts[number]} : {made})"
        return made
    if op == "LIMIT":
        low, value, high = args
        inner = _better(">", value, low), value[1]
        return _better("<", inner, high)
    made = args[0]
    for other in args[1:]:
        made = _better(">" if op == "MAX" else "<", made, other), made[1]
    return made[0]


def _better(sign: str, kept: tuple[str, Type], other: tuple[str, Type]) -> str:
    """``other`` when it is greater (less), else ``kept``: so a NaN changes nothing."""
    type_ = kept[1]
    if is_string(type_):
        name = "ldc_greater" if sign == ">" else "ldc_less"
        return f"{name}({kept[0]}, {other[0]}, {width(type_)})"
    name = "max" if sign == ">" else "min"
    return f"ldc_{name}_{suffix(type_)}({kept[0]}, {other[0]})"


def _folded(op: str, args: Args, result: Type) -> str:
    if op in ("NEG", "ABS"):
        return _alone(op, args[0], result)
    made = args[0]
    for other in args[1:]:
        made = _pair(op, made, other, result), result
    return made[0]


def _alone(op: str, arg: tuple[str, Type], result: Type) -> str:
    text, kind = arg[0], storage(arg[1])
    if kind.kind == "real":
        return f"(-{text})" if op == "NEG" else f"__builtin_fabs{'f' if kind.bits == 32 else ''}({text})"
    if op == "ABS" and kind.kind == "uint":
        return text
    return cast(f"0 - {text}", result) if op == "NEG" else f"ldc_abs_{suffix(kind)}({text})"


def _pair(op: str, left: tuple[str, Type], right: tuple[str, Type], result: Type) -> str:
    (a, a_type), (b, b_type), out = left, right, storage(result)
    a_kind, b_kind = storage(a_type), storage(b_type)
    if op in _LOGIC:
        return f"({a} {_SIGNS[op]} {b})"
    if out.kind == "time" and b_kind.kind == "real":
        return f"ldc_to_i64((double){a} {'*' if op == 'MUL' else '/'} {b}, INT64_MIN, INT64_MAX)"
    if out.kind == "time" and op == "DIV" and suffix(b_kind) == "u64":
        return f"ldc_div_time_u64({a}, {b})"
    if op in DIVISIONS:
        if out.kind == "real":
            return cast(f"(double){a} / (double){b}", result)
        name = "mod" if op == "MOD" else "div"
        return f"ldc_{name}_{suffix(out)}({a}, {b})"
    sign = _SIGNS[op]
    if out.kind == "real":
        return cast(f"(double){a} {sign} (double){b}", result)
    if out.kind == "tod":
        return f"ldc_day((int64_t){a} {sign} {b} % LDC_DAY)"
    if a_kind.kind == "date":
        return f"(((int64_t){a} - (int64_t){b}) * LDC_DAY)"
    if out.kind in ("time", "dt"):
        return cast(f"(uint64_t){a} {sign} (uint64_t){b}", result)
    return cast(f"{a} {sign} {b}", result)


def _count(arg: tuple[str, Type], sign: str) -> str:
    """A count or position of any integer type: ``u``: not below 0, ``i``: not beyond what is signed."""
    text, unsigned = arg[0], storage(arg[1]).kind == "uint"
    if sign == "u":
        return f"(uint64_t){text}" if unsigned else f"ldc_count({text})"
    return f"ldc_signed({text})" if suffix(arg[1]) == "u64" else f"(int64_t){text}"


# ---- conversions


def converted(text: str, source: Type, target: Type) -> str:
    """A conversion between stored types, one of which may be a string that is read."""
    if is_string(source):
        return f"ldc_read_{_reader(target)}({text}, {width(source)}{_bounds(target)})"
    names = (source.name, target.name)
    if names in (("REAL", "DWORD"), ("DWORD", "REAL"), ("LREAL", "LWORD"), ("LWORD", "LREAL")):
        return f"ldc_bits_{suffix(source)}_{suffix(target)}({text})"
    if target.kind == "bool":
        return f"({text} != 0)"
    if source == target:
        return text
    return _number(text, source, target)


def _number(text: str, source: Elementary, target: Elementary) -> str:
    a, b = source.kind, target.kind
    special: dict[tuple[str, str], str] = {
        ("dt", "date"): f"((uint32_t)({text} / LDC_DAY))", ("dt", "tod"): f"({text} % LDC_DAY)",
        ("date", "dt"): f"((uint64_t){text} * LDC_DAY)", ("tod", "time"): f"((int64_t){text})",
        ("time", "tod"): f"ldc_day({text})"}
    if (a, b) in special:
        return special[a, b]
    if a == "real":
        if b == "real":
            return cast(text, target)
        return _from_real(f"(double){text} * 1e6" if b == "time" else text, target, "to")
    if b == "real":
        return cast(f"(double){text} / 1e6" if a == "time" else f"(double){text}", target)
    if a == "date":
        return cast(f"(uint64_t){text} * 86400u", target)
    if b == "date":
        return cast(f"ldc_floor_days({text})" if source.kind == "int" else f"{text} / 86400u", target)
    if a in ("time", "tod", "dt"):
        return cast(f"{text} / {'1000000000u' if a == 'dt' else '1000000'}", target)
    if b == "tod":
        day = f"(uint64_t){text} % 86400000u" if source.kind != "int" else f"ldc_day_ms({text})"
        return f"(({day}) * UINT64_C(1000000))"
    if b in ("time", "dt"):
        unit = 1_000_000 if b == "time" else 1_000_000_000
        return cast(f"(uint64_t){_wide(text, source)} * UINT64_C({unit})", target)
    return cast(text, target)


def _wide(text: str, source: Elementary) -> str:
    """An integer extended by its sign."""
    return f"(int64_t){text}" if source.kind == "int" else text


def _from_real(text: str, target: Elementary, how: str) -> str:
    """Rounded (``to``) or cut (``trunc``), within the range of the type."""
    low, high = target.range
    if not low:
        return cast(f"ldc_{how}_u64({text}, UINT64_C({high}))", target)
    least = "INT64_MIN" if target.bits == 64 else f"(-INT64_C({-low}))"
    return cast(f"ldc_{how}_i64({text}, {least}, INT64_C({high}))", target)


def _reader(target: Elementary) -> str:
    match target.kind:
        case "int" | "time":
            return "i64" if target.kind == "int" else "time"
        case "uint" | "bits":
            return "u64"
        case "real":
            return "real" if target == LREAL else "single"
    return target.kind


def _bounds(target: Elementary) -> str:
    low, high = target.range if target.kind != "real" else (0, 0)
    if target.kind == "int":
        return f", {'INT64_MIN' if target.bits == 64 else f'-INT64_C({-low})'}, INT64_C({high})"
    return f", UINT64_C({high})" if target.kind in ("uint", "bits") else ""


# ---- functions that give a string


def text(op: str, args: Args, result: String, into: str) -> list[str]:
    """Calls that write the result into the buffer ``into``, which none of the arguments lies in."""
    cap, size = result.length, width(result)
    names = [name for name, _ in args]
    if op == "CONCAT":
        return [f"ldc_put({into}, {cap}, {names[0]}, {size});"] + [
            f"ldc_append({into}, {cap}, {name}, {size});" for name in names[1:]]
    if op in ("LEFT", "RIGHT", "MID", "INSERT", "DELETE", "REPLACE"):
        given = [name if is_string(type_) else _count((name, type_), "i") for name, type_ in args]
        return [f"ldc_{op.lower()}({into}, {cap}, {', '.join(given)}, {size});"]
    if op in CHOICES:
        return [f"ldc_put({into}, {cap}, {_chosen(op, args)}, {size});"]
    source = storage(args[0][1])
    if is_string(source):
        return [f"ldc_{'widen' if size == 2 else 'narrow'}({into}, {cap}, {names[0]});"]
    return [f"ldc_print_{_printer(source)}({into}, {cap}, {size}, {names[0]});"]


def _printer(source: Elementary) -> str:
    kinds: dict[str, str] = {"bool": "bool", "bits": "bits", "time": "time", "date": "date", "tod": "tod",
                             "dt": "dt", "int": "i64", "uint": "u64"}
    return kinds.get(source.kind) or ("single" if source == REAL else "real")
