"""Types of expressions: names and operators of the AST become typed expressions (IEC 61131-3 3.3.1).

Chains of operators may be a thousand long: they are walked in loops, only brackets nest.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache

from ldc.diagnostics import Diagnostics
from ldc.expr import SHORT_CIRCUIT, Apply, Const, Expr, Load, nodes
from ldc.library import functions
from ldc.library.faults import DivisionByZero
from ldc.model import calls, integer_bits, parts, places
from ldc.model import type_findings as findings
from ldc.model.environment import Environment
from ldc.model.names import suggest
from ldc.model.values import (
    AnyEnum,
    NetValue,
    Untyped,
    Value,
    as_number,
    coerce,
    converted,
    counting,
    fits,
    literal,
    natural,
    storable,
    unsigned,
)
from ldc.parser import ast
from ldc.source import Span
from ldc.types import (
    BOOL,
    LREAL,
    REAL,
    TIME,
    Array,
    Elementary,
    Enum,
    Instance,
    Scalar,
    String,
    Struct,
    Type,
    is_scalar,
    storage,
)

OPERATORS = {
    "OR": "OR", "XOR": "XOR", "AND": "AND", "=": "EQ", "<>": "NE", "<": "LT", ">": "GT", "<=": "LE",
    ">=": "GE", "+": "ADD", "-": "SUB", "*": "MUL", "/": "DIV", "MOD": "MOD", "**": "EXPT",
    "AND_THEN": "AND_THEN", "OR_ELSE": "OR_ELSE",
}
LOGIC = frozenset(("AND", "OR", "XOR"))
ARITHMETIC = frozenset(("ADD", "SUB", "MUL", "DIV", "MOD", "EXPT"))
COMPARISONS = frozenset(("EQ", "NE", "LT", "GT", "LE", "GE"))
DIVISIONS = frozenset(("DIV", "MOD", "DIVTIME"))
_COUNTING = (ARITHMETIC | COMPARISONS) - {"EXPT"}
_UNDECIDED = (Untyped, AnyEnum)


def expression(
    env: Environment, node: ast.Expr, wanted: Type | None, diagnostics: Diagnostics, what: str = ""
) -> Expr | None:
    """The typed expression, converted to ``wanted`` when that is a widening; None after an error.

    ``what`` names what asks for the type, for messages (``pin `PT```).
    """
    found = value(env, node, wanted, diagnostics)
    if found is None:
        return None
    return coerce(found, wanted, diagnostics, node.span, what)


def value(env: Environment, node: ast.Expr, hint: Type | None, diagnostics: Diagnostics) -> Value | None:
    """Like ``expression``, but what has no type of its own stays undecided. ``hint`` is the type that
    the context would like; it decides nothing but the meaning of names of enumeration values."""
    return _TYPING[type(node)](env, node, hint, diagnostics)


def constant(env: Environment, expr: Expr) -> Scalar | None:
    """The value of a constant expression; None when it is known only at run time or divides by zero."""
    spine = []
    while type(expr) is Apply and not expr.user and expr.args:
        if expr.op in SHORT_CIRCUIT:
            return None
        spine.append(expr)
        expr = expr.args[0]
    result = _constant_leaf(env, expr)
    for step in reversed(spine):
        if result is None:
            return None
        arguments = (result, *[constant(env, a) for a in step.args[1:]])
        if None in arguments:
            return None
        try:
            result = functions.meaning(step.op, tuple(a.type for a in step.args), step.type)(*arguments)
        except DivisionByZero:
            return None
    return result


def _constant_leaf(env: Environment, expr: Expr) -> Scalar | None:
    if type(expr) is Const:
        return expr.value
    if type(expr) is Load and not expr.place.steps:
        found = env.variable(expr.place.root.upper())
        if found is not None and found[0].constant and is_scalar(found[0].type):
            return found[0].initial
    return None


# ---- names ------------------------------------------------------------------------------------


def _name(env: Environment, node: ast.Name, hint: Type | None, diagnostics: Diagnostics) -> Value | None:
    key = node.name.upper()
    found = env.variable(key)
    if found is not None:
        return Load(places.variable_place(found, node.span), node.span)
    choices = env.enum_values(key)
    if len(choices) > 1 and isinstance(hint, Enum):
        choices = tuple(c for c in choices if c[0] == hint) or choices
    if len(choices) == 1:
        return Const(choices[0][1], choices[0][0], node.span)
    if choices:
        return AnyEnum(node.name, choices, node.span)
    if isinstance(hint, Enum):
        number = next((n for name, n in hint.values if name.upper() == key), None)
        if number is not None:
            return Const(number, hint, node.span)
    if key == "PI":
        return Untyped(math.pi, node.span)  # of TwinCAT, unless the project declares it
    places.place(env, node, diagnostics)
    return None


def _place(env: Environment, node: ast.Expr, hint: Type | None, diagnostics: Diagnostics) -> Value | None:
    found = places.place(env, node, diagnostics)
    return None if found is None else Load(found, node.span)


def _member(env: Environment, node: ast.Member, hint: Type | None, diagnostics: Diagnostics) -> Value | None:
    """A member of a variable; `Type.value` of an enumeration is what `Type#value` is."""
    base = node.base
    if parts.is_part(node):
        found = parts.part(env, node, diagnostics)
        return None if found is None else parts.read(found, node.span)
    if type(base) is ast.Name and isinstance(named := env.type_named(base.name.upper()), Enum):
        # A variable may have the name of its type: then only what is no value of the type is one of its bits.
        hiding = env.variable(base.name.upper())
        value_of = any(node.name.upper() == name.upper() for name, _ in named.values)
        if hiding is None or value_of and isinstance(hiding[0].type, Enum):
            return _enum_literal(env, ast.EnumLiteral(base.name, node.name, node.span), hint, diagnostics)
    return _place(env, node, hint, diagnostics)


def _literal(
    env: Environment, node: ast.Literal, hint: Type | None, diagnostics: Diagnostics
) -> Value | None:
    return literal(node, env.type_named(node.type.upper()) if node.type else None, diagnostics)


def _enum_literal(
    env: Environment, node: ast.EnumLiteral, hint: Type | None, diagnostics: Diagnostics
) -> Value | None:
    type_ = env.type_named(node.type.upper())
    if not isinstance(type_, Enum):
        if not env.silent(node.type.upper()):
            findings.unknown_type_prefix(diagnostics, node.span, node.type)
        return None
    key = node.name.upper()
    for name, number in type_.values:
        if name.upper() == key:
            return Const(number, type_, node.span)
    findings.bad_enum_value(diagnostics, node.span, f"{type_} has no value `{node.name}`", "unknown value",
                            suggest(node.name, (name for name, _ in type_.values))
                            or "its values are " + ", ".join(name for name, _ in type_.values[:12]))
    return None


def _call(env: Environment, node: ast.Call, hint: Type | None, diagnostics: Diagnostics) -> Value | None:
    return calls.call(env, node, hint, diagnostics)


# ---- operators --------------------------------------------------------------------------------


def _unary(env: Environment, node: ast.Unary, hint: Type | None, diagnostics: Diagnostics) -> Value | None:
    chain = []
    while type(node) is ast.Unary:
        chain.append(node)
        node = node.operand
    result = value(env, node, hint, diagnostics)
    for step in reversed(chain):
        if result is None:
            return None
        if step.op == "-" and type(result) is Untyped:
            result = Untyped(-result.value, step.span)
        else:
            name = "NEG" if step.op == "-" else "NOT"
            result = apply(env, name, (_logic_operand(name, result, hint),), step.span, diagnostics,
                           hint if name == "NOT" and type(result) is Untyped else None)
    return result


def _binary(env: Environment, node: ast.Binary, hint: Type | None, diagnostics: Diagnostics) -> Value | None:
    spine = []
    while type(node) is ast.Binary:
        spine.append(node)
        node = node.left
    result = value(env, node, _beside(spine[-1].op, None, hint), diagnostics)
    for step in reversed(spine):
        right = value(env, step.right, _beside(step.op, result, hint), diagnostics)
        if result is not None:
            result = None if right is None else _combine(env, step, result, right, hint, diagnostics)
    return result


def _beside(operator: str, other: Value | None, hint: Type | None) -> Type | None:
    """What a literal in an operand of AND, OR, XOR becomes, as in `w AND NOT 16#4`: the bit string that the
    other operand is, or that the context asks for; of an integer in the same way."""
    if OPERATORS[operator] not in LOGIC:
        return None
    type_ = hint if other is None or type(other) in _UNDECIDED else storage(other.type)
    return type_ if isinstance(type_, Elementary) and type_.kind in ("bits", "int", "uint") else None


def _combine(
    env: Environment, node: ast.Binary, left: Value, right: Value, hint: Type | None, diagnostics: Diagnostics
) -> Value | None:
    name = OPERATORS[node.op]
    if name in SHORT_CIRCUIT:
        return _short_circuit(env, name, left, right, node.span, diagnostics)
    if type(left) is Untyped and type(right) is Untyped and name in ARITHMETIC:
        folded = _exact(name, left, right, node.span, diagnostics)
        if folded is not NotImplemented:
            return folded
    left, right = _logic_operand(name, left, hint), _logic_operand(name, right, hint)
    asked = hint if name in LOGIC and type(left) is type(right) is Untyped else None
    found = apply(env, name, (left, right), node.span, diagnostics, asked)
    if found is None or found.op != name:
        return found
    first = found.args[0]
    # a AND b AND c is one AND of three: the same value, and consumers need not go deep.
    if type(first) is Apply and first.op == name and first is left and first.type == found.type and (
        name in LOGIC or name in ("ADD", "MUL") and found.type.kind in ("int", "uint")
    ):
        return Apply(name, first.args + found.args[1:], found.type, found.span)
    return found


def _short_circuit(
    env: Environment, name: str, left: Value, right: Value, span: Span, diagnostics: Diagnostics
) -> Apply | None:
    """AND_THEN, OR_ELSE: on BOOL, and in statements, which alone have an order."""
    if not env.statements:
        findings.short_circuit(diagnostics, span, name)
        return None
    found = apply(env, name.partition("_")[0], (left, right), span, diagnostics)
    if found is None:
        return None
    if storage(found.type) != BOOL:
        findings.no_such_operation(diagnostics, span, f"{name} takes BOOL, not {found.type}",
                                   "write AND or OR")
        return None
    return Apply(name, found.args, found.type, span)


def _logic_operand(name: str, operand: Value, hint: Type | None) -> Value:
    """0 and 1 beside a logic operator are BOOL unless the context asks for a bit string."""
    if type(operand) is Untyped and (name in LOGIC or name == "NOT"):
        if isinstance(hint, Elementary) and hint.kind == "bits" and fits(operand.value, hint):
            return Const(operand.value, hint, operand.span)
    return operand


def _exact(name: str, left: Untyped, right: Untyped, span: Span, diagnostics: Diagnostics):
    """Arithmetic on numbers without a type is exact; NotImplemented when it has to be done in a type."""
    a, b = left.value, right.value
    if name in DIVISIONS and b == 0:
        findings.division_by_zero(diagnostics, right.span)
        return None
    integers = isinstance(a, int) and isinstance(b, int)
    try:
        match name:
            case "ADD":
                return Untyped(a + b, span)
            case "SUB":
                return Untyped(a - b, span)
            case "MUL":
                return Untyped(a * b, span)
            case "DIV" if integers:
                return Untyped(abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1), span)
            case "DIV":
                return Untyped(a / b, span)
            case "MOD" if integers:
                return Untyped(abs(a) % abs(b) * (-1 if a < 0 else 1), span)
    except OverflowError:
        findings.does_not_fit(diagnostics, span, "this number", REAL)
        return None
    return NotImplemented


@lru_cache(maxsize=4096)
def _resolve(name: str, types: tuple[Type | None, ...]):
    return functions.resolve(name, types)


def resolve(
    name: str, args: tuple[Value | NetValue, ...], hint: Type | None = None
) -> functions.Resolved | str:
    """How the library takes these arguments; its words when it does not.

    A literal takes the type that the other arguments decide, unless it does not fit in there: then it
    counts with its natural type. When nothing decides and the result is of no use to the context,
    literals, and nets that a loop feeds later, take the type that the context asks for (``hint``) where
    theirs is that of the result.
    """
    types = [None if type(a) in _UNDECIDED else a.type for a in args]
    floats, names, known_real, enum = [], [], False, None
    for at, (argument, type_) in enumerate(zip(args, types, strict=True)):
        if type_ is None:
            if type(argument) is AnyEnum:
                names.append(at)
            elif type(argument) is Untyped and isinstance(argument.value, float):
                floats.append(at)
        elif type_ is REAL or type_ is LREAL:
            known_real = True
        elif type(type_) is Enum:
            enum = type_
    if floats and not known_real:
        # 1.5 beside a REAL or LREAL takes that type, beside anything else it is a REAL.
        for at in floats:
            types[at] = REAL
    for at in names:
        types[at] = enum
    found = _resolve(name, tuple(types))
    loose = [at for at, a in enumerate(args) if type(a) is Untyped]
    fed_later = [at for at, a in enumerate(args) if type(a) is NetValue and a.type is None]
    if not loose and not fed_later:
        return found
    if hint is not None and (isinstance(found, str) or not storable(found.result, hint)):
        asked = [at for at in (*loose, *fed_later)
                 if isinstance(found, str) or found.parameters[at] == found.result]
        hinted = _resolve(name, _replaced(types, asked, lambda at: storage(hint)))
        if not isinstance(hinted, str) and storable(hinted.result, hint):
            return hinted
    if isinstance(found, str) or all(fits(args[at].value, found.parameters[at]) for at in loose):
        return found
    retried = _resolve(name, _replaced(types, loose, lambda at: natural(args[at].value)))
    return found if isinstance(retried, str) else retried


def _replaced(
    types: list[Type | None], places: list[int], by: Callable[[int], Type]
) -> tuple[Type | None, ...]:
    return tuple(by(at) if at in places else type_ for at, type_ in enumerate(types))


def apply(
    env: Environment, name: str, args: tuple[Value, ...], span: Span, diagnostics: Diagnostics,
    hint: Type | None = None,
) -> Apply | None:
    """A standard function or operator on typed or undecided values."""
    if name == "MUL" and _time_last(args) and not all(map(_writes, args)):
        args = (args[1], args[0])
    resolved = resolve(name, args, hint)
    if isinstance(resolved, str) and (counted := _counted(env, name, args, span, diagnostics)) is not None:
        return counted
    if name in integer_bits.OPERATORS and (isinstance(resolved, str) or type(args[0]) is Untyped):
        taken = integer_bits.taken(name, args, hint, diagnostics)
        if taken is not None:
            return _on_bits(env, name, taken, span, diagnostics)
    if isinstance(resolved, str):
        findings.no_such_operation(diagnostics, span, resolved, _operation_help(name, args))
        return None
    typed = tuple([coerce(a, t, diagnostics, a.span or span)
                   for a, t in zip(args, resolved.parameters, strict=True)])
    if None in typed:
        return None
    if name in DIVISIONS and constant(env, typed[1]) == 0:
        findings.division_by_zero(diagnostics, typed[1].span or span)
        return None
    return Apply(resolved.name, typed, resolved.result, span)


def _counted(
    env: Environment, name: str, args: tuple[Value, ...], span: Span, diagnostics: Diagnostics
) -> Apply | None:
    """Bit strings that an operator takes for unsigned numbers, as other editors do: among themselves and with
    literals the result is a bit string of the largest size, with other numbers it is a number, as values of
    an enumeration are. None when it is something else that does not fit."""
    if name not in _COUNTING or any(type(a) is AnyEnum for a in args):
        return None
    numbers = []
    largest, enum, mixed = None, None, False
    for arg in args:
        if type(arg) is not Untyped and isinstance(arg.type, Enum):
            if enum is not None and arg.type != enum:
                return None
            enum, mixed = arg.type, True
            numbers.append(converted(arg, counting(enum)))
            continue
        own = None if type(arg) is Untyped else unsigned(arg.type)
        if own is None:
            mixed |= type(arg) is not Untyped
            numbers.append(arg)
            continue
        number = as_number(arg, own)
        if largest is None or own.bits > unsigned(largest).bits:
            largest = storage(arg.type)
        numbers.append(number)
    if largest is None and enum is None or isinstance(resolve(name, tuple(numbers)), str):
        return None
    found = apply(env, name, tuple(numbers), span, diagnostics)
    if found is None:
        return None
    if enum is not None:
        findings.enumerated(diagnostics, span, enum, counting(enum))
    if largest is None:
        return found
    findings.counted(diagnostics, span, largest, unsigned(largest))
    back = not mixed and found.type is unsigned(largest)
    return as_number(found, largest) if back else found


def _on_bits(
    env: Environment, name: str, taken: integer_bits.Taken, span: Span, diagnostics: Diagnostics
) -> Expr | None:
    found = apply(env, name, taken.args, span, diagnostics)
    if found is not None and taken.told:
        findings.counted(diagnostics, span, taken.number, found.type)
    return found if found is None or taken.mixed else converted(found, taken.number, span)


def _time_last(args: tuple[Value, ...]) -> bool:
    """Whether these are a number and a TIME, `n * T#1s`: the library takes the TIME first."""
    if len(args) != 2 or any(type(a) is AnyEnum for a in args):
        return False
    number, time = args
    if type(time) is Untyped or storage(time.type) != TIME:
        return False
    if type(number) is not Untyped and (number.type is None or storage(number.type) == TIME):
        return False
    return True


def _writes(value: Value) -> bool:
    """Whether a FUNCTION is called that writes variables of the caller."""
    return any(type(node) is Apply and node.outputs for node in nodes(value))


def _operation_help(name: str, args: tuple[Value, ...]) -> str:
    if name == "MUL" and _time_last(args):
        return ("write the TIME first, or put one of them into a variable before: "
                "both call functions that write")
    types = [a.type for a in args if type(a) not in _UNDECIDED]
    if any(isinstance(t, Instance) for t in types):
        return "name one of the outputs of the block, `instance.pin`"
    if name == "ADD" and any(isinstance(t, String) for t in types):
        return "texts are joined by `CONCAT(a, b)`"
    if any(isinstance(t, Array | Struct) for t in types):
        return "take single elements or members"
    if name in LOGIC or name == "NOT":
        return "compare numbers first, for example `level > 0`" if any(t != BOOL for t in types) else ""
    if len(types) == 2 and types[0] != types[1]:
        return findings.conversion_help(types[1], types[0])
    return ""


_TYPING = {
    ast.Name: _name,
    ast.Literal: _literal,
    ast.EnumLiteral: _enum_literal,
    ast.Direct: _place,
    ast.Member: _member,
    ast.Index: _place,
    ast.Unary: _unary,
    ast.Binary: _binary,
    ast.Call: _call,
}
