"""Calls in IL text: instances of function blocks and functions, with and without names of pins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ldc.expr import Apply, Const, Load, Place
from ldc.il import findings
from ldc.il.accumulator import POISON
from ldc.il.operands import Operand, member
from ldc.il.scan import Argument, Line
from ldc.library import functions
from ldc.model import call_findings, expressions, type_findings
from ldc.model.names import suggest
from ldc.model.values import Untyped, coerce, same
from ldc.source import Span
from ldc.symbols import Parameter, Signature
from ldc.types import Instance, Type, default

if TYPE_CHECKING:
    from ldc.il.reader import Reader

# Input operators of the standard blocks (2nd edition, table 54): they set a pin and call.
_INPUT_OPERATORS = frozenset("S R S1 R1 CLK CU CD LD PV IN PT".split())
_OPERATORS = ("LD LDN ST STN S R AND ANDN OR ORN XOR XORN NOT ADD SUB MUL DIV MOD GT GE EQ NE LE LT "
              "JMP JMPC JMPCN CAL CALC CALCN RET RETC RETCN").split()


# -- instances


def input_operator(reader: Reader, line: Line) -> bool:
    """``S1 latch`` is ``ST latch.S1`` and ``CAL latch``; False when the operand is no instance."""
    if line.op not in _INPUT_OPERATORS or line.start == line.end or line.paren:
        return False
    text = reader.operands.source.text[line.start:line.end]
    variable = reader.scope.variable(text.split(".")[0].split("[")[0].strip().upper())
    if variable is None or not _holds_instances(variable[0].type):
        return False
    place = reader.operands.place(line.start, line.end, write=False)
    if place is None or not isinstance(place.type, Instance):
        return False
    signature = reader.scope.signature(place.type.pou)
    pin = next((p for p in signature.inputs if p.name.upper() == line.op), None) if signature else None
    if pin is None:
        return False
    if reader.use(line.op) and reader.convert(pin.type, line.op):
        reader.emit("ST", member(place, pin.name, pin.type), pin.type)
        reader.emit("CAL", place, place.type)
    reader.define(None)
    return True


def _holds_instances(type_: Type) -> bool:
    while hasattr(type_, "element"):
        type_ = type_.element
    return isinstance(type_, Instance) or hasattr(type_, "fields")


def instance(reader: Reader, line: Line) -> None:
    """``CAL timer`` or ``CAL timer(IN := a, PT := T#1s, Q => b)``: values to the pins, the call, pins out."""
    with_arguments = line.arguments >= 0
    end = line.arguments if with_arguments else line.end
    while end > line.start and reader.operands.source.text[end - 1].isspace():
        end -= 1
    place = reader.operands.place(line.start, end, write=False)
    if place is None or not isinstance(place.type, Instance):
        if place is not None:
            findings.not_callable(reader.diagnostics, reader.span_of(line.start, end), line.op,
                                  f"this is {type_findings.described(place.type)}")
        reader.define(None)
        return
    conditional = line.op != "CAL"
    if conditional and not reader.condition(line.op):
        return
    if not with_arguments:
        reader.emit(line.op, place, place.type)
        if not conditional:
            reader.define(None)
        return
    signature = reader.scope.signature(place.type.pou)
    given = _pins(reader, line, signature)
    skip = ""
    if conditional:
        skip = reader.label()
        reader.emit("JMPCN" if line.op == "CALC" else "JMPC", name=skip)
    for parameter, argument in given:
        if not argument.output:
            _set_pin(reader, place, parameter, argument)
    reader.emit("CAL", place, place.type)
    for parameter, argument in given:
        if argument.output or parameter in signature.in_outs:
            _take_pin(reader, place, parameter, argument)
    if skip:
        reader.emit("LABEL", name=skip)
    reader.define(None)


def _pins(reader: Reader, line: Line, signature: Signature) -> list[tuple[Parameter, Argument]]:
    """The arguments with the pins that they are for; without names in declared order."""
    order = (*signature.inputs, *signature.in_outs, *signature.outputs)
    found: dict[str, tuple[Parameter, Argument]] = {}
    arguments = reader.scanner.arguments(line.arguments + 1, line.end)
    for number, argument in enumerate(arguments):
        span = _name_span(reader, argument)
        if argument.name is not None:
            parameter = signature.pin(argument.name)
        elif number < len(order):
            parameter = order[number]
            argument = Argument(None, argument.start, argument.end, parameter in signature.outputs,
                                name_start=argument.name_start)
        else:
            call_findings.too_many(reader.diagnostics, span, signature.name, len(order))
            break
        if parameter is None:
            call_findings.unknown_pin(reader.diagnostics, span, signature.name, argument.name,
                                      suggest(argument.name, (p.name for p in order)))
        elif parameter.name.upper() in found:
            call_findings.pin_twice(reader.diagnostics, span, parameter.name, "given again",
                                    _name_span(reader, found[parameter.name.upper()][1]), "leave one of the two out")
        elif parameter not in signature.in_outs and argument.output != (parameter in signature.outputs):
            call_findings.wrong_direction(reader.diagnostics, span, parameter.name, not argument.output)
        else:
            found[parameter.name.upper()] = parameter, argument
    return list(found.values())


def _name_span(reader: Reader, argument: Argument) -> Span:
    if argument.name is None:
        return reader.span_of(argument.start, argument.end)
    return reader.span_of(argument.name_start, argument.name_start + len(argument.name))


def _set_pin(reader: Reader, place: Place, parameter: Parameter, argument: Argument) -> None:
    if parameter in reader.scope.signature(place.type.pou).in_outs:
        target = reader.operands.place(argument.start, argument.end, write=True)
        if target is not None and not same(target.type, parameter.type):
            type_findings.mismatch(reader.diagnostics, reader.span_of(argument.start, argument.end),
                                   parameter.type, target.type, f"pin `{parameter.name}`")
    value = _argument(reader, argument, parameter)
    if value is not None:
        _load(reader, value)
        reader.emit("ST", member(place, parameter.name, parameter.type), parameter.type)


def _take_pin(reader: Reader, place: Place, parameter: Parameter, argument: Argument) -> None:
    target = reader.operands.place(argument.start, argument.end, write=True)
    if target is None:
        return
    pin = member(place, parameter.name, parameter.type)
    value = coerce(Load(pin), target.type, reader.diagnostics, _name_span(reader, argument),
                   f"`{target}`")
    if value is None:
        return
    _load(reader, value)
    if argument.negated and reader.check("NOT", target.type):
        reader.emit("NOT", None, target.type)
    reader.emit("ST", target, target.type)


def _argument(reader: Reader, argument: Argument, parameter: Parameter) -> Const | Load | Apply | None:
    """The value of an argument in the type of its pin."""
    span = reader.span_of(argument.start, argument.end)
    if argument.start == argument.end:
        findings.operand_missing(reader.diagnostics, _name_span(reader, argument), parameter.name, "a value")
        return None
    value = reader.operands.value(argument.start, argument.end, parameter.type)
    return _coerced(reader, value, parameter.type, span, f"pin `{parameter.name}`")


def _coerced(reader: Reader, value: Operand | None, wanted: Type, span: Span, what: str):
    if value is None:
        return None
    return coerce(Load(value) if isinstance(value, Place) else value, wanted, reader.diagnostics, span, what)


def _load(reader: Reader, value: Const | Load | Apply) -> None:
    """LD of a value, and the function that widens it."""
    inner = value.args[0] if isinstance(value, Apply) else value
    reader.emit("LD", inner.place if isinstance(inner, Load) else inner, inner.type)
    if isinstance(value, Apply):
        reader.emit("FN", None, value.type, value.op)


def _spill(reader: Reader, value: Const | Load | Apply) -> Const | Place:
    """The value as an operand; one that has to be widened goes through a temporary."""
    if isinstance(value, Apply):
        _load(reader, value)
        place = reader.temp(value.type)
        reader.emit("ST", place, value.type)
        return place
    return value.place if isinstance(value, Load) else value


# -- functions


def function(reader: Reader, line: Line) -> None:
    """A line that begins with the name of a function: the accumulator is the first argument, or all
    arguments stand in parentheses with their names."""
    if input_operator(reader, line):
        return
    user = reader.scope.signature(line.op)
    is_user = user is not None and user.kind == "FUNCTION"
    name = reader.span_of(line.op_start, line.op_end)
    if not is_user and not functions.is_function(line.op):
        what = "a function block is called by CAL and the name of an instance" if user is not None else ""
        findings.unknown_instruction(reader.diagnostics, name, name.text, what or _suggestion(reader, line.op))
        reader.define(POISON)
        return
    if not line.paren:
        _positional(reader, line, user if is_user else None)
    elif not line.closed:
        reader.never_closed(reader.span_of(line.arguments, line.arguments + 1))
        reader.define(POISON)
    elif is_user:
        _formal_user(reader, line, user)
    else:
        _formal_standard(reader, line)


def _suggestion(reader: Reader, op: str) -> str:
    names = [*_OPERATORS, *functions.names(), *reader.scope.callables()]
    return suggest(op, names)


def _positional(reader: Reader, line: Line, user: Signature | None) -> None:
    values = [(reader.operands.value(start, end), reader.span_of(start, end))
              for start, end in reader.scanner.split(line.start, line.end)]
    if any(value is None for value, _ in values):
        reader.define(POISON)
        return
    if user is None:
        if reader.use(line.op):
            standard(reader, line.op, tuple(v for v, _ in values))
        return
    _positional_user(reader, user, values)


def _positional_user(reader: Reader, user: Signature, values: list) -> None:
    wanted = user.inputs[1:]
    if len(values) > len(wanted):
        call_findings.too_many(reader.diagnostics, values[len(wanted)][1], user.name, len(wanted))
        reader.define(POISON)
        return
    args = [_coerced(reader, v, p.type, span, f"pin `{p.name}`") for (v, span), p in zip(values, wanted)]
    args += [_default(p) for p in wanted[len(values):]]
    if user.inputs:
        if not reader.use(user.name) or not reader.convert(user.inputs[0].type, user.name):
            return
    if None in args:
        reader.define(POISON)
        return
    _apply(reader, user.name.upper(), args, user.result)


def _apply(reader: Reader, name: str, args: list, result: Type) -> None:
    """FN on the accumulator; arguments that must be widened are computed before, around it."""
    if any(isinstance(a, Apply) for a in args):
        kept = reader.temp(reader.acc.type)
        reader.emit("ST", kept, kept.type)
        operands = tuple(_spill(reader, a) for a in args)
        reader.emit("LD", kept, kept.type)
    else:
        operands = tuple(_spill(reader, a) for a in args)
    reader.emit("FN", None, result, name, operands)
    reader.acc.set(result)


def standard(reader: Reader, name: str, values: tuple[Operand, ...]) -> None:
    """A standard function on the accumulator and ``values``."""
    acc = reader.acc
    first = Load(Place("", acc.type)) if acc.type is not None else Untyped(
        next(literal.value for _, literal, _ in acc.loose if literal is not None), reader.at)
    loads = tuple(Load(v) if isinstance(v, Place) else v for v in values)
    resolved = expressions.resolve(name, (first, *loads))
    if isinstance(resolved, str):
        type_findings.no_such_operation(reader.diagnostics, reader.at, resolved)
        reader.define(POISON)
        return
    args = [coerce(v, t, reader.diagnostics, reader.at) for v, t in zip(loads, resolved.parameters[1:])]
    if None in args:
        reader.define(POISON)
    elif reader.convert(resolved.parameters[0], name) and resolved.name != "MOVE":
        _apply(reader, resolved.name, args, resolved.result)


def _formal_standard(reader: Reader, line: Line) -> None:
    arguments = reader.scanner.arguments(line.arguments + 1, line.end)
    pins = functions.pins(line.op, max(len(arguments), _least(line.op)))
    found: dict[int, tuple[Operand, Argument]] = {}
    fine = True
    for number, argument in enumerate(arguments):
        span = _name_span(reader, argument)
        at = number if argument.name is None else _index(pins, argument.name)
        value = reader.operands.value(argument.start, argument.end) if argument.start < argument.end else None
        if at is None or argument.output:
            call_findings.unknown_pin(reader.diagnostics, span, line.op, argument.name or span.text,
                                      "its pins are " + ", ".join(pins))
        elif at in found:
            call_findings.pin_twice(reader.diagnostics, span, pins[at], "given again",
                                    _name_span(reader, found[at][1]), "leave one of the two out")
        elif argument.start == argument.end:
            findings.operand_missing(reader.diagnostics, span, pins[at], "a value")
        elif value is not None:
            found[at] = value, argument
            continue
        fine = False
    missing = [pin for n, pin in enumerate(pins) if n not in found]
    if fine and missing:
        call_findings.pin_missing(reader.diagnostics, reader.at, line.op, missing, "give every pin a value")
        fine = False
    if not fine:
        reader.define(POISON)
        return
    values = [found[n][0] for n in sorted(found)]
    loads = tuple(Load(v) if isinstance(v, Place) else v for v in values)
    resolved = expressions.resolve(line.op, loads)
    if isinstance(resolved, str):
        type_findings.no_such_operation(reader.diagnostics, reader.at, resolved)
        reader.define(POISON)
        return
    args = [coerce(v, t, reader.diagnostics, reader.at) for v, t in zip(loads, resolved.parameters)]
    if None in args:
        reader.define(POISON)
        return
    _invoke(reader, resolved.name, args, resolved.result, ())


def _least(name: str) -> int:
    row = functions.lookup(name)
    return row.least if row is not None else 1


def _index(pins: tuple[str, ...], name: str) -> int | None:
    key = name.upper()
    return pins.index(key) if key in pins else None


def _formal_user(reader: Reader, line: Line, user: Signature) -> None:
    given = _pins(reader, line, user)
    values = {p.name: _argument(reader, a, p) for p, a in given if not a.output}
    outputs = []
    for parameter, argument in given:
        if argument.output:
            target = reader.operands.place(argument.start, argument.end, write=True)
            if target is not None and target.type != parameter.type:
                type_findings.mismatch(reader.diagnostics, reader.span_of(argument.start, argument.end),
                                       target.type, parameter.type, f"`{target}`")
            outputs.append((parameter.name, target))
    if None in values.values() or any(target is None for _, target in outputs):
        reader.define(POISON)
        return
    args = [values.get(p.name) or _default(p) for p in user.inputs]
    _invoke(reader, user.name.upper(), args, user.result, tuple(outputs))


def _invoke(reader: Reader, name: str, args: list, result: Type, outputs) -> None:
    """FN with all arguments given by name: the first is loaded, whatever the accumulator held."""
    operands = tuple(_spill(reader, a) for a in args[1:])
    reader.define(None)
    if args:
        _load(reader, args[0])
    if name != "MOVE":
        reader.emit("FN", None, result, name, operands, outputs)
    reader.acc.set(result)


def _default(parameter: Parameter) -> Const:
    value = default(parameter.type) if parameter.initial is None else parameter.initial
    return Const(value, parameter.type)


