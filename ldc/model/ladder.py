"""Contacts, coils and jumps of a rung, typed (DESIGN sections 2 and 3)."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.expr import Apply, Const, IndexStep, Load, Place
from ldc.model import call_findings, elements, expressions, places
from ldc.model import type_findings as findings
from ldc.model.environment import Environment
from ldc.model.names import suggest
from ldc.model.values import AnyEnum, Untyped, coerce
from ldc.parser import ast
from ldc.source import Span
from ldc.types import BOOL, TIME, Elementary, String, Type, storage

CONTACTS = {"": "open", "/": "closed", "P": "rising", "N": "falling"}
COILS = {"": "normal", "/": "negated", "S": "set", "R": "reset", "P": "rising", "N": "falling"}
_PLACES = frozenset((ast.Name, ast.Direct, ast.Member, ast.Index))


def contact(env: Environment, node: ast.Contact, diagnostics: Diagnostics) -> elements.Contact | None:
    """A contact: of a BOOL variable, address or literal; any other BOOL expression is kind "expression"."""
    written = node.expr
    if type(written) is ast.Name:
        found = env.variable(written.name.upper())
        if found is not None and found[0].type is BOOL:
            operand = Load(places.variable_place(found, written.span), written.span)
            if node.modifier in "PN" and node.modifier:
                return _edge(env, node, operand, diagnostics)
            return elements.Contact(CONTACTS[node.modifier], operand, node.span)
    operand = _operand(env, written, diagnostics)
    if operand is None:
        return None
    plain = type(operand) is Const or type(operand) is Load and type(written) in _PLACES
    if not plain:
        if node.modifier:
            findings.modifier_on_expression(diagnostics, written.span, node.modifier, written.span.text)
            return None
        return elements.Contact("expression", operand, node.span)
    if node.modifier in ("P", "N"):
        return _edge(env, node, operand, diagnostics)
    if type(operand) is Load and _computed(operand.place):
        # An index that is computed may be out of range: like a division it is read only with power.
        guarded = operand if node.modifier == "" else Apply("NOT", (operand,), BOOL, operand.span)
        return elements.Contact("expression", guarded, node.span)
    return elements.Contact(CONTACTS[node.modifier], operand, node.span)


def _edge(
    env: Environment, node: ast.Contact, operand: Load | Const, diagnostics: Diagnostics
) -> elements.Contact | None:
    if env.kind == "FUNCTION":
        call_findings.no_memory(diagnostics, node.span, env.pou, "an edge contact")
        return None
    return elements.Contact(CONTACTS[node.modifier], operand, node.span)


def _operand(env: Environment, written: ast.Expr, diagnostics: Diagnostics):
    found = expressions.value(env, written, BOOL, diagnostics)
    if found is None:
        return None
    if type(found) is Untyped:
        if found.value in (0, 1) and isinstance(found.value, int):
            return Const(bool(found.value), BOOL, written.span)
        found = coerce(found, None, diagnostics, written.span)
    elif type(found) is AnyEnum:
        found = coerce(found, None, diagnostics, written.span)
    if found is None:
        return None
    if storage(found.type) == BOOL:
        return found
    findings.not_bool(diagnostics, written.span, "a contact", found.type,
                      _comparison(written.span.text, found.type))
    return None


def not_a_condition(diagnostics: Diagnostics, span: Span, what: str, type_: Type) -> None:
    """Reports a value of a statement that is not the BOOL that is needed there."""
    findings.not_bool(diagnostics, span, what, type_, _comparison(span.text, type_, "{}"))


def _comparison(text: str, type_: Type, shape: str = "[{}]") -> str:
    """How to make a condition of a value; ``shape``: what is written around it."""
    base = storage(type_)
    if base == TIME:
        return f"write `{shape.format(f'{text} <> T#0s')}`"
    if isinstance(base, Elementary) and base.kind in ("int", "uint", "bits", "real"):
        weak = not expressions.LOGIC.isdisjoint(text.upper().split())  # binds less than `<>`
        whole = f"({text})" if weak else text
        return f"write `{shape.format(f'{whole} <> 0')}`"
    if isinstance(base, String):
        return "write `" + shape.format(f"{text} <> ''") + "`"
    if hasattr(base, "pou"):
        return f"name one of its outputs, as in `{shape.format(text + '.Q')}`"
    return "compare it with something"


def _computed(place: Place) -> bool:
    return any(type(step) is IndexStep and any(type(i) is not Const for i in step.indexes)
               for step in place.steps)


def coil(env: Environment, node: ast.Coil, diagnostics: Diagnostics) -> elements.Coil | None:
    """A coil on a BOOL place that may be written."""
    target = places.place(env, node.target, diagnostics, write=True)
    if target is None:
        return None
    if storage(target.type) != BOOL:
        text = node.target.span.text
        findings.not_bool(diagnostics, node.target.span, "a coil", target.type,
                          "a coil writes one BOOL; write other values by a block, "
                          f"`<MOVE(IN := value, OUT => {text})>`")
        return None
    if node.modifier in ("P", "N") and env.kind == "FUNCTION":
        call_findings.no_memory(diagnostics, node.span, env.pou, "an edge coil")
        return None
    return elements.Coil(COILS[node.modifier], target, node.span)


def jump(
    labels: dict[str, str], node: ast.Jump, diagnostics: Diagnostics, silent: bool = False
) -> elements.Jump | None:
    """A jump to a named rung of the same POU; RETURN leaves it. ``labels``: capitals -> spelling;
    ``silent``: rungs are missing, so nothing is said about an unknown label."""
    key = node.target.upper()
    if key == "RETURN":
        return elements.Jump(None, node.span)
    label = labels.get(key)
    if label is None:
        if not silent:
            call_findings.unknown_label(diagnostics, node.span, node.target,
                                        suggest(node.target, labels.values()))
        return None
    return elements.Jump(label, node.span)
