"""Inputs and outputs of modules: variables with the structure that their data have in the export."""

from __future__ import annotations

from ldc.parser.foreign import Names
from ldc.parser.l5x import types
from ldc.parser.l5x.scope import Scope, Tag
from ldc.parser.l5x.starts import told
from ldc.parser.l5x.types import ATOMS, Array, Member, Structure, Type
from ldc.parser.l5x.writer import Context
from ldc.parser.plcopen.document import Node

_SUFFIX = {"InputTag": "I", "OutputTag": "O", "ConfigTag": "C"}
_RACKS = ("ICP", "POINTIO", "COMPACT", "FLEX", "5069")


def declare(controller: Node, scope: Scope, context: Context) -> None:
    """The tags of all modules, by the name that operands use: ``Local:1:I``, ``Rack:2:O``, ``Drive:I``."""
    for module in (n for group in controller.all("Modules") for n in group.all("Module")):
        place = _place(module)
        for node in module.descendants(*_SUFFIX):
            data = told(node)
            inner = data.find("Structure") if data is not None else None
            if inner is None:
                continue
            foreign = f"{place}:{_SUFFIX[node.tag]}"
            type_ = _structure(inner, context)
            tag = Tag(context.names.fresh(foreign.replace(":", "_")), foreign, type_, module.span, data=data)
            context.reading.remark("renamed", foreign, tag.name, node.span)
            if foreign.upper() not in scope.tags:
                scope.tags[foreign.upper()] = tag
                context.globals.declare(tag)


def _place(module: Node) -> str:
    """A module in a rack is known by its parent and slot, another one by its own name."""
    for port in (n for group in module.all("Ports") for n in group.all("Port")):
        if port.flag("Upstream") and port.get("Type").upper() in _RACKS and port.get("Address"):
            return f"{module.get('ParentModule')}:{port.get('Address')}"
    return module.get("Name")


def _structure(node: Node, context: Context) -> Type:
    name = node.get("DataType") or "module"
    key = f"MODULE {name.upper()}"
    known = context.types.known.get(key)
    if known is not None:
        return known
    made = Structure(context.names.fresh(name.replace(":", "_")), name, node.span)
    context.types.known[key] = made
    names = Names(context.reading)
    for child in node.children:
        foreign = child.get("Name")
        type_ = _member(child, context)
        if foreign and type_ is not None:
            made.members[foreign.upper()] = Member(names.name(foreign, child.span), type_, child.span)
    context.types.used.append(made)
    return made


def _member(node: Node, context: Context) -> Type | None:
    name = node.get("DataType")
    if node.tag == "StructureMember":
        return _structure(node, context)
    found = ATOMS.get(name.upper())
    if node.tag == "ArrayMember":
        inner = next((e.find("Structure") for e in node.all("Element")), None)
        element = _structure(inner, context) if inner is not None else found
        sizes = types.sizes(node.get("Dimensions"))
        return Array(sizes, element) if sizes and element is not None else None
    return found
