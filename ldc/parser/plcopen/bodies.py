"""The body of a POU, an action or a transition: in which languages it is written."""

from __future__ import annotations

from collections.abc import Iterator

from ldc.parser.plcopen.document import Node

GRAPHICAL = ("LD", "FBD", "CFC")


def languages(holder: Node) -> Iterator[Node]:
    """What stands in a body, by languages. A continuous function chart, which TC6 does not have, is
    additional data beside an empty body in another one: it comes first."""
    for data in holder.all("addData"):
        yield from (chart for chart in data.descendants("CFC") if chart.children)
    yield from holder.children
