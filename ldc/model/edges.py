"""Inputs with R_EDGE and F_EDGE (IEC 61131-3, 2nd edition, 2.5.2.2): inside of the POU they are the edge.

The declaration stands for an R_TRIG or F_TRIG that is called with the input when the POU is called, and each
use of the input in the body for its output Q. From outside the pin is what was put there.
"""

from __future__ import annotations

from collections.abc import Mapping

from ldc.model.names import PREFIX
from ldc.parser import ast
from ldc.records import record, replace
from ldc.symbols import Variable


@record
class Edge:
    """``pulse`` is TRUE in a call with the edge, ``memory`` what ``input`` was in the call before."""

    input: Variable
    falling: bool
    pulse: Variable
    memory: Variable

    @property
    def seen(self) -> Variable:
        """What the name of the input is in the body: it may be read as the input may."""
        return replace(self.pulse, kind="input", span=self.input.span)


def edges_of(pou: ast.Pou, variables: Mapping[str, Variable]) -> tuple[Edge, ...]:
    """The edges of a POU inputs; ``variables``: those that are right, by name in capitals."""
    found = []
    for declared in (v for block in pou.var_blocks for v in block.variables if v.edge is not None):
        variable = variables.get(declared.name.upper())
        if variable is None:
            continue
        pulse, memory = (Variable(f"{PREFIX.lower()}{word}_{variable.name}", variable.type, "hidden",
                                  retain=variable.retain) for word in ("edge", "was"))
        found.append(Edge(variable, declared.edge == "F_EDGE", pulse, memory))
    return tuple(found)
