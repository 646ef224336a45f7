"""Function blocks and functions drawn in a rung, typed (DESIGN section 2)."""

from __future__ import annotations

from itertools import count

from ldc.diagnostics import Diagnostics
from ldc.expr import Place
from ldc.library import conversion
from ldc.library.table import Function
from ldc.model import call_findings as findings
from ldc.model import action_calls, elements, expressions, places
from ldc.model.calls import pins_help, standard_function, unknown_function
from ldc.model.environment import Environment
from ldc.model.pins import NetOf, is_net
from ldc.model.type_findings import no_such_operation
from ldc.model.values import NetValue, Value
from ldc.model.wiring import Wiring
from ldc.parser import ast, format_of
from ldc.symbols import Signature
from ldc.types import BOOL, Instance, Type


def block(
    env: Environment, node: ast.Block, net_of: NetOf, diagnostics: Diagnostics
) -> elements.Block | None:
    """The typed block; None after an error. ``net_of`` gives the net of a network or junction at a pin;
    its method ``type_of``, if it has one, the type of that net, which an overloaded function needs."""
    key = node.type.upper()
    action = action_calls.called(env, ast.Name(node.type, node.span)) if node.instance is None else (
        action_calls.of_instance(env, node.instance, node.type))
    if action is not None:
        return action_calls.block(env, action, node, net_of, diagnostics)
    signature = env.signature(key)
    if signature is None:
        function = standard_function(key)
        if function is None:
            unknown_function(env, node.type, node.span, diagnostics)
            if node.instance is not None and env.silent(key) and format_of(node.span.source) is not None:
                findings.block_of_unknown_type(diagnostics, node.span, node.type)
            return None
        if node.instance is not None:
            return _function_with_instance(node, diagnostics)
        found = _standard_signature(env, node, function, net_of, diagnostics)
        if found is None:
            return None
        return Wiring(env, node, found[0], net_of, diagnostics, found[1]).function()
    if signature.kind == "PROGRAM":
        findings.wrong_kind(diagnostics, node.span, f"PROGRAM `{signature.name}` cannot be drawn as a block",
                            "a program runs by a task", "make it a FUNCTION_BLOCK")
        return None
    if signature.kind == "FUNCTION":
        if node.instance is not None:
            return _function_with_instance(node, diagnostics)
        if signature.result is None:
            return None
        return Wiring(env, node, signature, net_of, diagnostics).function()
    if node.instance is None:
        findings.wrong_kind(diagnostics, node.span, f"function block `{signature.name}` has no instance name",
                            "a block keeps its state in an instance",
                            f"declare `name : {signature.name};` and write `<name: {signature.name}(...)>`")
        return None
    place = places.place(env, node.instance, diagnostics)
    if place is None:
        return None
    own = env.signature(place.type.pou) if isinstance(place.type, Instance) else None
    if own is None or not own.called(key):
        _instance_mismatch(env, node, place, signature, diagnostics)
        return None
    if not places.lent(env, place, diagnostics):
        return None
    return Wiring(env, node, own, net_of, diagnostics).function_block(place)


def _instance_mismatch(
    env: Environment, node: ast.Block, place: Place, signature: Signature, diagnostics: Diagnostics
) -> None:
    found = env.variable(place.root.upper())
    written, declared = node.instance.span.text, str(place.type)
    help = f"declare an instance: `VAR name : {signature.name}; END_VAR`"
    if isinstance(place.type, Instance):
        known = env.signature(place.type.pou)
        declared = known.name if known is not None else declared
        help = f"write `{written}: {declared}`, or declare it as {signature.name}"
    findings.instance_mismatch(diagnostics, node.instance.span, written, declared, signature.name,
                               found[0].span if found is not None else None, help)


def _function_with_instance(node: ast.Block, diagnostics: Diagnostics) -> None:
    findings.wrong_kind(diagnostics, node.instance.span, f"`{node.type}` is a FUNCTION and has no instances",
                        "an instance name", f"write `<{node.type}(...)>`")


def _standard_signature(
    env: Environment, node: ast.Block, function: Function, net_of: NetOf, diagnostics: Diagnostics
) -> tuple[Signature, dict[int, Value]] | None:
    """The signature of a standard function for the values at its pins, and these values by the
    identity of their pins; undecided ones are left undecided."""
    given: dict[int, Value | NetValue | None] = {}
    values: dict[int, Value] = {}
    powered = function.position(node.power_in) if node.power_in is not None else None
    if powered is not None:
        given[powered] = NetValue(BOOL)
    by_position = (i for i in count() if i != powered)
    for pin in node.pins:
        if pin.output:
            continue
        if pin.name is None:
            at = next(by_position)
        else:
            at = function.position(pin.name)
        if at is None or at in given:
            continue  # EN, unknown, or given twice: the wiring knows
        given[at] = found = _pin_value(env, pin, net_of, diagnostics)
        if type(found) is not NetValue:
            values[id(pin)] = found
    number = max(max(given, default=-1) + 1, function.least)
    if not function.extensible:
        number = function.least
    names = function.pins(number)
    if function.name in conversion.KEPT:
        findings.bits_kept(diagnostics, node.span, function.name)
    if missing := [names[i] for i in range(number) if i not in given]:
        findings.pin_missing(diagnostics, node.span, function.name, missing,
                             pins_help(function.names) + (" ..." if function.extensible else ""))
        return None
    arguments = tuple(given[i] for i in range(number))
    if None in arguments:
        return None
    resolved = expressions.resolve(function.name, arguments, _target_type(env, node, diagnostics))
    if isinstance(resolved, str):
        no_such_operation(diagnostics, node.span, resolved)
        return None
    return resolved.signature, values


def _target_type(env: Environment, node: ast.Block, diagnostics: Diagnostics) -> Type | None:
    """The type of the variable that takes the result: what literals become when nothing else decides."""
    for pin in node.pins:
        if pin.output and pin.name.upper() == "OUT" and not is_net(pin):
            target = places.place(env, pin.value, diagnostics, write=True)
            return target.type if target is not None else None
    return None


def _pin_value(
    env: Environment, pin: ast.Pin, net_of: NetOf, diagnostics: Diagnostics
) -> Value | NetValue | None:
    """What a pin brings into the choice of the overload."""
    if type(pin.value) is ast.Branches:
        return NetValue(BOOL)
    if type(pin.value) is ast.Junction:
        type_of = getattr(net_of, "type_of", None)
        return NetValue(type_of(pin.value) if type_of is not None else None)
    return expressions.value(env, pin.value, None, diagnostics)
