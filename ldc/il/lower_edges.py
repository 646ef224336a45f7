"""The code before a body whose inputs have R_EDGE or F_EDGE: what R_TRIG and F_TRIG do (library/blocks)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ldc.expr import Place
from ldc.il.program import Instr, RungCode
from ldc.model.edges import Edge
from ldc.symbols import Variable

KEY = "_ldc_edges"


def lower_edges(edges: Iterable[Edge]) -> RungCode:
    """Executed once at the beginning of each call."""
    return RungCode(KEY, tuple(instr for edge in edges for instr in _edge(edge)))


def _edge(edge: Edge) -> Iterator[Instr]:
    first, second = (edge.memory, edge.input) if edge.falling else (edge.input, edge.memory)
    yield Instr("LD", _place(first), span=edge.input.span)
    yield Instr("ANDN", _place(second), span=edge.input.span)
    yield Instr("ST", _place(edge.pulse), span=edge.input.span)
    yield Instr("LD", _place(edge.input), span=edge.input.span)
    yield Instr("ST", _place(edge.memory), span=edge.input.span)


def _place(variable: Variable) -> Place:
    return Place(variable.name, variable.type)
