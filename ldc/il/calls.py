"""Calls of function blocks in IL text: ``CAL`` with and without arguments, and input operators."""

from __future__ import annotations

from ldc.expr import Const, Load, Place
from ldc.il import findings
from ldc.il.arguments import argument_value, load, name_span, pins
from ldc.il.enabling import apart
from ldc.il.machine import Machine
from ldc.il.operands import member
from ldc.il.scan import Argument, Line
from ldc.model import places, type_findings
from ldc.model.action_calls import Called, selector
from ldc.model.values import coerce, same
from ldc.symbols import ACTION, Parameter, Signature
from ldc.types import Instance, Type, holds_blocks

# Input operators of the standard blocks (2nd edition, table 54): they set a pin and call.
_INPUT_OPERATORS = frozenset("S R S1 R1 CLK CU CD LD PV IN PT".split())


def input_operator(machine: Machine, line: Line) -> bool:
    """``S1 latch`` is ``ST latch.S1`` and ``CAL latch``; False when the operand is no instance."""
    if line.op not in _INPUT_OPERATORS or line.start == line.end or line.paren:
        return False
    text = machine.operands.source.text[line.start:line.end]
    variable = machine.scope.variable(text.split(".")[0].split("[")[0].strip().upper())
    if variable is None or not _holds_instances(variable[0].type):
        return False
    place = machine.operands.place(line.start, line.end, write=False)
    if place is None or not isinstance(place.type, Instance):
        return False
    signature = machine.scope.signature(place.type.pou)
    pin = next((p for p in signature.inputs if p.name.upper() == line.op), None) if signature else None
    if pin is None:
        return False
    if places.lent(machine.scope, place, machine.diagnostics) and machine.use(line.op) and machine.convert(
            pin.type, line.op):
        machine.emit("ST", member(place, pin.name, pin.type), pin.type)
        machine.emit("CAL", place, place.type)
    machine.define(None)
    return True


def _holds_instances(type_: Type) -> bool:
    while hasattr(type_, "element"):
        type_ = type_.element
    return isinstance(type_, Instance) or hasattr(type_, "fields")


def instance(machine: Machine, line: Line) -> None:
    """``CAL timer`` or ``CAL timer(IN := a, PT := T#1s, Q => b)``: values to the pins, the call, pins out."""
    with_arguments = line.arguments >= 0
    end = line.arguments if with_arguments else line.end
    while end > line.start and machine.operands.source.text[end - 1].isspace():
        end -= 1
    action = machine.operands.action(line.start, end)
    if action is not None:
        _action(machine, line, action)
        return
    place = machine.operands.place(line.start, end, write=False)
    if place is None or not isinstance(place.type, Instance):
        if place is not None:
            findings.not_callable(machine.diagnostics, machine.span_of(line.start, end), line.op,
                                  f"this is {type_findings.described(place.type)}")
        machine.define(None)
        return
    if not places.lent(machine.scope, place, machine.diagnostics):
        machine.define(None)
        return
    conditional = line.op != "CAL"
    if conditional and not machine.condition(line.op):
        return
    if not with_arguments:
        machine.emit(line.op, place, place.type)
        if not conditional:
            machine.define(None)
        return
    signature = machine.scope.signature(place.type.pou)
    arguments, enabling = apart(machine, machine.scanner.arguments(line.arguments + 1, line.end), signature)
    given = pins(machine, arguments, signature)
    skip = ""
    if conditional:
        skip = machine.label()
        machine.emit("JMPCN" if line.op == "CALC" else "JMPC", name=skip)
    enabling.begin()
    for parameter, argument in given:
        if not argument.output:
            _set_pin(machine, place, parameter, argument)
    machine.emit("CAL", place, place.type)
    for parameter, argument in sorted(given, key=lambda pin: pin[0] not in signature.in_outs):
        if argument.output or parameter in signature.in_outs:
            _take_pin(machine, place, parameter, argument)
    enabling.end()
    if skip:
        machine.emit("LABEL", name=skip)
    machine.define(None)


def _action(machine: Machine, line: Line, action: Called) -> None:
    """``CAL action`` or ``CAL instance.action``, with nothing but EN and ENO in parentheses."""
    if action.instance is not None and not places.lent(machine.scope, action.instance, machine.diagnostics):
        machine.define(None)
        return
    conditional = line.op != "CAL"
    if conditional and not machine.condition(line.op):
        return
    taken = Signature(ACTION, action.owner.actions[action.number - 1])
    written = machine.scanner.arguments(line.arguments + 1, line.end) if line.arguments >= 0 else []
    arguments, enabling = apart(machine, written, taken)
    pins(machine, arguments, taken)
    skip = ""
    if conditional:
        skip = machine.label()
        machine.emit("JMPCN" if line.op == "CALC" else "JMPC", name=skip)
    enabling.begin()
    if action.instance is None:
        machine.emit("ACT", name=taken.name.upper())
    else:
        pin = selector(action.owner)
        chosen = member(action.instance, pin.name, pin.type)
        load(machine, Const(action.number, pin.type))
        machine.emit("ST", chosen, pin.type)
        machine.emit("CAL", action.instance, action.instance.type)
        load(machine, Const(0, pin.type))
        machine.emit("ST", chosen, pin.type)
    enabling.end()
    if skip:
        machine.emit("LABEL", name=skip)
    machine.define(None)


def _set_pin(machine: Machine, place: Place, parameter: Parameter, argument: Argument) -> None:
    if parameter in machine.scope.signature(place.type.pou).in_outs:
        target = machine.operands.place(argument.start, argument.end, write=True)
        if target is not None and not same(target.type, parameter.type):
            type_findings.mismatch(machine.diagnostics, machine.span_of(argument.start, argument.end),
                                   parameter.type, target.type, f"pin `{parameter.name}`")
    value = argument_value(machine, argument, parameter)
    if value is not None:
        load(machine, value)
        machine.emit("ST", member(place, parameter.name, parameter.type), parameter.type)


def _take_pin(machine: Machine, place: Place, parameter: Parameter, argument: Argument) -> None:
    target = machine.operands.place(argument.start, argument.end, write=True)
    if target is None:
        return
    pin = member(place, parameter.name, parameter.type)
    if holds_blocks(parameter.type):  # given back
        places.lent(machine.scope, target, machine.diagnostics)
        machine.emit("LD", pin, pin.type)
        machine.emit("ST", target, pin.type)
        return
    value = coerce(Load(pin), target.type, machine.diagnostics, name_span(machine, argument),
                   f"`{target}`")
    if value is None:
        return
    load(machine, value)
    if argument.negated and machine.check("NOT", target.type):
        machine.emit("NOT", None, target.type)
    machine.emit("ST", target, target.type)
