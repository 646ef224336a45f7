"""Conversions that other editors make by themselves, written out in Structured Text (kinds.py says which)."""

from __future__ import annotations

from collections.abc import Mapping

from ldc.diagnostics import Diagnostics
from ldc.library import functions
from ldc.parser import ast
from ldc.parser import statements as st
from ldc.parser.plcopen import findings, kinds
from ldc.parser.plcopen.kinds import Kind
from ldc.parser.plcopen.rewrite import rewritten
from ldc.records import replace
from ldc.types import Elementary


def written_out(
    body: object, numbers: Mapping[str, Elementary], pins: Mapping[str, Mapping[str, Elementary]],
    diagnostics: Diagnostics,
) -> object:
    """A body with its statements. ``numbers``: the types of the variables that it sees; ``pins``: those of
    the inputs of its instances of function blocks."""
    return rewritten(body, _Change(numbers, pins, diagnostics).node)


class _Change:
    """``known``: kinds of operators that were met, by identity; ``kept`` holds these nodes alive; ``mixed``:
    those whose operands were converted."""

    def __init__(self, numbers: Mapping[str, Elementary], pins: Mapping[str, Mapping[str, Elementary]],
                 diagnostics: Diagnostics) -> None:
        self.numbers, self.pins, self.diagnostics = numbers, pins, diagnostics
        self.known: dict[int, Kind] = {}
        self.kept: list[object] = []
        self.mixed: set[int] = set()

    def node(self, node: object) -> object:
        match node:
            case ast.Unary(op="-"):
                return self._noted(node, self._kind(node.operand))
            case ast.Binary() if node.op in kinds.ARITHMETIC or node.op in kinds.COMPARISONS:
                return self._operator(node)
            case st.Assign():
                target = self._kind(node.target)
                return self._taken(node, target.type if target is not None else None)
            case st.Invoke(callee=ast.Name()):
                pins = self.pins.get(node.callee.name.upper(), {})
                made = tuple(one if one.output or one.name is None else
                             self._taken(one, pins.get(one.name.upper())) for one in node.arguments)
                return replace(node, arguments=made) if pins else node
        return node

    def _taken(self, node: object, target: Elementary | None) -> object:
        """An assignment or an argument with its value in the type of what takes it."""
        source = self._kind(node.value)
        if not kinds.needed(source, target):
            return node
        if id(node.value) not in self.mixed:
            findings.converted(self.diagnostics, node.value.span, source.type.name, target.name)
        return replace(node, value=kinds.converted(node.value, source.type, target))

    def _kind(self, node: ast.Expr) -> Kind | None:
        return self.known.get(id(node)) or kinds.kind(node, self.numbers)

    def _noted(self, node: object, kind: Kind | None) -> object:
        if kind is not None:
            self.known[id(node)] = kind
            self.kept.append(node)
        return node

    def _operator(self, node: ast.Binary) -> object:
        compared = node.op in kinds.COMPARISONS
        left, right = self._kind(node.left), self._kind(node.right)
        if left is None and not kinds.untyped(node.left) or right is None and not kinds.untyped(node.right):
            return node  # one side is no number, or of a type that is not known
        found = [kind for kind in (left, right) if kind is not None]
        target = kinds.common(found, compared)
        if target is not None:
            node = replace(node, left=self._side(node.left, left, target),
                           right=self._side(node.right, right, target))
        if compared or not found:
            return node
        if target is not None:
            self.mixed.add(id(node))
        type_ = target or max((kind.type for kind in found), key=lambda type_: type_.bits)
        return self._noted(node, Kind(type_, max(kind.bits for kind in found)))

    def _side(self, node: ast.Expr, kind: Kind | None, target: Elementary) -> ast.Expr:
        if kind is None or kind.type == target:
            return node
        if not functions.widens(kind.type, target):
            findings.converted(self.diagnostics, node.span, kind.type.name, target.name)
        return kinds.converted(node, kind.type, target)
