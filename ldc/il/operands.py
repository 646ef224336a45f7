"""Operands of IL text: names and literals become typed places and constants."""

from __future__ import annotations

import re

from ldc.diagnostics import Diagnostics
from ldc.expr import Apply, Const, Expr, FieldStep, Load, Place
from ldc.il import findings
from ldc.model import action_calls, expressions
from ldc.model.project import Pou
from ldc.model.rewrite import mapped
from ldc.model.unnamed import named
from ldc.model.values import AnyEnum, Untyped
from ldc.parser import ast
from ldc.parser import parse_expression
from ldc.patterns import Pattern
from ldc.source import Span
from ldc.types import Instance, Type

Operand = Place | Const | Untyped | AnyEnum

_NAME = Pattern(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*\Z", re.ASCII)
_WORDS = frozenset(("TRUE", "FALSE", "NOT", "AND", "OR", "XOR", "MOD"))


class Operands:
    """Reads the operands of one POU. What was resolved once is looked up by its text afterwards."""

    def __init__(self, pou: Pou, scope, diagnostics: Diagnostics) -> None:
        self.source = pou.body.span.source
        self.scope = scope
        self.diagnostics = diagnostics
        self._named = named(dict(pou.body.names)) if pou.body.names else None
        self._read: dict[tuple[str, bool], Operand] = {}

    def span(self, start: int, end: int) -> Span:
        return Span(self.source, start, end)

    def value(self, start: int, end: int, hint: Type | None = None) -> Operand | None:
        """What stands at these offsets, to be read; None after an error. ``hint``: the type that the
        context would like, for names of enumeration values."""
        text = self.source.text[start:end]
        known = self._read.get((text, False))
        if known is not None:
            return known
        node = self._parse(text, start, end)
        if node is None:
            return None
        found = expressions.value(self.scope, node, hint, self.diagnostics)
        match found:
            case None:
                return None
            case Load(place):
                found = place
            case Apply():
                findings.not_simple(self.diagnostics, node.span, "an operand")
                return None
        return self._keep(text, False, found, node.span)

    def place(self, start: int, end: int, write: bool) -> Place | None:
        """The variable at these offsets; with ``write`` one that may be written."""
        text = self.source.text[start:end]
        known = self._read.get((text, write))
        if isinstance(known, Place):
            return known
        node = self._parse(text, start, end)
        if node is None:
            return None
        found = self._in_out(node) if write else None
        found = found or self.scope.place(node, self.diagnostics, write=write)
        if found is None:
            return None
        return self._keep(text, write, found, node.span)

    def _keep(self, text: str, write: bool, found: Operand, span: Span) -> Operand | None:
        if isinstance(found, Place) and not simple(found):
            findings.not_simple(self.diagnostics, span, "an index")
            return None
        if not isinstance(found, AnyEnum):
            self._read[text, write] = found
        return found

    def _parse(self, text: str, start: int, end: int) -> ast.Expr | None:
        if not text:
            findings.operand_missing(self.diagnostics, self.span(start, end), ",", "an operand on both sides")
            return None
        if text[-1] == ";":
            findings.malformed(self.diagnostics, self.span(end - 1, end), "a semicolon in IL",
                               "take it away; an instruction ends with its line")
            return None
        if _NAME.match(text) is None or text.upper() in _WORDS:
            node = parse_expression(self.source, start, end, self.diagnostics)
            return node if node is None or self._named is None else mapped(node, self._named)
        names = text.split(".")
        at = start + len(names[0])
        node: ast.Expr = ast.Name(names[0], self.span(start, at))
        for name in names[1:]:
            at += 1 + len(name)
            node = ast.Member(node, name, self.span(start, at))
        return node

    def action(self, start: int, end: int) -> action_calls.Called | None:
        """The action that is named at these offsets, if one is."""
        text = self.source.text[start:end]
        node = self._parse(text, start, end) if text and text[-1] not in ";)" else None
        return None if node is None else action_calls.called(self.scope, node)

    def _in_out(self, node: ast.Expr) -> Place | None:
        """``instance.pin`` of a VAR_IN_OUT, which only IL writes: it is copied before the call."""
        if not isinstance(node, ast.Member):
            return None
        base = self.scope.place(node.base, Diagnostics())
        if base is None or not isinstance(base.type, Instance):
            return None
        signature = self.scope.signature(base.type.pou)
        pin = next((p for p in signature.in_outs if p.name.upper() == node.name.upper()), None)
        return None if pin is None else member(base, pin.name, pin.type, node.span)


def member(instance: Place, pin: str, type_: Type, span: Span | None = None) -> Place:
    """The place of a pin of an instance."""
    return Place(instance.root, type_, (*instance.steps, FieldStep(pin)), instance.is_global, span)


def simple(place: Place) -> bool:
    """Whether every index is a constant or a variable, as IL asks for."""
    return all(_simple_index(i) for i in place.indexes())


def _simple_index(index: Expr) -> bool:
    return isinstance(index, Const) or isinstance(index, Load) and simple(index.place)
