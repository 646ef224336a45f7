"""Trees of frozen dataclasses as indented text: what `ldc compile --emit ast` prints.

Places in the source are left out, so that two texts that mean the same print the same.
"""

from __future__ import annotations

from ldc.records import is_record
from ldc.source import SourceFile, Span


def dump(root: object) -> str:
    """One line a node: its class, its plain fields; below it, indented, the fields that hold nodes.

    Works with a stack of its own: a chain of ten thousand operators is as deep a tree.
    """
    lines: list[str] = []
    todo: list[tuple[int, str, object]] = [(0, "", root)]
    while todo:
        depth, name, value = todo.pop()
        indent = "  " * min(depth, 60)
        if isinstance(value, tuple):
            lines.append(f"{indent}{name}:")
            todo += [(depth + 1, "", item) for item in reversed(value)]
        elif is_record(value):
            plain, below = [], []
            for field in value.__match_args__:
                content = getattr(value, field)
                if isinstance(content, SourceFile):
                    plain.append(content.path)
                elif content is None or isinstance(content, Span) or content == ():
                    continue
                elif _holds_nodes(content):
                    below.append((depth + 1, field, content))
                else:
                    plain.append(f"{field}={_plain(content)}")
            lines.append(" ".join([f"{indent}{name + ': ' if name else ''}{type(value).__name__}", *plain]))
            todo += reversed(below)
        else:
            lines.append(f"{indent}{name + ': ' if name else ''}{_plain(value)}")
    return "\n".join(lines) + "\n"


def _holds_nodes(value: object) -> bool:
    if isinstance(value, tuple):
        return any(map(_holds_nodes, value))
    return is_record(value)


def _plain(value: object) -> str:
    if isinstance(value, tuple):
        return "(" + ", ".join(map(_plain, value)) + ")"
    return value if isinstance(value, str) and value.isidentifier() else repr(value)
