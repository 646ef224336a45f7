"""Calls of components in C and C++: their structures are filled from an instance, and emptied into it.

A component is a library of its own, which the host loads and binds (``ldc_bind``). Globals that it names are
copied into a window before the call and, when it writes them, back after it.
"""

from __future__ import annotations

from collections.abc import Iterator

from ldc.backends.c.places import c_name
from ldc.backends.c.values import Callee
from ldc.il import c_types
from ldc.il.block import Block, Spot
from ldc.il.external import Binding, Shared
from ldc.il.program import Unit
from ldc.records import record
from ldc.symbols import Variable
from ldc.types import Array, Instance, String


@record
class Wrapper:
    """The C file that calls the component of a unit. ``structures``: in, out and state; ``before`` and
    ``after`` move values; ``window``: bytes of the globals."""

    unit: Unit
    head: str
    bound: str
    structures: tuple[str, ...]
    before: tuple[str, ...]
    after: tuple[str, ...]
    window: int


def bound(unit: Unit) -> str:
    """The variable that holds where the component's code is."""
    return f"bound_{c_name(unit.name).upper()}"


def callee(unit: Unit) -> Callee:
    """The wrapper as generated code calls it."""
    name = f"component_{c_name(unit.name).upper()}"
    return Callee(name, f"void {name}(uint8_t *m, uint8_t *s, int64_t elapsed);", False)


def wrapper(block: Block, unit: Unit, binding: Binding) -> Wrapper:
    """The wrapper of a unit whose component was built."""
    parts = c_types.members(unit)
    structures = tuple(c_types.structure(f"part_{part}", variables) for part, variables in parts.items())
    before = [line for part in parts for v in parts[part] for line in _moved(block, unit, part, v, True)]
    after = [line for part in ("out", "state") for v in parts[part]
             for line in _moved(block, unit, part, v, False)]
    for shared in binding.shared:
        spot = block.variable(shared.name, block.shared[shared.name.upper()])
        before.append(_window(block, shared, spot, True))
        if shared.written:
            after.append(_window(block, shared, spot, False))
    head = callee(unit).declaration.rstrip(";")
    return Wrapper(unit, head, bound(unit), structures, tuple(before), tuple(after), binding.size)


def _moved(block: Block, unit: Unit, part: str, variable: Variable, into: bool) -> Iterator[str]:
    """Copies one member; only elements of arrays of strings may lie at other distances in C."""
    offset, type_ = block.member(Instance(unit.name.upper()), variable.name)
    member = f"part_{part}_.{c_types.member(variable.name)}"
    count, element = 1, type_
    while isinstance(element, Array):
        count, element = count * element.count, element.element
    size = block.measure(element)
    pieces = count if isinstance(element, String) else 1
    for n in range(pieces):
        here = f"(uint8_t *)&{member} + {n} * sizeof(part_{part}_.{c_types.member(variable.name)}) / {pieces}"
        there = f"s + {offset + n * size}"
        length = size if pieces > 1 else size * count
        pair = f"{here}, {there}" if into else f"{there}, {here}"
        yield f"__builtin_memcpy({pair}, {length});"


def _window(block: Block, shared: Shared, spot: Spot, into: bool) -> str:
    here = f"window + {shared.offset}"
    if spot.bit is not None:
        count = shared.type.count if isinstance(shared.type, Array) else 1
        image = f"m + {spot.offset}, {spot.bit}"
        return f"ldc_unpack({here}, {image}, {count});" if into else f"ldc_pack({image}, {here}, {count});"
    pair = f"{here}, m + {spot.offset}" if into else f"m + {spot.offset}, {here}"
    return f"__builtin_memcpy({pair}, {block.measure(shared.type)});"
