"""The series/parallel binary tree's types: what reduction hands to IL (SPEC section 9, step 2).

A rung becomes an ordered tuple of ``Step``. A step with a ``net`` keeps the power that its tree
gives in a temporary of that net; a step without one ends at the right rail and is run for its
effects. Trees read temporaries through ``Tap``. Steps in order, and leaves of each tree from left
to right (pin trees of a block before the block), execute the elements in an order equivalent to
that of the drawing: only plain contacts may move, and not past a write of what they read.
"""

from __future__ import annotations

from ldc.model.elements import Net
from ldc.records import record


@record
class Leaf:
    """Element ``index`` of the rung.

    ``pins``: the trees of the input pins that are fed by a net, in declared order; a pin whose net
    is used elsewhere too, or carries a value, has a ``Tap`` (in a loop: a Parallel of taps).
    """

    index: int
    pins: tuple[tuple[str, Tree], ...] = ()


@record
class Tap:
    """What is kept for ``net`` (the steps and block outputs that feed it all came before), or
    (``previous``) was kept in the previous execution. Net 0 is the left rail: TRUE.

    What is tapped with ``previous`` is kept in a hidden memory (``Memories.nets``) instead of a
    temporary; it is written after every such tap of the same execution, so both read one variable.
    """

    net: Net
    previous: bool = False


@record
class Series:
    """Composition: the power that leaves a child enters the next one. At least two children."""

    children: tuple[Tree, ...]


@record
class Parallel:
    """All children get the same power; what leaves is the OR. At least two, in drawing order."""

    children: tuple[Tree, ...]


Tree = Leaf | Tap | Series | Parallel


@record
class Step:
    """``net := tree``, or the effects of ``tree`` when ``net`` is None.

    Several steps for one net, and the blocks whose output pins feed it, are joined by OR. Nets from
    ``len(graph.net_names)`` on are made by the reduction: what one element gives a net in a loop that
    others feed too.
    """

    net: Net | None
    tree: Tree


@record
class SPTree:
    """``previous``: elements whose power must be remembered for the next execution (loops through a
    block, DESIGN section 3 rule 5). ``outputs``: (block, output pin, net) for pins
    that are kept under another net than the one they are drawn to (a loop net that others feed too);
    all other output pins with a net are kept under that net when the block's leaf has run."""

    steps: tuple[Step, ...]
    previous: tuple[int, ...] = ()
    outputs: tuple[tuple[int, str, Net], ...] = ()
