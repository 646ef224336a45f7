"""Calls of functions in IL text: the accumulator is the first argument, or all are given by name."""

from __future__ import annotations

from ldc.expr import Apply, Const, Load, Place
from ldc.il import findings
from ldc.il.accumulator import POISON
from ldc.il.arguments import argument_value, coerced, load, name_span, pins, spill
from ldc.il.calls import input_operator
from ldc.il.enabling import Enabling, apart
from ldc.il.machine import Machine
from ldc.il.names import IL_WORDS
from ldc.il.operands import Operand
from ldc.il.scan import Argument, Line
from ldc.library import functions
from ldc.model import call_findings, expressions, type_findings
from ldc.model.expressions import DIVISIONS
from ldc.model.names import suggest
from ldc.model.values import Untyped, coerce
from ldc.symbols import Parameter, Signature
from ldc.types import Type, default


def function(machine: Machine, line: Line) -> None:
    """A line that begins with the name of a function: the accumulator is the first argument, or all
    arguments stand in parentheses with their names."""
    if input_operator(machine, line):
        return
    user = machine.scope.signature(line.op)
    is_user = user is not None and user.kind == "FUNCTION"
    name = machine.span_of(line.op_start, line.op_end)
    if not is_user and not functions.is_function(line.op):
        what = "a function block is called by CAL and the name of an instance" if user is not None else ""
        findings.unknown_instruction(machine.diagnostics, name, name.text,
                                     what or _suggestion(machine, line.op))
        machine.define(POISON)
        return
    if not line.paren:
        _positional(machine, line, user if is_user else None)
    elif not line.closed:
        machine.never_closed(machine.span_of(line.arguments, line.arguments + 1))
        machine.define(POISON)
    elif is_user:
        _formal_user(machine, line, user)
    else:
        _formal_standard(machine, line)


def _suggestion(machine: Machine, op: str) -> str:
    names = [*IL_WORDS, *functions.names(), *machine.scope.callables()]
    return suggest(op, names)


def _positional(machine: Machine, line: Line, user: Signature | None) -> None:
    values = [(machine.operands.value(start, end), machine.span_of(start, end))
              for start, end in machine.scanner.split(line.start, line.end)]
    if any(value is None for value, _ in values):
        machine.define(POISON)
        return
    if user is None:
        if machine.use(line.op):
            standard(machine, line.op, tuple(v for v, _ in values))
        return
    _positional_user(machine, user, values)


def _positional_user(machine: Machine, user: Signature, values: list) -> None:
    wanted = user.inputs[1:]
    if user.in_outs:
        _in_outs_missing(machine, user, [p.name for p in user.in_outs])
        return
    if len(values) > len(wanted):
        call_findings.too_many(machine.diagnostics, values[len(wanted)][1], user.name, len(wanted))
        machine.define(POISON)
        return
    args = [coerced(machine, v, p.type, span, f"pin `{p.name}`") for (v, span), p in zip(values, wanted)]
    args += [_default(p) for p in wanted[len(values):]]
    if user.inputs:
        if not machine.use(user.name) or not machine.convert(user.inputs[0].type, user.name):
            return
    if None in args:
        machine.define(POISON)
        return
    _apply(machine, user.name.upper(), args, user.result)


def _apply(machine: Machine, name: str, args: list, result: Type) -> None:
    """FN on the accumulator; arguments that must be widened are computed before, around it."""
    if any(isinstance(a, Apply) for a in args):
        kept = machine.temp(machine.acc.type)
        machine.emit("ST", kept, kept.type)
        operands = tuple(spill(machine, a) for a in args)
        machine.emit("LD", kept, kept.type)
    else:
        operands = tuple(spill(machine, a) for a in args)
    machine.emit("FN", None, result, name, operands)
    machine.acc.set(result)


def standard(machine: Machine, name: str, values: tuple[Operand, ...]) -> None:
    """A standard function on the accumulator and ``values``."""
    acc = machine.acc
    first = Load(Place("", acc.type)) if acc.type is not None else Untyped(
        next(literal.value for _, literal, _ in acc.loose if literal is not None), machine.at)
    loads = tuple(Load(v) if isinstance(v, Place) else v for v in values)
    resolved = expressions.resolve(name, (first, *loads))
    if isinstance(resolved, str):
        type_findings.no_such_operation(machine.diagnostics, machine.at, resolved)
        machine.define(POISON)
        return
    args = [coerce(v, t, machine.diagnostics, machine.at) for v, t in zip(loads, resolved.parameters[1:])]
    if None in args:
        machine.define(POISON)
    elif machine.convert(resolved.parameters[0], name) and resolved.name != "MOVE":
        _apply(machine, resolved.name, args, resolved.result)


def _formal_standard(machine: Machine, line: Line) -> None:
    enabling = Enabling(machine)
    arguments = [a for a in machine.scanner.arguments(line.arguments + 1, line.end) if not enabling.add(a)]
    formal = functions.pins(line.op, max(len(arguments), _least(line.op)))
    found: dict[int, tuple[Operand, Argument]] = {}
    fine = True
    for number, argument in enumerate(arguments):
        span = name_span(machine, argument)
        at = number if argument.name is None else _index(formal, argument.name)
        given = argument.start < argument.end
        value = machine.operands.value(argument.start, argument.end) if given else None
        if at is None or argument.output:
            call_findings.unknown_pin(machine.diagnostics, span, line.op, argument.name or span.text,
                                      "its pins are " + ", ".join(formal))
        elif at in found:
            call_findings.pin_twice(machine.diagnostics, span, formal[at], "given again",
                                    name_span(machine, found[at][1]), "leave one of the two out")
        elif not given:
            findings.operand_missing(machine.diagnostics, span, formal[at], "a value")
        elif value is not None:
            found[at] = value, argument
            continue
        fine = False
    missing = [pin for n, pin in enumerate(formal) if n not in found]
    if fine and missing:
        call_findings.pin_missing(machine.diagnostics, machine.at, line.op, missing, "give every pin a value")
        fine = False
    if not fine:
        machine.define(POISON)
        return
    values = [found[n][0] for n in sorted(found)]
    loads = tuple(Load(v) if isinstance(v, Place) else v for v in values)
    resolved = expressions.resolve(line.op, loads)
    if isinstance(resolved, str):
        type_findings.no_such_operation(machine.diagnostics, machine.at, resolved)
        machine.define(POISON)
        return
    args = [coerce(v, t, machine.diagnostics, machine.at) for v, t in zip(loads, resolved.parameters)]
    if None in args:
        machine.define(POISON)
        return
    _invoke(machine, resolved.name, args, resolved.result, (), enabling)


def _least(name: str) -> int:
    row = functions.lookup(name)
    return row.least if row is not None else 1


def _index(pins: tuple[str, ...], name: str) -> int | None:
    key = name.upper()
    return pins.index(key) if key in pins else None


def _formal_user(machine: Machine, line: Line, user: Signature) -> None:
    arguments, enabling = apart(machine, machine.scanner.arguments(line.arguments + 1, line.end), user)
    given = pins(machine, arguments, user)
    values = {p.name: argument_value(machine, a, p) for p, a in given if not a.output}
    missing = [p.name for p in user.in_outs if p.name not in values]
    if missing:
        _in_outs_missing(machine, user, missing)
        return
    outputs = []
    for parameter, argument in given:
        if argument.output or parameter in user.in_outs:
            target = machine.operands.place(argument.start, argument.end, write=True)
            if target is not None and target.type != parameter.type:
                type_findings.mismatch(machine.diagnostics, machine.span_of(argument.start, argument.end),
                                       target.type, parameter.type, f"`{target}`")
            outputs.append((parameter.name, target))
    if None in values.values() or any(target is None for _, target in outputs):
        machine.define(POISON)
        return
    args = [values.get(p.name) or _default(p) for p in (*user.inputs, *user.in_outs)]
    _invoke(machine, user.name.upper(), args, user.result, tuple(outputs), enabling)


def _in_outs_missing(machine: Machine, user: Signature, names: list[str]) -> None:
    call_findings.pin_missing(machine.diagnostics, machine.at, user.name, names,
                              "give each VAR_IN_OUT a variable by name: "
                              f"`{user.name}({names[0]} := variable)`")
    machine.define(POISON)


def _invoke(machine: Machine, name: str, args: list, result: Type, outputs, enabling: Enabling) -> None:
    """FN with all arguments given by name: the first is loaded, whatever the accumulator held."""
    enabling.begin(result)
    operands = tuple(spill(machine, a) for a in args[1:])
    if name in DIVISIONS:
        enabling.divide(operands[0], result)
    machine.define(None)
    if args:
        load(machine, args[0])
    if name != "MOVE":
        machine.emit("FN", None, result, name, operands, outputs)
    enabling.end()
    machine.acc.set(result)


def _default(parameter: Parameter) -> Const:
    value = default(parameter.type) if parameter.initial is None else parameter.initial
    return Const(value, parameter.type)
