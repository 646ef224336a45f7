"""From ropes to n-ary trees: chains are flattened, branches put in the order of execution."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ldc.graph.network import PARALLEL, SERIES, Rope
from ldc.graph.tree import Leaf, Parallel, Series, Tap, Tree

Grown = tuple[Tree, int]
_LATE = 1 << 60


def strands(kind: str, rope: Rope) -> list[Rope]:
    """The members of a chain of ``kind``, left to right."""
    found, stack = [], [rope]
    while stack:
        node = stack.pop()
        if type(node) is tuple and node[0] is kind:
            stack += (node[2], node[1])
        else:
            found.append(node)
    return found


def grow(
    rope: Rope, pins_of: Callable[[int], Sequence[tuple[str, Rope]]], position: Sequence[int],
) -> Grown:
    """The tree of ``rope`` and the position in the schedule of the element that it executes first (late
    when it has none). ``pins_of``: the pin ropes of a block; ``position``: element to its place there."""
    frames: list[tuple[object, list[Rope], list[Grown]]] = [("", [rope], [])]
    while True:
        what, pending, done = frames[-1]
        if pending:
            node = pending.pop()
            kind = type(node)
            if kind is int:
                pins = pins_of(node)
                if pins:
                    frames.append(((node, [name for name, _ in pins]), [r for _, r in reversed(pins)], []))
                else:
                    done.append((Leaf(node), position[node]))
            elif kind is Tap:
                done.append((node, _LATE))
            else:
                frames.append((node[0], strands(node[0], node)[::-1], []))
            continue
        frames.pop()
        if not frames:
            return done[0]
        if what is PARALLEL:
            done.sort(key=_first)
        first = next((at for _, at in done if at != _LATE), _LATE)
        members = tuple([tree for tree, _ in done])
        if what is SERIES:
            tree: Tree = Series(members)
        elif what is PARALLEL:
            tree = Parallel(members)
        else:
            index, names = what
            tree = Leaf(index, tuple(zip(names, members)))
            first = position[index] if first == _LATE else first
        frames[-1][2].append((tree, first))


def _first(grown: Grown) -> int:
    return grown[1]
