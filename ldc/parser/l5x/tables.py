"""Sequencers and statistics of arrays: SQI SQO SQL, AVE STD SRT, SIZE."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser.l5x import arithmetic, types
from ldc.parser.l5x.files import control_of, whole_array
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.types import BOOL, LREAL, Array, is_integer, is_real
from ldc.parser.l5x.values import Value, as_bits, bits_of, from_bits, joined, literal

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer


def _position(w: Writer, i: Instruction, at: int, control: tuple[Value, str]) -> Value | None:
    """The element of an array at the position of a control structure."""
    found = whole_array(w, i.operands[at], i.name)
    if found is None:
        return None
    array, begin, type_ = found
    place = ast.Member(control[0].expr, "POS", i.span)
    if not isinstance(begin, ast.Literal) or begin.value:
        place = ast.Binary("+", begin, place, i.span)
    if not is_integer(type_.element) and i.name != "SQL":
        w.reading.malformed(i.operands[at], f"{i.name} needs an array of whole numbers here")
        return None
    return Value(ast.Index(array.expr, (place,), i.span), type_.element, i.span, place=True)


def _input(w: Writer, i: Instruction) -> list[ast.Item]:
    """SQI(array, mask, source, control): power while the masked source is the masked element."""
    mask, source, control = w.read(i.operands[1]), w.read(i.operands[2]), control_of(w, i, 3)
    element = _position(w, i, 0, control) if control is not None else None
    if None in (mask, source, element):
        return []
    left, right = (arithmetic.logic("AND", value, mask, i.span) for value in (element, source))
    return [w.contact(arithmetic.compare("=", left, right, i.span), i.span)]


def _output(w: Writer, i: Instruction) -> list[ast.Item]:
    """SQO(array, mask, destination, control): the element goes through the mask to the destination."""
    mask, target, control = w.read(i.operands[1]), w.place(i.operands[2]), control_of(w, i, 3)
    element = _position(w, i, 0, control) if control is not None else None
    if None in (mask, target, element):
        return []
    width = bits_of(element, mask, target)
    through = joined("AND", as_bits(element, width), as_bits(mask, width))
    kept = joined("AND", as_bits(target, width), ast.Unary("NOT", as_bits(mask, width), mask.span))
    w.start(control[0], ("EN",), True)
    step = w.block(w.support.use("logix_step", CONTROL=control[1]), i.span, [("control", control[0].expr)],
                   "power", "OUT")
    return [step, w.store(target, from_bits(joined("OR", through, kept), width), i.span)]


def _load(w: Writer, i: Instruction) -> list[ast.Item]:
    """SQL(array, source, control): the source goes to the element of the next position."""
    source, control = w.read(i.operands[1]), control_of(w, i, 2)
    element = _position(w, i, 0, control) if control is not None else None
    if source is None or element is None:
        return []
    w.start(control[0], ("EN",), True)
    fresh = ast.Name(w.local("stepped", types.written(BOOL, i.span), i.span), i.span)
    name = w.support.use("logix_step", CONTROL=control[1])
    step = w.block(name, i.span, [("control", control[0].expr)], "power", "OUT", [("stepped", fresh)])
    return [_beside(w, i, step, fresh, w.store(element, source, i.span))]


def _beside(w: Writer, i: Instruction, block: ast.Block, fresh: ast.Expr, store: ast.Item) -> ast.Branches:
    """The block, through which the power goes on, and a store where it tells that there is something new."""
    levels = ((block,), (ast.Contact("", fresh, i.span), store, w.always(False, i.span)))
    return ast.Branches(tuple(ast.Path(items, i.span) for items in levels), i.span)


def _statistics(w: Writer, i: Instruction) -> list[ast.Item]:
    """AVE and STD(array, dimension, destination, control)."""
    found, target = whole_array(w, i.operands[0], i.name), w.place(i.operands[2])
    control = control_of(w, i, 3)
    if found is None or target is None or control is None or not _numbers(w, i, found[2]):
        return []
    array, at, type_ = found
    result = "middle" if target.type == LREAL else f"LREAL_TO_{(target.type or LREAL).name}(middle)"
    if not (is_real(target.type) or is_integer(target.type)):
        w.reading.malformed(i.operands[2], f"{i.name} needs a number here")
        return []
    name = w.support.use("logix_average", T=type_.element.name, N=f"{target.type.name}_{type_.sizes[0]}",
                         R=target.type.name, RESULT=result, ARRAY=types.text(type_), CONTROL=control[1])
    made = w.local(f"{i.name.lower()}_made", types.written(target.type, i.span), i.span)
    fresh = w.local(f"{i.name.lower()}_done", types.written(BOOL, i.span), i.span)
    deviates = ast.Literal(i.name == "STD", "BOOL", "TRUE" if i.name == "STD" else "FALSE", i.span)
    pins = [("into", at), ("deviates", deviates), ("cells", array.expr), ("control", control[0].expr)]
    block = w.block(name, i.span, pins, "power", "OUT",
                    [("result", ast.Name(made, i.span)), ("done", ast.Name(fresh, i.span))])
    store = w.store(target, Value(ast.Name(made, i.span), target.type, i.span), i.span)
    return [_beside(w, i, block, ast.Name(fresh, i.span), store)]


def _numbers(w: Writer, i: Instruction, type_: Array) -> bool:
    if is_real(type_.element) or is_integer(type_.element):
        return True
    w.reading.malformed(i.operands[0], f"{i.name} needs an array of numbers here")
    return False


def _sort(w: Writer, i: Instruction) -> list[ast.Item]:
    found, control = whole_array(w, i.operands[0], i.name), control_of(w, i, 2)
    if found is None or control is None or not _numbers(w, i, found[2]):
        return []
    array, at, type_ = found
    name = w.support.use("logix_sort", T=type_.element.name, N=str(type_.sizes[0]), ARRAY=types.text(type_),
                         CONTROL=control[1])
    pins = [("into", at), ("cells", array.expr), ("control", control[0].expr)]
    return [w.block(name, i.span, pins, "power", "OUT")]


def _size(w: Writer, i: Instruction) -> list[ast.Item]:
    """SIZE(array, dimension, destination): known when the file is read."""
    value, dimension, target = w.place(i.operands[0]), w.read(i.operands[1]), w.place(i.operands[2])
    if value is None or dimension is None or target is None:
        return []
    array = value.whole_array or value
    if not isinstance(array.type, Array) or not (
            isinstance(dimension.number, int) and 0 <= dimension.number < len(array.type.sizes)):
        w.reading.malformed(i.operands[0], f"`{i.operands[0].text[:40]}` has no such dimension",
                            help="SIZE takes an array and the number of a dimension, the first is 0")
        return []
    return [w.store(target, literal(array.type.sizes[dimension.number], i.span), i.span)]


TABLE = {
    "SQI": (4, 6, _input), "SQO": (4, 6, _output), "SQL": (3, 5, _load),
    "AVE": (4, 6, _statistics), "STD": (4, 6, _statistics), "SRT": (3, 5, _sort), "SIZE": (3, 3, _size),
}
