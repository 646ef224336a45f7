"""Instructions of LDmicro that compute: numbers are signed and wrap at the width of where they go."""

from __future__ import annotations

from ldc.parser.ldmicro.context import Context, as_integer, as_string, bypass, converted
from ldc.parser.ldmicro.text import Leaf
from ldc.parser.ldmicro.variables import BITS, INT, STRINGS, Variable, number, wider

_MAX_TABLE = 1_000
_DIGITS = (0x3F, 0x06, 0x5B, 0x4F, 0x66, 0x6D, 0x7D, 0x07, 0x7F, 0x6F, 0x77, 0x7C, 0x39, 0x5E, 0x79, 0x71)
_SIGNS = {"-": 0x40, "_": 0x08, "=": 0x48} | {f"{n:X}": code for n, code in enumerate(_DIGITS)}
_SEGMENTS = (*_DIGITS, *(code | 0x80 for code in _DIGITS),
             *(_SIGNS.get(chr(n), 0) for n in range(32, 96)))
"""Segments of digits, digits with a dot, and the characters of ASCII that look like a digit or a line."""


def move(context: Context, leaf: Leaf) -> str:
    target = context.integer(leaf.args[0], leaf)
    type_ = context.operand_type(leaf.args[1], leaf) or target.type
    return context.move(context.operand(leaf.args[1], type_, leaf), type_, target)


def calculation(context: Context, leaf: Leaf) -> str:
    """Computed as wide as the widest of the three, then cut to the target."""
    target, type_, (a, b) = _operands(context, leaf)
    if type_ == target.type:
        return f"<{leaf.word}({a}, {b}, OUT => {target.name})>"
    wide = context.added(f"wide_{type_}", type_, leaf, "holds results that are cut")
    return f"<{leaf.word}({a}, {b}, OUT => {wide})> {context.move(wide, type_, target)}"


def negation(context: Context, leaf: Leaf) -> str:
    target, type_, (a,) = _operands(context, leaf)
    return context.move(f"0 - {a}" if type_ == target.type else f"({type_}#0 - {a})", type_, target)


def bitwise(context: Context, leaf: Leaf) -> str:
    target, type_, operands = _operands(context, leaf)
    strings = [_string(context, text, type_) for text in operands]
    value = f"NOT {strings[0]}" if leaf.word == "NOT" else f" {leaf.word} ".join(strings)
    return context.move(as_integer(value, type_), type_, target)


def shift(context: Context, leaf: Leaf) -> str:
    """SHL SR0 ROL ROR work on bits; SR0 and the rotations as wide as what is shifted."""
    target = context.integer(leaf.args[0], leaf)
    own = context.operand_type(leaf.args[1], leaf) or target.type
    type_ = wider(target.type, own) if leaf.word == "SHL" else own
    value = as_string(context.operand(leaf.args[1], type_, leaf), type_)
    name = "SHR" if leaf.word == "SR0" else leaf.word
    count = context.operand(leaf.args[2], INT, leaf)
    return context.move(as_integer(f"{name}({value}, {count})", type_), type_, target)


def shift_right(context: Context, leaf: Leaf) -> str:
    """SHR keeps the sign, which no function of the standard does."""
    target = context.integer(leaf.args[0], leaf)
    function = context.supporting("shr")
    value = context.operand(leaf.args[1], "DINT", leaf)
    count = context.operand(leaf.args[2], INT, leaf)
    return context.move(f"{function}({value}, {count})", "DINT", target)


def swap(context: Context, leaf: Leaf) -> str:
    target, type_, (a,) = _operands(context, leaf)
    if type_ != INT:
        context.reading.unsupported(leaf.span, "SWAP of other than two bytes", "use shifts and OR")
        return ""
    return context.move(as_integer(f"ROL({as_string(a, type_)}, 8)", type_), type_, target)


def decimal(context: Context, leaf: Leaf) -> str:
    """BIN2BCD and BCD2BIN: four bits for each decimal digit."""
    target = context.integer(leaf.args[0], leaf)
    value = context.operand(leaf.args[1], "DINT", leaf)
    text = (f"DWORD_TO_DINT(UDINT_TO_BCD_DWORD(DINT_TO_UDINT({value})))" if leaf.word == "BIN2BCD"
            else f"UDINT_TO_DINT(DWORD_BCD_TO_UDINT({_unsigned(context, leaf.args[1], leaf)}))")
    return context.move(text, "DINT", target)


def _unsigned(context: Context, text: str, leaf: Leaf) -> str:
    """An operand as DWORD, filled with zeros, as a pattern of bits is."""
    type_ = context.operand_type(text, leaf)
    if type_ is None:
        return f"DWORD#{(number(text) or 0) % (1 << 32)}"
    own = as_string(context.integer(text, leaf).name, type_)
    return own if type_ == "DINT" else f"{STRINGS[type_]}_TO_DWORD({own})"


def opposite(context: Context, leaf: Leaf) -> str:
    """The bits in the other order, as many as the source has."""
    target = context.integer(leaf.args[0], leaf)
    type_ = context.operand_type(leaf.args[1], leaf) or target.type
    function = context.supporting("opposite", type=type_, string=STRINGS[type_], width=BITS[type_])
    return context.move(f"{function}({context.operand(leaf.args[1], type_, leaf)})", type_, target)


def bus(context: Context, leaf: Leaf) -> str:
    """BUS target source b7 ... b0: bit n of the source goes to bit ``bn`` of the target."""
    target = context.integer(leaf.args[0], leaf)
    places = [number(text) for text in leaf.args[2:10]]
    if None in places or not all(0 <= place < BITS[target.type] for place in places):
        context.reading.malformed(leaf.span, f"BUS needs eight bits of {leaf.args[0][:40]}, 0 to "
                                             f"{BITS[target.type] - 1}")
        return ""
    source = _unsigned(context, leaf.args[1], leaf)
    parts = []
    for bit, place in zip(range(7, -1, -1), places, strict=True):
        one = f"({source} AND DWORD#{1 << bit})"
        name = "SHL" if place > bit else "SHR"
        parts.append(one if place == bit else f"{name}({one}, {abs(place - bit)})")
    return context.move(f"DWORD_TO_DINT({' OR '.join(parts)})", "DINT", target)


def segments(context: Context, leaf: Leaf) -> str:
    """7SEGMENTS target source C|A: the segments of a digit; bit 0 is segment a, bit 6 is g, bit 7 the dot."""
    target, common = context.integer(leaf.args[0], leaf), leaf.args[2].upper()
    if common not in ("A", "C"):
        context.reading.malformed(leaf.span, f"the common pin of a display is C or A, not `{common[:20]}`")
        return ""
    codes = [code if common == "C" else code ^ 0xFF for code in _SEGMENTS]
    table = context.added(f"segments_{common}", f"ARRAY [0..{len(codes) - 1}] OF INT", leaf,
                          "segments of the digits 0 to F, with a dot from 16 on; of the signs of ASCII",
                          f"[{', '.join(map(str, codes))}]", f"segments {common}")
    index = context.operand(leaf.args[1], "DINT", leaf)
    inside = f"[{index} >= 0] [{index} < {len(codes)}]"
    return bypass(f"{inside} {context.move(f'{table}[{index}]', INT, target)}")


def one_bit(context: Context, leaf: Leaf) -> str:
    target = context.integer(leaf.args[0], leaf)
    string = STRINGS[target.type]
    mask = f"SHL({string}#1, {context.operand(leaf.args[1], INT, leaf)})"
    change = f"OR {mask}" if leaf.word == "SET_BIT" else f"AND NOT {mask}"
    value = as_integer(f"{as_string(target.name, target.type)} {change}", target.type)
    return context.move(value, target.type, target)


def shift_register(context: Context, leaf: Leaf) -> str:
    stages = number(leaf.args[1])
    if stages is None or not 1 <= stages <= _MAX_TABLE:
        context.reading.malformed(leaf.span, f"a shift register of `{leaf.args[1][:20]}` stages")
        return ""
    cells = [context.integer(f"{leaf.args[0]}{index}", leaf) for index in range(stages)]
    moves = [context.move(a.name, a.type, b) for a, b in zip(cells, cells[1:], strict=False)]
    trigger = f"<{context.instance('R_TRIG', 'shift', leaf)}: R_TRIG()>"
    return bypass(" ".join((trigger, *reversed(moves))))


def look_up(context: Context, leaf: Leaf) -> str:
    """LOOK_UP_TABLE target index count as_string values... name: nothing happens outside of the table."""
    target, index = (context.integer(name, leaf) for name in leaf.args[:2])
    values = _values(context, leaf, 4, number(leaf.args[2]))
    if not values:
        return ""
    type_ = INT if all(-(1 << 15) <= value < 1 << 15 for value in values) else "DINT"
    wanted = leaf.args[4 + len(values)] if len(leaf.args) > 4 + len(values) else f"{target.name}_table"
    table = context.added(
        wanted, f"ARRAY [0..{len(values) - 1}] OF {type_}", leaf, "a look-up table",
        f"[{', '.join(map(str, values))}]", f"table {leaf.span.start}")
    inside = f"[{index.name} >= 0] [{index.name} <= {len(values) - 1}]"
    return bypass(f"{inside} {context.move(f'{table}[{index.name}]', type_, target)}")


def piecewise(context: Context, leaf: Leaf) -> str:
    """PIECEWISE_LINEAR target index count x0 y0 x1 y1 ...: left of the table its first line goes on,
    right of it the target keeps its value."""
    target, index = (context.integer(name, leaf) for name in leaf.args[:2])
    count = number(leaf.args[2]) or 0
    values = _values(context, leaf, 3, count * 2)
    points = list(zip(values[::2], values[1::2], strict=True))
    if len(points) < 2 or any(b[0] <= a[0] for a, b in zip(points, points[1:], strict=False)):
        context.reading.malformed(leaf.span, "a piecewise linear table needs two points with growing x")
        return ""
    type_ = wider(target.type, index.type)
    x = converted(index.name, index.type, type_)
    branches = []
    for number_, ((x0, y0), (x1, y1)) in enumerate(zip(points, points[1:], strict=False)):
        value = f"({x} - {_literal(x0)}) * {_literal(y1 - y0)} / {x1 - x0} + {_literal(y0)}"
        above = f"[{x} > {_literal(x0)}] " if number_ else ""
        branches.append(f"{above}[{x} <= {_literal(x1)}] {context.move(value, type_, target)}")
    return f"{{ {' | '.join(reversed(branches))} | [TRUE] }}"


def _literal(value: int) -> str:
    return f"({value})" if value < 0 else str(value)


def _values(context: Context, leaf: Leaf, start: int, count: int | None) -> list[int]:
    if count is None or not 0 < count <= _MAX_TABLE:
        context.reading.malformed(leaf.span, f"a table of `{leaf.args[2][:20]}` values")
        return []
    values = [number(text) for text in leaf.args[start : start + count]]
    if len(values) < count or None in values:
        context.reading.malformed(leaf.span, f"the table has not {count} numbers")
        return []
    return [(value + (1 << 31)) % (1 << 32) - (1 << 31) for value in values]


def _string(context: Context, text: str, type_: str) -> str:
    """An operand of ``_operands`` as a bit string."""
    value = number(text)
    if value is None:
        return as_string(text, type_)
    bits = {"SINT": 8, "INT": 16, "DINT": 32}[type_]
    return f"{STRINGS[type_]}#{value % (1 << bits)}"


def _operands(context: Context, leaf: Leaf) -> tuple[Variable, str, list[str]]:
    """The target, the type to compute in, and the operands in it."""
    target = context.integer(leaf.args[0], leaf)
    texts = leaf.args[1:2] if leaf.word in ("NOT", "NEG", "SWAP") else leaf.args[1:3]
    type_ = wider(target.type, *(t for text in texts if (t := context.operand_type(text, leaf))))
    return target, type_, [context.operand(text, type_, leaf) for text in texts]
