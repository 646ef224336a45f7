"""Trees with some of their nodes changed: what stays the same is the same object."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ldc.model.paths import fields_of
from ldc.parser.unread import UnreadPaths
from ldc.records import is_record, replace
from ldc.source import Span


def nodes(tree: object) -> Iterator[object]:
    """All records of a tree, in the order of the text."""
    stack = [tree]
    while stack:
        node = stack.pop()
        if isinstance(node, tuple | UnreadPaths):
            stack += reversed(node)
        elif is_record(node) and not isinstance(node, Span):
            yield node
            stack += [getattr(node, name) for name in reversed(fields_of(type(node)))]


def mapped(node, change: Callable):
    """The tree with its records changed from the leaves on: ``change`` is given a record as it was, and as it
    is with what is inside of it changed."""
    if isinstance(node, tuple | UnreadPaths):
        made = tuple([mapped(part, change) for part in node])
        return node if all(a is b for a, b in zip(made, node, strict=True)) else made
    if not is_record(node) or isinstance(node, Span):
        return node
    parts = {name: getattr(node, name) for name in fields_of(type(node))}
    made = {name: new for name, old in parts.items() if (new := mapped(old, change)) is not old}
    return change(node, replace(node, **made) if made else node)
