"""Which variables of a POU live in the frame of one execution, and which may be C variables."""

from __future__ import annotations

from ldc.expr import Apply, Expr, Load, Place
from ldc.il.block import Block, Spot
from ldc.il.layout import measure
from ldc.il.statements import Assign, CallFunction, Goto, Label, Latch, Statement
from ldc.il.structure import Structured


def frame(block: Block, code: Structured) -> tuple[dict[str, int], bytes]:
    """Offsets (by name in capitals) of the variables in the frame, and its bytes at the begin of every
    execution. All of a FUNCTION are in it; of others the temporaries that may be read before they are written
    in the same rung. The rest are written first, so that they can be C variables of any function."""
    function = code.unit.kind == "FUNCTION"
    open_ = set() if function else unsettled(code)
    offsets: dict[str, int] = {}
    end = 0
    members = [v for v in code.unit.variables
               if v.kind != "external" and (function or v.name.upper() in open_)]
    for variable in members:
        size, align = measure(variable.type, block.units)
        offsets[variable.name.upper()] = end = -(-end // align) * align
        end += size
    data = bytearray(-(-end // 8) * 8)
    for variable in members:
        block.fill(data, Spot(offsets[variable.name.upper()], variable.type), variable.initial)
    return offsets, bytes(data)


def unsettled(code: Structured) -> set[str]:
    """Temporaries of the unit that some rung may read before it has surely written them."""
    temporary = {v.name.upper() for v in code.unit.variables if v.kind == "temp"}
    if not temporary:
        return set()
    rung_of = [rung for rung, _ in code.flat.places]
    entered = {target for at, target in code.flat.targets.items()
               if target < len(rung_of) and rung_of[at] != rung_of[target]}
    found: set[str] = set()
    defined: set[str] = set()
    skipped: set[int] = set()
    current = -1
    for statement in code.statements:
        at = statement.at
        if at >= len(rung_of):
            continue
        if rung_of[at] != current:
            current, defined, skipped = rung_of[at], set(), set()
        elif isinstance(statement, Label) and at in entered:
            defined.clear()
        if isinstance(statement, Label):
            skipped.discard(at)
        found |= (reads(statement) & temporary) - defined
        if isinstance(statement, Assign):
            name = statement.target.root.upper()
            if statement.target.steps:
                found |= {name} & temporary - defined
            elif not skipped:
                defined.add(name)
        elif isinstance(statement, Latch):
            found |= {statement.target.root.upper()} & temporary - defined
        elif isinstance(statement, Goto) and at < statement.target < len(rung_of) \
                and rung_of[statement.target] == current:
            skipped.add(statement.target)
    return found


def reads(statement: Statement) -> set[str]:
    """The roots, in capitals, of everything that a statement reads, indexes of its target too."""
    expressions: list[Expr] = []
    for name in ("value", "condition", "elapsed"):
        given = getattr(statement, name, None)
        if given is not None and not isinstance(given, bool):
            expressions.append(given)
    if isinstance(statement, CallFunction):
        expressions += statement.arguments
    found: set[str] = set()
    for place in (getattr(statement, "target", None), getattr(statement, "instance", None)):
        if isinstance(place, Place):
            expressions += place.indexes()
    while expressions:
        expr = expressions.pop()
        if isinstance(expr, Apply):
            expressions += expr.args
        elif isinstance(expr, Load):
            found.add(expr.place.root.upper())
            expressions += expr.place.indexes()
    return found
