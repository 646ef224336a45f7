"""Bits and parts of numbers: ``word.15``, ``count.3``, ``word.%B1`` (IEC 61131-3, 3rd edition, 6.5.5).

A bit is a step of a place. A larger part is no place: to read it is a shift, to assign it puts the whole
together anew, so that every engine and the proof know it.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.expr import Apply, BitStep, Const, Expr, Load, Place, nodes
from ldc.model import places
from ldc.model import type_findings as findings
from ldc.model.environment import Environment
from ldc.model.values import converted
from ldc.parser import ast
from ldc.records import record
from ldc.source import Span
from ldc.types import BYTE, DWORD, INT, LWORD, WORD, Elementary, Type, numbered

_SIZES = {"%B": BYTE, "%W": WORD, "%D": DWORD, "%L": LWORD}
_OF_BITS = {8: BYTE, 16: WORD, 32: DWORD, 64: LWORD}


@record
class Part:
    """Of a number: ``type`` bits from bit ``first`` of the value at ``place``."""

    place: Place
    first: int
    type: Elementary


def is_part(node: ast.Expr) -> bool:
    """Whether the expression names a part that is larger than a bit."""
    return type(node) is ast.Member and node.name[0] == "%"


def bit(env: Environment, node: ast.Member, type_: Type, diagnostics: Diagnostics) -> BitStep | None:
    """The bit that ``node`` names of a value of the type, by its number or by a constant; None after an
    error."""
    base = numbered(type_)
    number = _number(env, node)
    if base is None:
        findings.bad_bit(diagnostics, node.span, f"{findings.described(type_)} has no bits to name",
                         f"bit {node.name[:12]} is asked for",
                         "bit strings and integers have; convert it first")
        return None
    if number is None or not 0 <= number < base.bits:
        findings.bad_bit(diagnostics, node.span, f"{base} has no bit {node.name[:12]}",
                         f"the bits are 0 to {base.bits - 1}", "choose one of these")
        return None
    return BitStep(number, base.kind == "int" and number == base.bits - 1)


def names_bit(env: Environment, node: ast.Member, type_: Type) -> bool:
    """Whether ``node`` is a bit: a number, or a constant behind something that has bits."""
    return node.name.isdecimal() or numbered(type_) is not None and _number(env, node) is not None


def _number(env: Environment, node: ast.Member) -> int | None:
    if node.name.isdecimal():
        return int(node.name) if len(node.name) <= 4 else None
    found = env.variable(node.name.upper())
    constant = found is not None and found[0].constant and numbered(found[0].type) is not None
    return found[0].initial if constant else None


def without_parts(env: Environment, node: ast.Member, diagnostics: Diagnostics) -> ast.Member | None:
    """A bit of a part as one of the whole: ``d.%W1.3`` is ``d.19``; None after an error."""
    outer = node.base
    size = _SIZES[outer.name[:2]]
    step = bit(env, node, size, diagnostics)
    first = _first(outer, LWORD, diagnostics)
    if step is None or first is None:
        return None
    made = ast.Member(outer.base, str(first + step.bit), node.span)
    return without_parts(env, made, diagnostics) if is_part(outer.base) else made


def part(env: Environment, node: ast.Member, diagnostics: Diagnostics, write: bool = False) -> Part | None:
    """What a part names; ``write``: it is assigned to. None after an error."""
    chain = [node]
    while is_part(chain[-1].base):
        chain.append(chain[-1].base)
    place = places.place(env, chain[-1].base, diagnostics, write)
    if place is None:
        return None
    whole, first = numbered(place.type), 0
    if whole is None:
        findings.bad_bit(diagnostics, node.span, f"{findings.described(place.type)} has no parts to name",
                         f"`{node.name}` is asked for", "bit strings and integers have; convert it first")
        return None
    for link in reversed(chain):
        at = _first(link, whole, diagnostics)
        if at is None:
            return None
        first, whole = first + at, _SIZES[link.name[:2]]
    return Part(place, first, whole)


def _first(node: ast.Member, whole: Elementary, diagnostics: Diagnostics) -> int | None:
    """The first bit of a part of ``whole``."""
    size, number = _SIZES[node.name[:2]].bits, node.name[2:]
    if len(number) > 4 or (int(number) + 1) * size > whole.bits:
        count = whole.bits // size
        findings.bad_bit(diagnostics, node.span, f"{whole} has no part {node.name[:12]}",
                         f"the parts are {node.name[:2]}0 to {node.name[:2]}{count - 1}" if count
                         else f"{whole} has {whole.bits} bits", "choose a part that the value has")
        return None
    return int(number) * size


def read(found: Part, span: Span) -> Expr:
    """The value of a part."""
    string = _OF_BITS[numbered(found.place.type).bits]
    value = converted(Load(found.place, span), string, span)
    if found.first:
        value = Apply("SHR", (value, Const(found.first, INT)), string, span)
    return converted(value, found.type, span)


def assigned(found: Part, value: Expr, span: Span) -> Expr:
    """The whole with ``value`` in the place of the part. The value is computed first, then the whole read."""
    own = numbered(found.place.type)
    string = _OF_BITS[own.bits]
    moved = converted(value, string, span)
    if found.first:
        moved = Apply("SHL", (moved, Const(found.first, INT)), string, span)
    kept = string.range[1] ^ found.type.range[1] << found.first
    rest = Apply("AND", (converted(Load(found.place, span), string, span), Const(kept, string)), string, span)
    return converted(Apply("OR", (moved, rest), string, span), own, span)


def calls_in_index(place: Place) -> bool:
    """Whether an index on the way to the place calls something, which then would be called twice."""
    return any(type(node) is Apply and node.user for index in place.indexes() for node in nodes(index))
