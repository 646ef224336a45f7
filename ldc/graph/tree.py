"""The series/parallel binary tree's types: what reduction hands to IL (SPEC section 9, step 2).

A rung becomes an ordered tuple of ``Step``. A step with a ``net`` keeps the power that its tree
gives in a temporary of that net; a step without one ends at the right rail and is run for its
effects. Trees read temporaries through ``Tap``. Steps in order, and leaves of each tree from left
to right (pin trees of a block before the block), execute the elements in an order equivalent to
that of the drawing: only plain contacts may move, and not past a write of what they read.
"""

from __future__ import annotations

from dataclasses import dataclass

from ldc.model.elements import Net


@dataclass(frozen=True, slots=True)
class Leaf:
    """Element ``index`` of the rung. ``pins``: trees of input pins whose net feeds only that pin."""

    index: int
    pins: tuple[tuple[str, Tree], ...] = ()


@dataclass(frozen=True, slots=True)
class Tap:
    """The power kept for ``net`` by an earlier step, or (``previous``) in the previous execution.

    Net 0 is the left rail: TRUE.
    """

    net: Net
    previous: bool = False


@dataclass(frozen=True, slots=True)
class Series:
    """Composition: the power that leaves a child enters the next one. At least two children."""

    children: tuple[Tree, ...]


@dataclass(frozen=True, slots=True)
class Parallel:
    """All children get the same power; what leaves is the OR. At least two, in drawing order."""

    children: tuple[Tree, ...]


Tree = Leaf | Tap | Series | Parallel


@dataclass(frozen=True, slots=True)
class Step:
    """``net := tree``, or the effects of ``tree`` when ``net`` is None."""

    net: Net | None
    tree: Tree


@dataclass(frozen=True, slots=True)
class SPTree:
    """``previous``: elements whose power must be remembered for the next execution (loops through a
    block, DESIGN section 3 rule 5)."""

    steps: tuple[Step, ...]
    previous: tuple[int, ...] = ()
