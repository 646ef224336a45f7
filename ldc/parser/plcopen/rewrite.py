"""Trees with other nodes in them: bottom-up, in a loop, for chains of operators may be a thousand long."""

from __future__ import annotations

from collections.abc import Callable

from ldc.records import is_record, replace
from ldc.source import Span


def _is_node(value: object) -> bool:
    return type(value) is tuple or is_record(value) and not isinstance(value, Span)


def rewritten(tree: object, change: Callable[[object], object]) -> object:
    """The tree with ``change(node)`` in place of every node, the inner ones first. What is not changed is the
    same object as before."""
    work: list[tuple[object, bool]] = [(tree, False)]
    done: list[object] = []
    while work:
        node, entered = work.pop()
        parts = list(node) if type(node) is tuple else [getattr(node, name) for name in type(node).__match_args__]
        inner = [at for at, part in enumerate(parts) if _is_node(part)]
        if not entered and inner:
            work.append((node, True))
            work += ((parts[at], False) for at in reversed(inner))
            continue
        if inner:
            new = done[-len(inner):]
            del done[-len(inner):]
            changed = [(at, made) for at, made in zip(inner, new, strict=True) if made is not parts[at]]
            if changed and type(node) is tuple:
                for at, made in changed:
                    parts[at] = made
                node = tuple(parts)
            elif changed:
                names = type(node).__match_args__
                node = replace(node, **{names[at]: made for at, made in changed})
        done.append(node if type(node) is tuple else change(node))
    return done[0]
