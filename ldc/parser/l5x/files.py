"""Arrays: COP CPS FLL, first and last in first out, bits shifted through an array."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser.l5x import types
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.types import BOOL, DINT, LREAL, REAL, WIDTHS, Array, Type, is_integer, is_real
from ldc.parser.l5x.values import Value, convert, literal
from ldc.source import Span

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer

_COPY = "it copies between places of one type here"


def _array(value: Value) -> tuple[Value, ast.Expr, Array] | None:
    """The array in which a file begins, and at which index; None: it is no element of one."""
    if isinstance(value.type, Array) and len(value.type.sizes) == 1:
        return value, literal(0, value.span).expr, value.type
    if value.array is not None and isinstance(value.array.type, Array):
        return value.array, value.at, value.array.type
    return None


def _element(w: Writer, value: Value) -> Value:
    """The first element of a file."""
    found = _array(value)
    if found is None or value.array is not None:
        return value
    expr = ast.Index(value.expr, (found[1],), value.span)
    return Value(expr, found[2].element, value.span, place=True)


def _copy(w: Writer, i: Instruction) -> list[ast.Item]:
    source, target, length = w.place(i.operands[0]), w.place(i.operands[1]), w.read(i.operands[2])
    if source is None or target is None or length is None:
        return []
    first, last = _element(w, source), _element(w, target)
    if first.type is None or last.type is None:
        return [w.store(last, first, i.span)]
    if first.type != last.type and all(is_real(t) or is_integer(t) for t in (first.type, last.type)):
        return _recast(w, i, source, target, length)
    if first.type != last.type or first.type == BOOL:
        what = "BOOL arrays" if first.type == BOOL else "another type"
        w.reading.unsupported(i.span, f"{i.name} of {what}", f"{_COPY}: use MOV, or copy members one by one")
        return []
    a, b = _array(source), _array(target)
    if length.number == 1 or length.number is not None and b is None:
        return [w.store(last, first, i.span)]
    if a is None or b is None:
        w.reading.unsupported(i.span, f"{i.name} from or to what is no array",
                              f"{_COPY}: give it a length of 1")
        return []
    numbers = [("first", a[1]), ("into", b[1]), ("length", convert(length, DINT))]
    if a[0].span.text.upper() == b[0].span.text.upper():
        name = w.support.use("logix_move", T=_text(b[2].element), N=str(b[2].sizes[0]),
                             ARRAY=types.text(b[2]), COUNT=str(b[2].sizes[0]))
        return [w.block(name, i.span, [*numbers, ("cells", b[0].expr)])]
    name = w.support.use("logix_copy", T=_text(b[2].element), N=f"{a[2].sizes[0]}_{b[2].sizes[0]}",
                         SOURCE=types.text(a[2]), DEST=types.text(b[2]), COUNT=str(b[2].sizes[0]))
    return [w.block(name, i.span, [*numbers, ("source", a[0].expr), ("dest", b[0].expr)])]


def _recast(w: Writer, i: Instruction, source: Value, target: Value, length: Value) -> list[ast.Item]:
    """Numbers of one type to places of another, byte by byte."""
    gaps: dict[str, str] = {}
    pins: list[tuple[str, ast.Expr]] = []
    sides = ((source, "source", "here", "first"), (target, "dest", "there", "into"))
    for value, side, index, number in sides:
        found = _array(value)
        type_ = found[2].element if found is not None else value.type
        place = f"{side}[{index}]" if found is not None else side
        width = 64 if type_ == LREAL else 32 if type_ == REAL else WIDTHS[type_.name]
        string = {8: "BYTE", 16: "WORD", 32: "DWORD", 64: "LWORD"}[width]
        bits = f"{type_.name}_TO_{string}({place})"
        key = side.upper()
        gaps[key] = types.text(found[2] if found is not None else type_)
        gaps[f"{key}_BYTES"] = str(width // 8)
        gaps[f"{key}_BITS"] = bits if width == 64 else f"{string}_TO_LWORD({bits})"
        gaps["SOURCE_COUNT" if side == "source" else "COUNT"] = str(found[2].sizes[0] if found else 1)
        if side == "dest":
            whole = "whole" if width == 64 else f"LWORD_TO_{string}(whole)"
            gaps |= {"PLACE": place, "DEST_VALUE": f"{string}_TO_{type_.name}({whole})"}
        pins.append((number, found[1] if found is not None else literal(0, i.span).expr))
        pins.append((side, found[0].expr if found is not None else value.expr))
    name = w.support.use("logix_recast", T=f"{gaps['SOURCE']} to {gaps['DEST']}", **gaps)
    return [w.block(name, i.span, [*pins, ("length", convert(length, DINT))])]


def _text(type_: Type | None) -> str:
    return types.text(type_) if type_ is not None else "DINT"


def _fill(w: Writer, i: Instruction) -> list[ast.Item]:
    source, target, length = w.read(i.operands[0]), w.place(i.operands[1]), w.read(i.operands[2])
    if source is None or target is None or length is None:
        return []
    found = _array(target)
    element = found[2].element if found is not None else target.type
    if isinstance(element, types.Structure) and source.number == 0:
        return _clear(w, i, target, found, element, length)
    if found is None or length.number == 1:
        return [w.store(_element(w, target), source, i.span)]
    array, at, type_ = found
    name = w.support.use("logix_fill", T=_text(type_.element), N=str(type_.sizes[0]), ARRAY=types.text(type_),
                         COUNT=str(type_.sizes[0]))
    pins = [("value", convert(source, type_.element)), ("into", at), ("length", convert(length, DINT)),
            ("cells", array.expr)]
    return [w.block(name, i.span, pins)]


def _clear(w: Writer, i: Instruction, target: Value, found: tuple[Value, ast.Expr, Array] | None,
           element: types.Structure, length: Value) -> list[ast.Item]:
    """FLL of structures with zeros."""
    if found is None:
        return [w.block(w.support.use("logix_clear_one", T=element.name), i.span, [("place", target.expr)])]
    array, at, type_ = found
    name = w.support.use("logix_clear", T=element.name, N=str(type_.sizes[0]), ARRAY=types.text(type_),
                         COUNT=str(type_.sizes[0]))
    return [w.block(name, i.span, [("into", at), ("length", convert(length, DINT)), ("cells", array.expr)])]


def control_of(w: Writer, i: Instruction, at: int) -> tuple[Value, str] | None:
    """The CONTROL operand with its length and position behind it, which are values at the start."""
    found = w.structure(i.operands[at], "CONTROL")
    if found is None:
        return None
    for text, member in zip(i.operands[at + 1 : at + 3], ("LEN", "POS"), strict=False):
        number = None if text.text == "?" else w.read(text)
        if number is not None and isinstance(number.number, int):
            w.start(found[0], (member,), number.number)
        elif text.text != "?":
            w.reading.malformed(text, f"the {member} of {i.name} is no whole number", help="write `?` here")
            return None
    return found[0], found[1].name


def whole_array(
    w: Writer, text: Span, name: str, element: Type | None = None,
) -> tuple[Value, ast.Expr, Array] | None:
    """The array that an operand names, or in which it is an element: with the index and the type."""
    value = w.place(text)
    found = None if value is None else _array(value)
    if value is not None and (found is None or element is not None and found[2].element != element):
        w.reading.malformed(text, f"{name} needs {'an array of DINT' if element else 'an array'} here",
                            help="name an array or its first element")
        return None
    return found


def _load(w: Writer, i: Instruction) -> list[ast.Item]:
    source, found = w.read(i.operands[0]), whole_array(w, i.operands[1], i.name)
    control = control_of(w, i, 2)
    if source is None or found is None or control is None:
        return []
    w.start(control[0], ("EN",), True)
    array, at, type_ = found
    name = w.support.use("logix_load", T=_text(type_.element), N=str(type_.sizes[0]), ARRAY=types.text(type_),
                         CONTROL=control[1])
    pins = [("value", convert(source, type_.element)), ("into", at), ("cells", array.expr),
            ("control", control[0].expr)]
    return [w.block(name, i.span, pins, "power", "OUT")]


def _unload(w: Writer, i: Instruction) -> list[ast.Item]:
    """What is taken out goes to the destination where the controller says so: under power, at its rise."""
    found, target = whole_array(w, i.operands[0], i.name), w.place(i.operands[1])
    control = control_of(w, i, 2)
    if target is None or found is None or control is None:
        return []
    w.start(control[0], ("EU",), True)
    array, at, type_ = found
    element = type_.element
    if element is None:
        return []
    template = "logix_unload_first" if i.name == "FFU" else "logix_unload_last"
    name = w.support.use(template, T=_text(element), N=str(type_.sizes[0]), ARRAY=types.text(type_),
                         CONTROL=control[1])
    taken = w.local(f"{i.name.lower()}_taken", types.written(element, i.span), i.span)
    fresh = w.local(f"{i.name.lower()}_done", types.written(BOOL, i.span), i.span)
    block = w.block(name, i.span, [("into", at), ("cells", array.expr), ("control", control[0].expr)],
                    "power", "OUT",
                    [("taken", ast.Name(taken, i.span)), ("done", ast.Name(fresh, i.span))])
    store = w.store(target, Value(ast.Name(taken, i.span), element, i.span), i.span)
    levels = ([block], [ast.Contact("", ast.Name(fresh, i.span), i.span), store, w.always(False, i.span)])
    return [ast.Branches(tuple(ast.Path(tuple(items), i.span) for items in levels), i.span)]


def _shift(w: Writer, i: Instruction) -> list[ast.Item]:
    found, bit = whole_array(w, i.operands[0], i.name, DINT), w.read(i.operands[2], hint=BOOL)
    control = w.structure(i.operands[1], "CONTROL")
    if found is None or control is None or bit is None:
        return []
    if i.operands[3].text != "?":
        length = w.read(i.operands[3])
        if length is None or not isinstance(length.number, int):
            w.reading.malformed(i.operands[3], f"the length of {i.name} is no whole number",
                                help="write `?` here")
            return []
        w.start(control[0], ("LEN",), length.number)
    w.start(control[0], ("EN",), True)
    array, at, type_ = found
    name = w.support.use("logix_shift_left" if i.name == "BSL" else "logix_shift_right",
                         N=str(type_.sizes[0]),
                         ARRAY=types.text(type_), CONTROL=control[1].name)
    pins = [("bit", bit.expr), ("into", at), ("cells", array.expr), ("control", control[0].expr)]
    return [w.block(name, i.span, pins, "power", "OUT")]


TABLE = {
    "COP": (3, 3, _copy), "CPS": (3, 3, _copy), "FLL": (3, 3, _fill),
    "FFL": (3, 5, _load), "LFL": (3, 5, _load), "FFU": (3, 5, _unload), "LFU": (3, 5, _unload),
    "BSL": (4, 4, _shift), "BSR": (4, 4, _shift),
}
