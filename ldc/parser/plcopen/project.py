"""A PLCopen TC6 XML file to the tree that every source gives."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics, Severity
from ldc.parser import ast
from ldc.parser.findings import TooMany
from ldc.parser.lexer import lex
from ldc.parser.plcopen import configuration, findings, interface, texts
from ldc.parser.plcopen.body import ladder
from ldc.parser.plcopen.document import Document, Node
from ldc.parser.statements import StatementBody
from ldc.parser.structured import read_body
from ldc.parser.units import Units
from ldc.source import SourceFile, Span

_KINDS = {"program": "PROGRAM", "functionBlock": "FUNCTION_BLOCK", "function": "FUNCTION"}
_GRAPHICAL = ("LD", "FBD")


def is_xml(source: SourceFile) -> bool:
    """Whether a source is XML: no text language of ours begins with ``<``."""
    return source.text[:1] == "<" or source.text.lstrip()[:1] == "<"


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """All POUs, types, global variables and configurations of the project (codes LD014x)."""
    root = Document(source, diagnostics).root
    if root is not None and root.tag != "project":
        findings.no_project(diagnostics, root.span, root.tag)
        root = None
    if root is None:
        return ast.File(source, (), (), (), (), (), True)
    before = {d.sort_key for d in diagnostics}
    types = (interface.type_decl(node, diagnostics) for node in root.descendants("dataType"))
    pous = (_pou(node, diagnostics) for node in root.descendants("pou"))
    types, pous = tuple(t for t in types if t), tuple(p for p in pous if p)
    configurations, loose = _instances(root, diagnostics)
    if not (types or pous or loose or configurations or diagnostics.has_errors):
        findings.no_project(diagnostics, root.span, root.tag)
    lost = any(d.severity is Severity.ERROR and d.sort_key not in before for d in diagnostics)
    return ast.File(source, pous, types, loose, configurations, (), lost)


def _instances(
    root: Node, diagnostics: Diagnostics
) -> tuple[tuple[ast.Configuration, ...], tuple[ast.VarBlock, ...]]:
    """Configurations; a resource that stands alone (as one tool exports it) gets one of its own."""
    found = [configuration.configuration(node, diagnostics)
             for node in root.descendants("configuration") if node.children]
    alone = [node for data in root.all("addData") for node in data.descendants("resource")]
    resources = [configuration.resource(node, diagnostics) for node in alone]
    if resources:
        found.append(ast.Configuration(f"{resources[0].name}_configuration", (), tuple(resources),
                                       alone[0].whole))
    holders = [root, *root.all("types", "addData")]
    loose = [node for holder in holders for node in holder.all("globalVars")]
    loose += [node for data in root.all("addData") for node in data.descendants("globalVars", "resource")
              if node.tag == "globalVars"]
    return tuple(found), tuple(interface.var_block(node, diagnostics) for node in loose)


def _pou(node: Node, diagnostics: Diagnostics) -> ast.Pou | None:
    name = texts.name(node, diagnostics)
    kind = _KINDS.get(node.get("pouType"))
    if kind is None:
        findings.malformed(diagnostics, node.span, f"`{node.get('pouType')[:40]}` is no kind of POU",
                           "pouType is program, functionBlock or function")
    if name is None or kind is None:
        return None
    declared, result, blocks = node.find("interface"), None, ()
    if declared is not None:
        blocks = interface.var_blocks(declared, diagnostics)
        if kind == "FUNCTION":
            result = interface.type_of(declared.find("returnType"), node, diagnostics)
    title = texts.prose(node.find("documentation")) or None
    body, made = _body(node, name, diagnostics)
    if made:
        blocks = (*blocks, ast.VarBlock("VAR", (), made, node.span))
    return ast.Pou(kind, name, title, result, blocks, body, node.whole, node.attribute("name"))


def _statements(text: Span, diagnostics: Diagnostics) -> StatementBody:
    tokens = lex(text.source, text.start, text.end)
    try:
        return read_body(Units(tokens, diagnostics), 0, len(tokens.types), text)
    except TooMany:
        return StatementBody((), text)


def _body(
    pou: Node, name: str, diagnostics: Diagnostics
) -> tuple[ast.LadderBody | ast.TextBody | StatementBody, tuple[ast.VarDecl, ...]]:
    """The first body that says something, and variables that it needs beside those that are declared. A
    POU keeps its interface when its body cannot be read."""
    for holder in pou.all("body"):
        for node in holder.children:
            if node.tag in _GRAPHICAL:
                return ladder(node, name, diagnostics)
            if node.tag == "IL":
                return ast.TextBody(node.tag, node.body), ()
            if node.tag == "ST":
                return _statements(node.body, diagnostics), ()
            if node.tag == "SFC":
                findings.unsupported(
                    diagnostics, node.span, f"the body of {name} is a sequential function chart",
                    "an SFC", "ldc reads LD, FBD, ST and IL: write the sequence as one of them")
    at = pou.find("body") or pou
    return ast.LadderBody((), Span(at.span.source, at.stop, at.stop)), ()
