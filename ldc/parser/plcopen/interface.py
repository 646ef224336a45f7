"""Types, variables and initial values (PLCopen TC6 XML, types/dataTypes and pou/interface)."""

from __future__ import annotations

import re

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, literals
from ldc.parser.plcopen import findings, kept, texts
from ldc.parser.plcopen.document import Node
from ldc.parser.reader import parse_type
from ldc.patterns import Pattern
from ldc.source import Span
from ldc.types import ELEMENTARY

SECTIONS = {
    "localVars": "VAR", "inputVars": "VAR_INPUT", "outputVars": "VAR_OUTPUT", "inOutVars": "VAR_IN_OUT",
    "tempVars": "VAR_TEMP", "externalVars": "VAR_EXTERNAL", "globalVars": "VAR_GLOBAL",
}
_QUOTES = {"STRING": "'", "WSTRING": '"'}
_SYNONYMS = {"BIT": "BOOL"}
"""Types of other editors that are like one of the standard."""
_WRITTEN_OUT = Pattern(r"\s*(W?STRING\s*[(\[]|ARRAY\s*\[)", re.IGNORECASE)
_PATH = Pattern(r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*|\[[\d, -]+\])+", re.ASCII)
_QUALIFIERS = {"constant": "CONSTANT", "retain": "RETAIN", "persistent": "RETAIN", "nonretain": "NON_RETAIN"}


def var_blocks(parent: Node, diagnostics: Diagnostics) -> tuple[ast.VarBlock, ...]:
    """The sections of an interface, or the global variables of a configuration or resource."""
    return tuple(var_block(node, diagnostics) for node in parent.all(*SECTIONS) if node.children)


def var_block(node: Node, diagnostics: Diagnostics) -> ast.VarBlock:
    qualifiers = tuple(dict.fromkeys(word for key, word in _QUALIFIERS.items() if node.flag(key)))
    variables = (variable(child, diagnostics) for child in node.all("variable"))
    return ast.VarBlock(SECTIONS[node.tag], qualifiers, tuple(v for v in variables if v), node.whole)


def config_vars(parent: Node, diagnostics: Diagnostics) -> tuple[ast.VarBlock, ...]:
    """VAR_CONFIG: addresses and values of instances, which are named by their paths."""
    found = []
    for node in parent.all("configVars"):
        variables = [_configured(child, diagnostics) for child in node.all("configVariable")]
        if any(variables):
            found.append(ast.VarBlock("VAR_CONFIG", (), tuple(v for v in variables if v), node.whole))
    return tuple(found)


def _configured(node: Node, diagnostics: Diagnostics) -> ast.VarDecl | None:
    path, type_ = node.get("instancePathAndName").strip(), type_of(node.find("type"), node, diagnostics)
    if not _PATH.fullmatch(path):
        findings.malformed(diagnostics, node.span, f"`{path[:40]}` is no path of a variable in an instance")
        return None
    if type_ is None:
        return None
    value = _unquoted(node, type_) or initial(node.find("initialValue"), diagnostics)
    note = texts.prose(node.find("documentation")) or None
    return ast.VarDecl(path, node.get("address").strip().upper() or None, type_, value,
                       node.attribute("instancePathAndName"), node.span, note)


def variable(node: Node, diagnostics: Diagnostics) -> ast.VarDecl | None:
    name = texts.name(node, diagnostics)
    plain = _plain_type(node)
    type_ = plain or type_of(node.find("type"), node, diagnostics)
    if name is None or type_ is None:
        return None
    location = node.get("address").strip().upper() or None
    value = edge = None
    note = node.get("comment").strip() or None  # as MULTIPROG and its family write it
    if plain is None:
        value = _unquoted(node, type_) or initial(node.find("initialValue"), diagnostics)
        note = texts.prose(node.find("documentation")) or note
        edge = kept.edge(node)
    return ast.VarDecl(name, location, type_, value, node.attribute("name"), node.span, note, edge)


def _unquoted(node: Node, type_: ast.TypeExpr) -> ast.Literal | None:
    """The initial value of a string that stands without quotes, as Beremiz allows; None for others."""
    value = node.find("initialValue", "simpleValue")
    quote = _QUOTES.get(type_.name) if isinstance(type_, ast.NamedType) else None
    text = value.get("value").strip() if value is not None else ""
    if quote is None or not text or text.startswith(quote) or text.endswith(quote):
        return None
    written = f"{quote}{text.replace('$', '$$').replace(quote, f'${quote}')}{quote}"
    try:
        found, prefix, shown = literals.literal(written)
    except literals.Malformed:
        return None
    return ast.Literal(found, prefix, shown, value.attribute("value"))


def _plain_type(node: Node) -> ast.NamedType | None:
    """The type of a variable that has nothing but a type with a name."""
    if node.usual is None:
        return None
    which = "elementary" if node.usual["derived"] is None else "derived"
    name = node.usual[which].strip("</>")
    if which == "elementary" and name not in ELEMENTARY:
        return None
    return ast.NamedType(_SYNONYMS.get(name, name), None, Span(node.document.source, *node.usual.span(which)))


def type_decl(node: Node, diagnostics: Diagnostics) -> ast.TypeDecl | None:
    """A data type of the project."""
    name = texts.name(node, diagnostics)
    type_ = type_of(node.find("baseType"), node, diagnostics)
    if name is None or type_ is None:
        return None
    note = texts.prose(node.find("documentation")) or None
    return ast.TypeDecl(name, type_, initial(node.find("initialValue"), diagnostics), node.whole, note)


def type_of(holder: Node | None, of: Node, diagnostics: Diagnostics) -> ast.TypeExpr | None:
    """The type in a ``<type>``, ``<baseType>`` or ``<returnType>``."""
    node = next(iter(holder.children), None) if holder is not None else None
    if node is None:
        findings.malformed(diagnostics, of.span, f"`{of.get('name')[:40]}` has no type")
        return None
    tag = node.tag
    if tag == "derived":
        if _WRITTEN_OUT.match(node.get("name")):
            span = node.attribute("name")
            return parse_type(span.source, span.start, span.end, diagnostics)
        found = texts.type_name(node, diagnostics)
        return ast.NamedType(_SYNONYMS.get(found[0], found[0]), None, found[1]) if found else None
    if tag.upper() in ("STRING", "WSTRING"):
        length = texts.expression(node.attribute("length"), diagnostics) if node.get("length") else None
        return ast.NamedType(tag.upper(), length, node.span)
    if tag == "array":
        return _array(node, diagnostics)
    if tag == "struct":
        fields = (variable(child, diagnostics) for child in node.all("variable"))
        return ast.StructType(tuple(f for f in fields if f), node.whole)
    if tag == "enum":
        return _enum(node, diagnostics)
    if tag in ("subrangeSigned", "subrangeUnsigned"):
        bounds = _range(node.find("range"), node, diagnostics)
        base = type_of(node.find("baseType"), node, diagnostics)
        if bounds is None or not isinstance(base, ast.NamedType):
            return None
        return ast.SubrangeType(base.name, *bounds, node.whole)
    if tag.upper() in ELEMENTARY or tag.upper() == "BIT":
        return ast.NamedType(_SYNONYMS.get(tag.upper(), tag.upper()), None, node.span)
    help = "use one of the types of IEC 61131-3, 2nd edition"
    if tag in ("pointer", "reference"):
        help = "hand a variable over as VAR_IN_OUT, or use an ARRAY and an index"
    findings.unsupported(diagnostics, node.span, f"`{of.get('name')[:40]}` has the type <{tag[:40]}>, which ldc "
                         "does not have", "used here", help)
    return None


def _range(node: Node | None, of: Node, diagnostics: Diagnostics) -> tuple[ast.Expr, ast.Expr] | None:
    if node is None or not node.get("lower") or not node.get("upper"):
        findings.malformed(diagnostics, (node or of).span, "a range has no lower and upper bound")
        return None
    low, high = (texts.expression(node.attribute(side), diagnostics) for side in ("lower", "upper"))
    return None if low is None or high is None else (low, high)


def _array(node: Node, diagnostics: Diagnostics) -> ast.ArrayType | None:
    bounds = [_range(child, node, diagnostics) for child in node.all("dimension")]
    element = type_of(node.find("baseType"), node, diagnostics)
    if not bounds:
        findings.malformed(diagnostics, node.span, "an array has no dimension")
    if not bounds or None in bounds or element is None:
        return None
    return ast.ArrayType(tuple(bounds), element, node.whole)


def _enum(node: Node, diagnostics: Diagnostics) -> ast.EnumType | None:
    values = []
    for child in node.descendants("value"):
        name = texts.name(child, diagnostics)
        if name is None:
            return None
        value = texts.expression(child.attribute("value"), diagnostics) if child.get("value") else None
        values.append((name, value))
    if not values:
        findings.malformed(diagnostics, node.span, "an enumeration has no value")
        return None
    base = type_of(node.find("baseType"), node, diagnostics) if node.find("baseType") is not None else None
    return ast.EnumType(tuple(values), node.whole, base.name if isinstance(base, ast.NamedType) else None)


def initial(holder: Node | None, diagnostics: Diagnostics) -> ast.Initial | None:
    """The value in an ``<initialValue>`` or a ``<value>`` of an array or structure."""
    node = next(holder.all("simpleValue", "arrayValue", "structValue"), None) if holder is not None else None
    if node is None:
        return None
    if node.tag == "simpleValue":
        return texts.initial(node.attribute("value"), diagnostics) if node.get("value").strip() else None
    values = list(node.all("value"))
    inner = [initial(value, diagnostics) for value in values]
    if None in inner or not inner:
        return None
    if node.tag == "structValue":
        names = [texts.name(value, diagnostics, "member") for value in values]
        fields = tuple((name, value) for name, value in zip(names, inner) if name)
        return ast.Aggregate((), fields, node.whole)
    repeats = [max(1, value.number("repetitionValue", 1)) for value in values]
    return ast.Aggregate(tuple(zip(repeats, inner)), (), node.whole)
