"""A PLCopen TC6 XML file to the tree that every source gives."""

from __future__ import annotations

from collections.abc import Callable

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.findings import MAX_STATEMENTS
from ldc.parser.foreign import Reading
from ldc.parser.plcopen import (
    additional,
    addresses,
    attributes,
    bodies,
    configuration,
    edition,
    findings,
    inputs,
    interface,
    invocations,
    kept,
    kinds,
    names,
    others,
    sections,
    texts,
    written,
)
from ldc.parser.plcopen.body import ladder
from ldc.parser.plcopen.conversions import written_out
from ldc.parser.plcopen.document import Document, Node
from ldc.parser.plcopen.guarded import Additions, added, pins_of, retype
from ldc.parser.plcopen.lists import Lists, are_named
from ldc.parser.plcopen.sfc import ChartReader, nested
from ldc.parser.plcopen.structured import statements
from ldc.parser.sfc import Action, Body, SfcBody
from ldc.parser.statements import StatementBody
from ldc.records import record, replace
from ldc.source import SourceFile, Span

_KINDS = {"program": "PROGRAM", "functionblock": "FUNCTION_BLOCK", "function": "FUNCTION"}
_NOT_OURS = ("libraryBlocks",)
"""Interfaces of blocks of the editor, in additional data."""


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """All POUs, types, global variables and configurations of the project (codes LD014x)."""
    reading = Reading(source, "PLCopen XML", diagnostics)
    spelled = names.legal(source, reading)
    root = Document(spelled, diagnostics).root
    lists = Lists(root) if root is not None and are_named(source) else None
    if lists is not None and (plain := lists.unqualified(spelled)) is not spelled:
        root = Document(plain, diagnostics).root
    if root is not None and root.tag == "projects":  # one project in a list, as one editor writes it
        root = next(root.all("project"), root)
    own: frozenset[str] = frozenset()
    if root is not None and edition.is_project(root):
        root, own = edition.project(root, diagnostics), edition.ATTRIBUTES
    if root is not None and root.tag not in ("project", "pou"):
        findings.no_project(diagnostics, root.span, root.tag)
        root = None
    if root is None:
        return ast.File(source, (), (), (), (), (), True)
    if source.text.count(";") - source.text.count("&") > MAX_STATEMENTS:
        findings.too_large(diagnostics, root.span, MAX_STATEMENTS, "statements")
        return ast.File(source, (), (), (), (), (), True)
    others.tell(root, reading)
    attributes.tell(root.document, reading, own)
    types = (interface.type_decl(node, diagnostics) for node in root.descendants("dataType"))
    configurations, loose = _instances(root, diagnostics)
    shared = [*loose, *(block for c in configurations for holder in (c, *c.resources)
                        for block in holder.var_blocks)]
    types = tuple(t for t in types if t)
    pous = _pous(root, [v for block in shared for v in block.variables], types, reading)
    configurations = configuration.running(configurations, pous, diagnostics)
    if not (types or pous or loose or configurations or diagnostics.has_errors):
        findings.no_project(diagnostics, root.span, root.tag)
    remarks = reading.remarks
    if lists is not None:
        remarks += lists.remarks(source)
        loose = tuple(lists.named(block, remarks) for block in loose)
        configurations = tuple(_named(found, lists, remarks) for found in configurations)
    pous += additional.wanted(pous, shared, (found.name for found in (*pous, *types)), source.text)
    pous = sections.legal(pous, shared, reading)
    pous, loose, configurations = inputs.without_addresses(pous, loose, configurations, reading)
    groups = [loose, *(pou.var_blocks for pou in pous),
              *(holder.var_blocks for c in configurations for holder in (c, *c.resources))]
    placed = addresses.mended(groups, reading)
    pous = tuple(replace(pou, var_blocks=placed(pou.var_blocks)) for pou in pous)
    loose, configurations = placed(loose), tuple(_placed(found, placed) for found in configurations)
    return ast.File(source, pous, types, loose, configurations, (), False, tuple(remarks),
                    kept.safe_values(root))


def _placed(
    found: ast.Configuration, placed: Callable[[tuple[ast.VarBlock, ...]], tuple[ast.VarBlock, ...]]
) -> ast.Configuration:
    resources = tuple(replace(r, var_blocks=placed(r.var_blocks)) for r in found.resources)
    return replace(found, var_blocks=placed(found.var_blocks), resources=resources)


def _named(found: ast.Configuration, lists: Lists, remarks: list[ast.Remark]) -> ast.Configuration:
    def blocks(holder: ast.Configuration | ast.Resource) -> tuple[ast.VarBlock, ...]:
        return tuple(lists.named(block, remarks) for block in holder.var_blocks)

    resources = tuple(replace(r, var_blocks=blocks(r)) for r in found.resources)
    return replace(found, var_blocks=blocks(found), resources=resources)


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


@record
class _Head:
    """A POU without its body. ``actions``: further bodies with names, of a POU that is no chart."""

    node: Node
    kind: str
    name: str
    result: ast.TypeExpr | None
    sections: tuple[ast.VarBlock, ...]
    actions: tuple[Node, ...]


def _head(node: Node, diagnostics: Diagnostics) -> _Head | None:
    name = texts.name(node, diagnostics)
    kind = _KINDS.get(node.get("pouType").lower())
    if kind is None:
        findings.malformed(diagnostics, node.span, f"`{node.get('pouType')[:40]}` is no kind of POU",
                           "pouType is program, functionBlock or function")
    if name is None or kind is None:
        return None
    declared, result, sections = node.find("interface"), None, ()
    if declared is not None:
        sections = interface.var_blocks(declared, diagnostics)
    sections = sections or written.sections(node, diagnostics)
    if declared is not None:
        if kind == "FUNCTION" and declared.find("returnType") is not None:
            result = interface.type_of(declared.find("returnType"), node, diagnostics)
    charts = any(body.find("SFC") is not None for body in node.all("body"))
    actions = tuple(action for action in (node.find("actions") or node).all("action")
                    if not charts and texts.name(action, diagnostics) is not None)
    return _Head(node, kind, name, result, sections, actions)


def _pous(
    root: Node, shared: list[ast.VarDecl], types: tuple[ast.TypeDecl, ...], reading: Reading
) -> tuple[ast.Pou, ...]:
    """All POUs, and behind them the function blocks that their drawings need. ``shared``: global variables."""
    diagnostics = reading.diagnostics
    nodes = [root] if root.tag == "pou" else root.descendants("pou", *_NOT_OURS)
    heads = [h for node in nodes if node.tag == "pou" and (h := _head(node, diagnostics)) is not None]
    interfaces = {h.name.upper(): pins_of(h.sections) for h in heads if h.kind == "FUNCTION_BLOCK"}
    functions = {h.name.upper(): pins_of(h.sections) for h in heads if h.kind == "FUNCTION"}
    members = kinds.Members({t.name.upper(): t.type for t in types}, {
        name: {v.name.upper(): v.type for kind in ("VAR_INPUT", "VAR_OUTPUT") for v in pins[kind]}
        for name, pins in interfaces.items()})
    parts = members.numbers()
    actions = frozenset(node.get("name").strip().upper() for head in heads for node in head.actions)
    made: dict[str, ast.Pou] = {}
    pous = []
    for head in heads:
        local = {v.name.upper(): v for section in head.sections for v in section.variables}
        seen = kinds.Numbers((*shared, *local.values()), members)
        seen = seen if kinds.may_mix((*seen.values(), *parts)) else {}
        fixed = frozenset(v.name.upper() for section in head.sections for v in section.variables
                          if section.kind == "VAR_INPUT" or "CONSTANT" in section.qualifiers)
        more = Additions(interfaces, local, pous=made, functions=functions, numbers=seen, actions=actions,
                         fixed=fixed)
        bodies = [_body(node, head, more, diagnostics) for node in (head.node, *head.actions)]
        reading.remarks += more.remarks(head.name)
        for at, one in enumerate(bodies):
            if isinstance(one, StatementBody | SfcBody):
                bodies[at] = invocations.standard(one, local, interfaces)
                if seen:
                    pins = invocations.numbers(local, interfaces)
                    bodies[at] = written_out(bodies[at], seen, pins, diagnostics)
        own = tuple(Action(node.get("name").strip(), one, node.whole, node.attribute("name"))
                    for node, one in zip(head.actions, bodies[1:], strict=True))
        sections = retype(head.sections, more.retyped)
        if more.variables:
            sections = (*sections, ast.VarBlock("VAR", (), tuple(more.variables), head.node.span))
        title = texts.prose(head.node.find("documentation")) or None
        pous.append(ast.Pou(head.kind, head.name, title, head.result, sections, bodies[0], head.node.whole,
                            head.node.attribute("name"), own))
    reading.remarks += map(added, made.values())
    return (*pous, *made.values())


def _body(
    pou: Node, head: _Head, more: Additions, diagnostics: Diagnostics
) -> Body | SfcBody:
    """The first body that says something in a POU or an action of it. A POU keeps its interface when its body
    cannot be read."""
    for holder in pou.all("body"):
        for node in bodies.languages(holder):
            if node.tag in bodies.GRAPHICAL:
                return ladder(node, head.name, more, diagnostics, holder)
            if node.tag == "IL":
                return ast.TextBody(node.tag, node.body)
            if node.tag == "ST":
                return statements(node.body, diagnostics, more if pou.get("pouType") != "function" else None)
            if node.tag == "SFC" and pou is head.node:
                return ChartReader(pou, holder, node, head.name, more, diagnostics).chart()
            if node.tag == "SFC":
                return nested(head.node, node, pou.get("name").strip(), holder, head.name, more, diagnostics)
    at = pou.find("body") or pou
    return ast.LadderBody((), Span(at.span.source, at.stop, at.stop))
