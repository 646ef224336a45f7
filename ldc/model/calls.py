"""Calls of functions inside expressions (IEC 61131-3 table 20): arguments to parameters, defaults."""

from __future__ import annotations

from collections.abc import Iterable

from ldc.diagnostics import Diagnostics
from ldc.expr import Apply, Const, Expr, Output
from ldc.library import conversion, functions
from ldc.library.table import Function
from ldc.model import call_findings as findings
from ldc.model import bytes_of, expressions, pins, places, type_findings, wiring
from ldc.model.environment import Environment
from ldc.model.names import suggest
from ldc.model.values import Untyped, Value
from ldc.parser import ast
from ldc.records import replace
from ldc.source import Span
from ldc.symbols import Parameter, Signature
from ldc.types import (
    DINT, ELEMENTARY, Array, Elementary, Instance, Subrange, Type, default, holds_blocks, is_scalar)


_INSTEAD = dict.fromkeys(("ADR", "REF", "__NEW", "__DELETE"),
                         "pointers are not supported: pass the variable by VAR_IN_OUT, or name it")
_BOUNDS = {"LOWER_BOUND": 0, "UPPER_BOUND": 1}


def standard_function(key: str) -> Function | None:
    """A standard function that a program may call by name (in capitals)."""
    if not functions.is_function(key):
        return None
    # The overloaded TO_INT and so on have no row of their own; they are called like every conversion.
    return functions.lookup(key) or replace(functions.lookup("INT_TO_DINT"), name=key)


def call(env: Environment, node: ast.Call, hint: Type | None, diagnostics: Diagnostics) -> Value | None:
    """The typed call; None after an error."""
    key = node.name.upper()
    signature = env.signature(key)
    for argument in node.arguments:
        if argument.name is not None and argument.name.upper() in ("EN", "ENO"):
            _only_of_a_call(argument.span, argument.name.upper(), diagnostics)
            return None
    if signature is not None:
        if signature.kind != "FUNCTION":
            kind = signature.kind.lower().replace("_", " ")
            how = "call an instance of it, `instance(...);`," if env.statements else (
                "draw it as a block, `<instance: TYPE(...)>`,")
            findings.wrong_kind(diagnostics, node.span, f"`{node.name}` cannot be called in an expression",
                                f"this is a {kind}", f"{how} and read `instance.pin`")
            return None
        return _project_function(env, node, signature, diagnostics)
    found = env.variable(key)
    if found is not None and isinstance(found[0].type, Instance):
        findings.wrong_kind(diagnostics, node.span, f"`{node.name}` cannot be called in an expression",
                            "this is an instance of a function block",
                            f"call it before, and read its output, `{node.name}.pin`")
        return None
    if key in _BOUNDS and len(node.arguments) == 2:
        return _bound(env, node, key, diagnostics)
    if key == "SIZEOF" and len(node.arguments) == 1 and node.arguments[0].name is None:
        return bytes_of.size(env, node, diagnostics)
    function = standard_function(key)
    if function is None:
        unknown_function(env, node.name, node.span, diagnostics)
        return None
    return _standard_function(env, node, function, hint, diagnostics)


def _bound(env: Environment, node: ast.Call, key: str, diagnostics: Diagnostics) -> Const | None:
    """LOWER_BOUND and UPPER_BOUND of the 3rd edition: of a dimension of an array, counted from 1."""
    array, number = (argument.value for argument in node.arguments)
    place = places.place(env, array, diagnostics)
    dimension = expressions.expression(env, number, DINT, diagnostics, "the dimension")
    if place is None or dimension is None:
        return None
    at = expressions.constant(env, dimension)
    bounds = place.type.bounds if isinstance(place.type, Array) else ()
    if at is None or not 1 <= at <= len(bounds):
        type_findings.not_a_value(diagnostics, node.span,
                                  f"`{node.name}` needs an array and one of its dimensions",
                                  f"this has {len(bounds)}", f"write `{node.name}(array, 1)`")
        return None
    return Const(bounds[at - 1][_BOUNDS[key]], DINT, node.span)


def _only_of_a_call(span: Span, pin: str, diagnostics: Diagnostics) -> None:
    findings.outputs_in_expression(diagnostics, span, f"pin {pin} is used in an expression",
                                   "the expression takes the result in any case")


def unknown_function(env: Environment, name: str, span, diagnostics: Diagnostics) -> None:
    """Report a name that is no callable, unless its declaration is known to be broken."""
    own = env.signature(env.pou.upper())
    if own is not None and own.action(name):
        findings.wrong_kind(diagnostics, span, f"`{name}` cannot be called in an expression",
                            "this is an action",
                            "call it before, `name();`, and read the variables that it writes")
    elif not env.silent(name.upper()):
        findings.unknown_callee(diagnostics, span, name,
                                _INSTEAD.get(name.upper()) or _instance_help(env, name)
                                or suggest(name, (*env.callables(), *functions.names()))
                                or "declare it as FUNCTION or FUNCTION_BLOCK")


def _instance_help(env: Environment, name: str) -> str:
    """For an instance that is drawn as if it were the block, and for one that is not declared, `TON1`."""
    found = env.variable(name.upper())
    if found is not None and isinstance(found[0].type, Instance):
        return f"`{name}` is an instance: write `<{name}: {found[0].type}(...)>`"
    block = env.signature(name.upper().rstrip("_0123456789"))
    if block is not None and block.kind == "FUNCTION_BLOCK":
        return f"declare an instance in VAR: `{name} : {block.name};`"
    return ""


def _inputs_only(node: ast.Call, diagnostics: Diagnostics) -> bool:
    for argument in node.arguments:
        if argument.output:
            findings.outputs_in_expression(diagnostics, argument.span,
                                           f"outputs of `{node.name}` cannot be taken in an expression",
                                           "an output")
            return False
    named = [a for a in node.arguments if a.name is not None]
    if named and len(named) < len(node.arguments):
        first = next(a for a in node.arguments if a.name is None)
        findings.mixed_arguments(diagnostics, first.span, node.name)
        return False
    return True


def _standard_function(
    env: Environment, node: ast.Call, function: Function, hint: Type | None, diagnostics: Diagnostics
) -> Value | None:
    if not _inputs_only(node, diagnostics):
        return None
    places: dict[int, ast.Argument] = {}
    for at, argument in enumerate(node.arguments):
        position = at if argument.name is None else function.position(argument.name)
        if position is None:
            findings.unknown_pin(diagnostics, argument.span, function.name, argument.name,
                                 suggest(argument.name, function.names) or pins_help(function.names))
            return None
        if position in places:
            findings.pin_twice(diagnostics, argument.span, argument.name, "given again here",
                               places[position].span, "give it once")
            return None
        places[position] = argument
    count = max(places, default=-1) + 1
    if not function.extensible and count > function.least:
        findings.too_many(diagnostics, places[function.least].span, function.name, function.least)
        return None
    missing = [i for i in range(max(count, function.least)) if i not in places]
    if missing:
        names = function.pins(max(count, function.least))
        findings.pin_missing(diagnostics, node.span, function.name, [names[i] for i in missing],
                             f"write `{function.name}({', '.join(function.names)})`")
        return None
    values = [expressions.value(env, places[i].value, _wanted(function, places[i].value), diagnostics)
              for i in range(count)]
    if None in values:
        return None
    if function.name in conversion.KEPT:
        findings.bits_kept(diagnostics, node.span, function.name)
    truncated = function.name == "TRUNC" and type(values[0]) is not Untyped
    name = _truncation(values[0].type, hint) if truncated else ""
    return expressions.apply(env, name or function.name, tuple(values), node.span, diagnostics, hint)


def _wanted(function: Function, argument: ast.Expr) -> Type | None:
    """What a conversion asks of TRUNC, whose result is of any integer type (2.5.1.5.1)."""
    if type(argument) is ast.Call and argument.name.upper() == "TRUNC":
        return ELEMENTARY.get(function.name.partition("_TO_")[0])
    return None


def _truncation(source: Type, hint: Type | None) -> str:
    """TRUNC where a type is asked for that a DINT does not go to."""
    if isinstance(hint, Subrange):
        hint = hint.base
    if not isinstance(source, Elementary) or not isinstance(hint, Elementary) or hint == DINT or (
            functions.widens(DINT, hint)):
        return ""
    name = f"{source.name}_TRUNC_{hint.name}"
    return name if functions.lookup(name) is not None else ""


def _project_function(
    env: Environment, node: ast.Call, signature: Signature, diagnostics: Diagnostics
) -> Value | None:
    if env.statements and (signature.in_outs or any(a.output for a in node.arguments)):
        return _with_outputs(env, node, signature, diagnostics)
    if not _inputs_only(node, diagnostics):
        return None
    if signature.in_outs:
        findings.outputs_in_expression(diagnostics, node.span,
                                       f"`{signature.name}` has VAR_IN_OUT pins", "called in an expression")
        return None
    if signature.result is None:
        return None
    given: dict[str, ast.Argument] = {}
    for at, argument in enumerate(node.arguments):
        parameter = _parameter(env, signature, at, argument, diagnostics)
        if parameter is None:
            return None
        key = parameter.name.upper()
        if key in given:
            findings.pin_twice(diagnostics, argument.span, parameter.name, "given again here",
                               given[key].span, "give it once")
            return None
        given[key] = argument
    typed: list[Expr | None] = []
    missing, bare = [], []
    for parameter in signature.inputs:
        argument = given.get(parameter.name.upper())
        if argument is not None and holds_blocks(parameter.type):
            typed.append(pins.lent_to_input(env, argument.value, parameter, diagnostics))
        elif argument is not None:
            typed.append(expressions.expression(env, argument.value, parameter.type, diagnostics,
                                                f"pin `{parameter.name}`"))
        elif (unset := default_argument(parameter, by_name(env, node.arguments))) is not None:
            typed.append(unset)
            if parameter.initial is None:
                bare.append(parameter.name)
        else:
            missing.append(parameter.name)
    if bare and not missing:
        findings.left_out(diagnostics, node.span, signature.name, bare)
    if missing:
        findings.pin_missing(diagnostics, node.span, signature.name, missing,
                             "give a value to every input that has no initial value")
        return None
    if None in typed:
        return None
    return Apply(signature.name.upper(), tuple(typed), signature.result, node.span, user=True)


def _with_outputs(
    env: Environment, node: ast.Call, signature: Signature, diagnostics: Diagnostics
) -> Apply | None:
    """A FUNCTION that also writes variables, in an expression of a statement."""
    if signature.result is None:
        return None
    pins = tuple(ast.Pin(a.name, a.value, a.output, a.span) for a in node.arguments)
    drawn = ast.Block(None, node.name, pins, wiring.NOT_WIRED, wiring.NOT_WIRED, node.span)
    block = wiring.Wiring(env, drawn, signature, _no_net, diagnostics).function()
    if block is None:
        return None
    for pin in (*block.inputs, *block.outputs):
        if pin.pin == "OUT":
            _only_of_a_call(pin.span, pin.pin, diagnostics)
            return None
    both = {parameter.name for parameter in signature.in_outs}
    outputs = tuple(Output(p.pin, p.type, p.target, p.pin in both) for p in block.outputs)
    env.taken.extend(output.place for output in outputs)
    return Apply(signature.name.upper(), tuple(p.source for p in block.inputs), signature.result, node.span,
                 user=True, outputs=outputs)


def _no_net(node: ast.Expr) -> int:
    raise TypeError(f"{node!r} is no network: expressions have none")


def _parameter(
    env: Environment, signature: Signature, at: int, argument: ast.Argument, diagnostics: Diagnostics
) -> Parameter | None:
    if argument.name is None:
        if at < len(signature.inputs):
            return signature.inputs[at]
        if not env.silent_pin(signature.name.upper(), ""):
            findings.too_many(diagnostics, argument.span, signature.name, len(signature.inputs))
        return None
    key = argument.name.upper()
    found = next((p for p in signature.inputs if p.name.upper() == key), None)
    if found is None and not env.silent_pin(signature.name.upper(), key):
        findings.unknown_pin(diagnostics, argument.span, signature.name, argument.name,
                             suggest(argument.name, (p.name for p in signature.inputs))
                             or pins_help([p.name for p in signature.inputs]))
    return found


def default_argument(parameter: Parameter, named: bool) -> Const | None:
    """What an input takes that a call leaves out: its declared initial value, if it is a scalar; that of its
    type in a call by name."""
    if not is_scalar(parameter.type) or parameter.initial is None and not named:
        return None
    return Const(default(parameter.type) if parameter.initial is None else parameter.initial, parameter.type)


def by_name(env: Environment, given: Iterable[ast.Argument | ast.Pin]) -> bool:
    """Whether a statement gives all arguments by name: such a list need not be complete (2.5.1.3)."""
    return env.statements and all(one.name is not None for one in given)


def pins_help(names) -> str:
    return "its pins are " + ", ".join(names) if names else "it has no pins"
