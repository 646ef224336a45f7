"""What `ldc export` keeps beside a drawing, for reading it back as it was: rungs as text, names, settings.

TC6 asks other tools to preserve such data (`handleUnknown="preserve"`). It counts only while what it stands
beside is as it was written: text of a rung that somebody has drawn anew is not looked at.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterator, Sequence

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, sfc
from ldc.parser.findings import TooMany
from ldc.parser.lexer import lex
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.drawing import RAIL, VALUES, Drawing, Element
from ldc.parser.plcopen.turns import shown
from ldc.parser.units import Units
from ldc.patterns import Pattern
from ldc.records import replace
from ldc.source import Span

NAMESPACE = "urn:ldc:plcopen"
_NAME = Pattern(r"[A-Za-z_]\w{0,200}\Z", re.ASCII)
_GEOMETRY = ("position", "relPosition", "addData", "documentation")
_LOOKS = frozenset(("localId", "refLocalId", "height", "width", "globalId", "executionOrderId"))
_SAFE: dict[str, tuple[Pattern, Callable[[str], bool | int | float | str]]] = {
    "bool": (Pattern(r"(True|False)\Z"), lambda text: text == "True"),
    "int": (Pattern(r"-?\d{1,18}\Z", re.ASCII), int),
    "float": (Pattern(r"-?\d{1,40}(\.\d{1,40})?(e[+-]?\d{1,3})?\Z", re.ASCII), float),
    "str": (Pattern(r""), str),
}
_USUAL = {"negated": "false", "edge": "none", "storage": "none", "hidden": "false", "formalParameter": ""}


def own_data(node: Node, topic: str) -> Node | None:
    """Our data of a topic in an element."""
    for holder in node.all("addData"):
        for data in holder.all("data"):
            if data.get("name") == f"{NAMESPACE}/{topic}":
                return next(iter(data.children), None)
    return None


def original(node: Node, attribute: str) -> str:
    """An attribute as the exported project has it; another one may be written for the sake of other tools."""
    found = own_data(node, "originals")
    value = node.get(attribute)
    for one in found.all("original") if found is not None else ():
        if one.get("attribute") == attribute and one.get("written") == value:
            return one.get("value")
    return value


def placement(resource: Node) -> tuple[str, dict[str, int]]:
    """The processor of a resource ("" when nothing is said), and the place of each program (in capitals) in
    the order in which they were declared."""
    found = own_data(resource, "placement")
    if found is None:
        return "", {}
    processor = found.get("processor").strip()
    programs = found.get("programs").upper().split()
    return processor if _NAME.match(processor) else "", {name: at for at, name in enumerate(programs)}


def edge(variable: Node) -> str | None:
    """R_EDGE or F_EDGE of an input; TC6 has no place for it."""
    found = own_data(variable, "edge")
    word = found.get("is").strip() if found is not None else ""
    return word if word in ("R_EDGE", "F_EDGE") else None


def safe_values(root: Node) -> tuple[tuple[str, bool | int | float | str], ...]:
    """What outputs take when a task stops by a fault: `[safe]` of ldc.toml."""
    found = own_data(root, "safe")
    values: list[tuple[str, bool | int | float | str]] = []
    for one in found.all("value") if found is not None else ():
        text, kind = one.get("is"), _SAFE.get(one.get("kind"))
        if kind is not None and kind[0].match(text):
            values.append((one.get("of"), kind[1](text)))
    return tuple(values)


def transitions(holder: Node, found: Sequence[tuple[Node, sfc.Transition]]) -> list[sfc.Transition]:
    """The transitions of a chart, given in the order in which they are drawn with what draws them: as they
    were written, when each one still stands in its place and leads from and to the steps that it led to."""
    plain = [transition for _, transition in found]
    data = own_data(holder, "transitions")
    if data is None or [node.get("localId").strip() for node, _ in found] != data.get("drawn").split():
        return plain
    drawn = {node.get("localId").strip(): (node, transition) for node, transition in found}
    written = []
    for one in data.all("transition"):
        node, transition = drawn.pop(one.get("id"), (None, None))
        sources, targets = (one.get(side).upper().split() for side in ("from", "to"))
        ends = [{step.name.upper(): step for step in steps}
                for steps in (transition.sources, transition.targets)] if transition is not None else []
        if node is None or [sorted(end) for end in ends] != [sorted(sources), sorted(targets)]:
            return plain
        if node.get("priority").strip() != one.get("written"):
            return plain
        name = one.get("name") if _NAME.match(one.get("name")) else None
        priority = one.number("priority") if one.get("priority") else None
        above, below = (tuple(map(end.get, keys)) for end, keys in zip(ends, (sources, targets), strict=True))
        written.append(replace(transition, name=transition.name or name, priority=priority,
                               sources=above, targets=below))
    return plain if drawn else written


def rungs(holder: Node, drawing: Drawing) -> list[tuple[tuple[int, ...], ast.Rung]]:
    """The rungs that are drawn as they were written, from their text, each with the order of its first
    element. Takes their elements out of the drawing."""
    data = own_data(holder, "rungs")
    if data is None:
        return []
    listed = [(one, one.get("elements").split()) for one in data.all("rung")]
    nodes = {node.get("localId").strip(): node for node in drawing.body.children}
    known = {id_ for _, ids in listed for id_ in ids}
    if not all(node.get("localId").strip() in known for node in drawing.labels):
        return []  # a label that was drawn later makes a rung of its own
    outside = _read_from_outside(drawing, listed)
    found = []
    for number, (one, ids) in enumerate(listed):
        whole = number not in outside and len(set(ids)) == len(ids) and all(id_ in nodes for id_ in ids)
        if not whole or fingerprint([nodes[id_] for id_ in ids]) != one.get("digest"):
            continue
        own = [e for id_ in ids if (e := drawing.elements.get(id_)) and e.kind not in VALUES]
        rung = _rung(one.content) if own and _in_order(own) else None
        if rung is not None:
            found.append((min(e.order for e in own), rung))
            _take_out(drawing, set(ids))
    return found


def _in_order(elements: Sequence[Element]) -> bool:
    """Whether elements are still evaluated in the order in which they were written."""
    places = {e.id: e.order for e in elements}
    if list(places.values()) == sorted(places.values()):
        return True
    wires = ((source, e.id) for e in elements for pin in e.inputs for source, _ in pin.sources)
    return shown([(e.id, e.kind) for e in elements], places, wires)


def _read_from_outside(drawing: Drawing, listed: Sequence[tuple[Node, list[str]]]) -> set[int]:
    """The numbers of rungs of which an element outside of them reads."""
    of = {id_: number for number, (_, ids) in enumerate(listed) for id_ in ids}
    return {of[source[0]] for element in drawing.elements.values() for pin in element.inputs
            for source in pin.sources - {RAIL} if source[0] in of and of.get(element.id) != of[source[0]]}


def _take_out(drawing: Drawing, ids: set[str]) -> None:
    for id_ in ids:
        drawing.elements.pop(id_, None)
    drawing.labels = [node for node in drawing.labels if node.get("localId").strip() not in ids]
    drawing.notes = [node for node in drawing.notes if node.get("localId").strip() not in ids]


def _rung(text: Span) -> ast.Rung | None:
    found = Diagnostics()
    tokens = lex(text.source, text.start, text.end)
    try:
        rung = Units(tokens, found).parse("rung", 0, len(tokens.types), "rung")
    except TooMany:
        return None
    return None if found.has_errors else rung


def fingerprint(nodes: Sequence[Node]) -> str:
    """A digest of drawn elements: what they are, say and are wired to, and in which order, but not where they
    lie. Elements that they are wired to are known by their place in ``nodes``."""
    numbers = {node.get("localId").strip(): str(number) for number, node in enumerate(nodes)}
    digest = hashlib.sha256()
    for node in nodes:
        for part in _parts(node, numbers):
            digest.update(part.encode("utf-8", "replace") + b"\0")
    return digest.hexdigest()[:16]


def _parts(node: Node, numbers: dict[str, str]) -> Iterator[str]:
    work: list[Node | str] = [node]
    while work:
        node = work.pop()
        if isinstance(node, str):
            yield node
            continue
        yield f"<{node.tag}"
        for name in sorted(node.attributes.keys() - _LOOKS):
            value = node.get(name).strip()
            if value != _USUAL.get(name):
                yield f"{name}={value}"
        if "refLocalId" in node.attributes:
            yield f"from {numbers.get(node.get('refLocalId').strip(), 'elsewhere')}"
        work.append(">")
        inner = [child for child in node.children if child.tag not in _GEOMETRY]
        work += reversed(inner)
        if not node.children:
            yield " ".join(node.content.text.split())
