"""Variable boxes of a drawing that have an edge or store: they mean a contact and a coil.

TC6 has negation, edges and storage at the boxes of variables too. An input variable with an edge is an edge
contact at the left rail; an output variable that sets, resets or waits for an edge is a coil that does.
"""

from __future__ import annotations

from ldc.parser.plcopen.document import Node

NOT_NAMED = "???"
"""What some editors write where no variable is named yet."""
_NONE = ("", "none")
_TAGS = {"inVariable": "contact", "outVariable": "coil"}


def modifier(node: Node, name: str) -> str:
    """An attribute `edge` or `storage` in small letters; "" when it says nothing."""
    found = node.get(name)
    return "" if found in _NONE else found.strip().lower()


def drawn(node: Node) -> Node:
    """The contact or coil that a box means; the box itself when it is nothing but a variable."""
    tag = _TAGS.get(node.tag)
    if tag is None or not (modifier(node, "edge") or tag == "coil" and modifier(node, "storage")):
        return node
    parts = [child.like("variable", child.children) if child.tag == "expression" else child
             for child in node.children]
    return node.like(tag, parts)


def is_negated(node: Node, reads: bool) -> bool:
    """Whether what a box gives (``reads``) or what it takes is negated; a box that does both says it twice."""
    if node.tag == "inOutVariable":
        return node.flag("negatedOut" if reads else "negatedIn")
    return node.flag("negated")
