"""Calls of function blocks in statements, with the names of pins that the standard has.

Conversions between bit strings and REAL, which the standard does not have, are two. Some editors call the pins
of standard blocks otherwise (`RESET` of a counter); some let outputs follow the inputs in a call without names:
`t(start, T#1s, done, elapsed)`.
"""

from __future__ import annotations

from collections.abc import Mapping

from ldc.library import blocks
from ldc.parser import ast
from ldc.parser import statements as st
from ldc.parser.plcopen import kinds
from ldc.parser.plcopen.guarded import Pins
from ldc.parser.plcopen.pins import standard_names
from ldc.parser.plcopen.rewrite import rewritten
from ldc.records import replace
from ldc.types import Elementary

_OTHERWISE = frozenset(("CTU", "CTD", "CTUD", "SR", "RS"))


def standard(
    body: object, variables: Mapping[str, ast.VarDecl], interfaces: Mapping[str, Pins]
) -> object:
    """A body with its calls. ``variables``: of the POU, by name in capitals;
    ``interfaces``: of the function blocks of the file."""
    types = {name: v.type.name.upper() for name, v in variables.items() if isinstance(v.type, ast.NamedType)}
    called = {name: type_ for name, type_ in types.items() if type_ in interfaces or blocks.signature(type_)}

    def change(node: object) -> object:
        if not isinstance(node, st.Invoke) or not isinstance(node.callee, ast.Name) or not node.arguments:
            return node
        type_ = called.get(node.callee.name.upper())
        if type_ is None:
            return node
        if all(argument.name is None for argument in node.arguments):
            return replace(node, arguments=_named(node.arguments, *_pins(type_, interfaces)))
        own = type_ in interfaces or type_ not in _OTHERWISE
        return node if own else replace(node, arguments=_renamed(node.arguments, type_))

    return rewritten(body, change) if called else body


def numbers(
    variables: Mapping[str, ast.VarDecl], interfaces: Mapping[str, Pins]
) -> dict[str, dict[str, Elementary]]:
    """The inputs of instances of function blocks that are numbers, with their types, by names in capitals."""
    found = {}
    for name, variable in variables.items():
        type_ = variable.type.name.upper() if isinstance(variable.type, ast.NamedType) else ""
        if type_ in interfaces:
            found[name] = kinds.declared(interfaces[type_]["VAR_INPUT"])
        elif (signature := blocks.signature(type_)) is not None:
            found[name] = {p.name: p.type for p in signature.inputs if p.type.name in kinds.NUMBERS}
    return found


def _pins(type_: str, interfaces: Mapping[str, Pins]) -> tuple[list[str], list[str]]:
    """The names of what takes a value, and of the outputs."""
    if type_ in interfaces:
        own = interfaces[type_]
        return ([v.name for kind in ("VAR_INPUT", "VAR_IN_OUT") for v in own[kind]],
                [v.name for v in own["VAR_OUTPUT"]])
    signature = blocks.signature(type_)
    return [p.name for p in signature.inputs], [p.name for p in signature.outputs]


def _named(
    arguments: tuple[ast.Argument, ...], inputs: list[str], outputs: list[str]
) -> tuple[ast.Argument, ...]:
    """With names, when there are more than inputs; too many are left for a finding."""
    if not len(inputs) < len(arguments) <= len(inputs) + len(outputs):
        return arguments
    names = (*((name, False) for name in inputs), *((name, True) for name in outputs))
    return tuple(replace(argument, name=name, output=output)
                 for argument, (name, output) in zip(arguments, names, strict=False))


def _renamed(arguments: tuple[ast.Argument, ...], type_: str) -> tuple[ast.Argument, ...]:
    given = [argument for argument in arguments if argument.name is not None and not argument.output]
    names = iter(standard_names(type_, False, [argument.name for argument in given]))
    return tuple(replace(argument, name=next(names)) if argument.name is not None and not argument.output
                 else argument for argument in arguments)
