"""The order of evaluation in an LD body, as numbers only where places do not show it.

Other editors sort coils by their places alone and evaluate whatever has a number before them, so numbers that
are not needed would put all blocks of a POU before its first coil.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element

from ldc.parser.plcopen.turns import Place, shown

_ORDER = "executionOrderId"


def drop_shown(ladder: Element) -> None:
    """Takes the numbers away if the places of the elements say the same."""
    numbered = {element.get("localId"): element for element in ladder if element.get(_ORDER) is not None}
    wires = ((wire.get("refLocalId"), id_) for id_, element in numbered.items()
             for wire in element.iter("connection"))
    if shown([(id_, element.tag) for id_, element in numbered.items()],
             {id_: _place(element) for id_, element in numbered.items()}, wires):
        for element in numbered.values():
            del element.attrib[_ORDER]


def _place(element: Element) -> Place:
    position = element.find("position")
    return float(position.get("y")), float(position.get("x"))
