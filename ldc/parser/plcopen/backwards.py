"""Drawings whose numbers of execution say that something is executed before what feeds it.

There it reads the value of the scan before, here that of this scan: told. In a loop one of the elements has to
begin, and the numbers decide which.
"""

from __future__ import annotations

from collections.abc import Iterable

from ldc.diagnostics import Diagnostics
from ldc.parser.plcopen import findings
from ldc.parser.plcopen.drawing import Drawing, Element


def tell(drawing: Drawing, group: Iterable[Element], diagnostics: Diagnostics) -> None:
    """Warn of every such element of a rung (LD0159)."""
    wires = [(source, element) for element in group for pin in element.inputs for id_, _ in pin.sources
             if id_ and (source := drawing.elements[id_]).order[0] == element.order[0] == 0]
    if all(source.order < element.order for source, element in wires):
        return
    import networkx as nx  # few files need it

    loops = nx.strongly_connected_components(nx.DiGraph((source.id, element.id) for source, element in wires))
    loop_of = {id_: number for number, ids in enumerate(loops) for id_ in ids}
    for source, element in wires:
        if source.order > element.order and loop_of[source.id] != loop_of[element.id]:
            findings.fed_later(diagnostics, element.node.span, f"{drawing.where}: {element.describe()}",
                               source.describe())
