"""A flat chain of operands and operators into a tree, by precedence (IEC 61131-3, table 55 and B.3.1).

All operators are left associative. A sign and NOT bind tighter than any of them, ``**`` too.
"""

from __future__ import annotations

from ldc.parser import ast
from ldc.source import Span

PRECEDENCE = {
    "OR": 1, "OR_ELSE": 1, "XOR": 2, "AND": 3, "AND_THEN": 3, "=": 4, "<>": 4, "<": 5, ">": 5, "<=": 5,
    ">=": 5,
    "+": 6, "-": 6, "*": 7, "/": 7, "MOD": 7, "**": 8,
}
UNARY = 9


def tree(chain: list) -> ast.Expr:
    """``chain``: operand, operator, operand, ... Iterative: a chain may be long."""
    operands, operators = [chain[0]], []
    for at in range(1, len(chain), 2):
        operator = chain[at]
        rank = PRECEDENCE[operator]
        while operators and PRECEDENCE[operators[-1]] >= rank:
            _join(operands, operators.pop())
        operators.append(operator)
        operands.append(chain[at + 1])
    while operators:
        _join(operands, operators.pop())
    return operands[0]


def _join(operands: list[ast.Expr], operator: str) -> None:
    right = operands.pop()
    left = operands[-1]
    span = Span(left.span.source, left.span.start, right.span.end)
    operands[-1] = ast.Binary(operator, left, right, span)
