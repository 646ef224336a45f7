"""What a PLCopen file may hold and this compiler does not read: told, never dropped in silence."""

from __future__ import annotations

from ldc.parser.foreign import Reading
from ldc.parser.plcopen.document import Node

_OBJECT_ORIENTED = {"Method": "the method", "Property": "the property", "Interface": "the interface"}


def tell(root: Node, reading: Reading) -> None:
    """Report access paths (which nothing in the program can see), methods and properties (which have an
    effect)."""
    for node in root.descendants("accessVars"):
        if node.children:
            reading.left_out(node.span, "VAR_ACCESS", "access paths are for other devices")
    for node in root.descendants(*_OBJECT_ORIENTED):
        what = f"{_OBJECT_ORIENTED[node.tag]} `{node.get('name')[:40]}`"
        help = "make it a FUNCTION_BLOCK or a FUNCTION of its own"
        reading.unsupported(node.span, what, help, "object-oriented")
