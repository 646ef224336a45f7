"""Initial values: constant expressions and aggregates, computed and completed (IEC 61131-3 2.4.3.2)."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.expr import Apply, Const, Expr, Load
from ldc.model import declaration_findings as findings
from ldc.model import expressions
from ldc.model.environment import Environment
from ldc.model.names import suggest
from ldc.model.type_findings import described, does_not_fit
from ldc.model.values import coerce, const_fits, fits
from ldc.parser import ast
from ldc.types import Array, Elementary, Enum, Instance, Scalar, Struct, Type, Value, default, storage


def scalar(
    env: Environment, node: ast.Expr, type_: Type | None, diagnostics: Diagnostics, what: str
) -> Const | None:
    """The value of a constant expression in the type that is asked for; None after an error."""
    found = computed(env, node, type_, diagnostics, what)
    if found is None or type(found) is Const:
        return found
    findings.not_constant(diagnostics, node.span, what)
    return None


def computed(
    env: Environment, node: ast.Expr, type_: Type | None, diagnostics: Diagnostics, what: str
) -> Expr | None:
    """The expression in the type that is asked for: a Const where it is constant; None after an error."""
    value = expressions.value(env, node, type_, diagnostics)
    if value is None:
        return None
    known = _known_integer(env, value, type_)
    if known is not None:
        return Const(known, storage(type_), node.span)
    expr = coerce(value, type_, diagnostics, node.span, what)
    found = expressions.constant(env, expr) if expr is not None else None
    if found is None:
        return expr
    if type_ is not None and not const_fits(found, type_):
        does_not_fit(diagnostics, node.span, f"the value {found!r}", type_)
        return None
    return Const(found, expr.type, node.span)


def _known_integer(env: Environment, value: expressions.Value, type_: Type | None) -> int | None:
    """A constant of one integer type that fits another one, which needs no conversion: the number is known.
    None for all else."""
    if type(value) not in (Const, Load, Apply) or isinstance(value.type, Enum):
        return None
    if type_ is None or isinstance(type_, Enum):
        return None
    wanted, own = storage(type_), storage(value.type)
    if not all(isinstance(t, Elementary) and t.kind in ("int", "uint") for t in (wanted, own)):
        return None
    number = expressions.constant(env, value)
    return number if number is not None and fits(number, type_) else None


def integer(env: Environment, node: ast.Expr, diagnostics: Diagnostics, what: str) -> int | None:
    """The value of a constant integer expression."""
    found = scalar(env, node, None, diagnostics, what)
    if found is None:
        return None
    base = storage(found.type)  # of a value of an enumeration its number, as other editors take it
    if not isinstance(base, Elementary) or base.kind not in ("int", "uint"):
        findings.bad_bounds(diagnostics, node.span, f"{what} must be an integer",
                            f"this is {described(found.type)}")
        return None
    return found.value


def initial_value(env: Environment, node: ast.Initial, type_: Type, diagnostics: Diagnostics) -> Value | None:
    """The initial value of a variable of ``type_`` in the form of ``ldc.types.Value``, complete for
    arrays and structures; None after an error."""
    match type_:
        case Array():
            return _array(env, node, type_, diagnostics)
        case Struct():
            return _fields(env, node, type_, {f.name.upper(): f for f in type_.fields}, diagnostics)
        case Instance():
            signature = env.signature(type_.pou)
            if signature is None:
                return None
            pins = {p.name.upper(): p for p in (*signature.inputs, *signature.outputs)}
            return _fields(env, node, type_, pins, diagnostics)
    if isinstance(node, ast.Aggregate):
        findings.bad_initial(diagnostics, node.span, f"{type_} takes a single value", "several values",
                             "write one value")
        return None
    found = scalar(env, node, type_, diagnostics, "an initial value")
    return None if found is None else found.value


def _array(env: Environment, node: ast.Initial, type_: Array, diagnostics: Diagnostics) -> tuple | None:
    if not isinstance(node, ast.Aggregate):
        return _copied(env, node, type_, diagnostics)
    if node.fields:
        findings.bad_initial(diagnostics, node.span, "an array takes a list of values", "names of members",
                             "write `[value, value, 3(value)]`")
        return None
    # An array of several dimensions may be given row by row.
    listed = any(isinstance(item, ast.Aggregate) and item.items for _, item in node.items)
    rows = len(type_.bounds) > 1 and listed
    element = Array(type_.bounds[1:], type_.element) if rows else type_.element
    total = sum(repeat for repeat, _ in node.items) * (element.count if rows else 1)
    if total > type_.count or any(repeat < 0 for repeat, _ in node.items):
        findings.bad_initial(diagnostics, node.span, f"{total} values for an array of {type_.count}",
                             "too many", "leave some out, or make the array larger")
        return None
    values: list[Scalar | tuple] = []
    failed = False
    for repeat, item in node.items:
        found = initial_value(env, item, element, diagnostics)
        failed |= found is None
        values += (found or ()) * repeat if rows else [found] * repeat
    if failed:
        return None
    rest = type_.count - total
    return tuple(values) + ((default(type_.element),) * rest if rest else ())


def _fields(env: Environment, node: ast.Initial, type_: Struct | Instance, members, diagnostics: Diagnostics):
    if not isinstance(node, ast.Aggregate):
        return _copied(env, node, type_, diagnostics)
    if node.items or not node.fields:
        findings.bad_initial(diagnostics, node.span, f"{type_} takes values by name", "values without names",
                             "write `(member := value, ...)`")
        return None
    given: dict[str, Value] = {}
    failed = False
    for name, item in node.fields:
        member = members.get(name.upper())
        if member is None or name.upper() in given:
            failed = True
            if member is None:
                names = [m.name for m in members.values()]
                message = f"{type_} has no member `{name}`"
                help = suggest(name, names) or "it has " + ", ".join(names)
            else:
                message, help = f"member `{name}` is given twice", "give it once"
            findings.bad_initial(diagnostics, item.span, message, "a value for it", help)
            continue
        found = initial_value(env, item, member.type, diagnostics)
        failed |= found is None
        given[name.upper()] = found
    if failed:
        return None
    if isinstance(type_, Instance):
        return tuple((member.name, given[key]) for key, member in members.items() if key in given)
    complete = dict(default(type_))
    return tuple((member.name, given.get(key, complete[member.name])) for key, member in members.items())


def _copied(env: Environment, node: ast.Expr, type_: Type, diagnostics: Diagnostics) -> tuple | None:
    """The value of another constant of the same type."""
    if isinstance(node, ast.Name):
        found = env.variable(node.name.upper())
        if found is not None and found[0].constant and found[0].type == type_:
            return found[0].initial
    form = "(member := value, ...)" if isinstance(type_, Struct | Instance) else "[value, value, 3(value)]"
    findings.bad_initial(diagnostics, node.span, f"{described(type_)} takes several values", "a single value",
                         f"write `{form}`")
    return None
