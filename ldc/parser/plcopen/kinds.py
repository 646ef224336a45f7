"""Types of expressions, as far as they are integers or bit strings; and what other editors make of a mix.

They take BYTE, WORD, DWORD and LWORD for unsigned numbers, and convert between numbers of the same size, or
to larger ones, by themselves. Here that is written out (`WORD_TO_INT(x)`), with a warning. A value that may
not fit (DINT to INT) is left as it is, and is an error.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from ldc.library import blocks, functions
from ldc.parser import ast
from ldc.records import record
from ldc.types import ELEMENTARY, Elementary

NUMBERS = {name: type_ for name, type_ in ELEMENTARY.items()
           if isinstance(type_, Elementary) and type_.kind in ("int", "uint", "bits")}
_SIGNED = {8: "SINT", 16: "INT", 32: "DINT", 64: "LINT"}
_UNSIGNED = {8: "USINT", 16: "UINT", 32: "UDINT", 64: "ULINT"}
_SIZES = {"B": "BYTE", "W": "WORD", "D": "DWORD", "L": "LWORD"}
ARITHMETIC = frozenset(("+", "-", "*", "/", "MOD"))
COMPARING = {"EQ": "=", "NE": "<>", "LT": "<", "LE": "<=", "GT": ">", "GE": ">="}
"""Functions and their operators; their result is BOOL."""
COMPARISONS = frozenset(COMPARING.values())
OPERATORS = frozenset((*COMPARING, "ADD", "SUB", "MUL", "DIV", "MOD", "MOVE"))


@record
class Kind:
    """The type of a value; ``bits``: of the largest operand that it comes from, what a mix was computed in
    may be larger."""

    type: Elementary
    bits: int


@record
class Members:
    """What parts of variables are: ``types`` that the file declares and ``pins`` of its function blocks that
    can be read from outside, by names in capitals."""

    types: Mapping[str, ast.TypeExpr]
    pins: Mapping[str, Mapping[str, ast.TypeExpr]]

    def named(self, type_: ast.TypeExpr) -> ast.TypeExpr:
        """What is behind the name of a type."""
        seen = set()
        while isinstance(type_, ast.NamedType) and (key := type_.name.upper()) in self.types and key not in seen:
            seen.add(key)
            type_ = self.types[key]
        return type_

    def inside(
        self, link: ast.Member | ast.Index, type_: ast.TypeExpr
    ) -> ast.TypeExpr | Elementary | None:
        """The type of an element, a member of a structure, a pin of an instance."""
        type_ = self.named(type_)
        if isinstance(link, ast.Index):
            return type_.element if isinstance(type_, ast.ArrayType) else None
        key = link.name.upper()
        if isinstance(type_, ast.StructType):
            return next((field.type for field in type_.fields if field.name.upper() == key), None)
        if not isinstance(type_, ast.NamedType):
            return None
        if (own := self.pins.get(type_.name.upper())) is not None:
            return own.get(key)
        signature = blocks.signature(type_.name.upper())
        pin = signature.pin(key) if signature is not None else None
        return pin.type if pin is not None and isinstance(pin.type, Elementary) else None

    def numbers(self) -> Iterable[Elementary]:
        """The numbers among all members and pins."""
        found = [field.type for type_ in self.types.values() if isinstance(type_, ast.StructType)
                 for field in type_.fields]
        found += [type_ for pins in self.pins.values() for type_ in pins.values()]
        return [one for type_ in found if (one := _number(type_)) is not None]


class Numbers(dict[str, Elementary]):
    """The variables that are numbers, by name in capitals, and what the parts of all ``variables`` are."""

    def __init__(self, variables: Iterable[ast.VarDecl], members: Members) -> None:
        self.types = {v.name.upper(): v.type for v in variables}
        self.members = members
        named = ((key, _number(members.named(type_))) for key, type_ in self.types.items())
        super().__init__((key, type_) for key, type_ in named if type_ is not None)

    def part(self, node: ast.Member | ast.Index) -> Elementary | None:
        """The type of a part of a variable, when it is a number."""
        links = []
        while isinstance(node, ast.Member | ast.Index):
            links.append(node)
            node = node.base
        type_ = self.types.get(node.name.upper()) if isinstance(node, ast.Name) else None
        for link in reversed(links):
            if type_ is None or isinstance(type_, Elementary):
                return None
            type_ = self.members.inside(link, type_)
        if isinstance(type_, Elementary):
            return NUMBERS.get(type_.name)
        return _number(self.members.named(type_)) if type_ is not None else None


def _number(type_: ast.TypeExpr) -> Elementary | None:
    return NUMBERS.get(type_.name.upper()) if isinstance(type_, ast.NamedType) else None


def kind(node: ast.Expr, numbers: Mapping[str, Elementary]) -> Kind | None:
    """The kind of an expression without operators; None when it is no number, or not known."""
    type_ = None
    match node:
        case ast.Name():
            type_ = numbers.get(node.name.upper())
        case ast.Member() | ast.Index() if isinstance(numbers, Numbers):
            type_ = numbers.part(node)
        case ast.Direct():
            type_ = NUMBERS.get(_SIZES.get(node.address[2:3].upper(), ""))
        case ast.Literal():
            type_ = NUMBERS.get(node.type or "")
        case ast.Call():
            type_ = result(node.name)
    return Kind(type_, type_.bits) if type_ is not None else None


def result(function: str) -> Elementary | None:
    """What a conversion function gives, when it is a number."""
    _, mark, to = function.upper().rpartition("_TO_")
    return NUMBERS.get(to) if mark else None


def common(operands: Sequence[Kind | None], compared: bool) -> Elementary | None:
    """What the operands of an operator become; None when they are fine as they are (a literal is None)."""
    known = [one for one in operands if one is not None]
    kinds = {one.type.kind for one in known}
    if "bits" not in kinds and kinds != {"int", "uint"} or compared and kinds == {"bits"}:
        return None
    if "int" not in kinds:
        return ELEMENTARY[_UNSIGNED[max(one.type.bits for one in known)]]
    widest = max(one.type.bits * (1 if one.type.kind == "int" else 2) for one in known)
    return ELEMENTARY[_SIGNED[widest]] if widest in _SIGNED else None


def declared(variables: Iterable[ast.VarDecl]) -> dict[str, Elementary]:
    """The variables that are numbers, by name in capitals."""
    return {v.name.upper(): NUMBERS[v.type.name.upper()] for v in variables
            if isinstance(v.type, ast.NamedType) and v.type.name.upper() in NUMBERS}


def may_mix(found: Iterable[Elementary]) -> bool:
    """Whether there is a bit string, or signed and unsigned numbers: without, nothing is to be converted."""
    kinds = {type_.kind for type_ in found}
    return "bits" in kinds or len(kinds) > 1


def needed(source: Kind | None, target: Elementary | None) -> bool:
    """Whether a value becomes one of another type by a conversion that other editors do by themselves."""
    if source is None or target is None or target.name not in NUMBERS or source.type == target:
        return False
    return target.bits >= source.bits and not functions.widens(source.type, target)


def converted(node: ast.Expr, source: Elementary, target: Elementary) -> ast.Expr:
    """The value in another type; the value itself when it is of that type."""
    if source == target:
        return node
    given = ast.Argument(None, node, False, node.span)
    return ast.Call(f"{source.name}_TO_{target.name}", (given,), node.span)


def untyped(node: ast.Expr) -> bool:
    """Whether this is a whole number that takes its type from beside it."""
    while isinstance(node, ast.Unary):
        node = node.operand
    return isinstance(node, ast.Literal) and node.type is None and type(node.value) is int
