"""Walks over the AST that need no types: who is called and named. Loops only, chains may be long."""

from __future__ import annotations

from collections.abc import Iterator

from ldc.parser import ast

_LEAVES = (ast.Literal, ast.EnumLiteral, ast.Name, ast.Direct)


def calls_in(node: ast.Expr) -> Iterator[ast.Call]:
    """The calls inside an expression."""
    stack = [node]
    while stack:
        node = stack.pop()
        match node:
            case ast.Call():
                yield node
                stack.extend(a.value for a in node.arguments)
            case ast.Binary():
                stack += (node.left, node.right)
            case ast.Unary():
                stack.append(node.operand)
            case ast.Member():
                stack.append(node.base)
            case ast.Index():
                stack.append(node.base)
                stack.extend(node.indexes)


def elements_in(rung: ast.Rung) -> Iterator[ast.Contact | ast.Coil | ast.Block | ast.Jump]:
    """The elements of a rung, those at pins too, in no particular order."""
    stack: list = list(rung.paths)
    while stack:
        node = stack.pop()
        match node:
            case ast.Path():
                stack.extend(node.items)
            case ast.Branches():
                stack.extend(node.paths)
            case ast.Block():
                yield node
                stack.extend(p.value for p in node.pins if type(p.value) is ast.Branches)
            case ast.Contact() | ast.Coil() | ast.Jump():
                yield node


def callees(rung: ast.Rung) -> Iterator[tuple[str, ast.Block | ast.Call]]:
    """What the rung calls by name: blocks without an instance, and calls in its expressions."""
    for element in elements_in(rung):
        match element:
            case ast.Contact():
                expressions = (element.expr,)
            case ast.Coil():
                expressions = (element.target,)
            case ast.Block():
                if element.instance is None:
                    yield element.type, element
                values = (p.value for p in element.pins)
                expressions = tuple(v for v in values if not isinstance(v, ast.Branches | ast.Junction))
            case _:
                continue
        for expression in expressions:
            if type(expression) not in _LEAVES:
                for call in calls_in(expression):
                    yield call.name, call
