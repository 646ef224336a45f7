"""The rungs of a graphical body: which elements belong together, in which order, under which name."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable
from itertools import accumulate

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.plcopen import findings, kept, texts
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.drawing import RAIL, VALUES, Drawing, Element, Input
from ldc.parser.plcopen.guarded import Additions
from ldc.parser.plcopen.rung import RungWriter

_ON = frozenset((RAIL,))
_SETTINGS = ("fbdattributes",)
"""What is in elements of a vendor that say something of a body, and have no words of their own."""
_UNFED = ("block", *VALUES)
"""What may stand in a drawing though nothing feeds it."""


def ladder(
    body: Node, where: str, more: Additions, diagnostics: Diagnostics, holder: Node | None = None
) -> ast.LadderBody:
    """What is drawn, as rungs; ``more`` takes what they need beside what is declared. A rung is what hangs
    together without the rails; rungs follow each other by their first elements. ``holder``: the element
    around the body, in which the text of rungs may be kept."""
    drawing = Drawing(body, where, more, diagnostics)
    return rungs_of(drawing, diagnostics, kept.rungs(holder, drawing) if holder is not None else ())


def rungs_of(
    drawing: Drawing, diagnostics: Diagnostics, written: Iterable[tuple[tuple[int, ...], ast.Rung]] = ()
) -> ast.LadderBody:
    """The rungs of a drawing, and between them those that are ``written``, each with its place."""
    _drop_loose(drawing, diagnostics)
    groups = _together(drawing)
    places = _Places(groups)
    names, other = _labels(drawing, places)
    titles = _titles(drawing, places)
    found = [(order, rung, False) for order, rung in written]
    for index, group in enumerate(groups):
        writer = RungWriter(drawing, group, other, diagnostics)
        rung = writer.rung(names.get(index), titles.get(index))
        if rung is not None:
            found.append((group[0].order, rung, writer.failed))
    rungs: list[ast.Rung] = []
    unread: list[tuple[int, ast.Rung]] = []
    for _, rung, failed in sorted(found, key=lambda entry: entry[0]):
        if failed:
            unread.append((len(rungs), rung))
        else:
            rungs.append(rung)
    return ast.LadderBody(tuple(rungs), drawing.body.whole, tuple(unread))


def _drop_loose(drawing: Drawing, diagnostics: Diagnostics) -> None:
    """Leave out contacts that nothing feeds or that feed nothing, and coils and jumps that nothing feeds;
    editors leave such parts behind. In a body without a left rail an open input is at the rail."""
    elements = drawing.elements
    if not drawing.has_rail:
        for element in elements.values():
            if element.kind == "contact" and not element.inputs[0].sources and not element.inputs[0].cut:
                element.inputs[0].sources = _ON
    used: set[str] = set()
    for element in elements.values():
        if element.kind in ("jump", "return") and not element.inputs[0].sources and not element.inputs[0].cut:
            element.inputs[0].sources = _ON
        for pin in element.inputs:
            if RAIL in pin.sources:  # what is wired beside the rail changes nothing
                pin.sources = _ON
            else:
                used.update([id_ for id_, _ in pin.sources])
    for element in elements.values():
        if element.kind == "inVariable" and element.id not in used and not drawing.broken:
            what = f"{drawing.where}: {element.describe()}"
            findings.loose(diagnostics, element.node.span, what, "is wired to nothing")
    work = [e for e in elements.values() if _is_unfed(e) or e.kind == "contact" and e.id not in used]
    if work:
        _take_out(drawing, work, diagnostics)


def _is_unfed(element: Element) -> bool:
    if element.kind in _UNFED:
        return False
    first = element.inputs[0]
    return not first.sources and first.text is None


def _take_out(drawing: Drawing, work: list[Element], diagnostics: Diagnostics) -> None:
    """Leave out elements that are loose, and what is loose without them."""
    elements = drawing.elements
    feeds: dict[str, list[tuple[Element, Input]]] = {}
    for element in elements.values():
        for pin in element.inputs:
            for id_, _ in pin.sources:
                feeds.setdefault(id_, []).append((element, pin))
    users = {id_: len(feeds.get(id_, ())) for id_ in elements}
    gone: set[str] = set()
    while work:
        element = work.pop()
        if element.id in gone:
            continue
        unfed = _is_unfed(element)
        if not unfed and (element.kind != "contact" or users[element.id]):
            continue
        gone.add(element.id)
        why = "is fed by nothing" if unfed else "leads to no coil, block or jump"
        if not drawing.broken:
            findings.loose(diagnostics, element.node.span, f"{drawing.where}: {element.describe()}", why)
        for user, pin in feeds.get(element.id, ()):
            pin.sources = frozenset(s for s in pin.sources if s[0] != element.id)
            pin.cut = True
            work.append(user)
        for pin in element.inputs:
            for id_, _ in pin.sources - _ON:
                users[id_] -= 1
                work.append(elements[id_])
    for id_ in gone:
        del elements[id_]


def _together(drawing: Drawing) -> list[list[Element]]:
    """The groups of connected elements, each in drawing order. Groups whose execution numbers interleave
    are one rung, for the order to be kept."""
    members = [e for e in drawing.elements.values() if e.kind not in VALUES]
    parts = {e.id: [e] for e in members}
    for element in members:
        for pin in element.inputs:
            for id_, _ in pin.sources:
                less, more = parts[element.id], parts.get(id_)
                if more is None or more is less:
                    continue
                if len(less) > len(more):
                    less, more = more, less
                more += less
                for moved in less:
                    parts[moved.id] = more
    groups: dict[int, list[Element]] = {}
    for element in members:
        groups.setdefault(id(parts[element.id]), []).append(element)
    found: list[list[Element]] = []
    for group in sorted(groups.values(), key=lambda g: g[0].order):
        numbered = [e.order for e in group if e.order[0] == 0]
        before = [e.order for e in found[-1] if e.order[0] == 0] if found else []
        if numbered and before and numbered[0] < before[-1]:
            found[-1] = sorted(found[-1] + group, key=lambda e: e.order)
        else:
            found.append(group)
    return found


def _labels(drawing: Drawing, places: _Places) -> tuple[dict[int, str], dict[str, str]]:
    """Rungs that have a label: its name, by their number; and what other labels mean (a second label at
    one rung its first one, a label behind the last rung the end)."""
    names: dict[int, str] = {}
    other: dict[str, str] = {}
    for node in drawing.labels:
        label = texts.label(node.get("label"), "label")
        index = places.rung_at(node)
        if index is None:
            other[label.upper()] = "RETURN"
        elif index in names:
            other[label.upper()] = names[index]
        else:
            names[index] = label
    return names, other


def _titles(drawing: Drawing, places: _Places) -> dict[int, str]:
    titles: dict[int, str] = {}
    for node in drawing.notes:
        if node.tag == "vendorElement" and next(node.descendants(*_SETTINGS), None) is not None:
            continue
        text = texts.prose(node.find("content") or node.find("alternativeText"))
        index = places.rung_at(node) if text else None
        if index is not None:
            titles[index] = f"{titles[index]}; {text}" if index in titles else text
    return {index: title[:200] for index, title in titles.items()}


class _Places:
    """Where rungs are: for what belongs to the next one."""

    def __init__(self, groups: list[list[Element]]) -> None:
        self.placed = any(element.position != (0, 0) for group in groups for element in group)
        ends = (max(e.position[0] if self.placed else e.node.start for e in group) for group in groups)
        self.ends = list(accumulate(ends, max))

    def rung_at(self, node: Node) -> int | None:
        """The first rung that ends beside or below something; without positions, behind it in the text."""
        at = node.find("position")
        y = (at.number("y") if at is not None else 0) if self.placed else node.start
        index = bisect_left(self.ends, y)
        return index if index < len(self.ends) else None
