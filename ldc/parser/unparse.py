"""Canonical text of expressions, types and rungs: parsing it gives the same tree.

Parentheses only where precedence needs them, one space around operators, names and literals as written.
Rungs are printed without breaking lines (format.py does that).
"""

from __future__ import annotations

from ldc.parser import ast
from ldc.parser.literals import quoted
from ldc.parser.operators import PRECEDENCE, UNARY

_PRIMARY = UNARY + 1
INDENT = "    "


def expr_text(expr: ast.Expr) -> str:
    """An expression as ST."""
    match expr:
        case ast.Name(name):
            return name
        case ast.Literal(_, _, text):
            return text
        case ast.EnumLiteral(type_, name):
            return f"{type_}#{name}"
        case ast.Direct(address):
            return address
        case ast.Member() | ast.Index():
            return _reference(expr)
        case ast.Unary("NOT", operand):
            return f"NOT {_nested(operand, UNARY)}"
        case ast.Unary(op, operand):  # a sign before a number would become part of the literal
            text = _nested(operand, UNARY)
            bare = isinstance(operand, ast.Literal) and text[:1].isdigit() or text.startswith("-")
            return f"{op}({text})" if bare else op + text
        case ast.Binary():
            return _chain(expr)
        case ast.Call(name, arguments):
            return f"{name}({', '.join(map(argument_text, arguments))})"
    raise TypeError(f"no expression: {expr!r}")


def _rank(expr: ast.Expr) -> int:
    if isinstance(expr, ast.Binary):
        return PRECEDENCE[expr.op]
    return UNARY if isinstance(expr, ast.Unary) else _PRIMARY


def _nested(expr: ast.Expr, rank: int) -> str:
    """In parentheses when it binds looser than ``rank``."""
    return f"({expr_text(expr)})" if _rank(expr) < rank else expr_text(expr)


def _chain(expr: ast.Binary) -> str:
    """Iteratively along the left operands: a chain of operators is deep on its left."""
    parts: list[str] = []
    node: ast.Expr = expr
    opened = 0
    while isinstance(node, ast.Binary):
        rank = PRECEDENCE[node.op]
        parts += (_nested(node.right, rank + 1), f" {node.op} ")
        node = node.left
        if _rank(node) < rank:
            parts.append(")")
            opened += 1
    parts += (expr_text(node), "(" * opened)
    return "".join(reversed(parts))


def _reference(expr: ast.Expr) -> str:
    """``a.b[1].c``, iteratively."""
    steps: list[str] = []
    while True:
        match expr:
            case ast.Member(base, name):
                steps.append(f".{name}")
            case ast.Index(base, indexes):
                steps.append(f"[{', '.join(map(expr_text, indexes))}]")
            case _:
                return expr_text(expr) + "".join(reversed(steps))
        expr = base


def argument_text(argument: ast.Argument) -> str:
    if argument.name is None:
        return expr_text(argument.value)
    return f"{argument.name} {'=>' if argument.output else ':='} {expr_text(argument.value)}"


# ---- types and initial values


def bounds_text(array: ast.ArrayType) -> str:
    """What stands between the brackets: ``0..9, *``."""
    return ", ".join("*" if pair is None else "..".join(map(expr_text, pair)) for pair in array.bounds)


def type_text(type_: ast.TypeExpr, indent: str = "") -> str:
    """A type; a STRUCT goes over several lines, whose indent it is given."""
    match type_:
        case ast.NamedType(name, None):
            return name
        case ast.NamedType(name, length):
            return f"{name}[{expr_text(length)}]"
        case ast.ArrayType(element=element):
            return f"ARRAY [{bounds_text(type_)}] OF {type_text(element, indent)}"
        case ast.SubrangeType(base, low, high):
            return f"{base} ({expr_text(low)}..{expr_text(high)})"
        case ast.EnumType(values, base=base):
            listed = ", ".join(n if v is None else f"{n} := {expr_text(v)}" for n, v in values)
            return f"({listed})" if base is None else f"({listed}) {base}"
        case ast.StructType(fields):
            inner = indent + INDENT
            lines = "".join(f"{inner}{f.name} : {declared_text(f, inner)};\n" for f in fields)
            return f"STRUCT\n{lines}{indent}END_STRUCT"
    raise TypeError(f"no type: {type_!r}")


def declared_text(declared: ast.VarDecl | ast.TypeDecl, indent: str = "") -> str:
    """What stands behind the colon: type, edge and initial value."""
    text = type_text(declared.type, indent)
    if isinstance(declared, ast.VarDecl) and declared.edge is not None:
        text = f"{text} {declared.edge}"
    return text if declared.initial is None else f"{text} := {initial_text(declared.initial)}"


def initial_text(initial: ast.Initial) -> str:
    """An initial value: an expression, ``[1, 3(0)]`` or ``(a := 1)``."""
    if not isinstance(initial, ast.Aggregate):
        return expr_text(initial)
    if initial.fields:
        return f"({', '.join(f'{name} := {initial_text(value)}' for name, value in initial.fields)})"
    items = (initial_text(v) if n == 1 else f"{n}({initial_text(v)})" for n, v in initial.items)
    return f"[{', '.join(items)}]"


# ---- the ladder


def item_text(item: ast.Item) -> str:
    """An element, or branches, on one line."""
    if type(item) is ast.Contact and type(item.expr) is ast.Name:  # nearly all are
        return f"[{_modified(item.modifier)}{item.expr.name}]"
    match item:
        case ast.Contact(modifier, expr):
            return f"[{_modified(modifier)}{expr_text(expr)}]"
        case ast.Coil(modifier, target):
            return f"({_modified(modifier)}{expr_text(target)})"
        case ast.Junction(name):
            return f"@{name}"
        case ast.Jump(target):
            return f">>{target}"
        case ast.Branches(paths):
            return f"{{ {' | '.join(map(path_text, paths))} }}"
        case ast.Block(pins=pins):
            return f"{block_head(item)}{', '.join(map(pin_text, pins))}{block_tail(item)}"
    raise TypeError(f"no element: {item!r}")


def _modified(modifier: str) -> str:
    return modifier + " " if modifier.isalpha() else modifier


def block_head(block: ast.Block) -> str:
    instance = f"{expr_text(block.instance)}: " if block.instance is not None else ""
    return f"<{instance}{block.type}("


def block_tail(block: ast.Block) -> str:
    chosen = (("in", block.power_in), ("out", block.power_out))
    return ")" + "".join(f" {side}={pin}" for side, pin in chosen if pin is not None) + ">"


def pin_head(pin: ast.Pin) -> str:
    return "" if pin.name is None else f"{pin.name} {'=>' if pin.output else ':='} "


def pin_text(pin: ast.Pin) -> str:
    value = pin.value
    drawn = isinstance(value, ast.Branches | ast.Junction)
    return pin_head(pin) + (item_text(value) if drawn else expr_text(value))


def path_text(path: ast.Path) -> str:
    return " ".join(map(item_text, path.items))


def paths_text(rung: ast.Rung) -> str:
    """What is drawn, on one line: the identity of a rung without a name."""
    return "; ".join(map(path_text, rung.paths))


def rung_head(rung: ast.Rung) -> str:
    name = "" if rung.name is None else f" {rung.name}"
    return f"RUNG{name}" + ("" if rung.title is None else f" {quoted(rung.title)}")


def rung_text(rung: ast.Rung) -> str:
    """A rung in canonical text: its head, then a path on each line, however long."""
    return f"{rung_head(rung)}\n{body_text(rung)}"


def body_text(rung: ast.Rung) -> str:
    """The lines of a rung below its head."""
    return ";\n".join([INDENT + path_text(path) for path in rung.paths])
