"""Values on their way to IL: typed expressions, and what was computed once and is held."""

from __future__ import annotations

from ldc.expr import Apply, BitStep, Const, Expr, FieldStep, IndexStep, Load, Place
from ldc.records import record
from ldc.types import BOOL, DATE, DT, TIME, TOD, Elementary, Type

# Arithmetic whose two sides have different types is a call of the standard's typed function (table 30).
_MIXED = {
    ("ADD", TOD, TIME): "ADD_TOD_TIME", ("ADD", DT, TIME): "ADD_DT_TIME",
    ("SUB", DATE, DATE): "SUB_DATE_DATE", ("SUB", TOD, TIME): "SUB_TOD_TIME",
    ("SUB", TOD, TOD): "SUB_TOD_TOD", ("SUB", DT, TIME): "SUB_DT_TIME", ("SUB", DT, DT): "SUB_DT_DT",
}


@record
class Held:
    """A value that was computed once: in the accumulator still, or (when that was needed) in a temporary."""

    id: int
    type: Type


Value = Expr | Held


def conjunction(items: list[Value]) -> Value:
    return items[0] if len(items) == 1 else Apply("AND", tuple(items), BOOL)


def disjunction(items: list[Value]) -> Value:
    return items[0] if len(items) == 1 else Apply("OR", tuple(items), BOOL)


def negation(item: Value) -> Value:
    if isinstance(item, Const):
        return Const(not item.value, BOOL, item.span)
    return Apply("NOT", (item,), BOOL)


def typed_function(op: str, types: tuple[Type, ...]) -> str | None:
    """The name of the function that an operator on unequal types stands for (MULTIME, SUB_DT_DT ...)."""
    if len(types) != 2:
        return None
    left, right = types
    if op in ("MUL", "DIV") and left == TIME and right != TIME:
        return op + "TIME"
    return _MIXED.get((op, left, right))


def can_fault(expr: Value) -> bool:
    """Whether evaluating may stop the task: a division, an index that is not constant, a user function."""
    if isinstance(expr, Load) and not expr.place.steps:
        return False
    stack: list[Value] = [expr]
    while stack:
        match stack.pop():
            case Load(place):
                if any(isinstance(s, IndexStep) and not all(isinstance(i, Const) for i in s.indexes)
                       for s in place.steps):
                    return True
            case Apply(op, args, user=user):
                if user or op in ("DIV", "MOD", "DIVTIME") and not _nonzero(args[1]):
                    return True
                stack.extend(args)
    return False


def _nonzero(expr: Value) -> bool:
    return isinstance(expr, Const) and expr.value != 0


def is_real(type_: Type) -> bool:
    """Whether the type is REAL or LREAL."""
    return isinstance(type_, Elementary) and type_.kind == "real"


def is_simple(expr: Value) -> bool:
    """Whether one operand says it: a constant, a variable, a held value."""
    return not isinstance(expr, Apply)


def is_not(expr: Value) -> bool:
    """Whether it is a negation."""
    return isinstance(expr, Apply) and expr.op == "NOT"


def simple_indexes(step: IndexStep) -> bool:
    """Whether IL can write every index: constants and variables."""
    return all(isinstance(i, Const) or isinstance(i, Load) and
               all(isinstance(s, FieldStep | BitStep) or simple_indexes(s) for s in i.place.steps)
               for i in step.indexes)


def as_expr(operand: Const | Place) -> Expr:
    """The operand as an expression."""
    return operand if isinstance(operand, Const) else Load(operand)


def all_negated(expr: Value) -> Apply | None:
    """De Morgan: ``/a OR /b`` is NOT (a AND b), which needs no load of its own for the first operand."""
    if (isinstance(expr, Apply) and expr.op in ("AND", "OR") and expr.type == BOOL
            and all(is_not(a) and is_simple(a.args[0]) for a in expr.args)):
        return Apply("OR" if expr.op == "AND" else "AND", tuple(a.args[0] for a in expr.args), BOOL,
                     expr.span)
    return None
