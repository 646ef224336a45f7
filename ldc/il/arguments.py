"""Arguments of calls in IL text: which pin each is for, and its value in the type of the pin."""

from __future__ import annotations

from ldc.expr import Apply, Const, Load, Place
from ldc.il import findings
from ldc.il.machine import Machine
from ldc.il.operands import Operand
from ldc.il.scan import Argument
from ldc.model import call_findings
from ldc.model.names import suggest
from ldc.model.type_findings import described
from ldc.model.values import coerce
from ldc.source import Span
from ldc.symbols import Parameter, Signature
from ldc.types import Type, holds_blocks


def pins(machine: Machine, arguments: list[Argument], signature: Signature
         ) -> list[tuple[Parameter, Argument]]:
    """The arguments with the pins that they are for; without names in declared order."""
    order = (*signature.inputs, *signature.in_outs, *signature.outputs)
    found: dict[str, tuple[Parameter, Argument]] = {}
    for number, argument in enumerate(arguments):
        span = name_span(machine, argument)
        if argument.name is not None:
            parameter = signature.pin(argument.name)
        elif number < len(order):
            parameter = order[number]
            argument = Argument(None, argument.start, argument.end, parameter in signature.outputs,
                                name_start=argument.name_start)
        else:
            call_findings.too_many(machine.diagnostics, span, signature.name, len(order))
            break
        if parameter is None:
            call_findings.unknown_pin(machine.diagnostics, span, signature.name, argument.name,
                                      suggest(argument.name, (p.name for p in order)))
        elif parameter.name.upper() in found:
            call_findings.pin_twice(machine.diagnostics, span, parameter.name, "given again",
                                    name_span(machine, found[parameter.name.upper()][1]),
                                    "leave one of the two out")
        elif parameter not in signature.in_outs and argument.output != (parameter in signature.outputs):
            call_findings.wrong_direction(machine.diagnostics, span, parameter.name, not argument.output)
        else:
            found[parameter.name.upper()] = parameter, argument
    return list(found.values())


def name_span(machine: Machine, argument: Argument) -> Span:
    if argument.name is None:
        return machine.span_of(argument.start, argument.end)
    return machine.span_of(argument.name_start, argument.name_start + len(argument.name))


def argument_value(machine: Machine, argument: Argument, parameter: Parameter) -> Const | Load | Apply | None:
    """The value of an argument in the type of its pin."""
    span = machine.span_of(argument.start, argument.end)
    if argument.start == argument.end:
        findings.operand_missing(machine.diagnostics, name_span(machine, argument), parameter.name, "a value")
        return None
    if holds_blocks(parameter.type):
        return _instance(machine, argument, parameter, span)
    value = machine.operands.value(argument.start, argument.end, parameter.type)
    return coerced(machine, value, parameter.type, span, f"pin `{parameter.name}`")


def _instance(machine: Machine, argument: Argument, parameter: Parameter, span: Span) -> Load | None:
    """An instance that is handed over, or what holds some."""
    place = machine.operands.place(argument.start, argument.end, write=False)
    if place is not None and place.type != parameter.type:
        call_findings.bad_in_out(machine.diagnostics, span, parameter.name,
                                 f"this is {described(place.type)}",
                                 f"give it a variable of type {parameter.type}", changed=False)
        return None
    return None if place is None else Load(place, span)


def coerced(machine: Machine, value: Operand | None, wanted: Type, span: Span, what: str):
    if value is None:
        return None
    return coerce(Load(value) if isinstance(value, Place) else value, wanted, machine.diagnostics, span, what)


def load(machine: Machine, value: Const | Load | Apply) -> None:
    """LD of a value, and the function that widens it."""
    inner = value.args[0] if isinstance(value, Apply) else value
    machine.emit("LD", inner.place if isinstance(inner, Load) else inner, inner.type)
    if isinstance(value, Apply):
        machine.emit("FN", None, value.type, value.op)


def spill(machine: Machine, value: Const | Load | Apply) -> Const | Place:
    """The value as an operand; one that has to be widened goes through a temporary."""
    if isinstance(value, Apply):
        load(machine, value)
        place = machine.temp(value.type)
        machine.emit("ST", place, value.type)
        return place
    return value.place if isinstance(value, Load) else value
