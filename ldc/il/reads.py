"""What statements read, and calls that may stand where their result is read."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ldc.expr import Expr, Load, Place, nodes
from ldc.il import statements as il


def loads(expr: Expr) -> Iterator[Place]:
    """Every place that an expression reads."""
    return (node.place for node in nodes(expr) if type(node) is Load)


def read_once(statements: Iterable[il.Statement]) -> frozenset[il.CallFunction]:
    """Calls of FUNCTIONs without outputs whose result one expression reads, as a whole and once, before it is
    written again."""
    found: set[il.CallFunction] = set()
    calls: dict[str, list] = {}  # by temporary: the last call that wrote it, and how often it was read since
    for s in statements:
        for place, whole in _read_in(s):
            if (last := calls.get(place.root.upper())) is not None:
                last[1] += 1 if whole else 2
        called = isinstance(s, il.CallFunction)
        written = s.result if called else s.target if isinstance(s, il.Assign) else None
        if written is None:
            continue
        call, reads = calls.pop(written.root.upper(), (None, 0))
        found |= {call} if reads == 1 else set()
        if called and not s.outputs:
            calls[written.root.upper()] = [s, 0]
    return frozenset(found | {call for call, reads in calls.values() if reads == 1})


def _read_in(s: il.Statement) -> Iterator[tuple[Place, bool]]:
    """The places that a statement reads, and whether they stand in a value as a whole."""
    values: tuple[Expr | None, ...] = ()
    places: tuple[Place, ...] = ()
    match s:
        case il.Assign(target=target, value=value):
            values, places = (value,), (target,)
        case il.Latch(target=target, condition=condition):
            values, places = (condition,), (target,)
        case il.CallBlock(instance=instance, condition=condition):
            values, places = (condition,), (instance,)
        case il.CallFunction(arguments=arguments, outputs=outputs):
            values, places = arguments, tuple(place for _, place in outputs)
        case il.Goto(condition=condition) | il.Return(condition=condition):
            values = (condition,)
    for value in values:
        if value is not None:
            yield from ((place, not place.steps) for place in loads(value))
    for place in places:
        yield from ((read, False) for index in place.indexes() for read in loads(index))


def reads(call: il.CallFunction, root: str) -> bool:
    """Whether the arguments of a call read a variable."""
    return any(place.root.upper() == root.upper() for place, _ in _read_in(call))
