"""The order of evaluation in an LD body, as numbers only where places do not show it.

Other editors sort coils by their places alone and evaluate whatever has a number before them, so numbers that
are not needed would put all blocks of a POU before its first coil.
"""

from __future__ import annotations

from xml.etree.ElementTree import Element

from ldc.parser.plcopen.turns import Place, in_loops, shown

_ORDER = "executionOrderId"


def drop_shown(ladder: Element) -> None:
    """Takes the numbers away if the places of the elements say the same."""
    numbered = {element.get("localId"): element for element in ladder if element.get(_ORDER) is not None}
    wires = [(wire.get("refLocalId"), id_) for id_, element in numbered.items()
             for wire in element.iter("connection")]
    written = [(id_, element.tag) for id_, element in numbered.items()]
    by_place = sorted(written, key=lambda entry: _place(numbered[entry[0]]))
    sources: dict[str, list[str]] = {id_: [] for id_ in numbered}
    for source, id_ in wires:
        if source in numbered:
            sources[id_].append(source)
    turns, loops = in_loops(dict(by_place), sources)
    if any(numbered[id_].tag == "contact" for loop in loops for id_ in loop):
        return  # without numbers it would be read in this scan
    if shown(written, {id_: (turn,) for turn, id_ in enumerate(turns)}, wires):
        for element in numbered.values():
            del element.attrib[_ORDER]


def _place(element: Element) -> Place:
    position = element.find("position")
    return float(position.get("y")), float(position.get("x"))
