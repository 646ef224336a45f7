"""Typed expressions and elements as canonical text, for dumps and messages."""

from __future__ import annotations

from collections.abc import Callable

from ldc.expr import Const, Expr, FieldStep, IndexStep, Load, Place
from ldc.model.elements import Block, Coil, Contact, Element, Net
from ldc.types import BOOL, TIME

_INFIX = {"OR": ("OR", 1), "XOR": ("XOR", 2), "AND": ("AND", 3), "EQ": ("=", 4), "NE": ("<>", 4),
          "LT": ("<", 5), "GT": (">", 5), "LE": ("<=", 5), "GE": (">=", 5), "ADD": ("+", 6),
          "SUB": ("-", 6), "MUL": ("*", 7), "DIV": ("/", 7), "MOD": ("MOD", 7)}
_PREFIX = {"NOT": "NOT ", "NEG": "-"}
_TIGHT = 8
_CONTACT = {"open": "", "closed": "/", "rising": "P ", "falling": "N ", "expression": ""}
_COIL = {"normal": "", "negated": "/", "set": "S ", "reset": "R ", "rising": "P ", "falling": "N "}


def expression_text(expr: Expr) -> str:
    """IEC text with the fewest parentheses; conversions that the model added are shown."""
    # Chains of operators nest to the left as deep as they are long, so the left side is not recursed into.
    parts: list[str] = []
    stack: list[str | tuple[Expr, int]] = [(expr, 0)]
    while stack:
        node = stack.pop()
        if isinstance(node, str):
            parts.append(node)
            continue
        node, outside = node
        if isinstance(node, Const):
            parts.append(constant_text(node))
        elif isinstance(node, Load):
            parts.append(place_text(node.place))
        else:
            stack.extend(reversed(_pieces(node, outside)))
    return "".join(parts)


def _pieces(node: Expr, outside: int) -> list[str | tuple[Expr, int]]:
    pieces: list[str | tuple[Expr, int]] = []
    if node.op in _INFIX and len(node.args) > 1:
        word, level = _INFIX[node.op]
        for n, arg in enumerate(node.args):
            pieces += [f" {word} "] * bool(n) + [(arg, level + bool(n))]
        return ["(", *pieces, ")"] if level < outside else pieces
    if node.op in _PREFIX and len(node.args) == 1:
        return [_PREFIX[node.op], (node.args[0], _TIGHT)]
    for n, arg in enumerate(node.args):
        pieces += [", "] * bool(n) + [(arg, 0)]
    return [f"{node.op}(", *pieces, ")"]


def constant_text(const: Const) -> str:
    value, type_ = const.value, const.type
    if type_ == BOOL:
        return "TRUE" if value else "FALSE"
    if type_ == TIME:
        return f"T#{_time(value)}"
    if isinstance(value, bytes):
        return "'" + value.decode("latin-1").replace("$", "$$").replace("'", "$'") + "'"
    if isinstance(value, str):
        return '"' + value.replace("$", "$$").replace('"', '$"') + '"'
    return repr(value)


def _time(nanoseconds: int) -> str:
    for unit, size in (("s", 1_000_000_000), ("ms", 1_000_000), ("us", 1_000)):
        if nanoseconds % size == 0:
            return f"{nanoseconds // size}{unit}"
    return f"{nanoseconds}ns"


def place_text(place: Place) -> str:
    text = place.root
    for step in place.steps:
        if isinstance(step, FieldStep):
            text += f".{step.name}"
        elif isinstance(step, IndexStep):
            text += f"[{', '.join(map(expression_text, step.indexes))}]"
        else:
            text += f".{step.bit}"
    return text


def element_text(element: Element, net: Callable[[Net], str]) -> str:
    """The element as it is written in ``.ld``; ``net`` names the nets at pins."""
    if isinstance(element, Contact):
        return f"[{_CONTACT[element.kind]}{expression_text(element.expr)}]"
    if isinstance(element, Coil):
        return f"({_COIL[element.kind]}{place_text(element.place)})"
    if isinstance(element, Block):
        return _block(element, net)
    return f">>{element.label or 'RETURN'}"


def _block(block: Block, net: Callable[[Net], str]) -> str:
    pins = [f"{p.pin} := {net(p.source) if isinstance(p.source, int) else expression_text(p.source)}"
            for p in block.inputs]
    pins += [f"{p.pin} => {net(p.target) if isinstance(p.target, int) else place_text(p.target)}"
             for p in block.outputs]
    name = block.callee if block.instance is None else f"{place_text(block.instance)}: {block.callee}"
    power = f" in={block.power_in or '_'} out={block.power_out or '_'}"
    return f"<{name}({', '.join(pins)}){power}>"
