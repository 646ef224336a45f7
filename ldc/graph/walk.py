"""A series/parallel tree as a flat sequence of operations, in the order of execution.

Trees may be 10,000 deep, so nobody recurses over them: consumers run these operations on a stack.
"""

from __future__ import annotations

from collections.abc import Iterator

from ldc.graph.tree import Leaf, Parallel, Series, Tap, Tree

LEAF, TAP, FORK, NEXT, JOIN, PIN, PIN_END = range(7)
Operation = tuple[int, Leaf | Tap | str | None]
_FORK, _NEXT, _JOIN = (FORK, None), (NEXT, None), (JOIN, None)


def operations(tree: Tree) -> Iterator[Operation]:
    """LEAF leaf: the power passes the element (its pins were given before). TAP tap: AND with what is
    kept. FORK: keep the power, begin the first branch; NEXT: end a branch, begin the next with the
    same power; JOIN: end the last, go on with the OR. PIN name: keep the power, begin the tree of a
    pin with TRUE; PIN_END name: what it gives is the pin's, go on with the power kept."""
    stack: list[Tree | Operation] = [tree]
    while stack:
        node = stack.pop()
        kind = type(node)
        if kind is tuple:
            yield node
        elif kind is Leaf:
            if node.pins:
                stack.append((LEAF, node))
                for name, pin in reversed(node.pins):
                    stack += ((PIN_END, name), pin, (PIN, name))
            else:
                yield (LEAF, node)
        elif kind is Tap:
            yield (TAP, node)
        elif kind is Series:
            stack.extend(reversed(node.children))
        elif kind is Parallel:
            stack.append(_JOIN)
            for child in reversed(node.children):
                stack += (child, _NEXT)
            stack[-1] = _FORK
