"""The pins of drawn blocks: names that editors give to pins of standard blocks, and values of open inputs."""

from __future__ import annotations

from collections.abc import Sequence

from ldc.diagnostics import Diagnostics
from ldc.library import blocks, functions
from ldc.parser import ast
from ldc.parser.plcopen import findings
from ldc.source import Span
from ldc.symbols import OTHER_PINS, Signature
from ldc.types import BOOL, ELEMENTARY

NO_WIRE = "_"
_ANY_ORDER = ("AND", "OR", "XOR", "ADD", "MUL", "MIN", "MAX")
_ZERO = {"bool": (False, "BOOL", "FALSE"), "time": (0, "TIME", "T#0s"), "string": (b"", None, "''")}


def standard_names(type_: str, is_function: bool, names: Sequence[str]) -> list[str]:
    """The inputs of a block as the standard calls them (IEC 61131-3, 2nd edition, tables 22 to 37). Some
    editors count the inputs of a function from EN, and have longer names for those of counters."""
    if not is_function:
        signature = blocks.signature(type_)
        known = {p.name for p in signature.inputs} if signature is not None else set()
        return [OTHER_PINS.get(name.upper(), name) if signature is not None and name.upper() not in known
                else name for name in names]
    row = functions.lookup(type_)
    values = [name for name in names if name.upper() != "EN"]
    if row is None or not values or len(values) > row.least and not row.extensible:
        return list(names)
    expected = row.pins(len(values))
    known = all(row.position(name) is not None for name in values)
    if known and (not row.extensible or {name.upper() for name in values} == set(expected)):
        return list(names)
    standard = iter(expected)
    return [name if name.upper() == "EN" else next(standard) for name in names]


def usual(chosen: str | None, side: str, is_function: bool, signature: Signature | None) -> str | None:
    """What is written for the pin that power was chosen to go by, on the ``side`` in or out: None for the one
    that it goes by anyway. ``signature``: that of a standard function block."""
    if chosen == NO_WIRE or chosen is None:
        return chosen
    if is_function:
        return None if chosen.upper() in ("EN", "ENO") else chosen
    if signature is not None:
        group = signature.inputs if side == "in" else signature.outputs
        if next((p.name for p in group if p.type == BOOL), "") == chosen.upper():
            return None
    return chosen


class OpenPins:
    """Gives the open inputs of a function a value: it has no memory that could hold one. An operator that
    takes its inputs in any order goes without the open ones."""

    def __init__(self, where: str, diagnostics: Diagnostics) -> None:
        self.where, self.diagnostics = where, diagnostics

    def standard(self, type_: str, given: list[ast.Pin], open_: Sequence[tuple[str, Span]]) -> list[ast.Pin]:
        """The inputs of a standard function, ``given`` ones and values for the open ones."""
        row = functions.lookup(type_)
        if row is None or not open_:
            return given
        values = [pin for pin in given if pin.name is None or pin.name.upper() != "EN"]
        if (functions.typed(row.name) or (row.name,))[0] in _ANY_ORDER and len(values) >= row.least:
            for name, span in open_:
                findings.open_pin(self.diagnostics, span, self.where, name, "is left out")
            names = iter(row.pins(len(values)))
            return [ast.Pin(next(names), p.value, False, p.span) if p in values else p for p in given]
        found = list(given)
        for name, span in open_:
            at = row.position(name)
            if at is None:
                continue
            kind = row.shapes[0].inputs[min(at, row.least - 1)]
            text = "STRING" in kind
            value = ast.Literal(b"", None, "''", span) if text else ast.Literal(0, None, "0", span)
            findings.open_pin(self.diagnostics, span, self.where, name, f"is {value.text}")
            found.append(ast.Pin(name, value, False, span))
        return found

    def own(self, inputs: Sequence[ast.VarDecl], given: list[ast.Pin], span: Span) -> list[ast.Pin]:
        """The inputs of a function of the project: an open one has its declared initial value, or the
        default of its type."""
        names = {pin.name.upper() for pin in given if pin.name is not None}
        if any(pin.name is None for pin in given):
            return given
        found = list(given)
        for declared in inputs:
            if declared.name.upper() in names:
                continue
            value = declared.initial or default(declared.type, span)
            if value is not None and not isinstance(value, ast.Aggregate):
                shown = value.span.text if value is declared.initial else value.text
                findings.open_pin(self.diagnostics, span, self.where, declared.name, f"is {shown}")
                found.append(ast.Pin(declared.name, value, False, span))
        return found


def default(type_: ast.TypeExpr, span: Span) -> ast.Literal | None:
    """The default value of an elementary type as a literal; None for other types."""
    if not isinstance(type_, ast.NamedType):
        return None
    if type_.name.upper() in ("STRING", "WSTRING"):
        return ast.Literal(b"", None, "''", span) if type_.name.upper() == "STRING" else None
    elementary = ELEMENTARY.get(type_.name.upper())
    if elementary is None or elementary.kind in ("date", "tod", "dt"):
        return None
    value, prefix, text = _ZERO.get(elementary.kind, (0, None, "0"))
    return ast.Literal(value, prefix, text, span)
