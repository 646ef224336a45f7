"""What C of a component may not do: keep data outside of its state, use a number as an address (SPEC 9.4)."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator

from pycparser import c_ast

from ldc.records import record

_MOST = 100
_BIG = 1 << 64
_ARITHMETIC = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "&": operator.and_,
    "|": operator.or_,
    "^": operator.xor,
    "<<": lambda left, right: left << min(max(right, 0), 64),
    ">>": lambda left, right: left >> min(max(right, 0), 64),
}
_SIGNS = {"-": operator.neg, "+": operator.pos, "~": operator.invert}
_LASTING = {"static", "_Thread_local"}


@record
class Site:
    """A node where it stands: ``role`` is the name that the node ``above`` calls it by; ``local``: inside of
    a function, a structure or a list of parameters."""

    node: c_ast.Node
    role: str = ""
    above: Site | None = None
    local: bool = False


def sites(tree: c_ast.Node) -> Iterator[Site]:
    """Every node of a tree, those above first."""
    todo = [Site(tree)]
    while todo:
        site = todo.pop()
        yield site
        inside = c_ast.FuncDef | c_ast.FuncDecl | c_ast.Struct | c_ast.Union
        local = site.local or isinstance(site.node, inside)
        todo += [Site(child, name, site, local) for name, child in site.node.children()]


def lasting(site: Site) -> bool:
    """Whether a node declares data that can change and that outlives a call."""
    node = site.node
    if not isinstance(node, c_ast.Decl) or node.name is None or isinstance(node.type, c_ast.FuncDecl):
        return False
    if _constant(node.type):
        return False
    outside = not site.local and ("extern" not in node.storage or node.init is not None)
    return outside or not _LASTING.isdisjoint(node.storage)


def _constant(type_: c_ast.Node) -> bool:
    """Whether nothing of a declared object can change."""
    while isinstance(type_, c_ast.ArrayDecl):
        type_ = type_.type
    return "const" in (getattr(type_, "quals", None) or [])


def pointers(tree: c_ast.FileAST) -> frozenset[str]:
    """Names of types that are pointers."""
    found: set[str] = set()
    for node in tree.ext:
        if isinstance(node, c_ast.Typedef) and _pointer(node.type, found):
            found.add(node.name)
    return frozenset(found)


def _pointer(type_: c_ast.Node, names: frozenset[str] | set[str]) -> bool:
    if isinstance(type_, c_ast.TypeDecl) and isinstance(type_.type, c_ast.IdentifierType):
        return type_.type.names[-1] in names
    return isinstance(type_, c_ast.PtrDecl)


def raw_address(node: c_ast.Node, names: frozenset[str]) -> c_ast.Node | None:
    """The first number of an expression, not 0, that a cast or a declaration makes a pointer of; ``names``:
    types that are some."""
    match node:
        case c_ast.Cast() if _pointer(node.to_type.type, names):
            value = node.expr
        case c_ast.Decl() if node.init is not None and _pointer(node.type, names):
            value = node.init
        case _:
            return None
    if not _number(value):
        return None
    while not isinstance(value, c_ast.Constant):
        value = value.left if isinstance(value, c_ast.BinaryOp) else value.expr
    return value


def _number(node: c_ast.Node) -> int | None:
    """The value of an expression that is made of few whole numbers alone."""
    parts = []
    for site in sites(node):
        if isinstance(site.node, c_ast.BinaryOp | c_ast.UnaryOp | c_ast.Cast | c_ast.Constant):
            parts.append(site.node)
        elif site.role != "to_type" and not isinstance(
            site.node, c_ast.Typename | c_ast.TypeDecl | c_ast.IdentifierType | c_ast.PtrDecl
        ):
            return None
        if len(parts) > _MOST:
            return None
    return _value(node)


def _value(node: c_ast.Node) -> int | None:
    match node:
        case c_ast.Constant() if "int" in node.type:
            digits = node.value.rstrip("uUlL")
            octal = len(digits) > 1 and digits[0] == "0" and digits.isdigit()
            return int(digits, 8 if octal else 0)
        case c_ast.Cast():
            return _value(node.expr)
        case c_ast.UnaryOp(op="-" | "+" | "~"):
            return _applied(_SIGNS[node.op], _value(node.expr))
        case c_ast.BinaryOp() if node.op in _ARITHMETIC:
            return _applied(_ARITHMETIC[node.op], _value(node.left), _value(node.right))
    return None


def _applied(operation: Callable[..., int], *values: int | None) -> int | None:
    known = [v for v in values if v is not None and abs(v) <= _BIG]
    return operation(*known) if len(known) == len(values) else None
