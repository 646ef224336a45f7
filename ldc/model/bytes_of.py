"""SIZEOF of a variable or a type: how many bytes other editors count for it.

What is kept here lies as ``ldc.il.layout`` says, and no program sees it; texts use SIZEOF for the number of
elements of an array, and for the room of a string.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.library import functions
from ldc.model import places
from ldc.model import type_findings as findings
from ldc.model.environment import Environment
from ldc.model.values import Untyped, counting
from ldc.parser import ast
from ldc.types import (
    ELEMENTARY, Array, Elementary, Enum, Instance, String, Struct, Subrange, Type, holds_blocks)


def size(env: Environment, node: ast.Call, diagnostics: Diagnostics) -> Untyped | None:
    """The value of ``SIZEOF(x)``, which takes the type that its context asks for; None after an error."""
    argument = node.arguments[0].value
    type_ = _named(env, argument)
    if type_ is None:
        place = places.place(env, argument, diagnostics)
        if place is None:
            return None
        type_ = place.type
    if holds_blocks(type_):
        findings.not_a_value(diagnostics, argument.span, "how many bytes a function block takes is not told",
                             f"this is {findings.described(type_)}", "write the number")
        return None
    return Untyped(_measured(type_)[0], node.span)


def _named(env: Environment, node: ast.Expr) -> Type | None:
    """The type that is named, where no variable has the name."""
    if type(node) is not ast.Name or env.variable(node.name.upper()) is not None:
        return None
    return env.type_named(node.name.upper()) or ELEMENTARY.get(node.name.upper())


def _measured(type_: Type) -> tuple[int, int]:
    """Bytes, and what their address is a multiple of."""
    match type_:
        case Elementary(bits=bits):
            count = 4 if functions.is_temporal(type_) else max(bits // 8, 1)
            return count, count
        case Enum():
            return _measured(counting(type_))
        case Subrange(base=base):
            return _measured(base)
        case String(name, length):
            width = 1 if name == "STRING" else 2
            return (length + 1) * width, width
        case Array(element=element):
            one, align = _measured(element)
            return one * type_.count, align
        case Struct(fields=fields):
            end, widest = 0, 1
            for one, align in (_measured(field.type) for field in fields):
                end = -(-end // align) * align + one
                widest = max(widest, align)
            return -(-end // widest) * widest, widest
        case Instance():
            raise TypeError(f"{type_} has no size")
