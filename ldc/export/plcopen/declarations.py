"""Types, variables and initial values as TC6 has them."""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

from ldc.export.plcopen.tags import add, code, formatted, own_data, prose
from ldc.parser import ast
from ldc.parser.unparse import expr_text
from ldc.types import ELEMENTARY

SECTIONS = {
    "VAR": "localVars", "VAR_INPUT": "inputVars", "VAR_OUTPUT": "outputVars", "VAR_IN_OUT": "inOutVars",
    "VAR_TEMP": "tempVars", "VAR_EXTERNAL": "externalVars", "VAR_GLOBAL": "globalVars",
}
_QUALIFIERS = {"CONSTANT": "constant", "RETAIN": "retain", "NON_RETAIN": "nonretain",
               "PERSISTENT": "persistent"}
_SHORT = {"DATE_AND_TIME": "DT", "TIME_OF_DAY": "TOD", "STRING": "string", "WSTRING": "wstring"}

Notes = Mapping[tuple[str, int], str]
"""What is said about a variable, a member or a type, by the path of its file and the offset of its name
there."""


def section(parent: Element, block: ast.VarBlock, notes: Notes) -> None:
    """A VAR section with its variables."""
    qualifiers = {_QUALIFIERS[word]: "true" for word in block.qualifiers}
    made = add(parent, SECTIONS[block.kind], **qualifiers)
    for declared in block.variables:
        variable(made, declared, notes)


def variable(
    parent: Element, declared: ast.VarDecl, notes: Notes, tag: str = "variable", named: str = "name"
) -> None:
    made = add(parent, tag, **{named: declared.name}, address=declared.location)
    type_(add(made, "type"), declared.type, notes)
    _initial(made, declared.initial)
    if declared.edge is not None:
        own_data(made, "edge").set("is", declared.edge)
    _documentation(made, declared, notes)


def type_decl(parent: Element, declared: ast.TypeDecl, notes: Notes) -> None:
    made = add(parent, "dataType", name=declared.name)
    type_(add(made, "baseType"), declared.type, notes)
    _initial(made, declared.initial)
    _documentation(made, declared, notes)


def _documentation(parent: Element, declared: ast.VarDecl | ast.TypeDecl, notes: Notes) -> None:
    note = declared.note or notes.get((declared.span.source.path, declared.span.start))
    if note:
        formatted(parent, "documentation", prose(note))


def type_(parent: Element, written: ast.TypeExpr, notes: Notes) -> None:
    """A type, as the only child of ``parent``. Bounds and lengths stay expressions."""
    match written:
        case ast.NamedType(name, length):
            key = name.upper()
            if key in ELEMENTARY:
                key = ELEMENTARY[key].name
                size = None if length is None else code(expr_text(length))
                add(parent, _SHORT.get(key, key), length=size)
            else:
                add(parent, "derived", name=name)
        case ast.ArrayType(bounds, element):
            made = add(parent, "array")
            for low, high in bounds:
                add(made, "dimension", lower=expr_text(low), upper=expr_text(high))
            type_(add(made, "baseType"), element, notes)
        case ast.StructType(fields):
            made = add(parent, "struct")
            for field in fields:
                variable(made, field, notes)
        case ast.EnumType(values, base=base):
            outer = add(parent, "enum")
            made = add(outer, "values")
            for name, value in values:
                add(made, "value", name=name, value=None if value is None else expr_text(value))
            if base is not None:
                type_(add(outer, "baseType"), ast.NamedType(base, None, written.span), notes)
        case ast.SubrangeType(base, low, high):
            unsigned = base.upper() in ("USINT", "UINT", "UDINT", "ULINT")
            made = add(parent, "subrangeUnsigned" if unsigned else "subrangeSigned")
            add(made, "range", lower=expr_text(low), upper=expr_text(high))
            add(add(made, "baseType"), ELEMENTARY[base.upper()].name)


def _initial(parent: Element, initial: ast.Initial | None) -> None:
    if initial is not None:
        _value(add(parent, "initialValue"), initial)


def _value(parent: Element, initial: ast.Initial) -> None:
    if not isinstance(initial, ast.Aggregate):
        add(parent, "simpleValue", value=code(expr_text(initial)))
    elif initial.fields:
        made = add(parent, "structValue")
        for name, value in initial.fields:
            _value(add(made, "value", member=name), value)
    else:
        made = add(parent, "arrayValue")
        for times, value in initial.items:
            _value(add(made, "value", repetitionValue=times if times != 1 else None), value)
