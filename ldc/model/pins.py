"""The pins of a block: what is written at each, typed (DESIGN section 2)."""

from __future__ import annotations

from collections.abc import Callable

from ldc.diagnostics import Diagnostics
from ldc.expr import Load, Place
from ldc.model import call_findings as findings
from ldc.model import expressions, places, type_findings
from ldc.model.elements import Net, PinIn, PinOut
from ldc.model.environment import Environment
from ldc.model.values import Value, coerce, storable
from ldc.parser import ast
from ldc.symbols import Parameter
from ldc.types import BOOL, holds_blocks, storage

NetOf = Callable[[ast.Branches | ast.Junction], Net]


def is_net(pin: ast.Pin) -> bool:
    """Whether a ladder network or a junction is written at the pin."""
    return type(pin.value) is ast.Branches or type(pin.value) is ast.Junction


def pin_in(
    env: Environment, pin: ast.Pin, parameter: Parameter, net_of: NetOf, diagnostics: Diagnostics,
    known: Value | None = None,
) -> PinIn | None:
    """An input with what feeds it: an expression of the pin's type, or a net. ``known``: the value at
    the pin when it is typed already."""
    if holds_blocks(parameter.type):
        lent = lent_to_input(env, pin.value, parameter, diagnostics)
        return None if lent is None else PinIn(parameter.name, parameter.type, lent, pin.span)
    if type(pin.value) is ast.Branches and storage(parameter.type) != BOOL:
        findings.network_on_value_pin(diagnostics, pin.value.span, parameter.name, str(parameter.type))
        return None
    if is_net(pin):
        return PinIn(parameter.name, parameter.type, net_of(pin.value), pin.span)
    if known is None:
        known = expressions.value(env, pin.value, parameter.type, diagnostics)
    if known is None:
        return None
    source = coerce(known, parameter.type, diagnostics, pin.value.span, f"pin `{parameter.name}`")
    return None if source is None else PinIn(parameter.name, parameter.type, source, pin.span)


def lent_to_input(
    env: Environment, node: ast.Expr, parameter: Parameter, diagnostics: Diagnostics
) -> Load | None:
    """What is at an input that takes an instance, to read it: the caller's, as it is before the call."""
    place = _variable(env, node, parameter, diagnostics, write=False)
    return None if place is None else Load(place, node.span)


def pin_out(
    env: Environment, pin: ast.Pin, parameter: Parameter, net_of: NetOf, diagnostics: Diagnostics
) -> PinOut | None:
    """An output with what it feeds: a place of the same or a wider type, or a net."""
    if type(pin.value) is ast.Branches:
        type_findings.not_a_value(diagnostics, pin.value.span, f"output `{parameter.name}` feeds a network",
                                  "a network in braces", f"name a junction, `{parameter.name} => @name`, and "
                                  "start a path of the rung with `@name`")
        return None
    if is_net(pin):
        return PinOut(parameter.name, parameter.type, net_of(pin.value), pin.span)
    target = places.place(env, pin.value, diagnostics, write=True)
    if target is None:
        return None
    if not storable(parameter.type, target.type):
        type_findings.not_storable(diagnostics, pin.value.span, parameter.name, parameter.type, target.type)
        return None
    return PinOut(parameter.name, parameter.type, target, pin.span)


def pin_in_out(
    env: Environment, pin: ast.Pin, parameter: Parameter, diagnostics: Diagnostics
) -> tuple[PinIn, PinOut] | None:
    """A VAR_IN_OUT pin: copied in before the call, copied out after it."""
    place = _variable(env, pin.value, parameter, diagnostics, write=True)
    if place is None or holds_blocks(place.type) and not places.lent(env, place, diagnostics):
        return None
    source = Load(place, pin.value.span)
    return (PinIn(parameter.name, parameter.type, source, pin.span),
            PinOut(parameter.name, parameter.type, place, pin.span))


def _variable(
    env: Environment, node: ast.Expr, parameter: Parameter, diagnostics: Diagnostics, write: bool
) -> Place | None:
    """The variable that is given to a pin, of just the type of the pin."""
    if type(node) in (
            ast.Branches, ast.Junction, ast.Literal, ast.EnumLiteral, ast.Unary, ast.Binary, ast.Call):
        findings.bad_in_out(diagnostics, node.span, parameter.name, "this is no variable",
                            f"write `{parameter.name} := variable`", changed=write)
        return None
    place = places.place(env, node, diagnostics, write)
    if place is not None and place.type != parameter.type:
        findings.bad_in_out(diagnostics, node.span, parameter.name,
                            f"this is {type_findings.described(place.type)}",
                            f"give it a variable of type {parameter.type}", changed=write)
        return None
    return place
