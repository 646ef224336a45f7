"""Operators of IL text: two sides with one type, on the line or between parentheses."""

from __future__ import annotations

from ldc.expr import Const, Place
from ldc.il import findings, function_calls
from ldc.il.accumulator import POISON, Accumulator, Open, base, common, plain
from ldc.il.values import typed_function
from ldc.il.machine import Machine, conversion_line
from ldc.il.operands import Operand
from ldc.il.program import COMPARISON, LOGIC, Instr
from ldc.il.scan import Line
from ldc.library import functions
from ldc.model.type_findings import described
from ldc.model.values import AnyEnum, Untyped, same, settle
from ldc.records import replace
from ldc.types import BOOL, TIME, Type, storage

_DEEPEST = 100


def operator(machine: Machine, line: Line) -> None:
    op = line.op.replace("&", "AND")
    if line.paren:
        _open(machine, line, op)
        return
    if not machine.operand(line):
        return
    parts = machine.scanner.split(line.start, line.end)
    if len(parts) > 1 and op not in ("ADD", "MUL", *LOGIC):
        findings.malformed(machine.diagnostics, machine.span_of(*parts[1]), f"`{op}` takes one operand",
                           "write one instruction for each")
        machine.acc.set(POISON)
        return
    for start, end in parts:
        value = machine.value(start, end)
        if not machine.use(op):
            return
        operate(machine, op, value)


def operate(machine: Machine, op: str, value: Operand | None) -> None:
    """Joins the accumulator with a value."""
    acc = machine.acc
    if isinstance(value, Untyped) and acc.type is not None:
        wanted = acc.type
        if wanted == TIME and op in ("MUL", "DIV"):
            wanted = None
        value = settle(value, wanted, machine.diagnostics)
    elif isinstance(value, AnyEnum):
        value = settle(value, acc.type, machine.diagnostics)
    if value is None:
        acc.set(POISON)
    elif isinstance(value, Untyped):
        acc.literal = None
        acc.loose.append((len(machine.code), value, True))
        machine.emit(op)
        _finish(machine, op)
    elif not acc.loose or acc.settle(base(value.type), machine.code, machine.diagnostics):
        _join(machine, op, value)


def _join(machine: Machine, op: str, value: Const | Place) -> None:
    left, right = machine.acc.type, base(value.type)
    mixed = typed_function(op, (left, right))
    if mixed is not None:
        function_calls.standard(machine, mixed, (value,))
        return
    type_ = common(left, right)
    if type_ is None:
        _cannot_join(machine, op, left, right)
        return
    if not machine.convert(type_, op) or not machine.check(plain(op), type_):
        return
    if same(right, type_):
        machine.emit(op, value, type_)
    else:
        machine.emit(op + "(", value, type_)
        machine.emit("FN", None, type_, functions.conversion(storage(right), storage(type_)))
        machine.emit(")", None, type_)
    machine.acc.set(BOOL if op in COMPARISON else type_)


def _finish(machine: Machine, op: str) -> None:
    """After an operator on literals only: a comparison has to decide their type now."""
    if op in COMPARISON:
        if machine.acc.settle(machine.acc.natural(), machine.code, machine.diagnostics):
            machine.acc.set(BOOL)


def _cannot_join(machine: Machine, op: str, left: Type, right: Type) -> None:
    if plain(op.removesuffix("(")) in LOGIC:
        help = "compare numbers first, for example by `GT 0`" if BOOL in (left, right) else ""
    else:
        help = conversion_line(left, right) or conversion_line(right, left, "convert the operand by `")
    findings.wrong_types(machine.diagnostics, machine.at,
                         f"`{op}` cannot join {described(left)} with {described(right)}",
                         f"the accumulator holds {described(left)}", help)
    machine.acc.set(POISON)


def _open(machine: Machine, line: Line, op: str) -> None:
    machine.use(op + "(")
    if len(machine.stack) == _DEEPEST:
        findings.too_deep(machine.diagnostics, machine.at, _DEEPEST)
    machine.stack.append(Open(op, len(machine.code), machine.acc, machine.at))
    machine.acc = Accumulator()
    value = machine.value(line.start, line.end, whole=True) if line.start < line.end else None
    if line.start < line.end:
        machine.load(op + "(", value)
        machine.acc.loose = [(index, literal, False) for index, literal, _ in machine.acc.loose]
        machine.acc.literal = None
    else:
        machine.emit(op + "(")


def close(machine: Machine, line: Line) -> None:
    machine.nothing_more(line)
    closing(machine)


def closing(machine: Machine) -> None:
    if not machine.stack:
        if machine.forgiven == 0:
            findings.unbalanced(machine.diagnostics, machine.at, "nothing is open here", "take it away")
        machine.forgiven = max(0, machine.forgiven - 1)
        return
    defined = machine.acc.defined
    machine.use(")")
    opened, inner = machine.stack.pop(), machine.acc
    machine.acc = opened.before
    if not defined or inner.poisoned or machine.acc.poisoned:
        machine.acc.set(POISON)
        return
    _combine(machine, opened, inner)


def _combine(machine: Machine, opened: Open, inner: Accumulator) -> None:
    op, outer = opened.op, machine.acc
    outer.literal = None
    if inner.loose and outer.loose:
        outer.loose += [*inner.loose, (opened.index, None, True), (len(machine.code), None, True)]
        machine.emit(")")
        _finish(machine, op)
        return
    if inner.loose and not inner.settle(outer.type, machine.code, machine.diagnostics) or (
            outer.loose and not outer.settle(inner.type, machine.code, machine.diagnostics)):
        outer.set(POISON)
        return
    left, right = outer.type, inner.type
    type_ = common(left, right)
    if type_ is None:
        _cannot_join(machine, op + "(", left, right)
        return
    if not machine.check(plain(op), type_):
        return
    if not same(right, type_):
        machine.emit("FN", None, type_, functions.conversion(storage(right), storage(type_)))
    machine.code[opened.index] = replace(machine.code[opened.index], type=type_)
    if not same(left, type_):
        name = functions.conversion(storage(left), storage(type_))
        machine.code.insert(opened.index, Instr("FN", None, type_, name, span=opened.span))
    machine.emit(")", None, type_)
    machine.acc.set(BOOL if op in COMPARISON else type_)


def negate(machine: Machine, line: Line) -> None:
    machine.nothing_more(line)
    if machine.use("NOT") and machine.convert_loose(BOOL) and machine.check("NOT", machine.acc.type):
        machine.emit("NOT", None, machine.acc.type)
        machine.acc.literal = None
