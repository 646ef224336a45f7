"""The rungs, networks and charts of a body in XML of IEC 61131-10, as the elements of a drawing of TC6."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from ldc.parser.plcopen import kinds, sequences
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.sequences import kind

_APART = 1_000
"""Between networks that have no places: each lies below the one before."""
_LISTS = {"InputVariables": "inputVariables", "InOutVariables": "inOutVariables",
          "OutputVariables": "outputVariables"}
_PINS = ("InputVariable", "InOutVariable", "OutputVariable")
_TAGS = {"Contact": "contact", "CompareContact": "contact", "Coil": "coil", "DataSource": "inVariable",
         "DataSink": "outVariable", "LeftPowerRail": "leftPowerRail", "RightPowerRail": "rightPowerRail",
         "Block": "block", "Jump": "jump", "Return": "return", "Connector": "connector",
         "Continuation": "continuation"}
_OPERANDS = {"operand": "variable", "operand1": "variable", "operand2": "variable1",
             "identifier": "expression"}
"""Attributes that hold an operand, and the element that does in TC6."""
_COMPARED = {sign: name for name, sign in kinds.COMPARING.items()}
_TAGS |= sequences.TAGS
_SAME = ("negated", "edge", "typeName", "instanceName", "name", "label", *sequences.ATTRIBUTES)
_KNOWN = frozenset((*_SAME, *_OPERANDS, "type", "globalId", "latch", "targetNetworkLabel", "compareOperator"))
_PASSED = frozenset(("RelPosition", "Size", "Documentation", "AddData", "Type", "ConnectionPointIn",
                     "ConnectionPointOut", *_LISTS, *sequences.PARTS))
_OBJECTS = ("LdObject", "FbdObject", "CommonObject", "SfcObject")

Placed = tuple[Node, tuple[int, int]]
Tell = Callable[[Node, str, str], None]


class Networks:
    """``elements``: what was drawn so far. Elements are numbered through all networks of a body. ``body``
    reads a body that stands inside of an element."""

    def __init__(self, tell: Tell, body: Callable[[Node], Node]) -> None:
        self.tell, self.body = tell, body
        self.elements: list[Node] = []
        self._next, self._below = 1, 0

    def add(self, body: Node) -> None:
        networks = list(body.all("Rung", "Network"))
        networks.sort(key=lambda network: network.number("evaluationOrder"))
        for network in networks:
            self._network(network)

    def chart(self, body: Node) -> None:
        """A chart, and beside it the networks of its conditions, which stand inside of its transitions: all
        outputs of a chart are numbered together."""
        found: list[Placed] = []
        for holder in (body, *body.all("Network")):
            for node in holder.all(*_OBJECTS):
                own = _place(node) or (0, 0)
                found.append((node, own))
                for drawn in sequences.networks(node):
                    x, y = _place(drawn) or (0, 0)
                    for inner in drawn.all(*_OBJECTS):
                        to = _place(inner) or (0, 0)
                        found.append((inner, (own[0] + x + to[0], own[1] + y + to[1])))
        self._all(found)

    def _network(self, network: Node) -> None:
        own = _place(network)
        top = max(self._below, own[1] if own is not None else 0)
        left = own[0] if own is not None else 0
        if network.get("label").strip():
            label = {"label": network.get("label")}
            self.elements.append(self._made(network, "label", (), label, (left, top)))
        found: list[Placed] = []
        for at, node in enumerate(network.all(*_OBJECTS)):
            x, y = _place(node) or (10 * at, 0)
            found.append((node, (left + x, top + y)))
        self._all(found)
        lowest = max((y for _, (_, y) in found), default=top)
        self._below = max(top, lowest) + (1 if own is not None else _APART)

    def _all(self, found: Sequence[Placed]) -> None:
        """The elements, whose outputs are numbered together."""
        numbers = range(self._next, self._next + len(found))
        outputs = {number: (str(id_) if kind(node) in _TAGS else "", pin)
                   for id_, (node, _) in zip(numbers, found) for number, pin in _outputs(node)}
        for node, place in found:
            made = self._object(node, outputs, place)
            if made is not None:
                self.elements.append(made)

    def _made(self, node: Node, tag: str, parts: Sequence[Node], attributes: dict[str, str],
              place: tuple[int, int]) -> Node:
        at = node.like("position", (), {"x": str(place[0]), "y": str(place[1])})
        made = node.like(tag, (at, *parts), {"localId": str(self._next), **attributes})
        self._next += 1
        return made

    def _object(self, node: Node, outputs: dict[str, tuple[str, str]], place: tuple[int, int]) -> Node | None:
        what = kind(node)
        if what == "Comment":
            text = tuple(child.like("content", ()) for child in node.all("Content"))
            return self._made(node, "comment", text, {}, place)
        tag = _TAGS.get(what)
        if tag is None or (odd := _odd(node)):
            self.tell(node, f"an element {what[:40] or node.tag}" + (f" with {odd[:40]}" if tag else ""),
                      "draw it with contacts, coils, variables and blocks")
            self._next += 1
            return None
        attributes = {name: node.get(name) for name in _SAME if node.get(name)}
        if node.get("latch"):
            attributes["storage"] = node.get("latch")
        if node.get("targetNetworkLabel"):
            attributes["label"] = node.get("targetNetworkLabel")
        if what == "CompareContact":
            operator = node.get("compareOperator").strip()
            attributes["typeName"] = _COMPARED.get(operator, operator or "?")
        parts = list(_points(node, outputs))
        for name in _OPERANDS:
            if node.get(name):
                words = node.attribute(name)
                parts.append(Node(node.document, _OPERANDS[name], words.start, words.start, words.end, {}))
        parts += sequences.parts(node, lambda inner: list(_points(inner, outputs)), self.body, self.tell)
        for one in node.all(*_LISTS):
            parts.append(one.like(_LISTS[one.tag], [_pin(pin, outputs) for pin in one.all(*_PINS)]))
        return self._made(node, tag, parts, attributes, place)


def _place(node: Node) -> tuple[int, int] | None:
    at = node.find("RelPosition")
    return None if at is None else (at.number("x"), at.number("y"))


def _odd(node: Node) -> str:
    """An attribute or element in it that nothing is known of."""
    names = (name for name in node.attributes if ":" not in name and name != "xmlns")
    return (next((name for name in names if name not in _KNOWN), "")
            or next((child.tag for child in node.children if child.tag not in _PASSED), ""))


def _pin(node: Node, outputs: dict[str, tuple[str, str]]) -> Node:
    attributes = {name: node.get(name) for name in ("negated", "edge") if node.get(name)}
    return node.like("variable", list(_points(node, outputs)),
                     {"formalParameter": node.get("parameterName"), **attributes})


def _points(node: Node, outputs: dict[str, tuple[str, str]]) -> Iterator[Node]:
    """Its inputs with their wires, and its outputs."""
    for point in node.all("ConnectionPointIn"):
        wires = []
        for wire in point.all("Connection"):
            number = wire.get("refConnectionPointOutId").strip()
            id_, pin = outputs.get(number, (f"output {number}", ""))
            if id_:  # not from what is told already
                named = {"formalParameter": pin} if pin else {}
                wires.append(wire.like("connection", (), {"refLocalId": id_, **named}))
        yield point.like("connectionPointIn", wires)
    for point in node.all("ConnectionPointOut"):
        yield point.like("connectionPointOut", ())


def _outputs(node: Node) -> Iterator[tuple[str, str]]:
    """The numbers of its outputs, each with the name of its pin."""
    for point in node.all("ConnectionPointOut", "ConnectionPointOutAction"):
        yield point.get("connectionPointOutId").strip(), ""
    for pins in node.all("OutputVariables", "InOutVariables"):
        for pin in pins.children:
            for point in pin.all("ConnectionPointOut"):
                yield point.get("connectionPointOutId").strip(), pin.get("parameterName")
