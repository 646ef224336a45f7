"""A drawing in JSON as the elements that PLCopen XML has, which is how its own editor exports it.

Nodes become elements, edges connections; the nodes that open and close parallels are wires. What the
elements then mean is decided where that of PLCopen drawings is (docs/plcopen.md).
"""

from __future__ import annotations

from collections.abc import Iterable

from ldc.library import blocks
from ldc.parser import ast
from ldc.parser.foreign import Reading
from ldc.parser.openplc.values import JsonText, Value
from ldc.parser.plcopen.body import ladder
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.guarded import Additions, Pins
from ldc.records import replace
from ldc.source import Span

MAX_WIRES = 1_000_000
_CONTACTS = {"negated": ("negated", "true"), "risingEdge": ("edge", "rising"),
             "fallingEdge": ("edge", "falling")}
_COILS = {**_CONTACTS, "set": ("storage", "set"), "reset": ("storage", "reset")}
_VARIABLES = {"input-variable": "inVariable", "output-variable": "outVariable",
              "inout-variable": "inOutVariable"}
_SECTIONS = {"input": "VAR_INPUT", "output": "VAR_OUTPUT", "inOut": "VAR_IN_OUT"}
_WIRES = ("parallel", "powerRail")
_ON_PINS = ("variable",)
_PLACEHOLDERS = ("placeholder", "parallelPlaceholder")


class Drawn(Node):
    """A node of a drawing as an element of PLCopen XML. ``span``: what messages show of it; ``whole``: all of
    it; ``content``: its text; ``places``: where its attributes stand."""

    __slots__ = ("span", "whole", "content", "places")

    def __init__(self, text: JsonText, tag: str, span: Span, **attributes: str) -> None:
        super().__init__(text, tag, span.start, span.start, span.start, attributes)
        self.children = []
        self.span = self.whole = self.content = span
        self.places: dict[str, Span] = {}

    def attribute(self, name: str) -> Span:
        return self.places.get(name, self.span)

    def child(self, tag: str, span: Span | None = None, **attributes: str) -> Drawn:
        made = Drawn(self.document, tag, span or self.span, **attributes)
        self.children.append(made)
        return made


class Drawings:
    """Writes the drawings of one POU as rungs. ``more`` takes what they need beside what is declared."""

    def __init__(self, reading: Reading, text: JsonText, where: str, more: Additions) -> None:
        self.reading, self.text, self.where, self.more = reading, text, where, more
        self.numbers = 0
        self.wires = 0

    def body(self, root: Value) -> ast.LadderBody:
        """The rungs of ``{"rungs": [...]}`` (LD) or ``{"rung": {...}}`` (FBD)."""
        drawn = root.get("rung")
        found: list[ast.Rung] = []
        unread: list[tuple[int, ast.Rung]] = []
        if drawn is not None:
            body = self._rungs(drawn, self.where)
            return replace(body, span=self.text.span(root))
        if root.get("rungs") is None:
            self.reading.malformed(self._short(root), f"the body of {self.where} has no rungs")
        for number, rung in enumerate(root.items("rungs"), 1):
            body = self._rungs(rung, f"{self.where}, rung {number}")
            rungs = list(body.rungs)
            title = " ".join(rung.text("comment").split())[:200]
            if title and rungs:
                rungs[0] = replace(rungs[0], title=title)
            unread += [(len(found) + before, part) for before, part in body.unread]
            found += rungs
        return ast.LadderBody(tuple(found), self.text.span(root), tuple(unread))

    def _rungs(self, rung: Value, where: str) -> ast.LadderBody:
        if any(not isinstance((rung.get(key) or rung).data, list) for key in ("nodes", "edges")):
            self.reading.malformed(self._short(rung), f"{where} has no nodes and edges")
            return ast.LadderBody((), self._short(rung))
        body = _Rung(self, rung, where).body()
        return ladder(body, where, self.more, self.reading.diagnostics)

    def _short(self, value: Value) -> Span:
        return Span(self.text.source, value.start, value.start + 1)

    def number(self) -> str:
        self.numbers += 1
        return str(self.numbers)


class _Rung:
    """One drawing: ``ids`` are the elements that its nodes become, ``into`` the edges that end at a node,
    ``on_pins`` the texts at pins of blocks by (node, pin)."""

    def __init__(self, drawings: Drawings, rung: Value, where: str) -> None:
        self.drawings, self.text, self.reading = drawings, drawings.text, drawings.reading
        self.where, self.rung = where, rung
        self.nodes = {node.text("id"): node for node in rung.items("nodes")}
        self.ids = {key: drawings.number() for key in self.nodes}
        self.into: dict[str, list[Value]] = {}
        self.behind: dict[str, tuple[Value, ...]] = {}
        self.on_pins: dict[tuple[str, str], Value] = {}
        self.leaving: dict[str, list[str]] = {}
        for edge in rung.items("edges"):
            self.into.setdefault(edge.text("target"), []).append(edge)
            self.leaving.setdefault(edge.text("source"), []).append(edge.text("sourceHandle"))

    def body(self) -> Node:
        body = Drawn(self.text, "LD", self.text.span(self.rung))
        self._texts_on_pins()
        for key, node in self.nodes.items():
            kind = node.text("type")
            if kind in ("contact", "coil"):
                self._element(body, key, node, _CONTACTS if kind == "contact" else _COILS)
            elif kind == "block":
                self._block(body, key, node)
            elif kind == "powerRail":
                if node.text("data", "variant") != "right":
                    self._made(body, key, node, "leftPowerRail")
            elif kind in _VARIABLES:
                self._variable(body, key, node, _VARIABLES[kind])
            elif kind in ("connector", "continuation"):
                made = self._made(body, key, node, kind, name=node.text("data", "variable", "name"))
                if kind == "connector":
                    self._connect(made, key)
            elif kind == "comment":
                content = node.get("data", "content")
                if content is not None:
                    self._made(body, key, node, "comment").child("content", self.text.content(content))
            elif kind not in (*_WIRES, *_ON_PINS, *_PLACEHOLDERS):
                shown = kind[:40] or "without a type"
                self.reading.unsupported(self._place(node), f"{self.where}: a node `{shown}`",
                                         "draw it with contacts, coils and blocks")
        return body

    # ---- elements

    def _place(self, node: Value) -> Span:
        """What messages show of a node: the name of its variable, of its type, or its id."""
        for path in (("data", "variable", "name"), ("data", "variant", "name"), ("id",), ("type",)):
            value = node.get(*path)
            if value is not None and isinstance(value.data, str) and value.data.strip():
                return self.text.content(value)
        return Span(self.text.source, node.start, node.start + 1)

    def _made(self, body: Drawn, key: str, node: Value, tag: str, **attributes: str) -> Drawn:
        order = node.number("data", "executionOrder")
        if order > 0:
            attributes["executionOrderId"] = str(order)
        made = body.child(tag, self._place(node), localId=self.ids[key], **attributes)
        made.child("position", x=str(node.number("position", "x")), y=str(node.number("position", "y")))
        return made

    def _element(self, body: Drawn, key: str, node: Value, kinds: dict[str, tuple[str, str]]) -> None:
        kind, variant = node.text("type"), node.text("data", "variant")
        if variant not in kinds and variant not in ("default", ""):
            self.reading.unsupported(self._place(node), f"{self.where}: a {kind} `{variant[:40]}`",
                                     "draw it as another kind of contact or coil")
            return
        modified = dict([kinds[variant]] if variant in kinds else [])
        made = self._made(body, key, node, kind, **modified)
        self._connect(made, key)
        name = node.get("data", "variable", "name")
        if name is not None:
            made.child("variable", self.text.content(name))

    def _variable(self, body: Drawn, key: str, node: Value, tag: str) -> None:
        negated = "true" if node.flag("data", "negated") else "false"
        made = self._made(body, key, node, tag, negated=negated)
        if tag != "inVariable":
            self._connect(made, key)
        name = node.get("data", "variable", "name")
        if name is not None:
            made.child("expression", self.text.content(name))

    def _block(self, body: Drawn, key: str, node: Value) -> None:
        """Pins are those that are drawn, those that are wired and those that have a variable."""
        attributes = {"typeName": node.text("data", "variant", "name")}
        if node.text("data", "variant", "type") == "function-block":
            attributes["instanceName"] = node.text("data", "variable", "name")
            if blocks.signature(attributes["typeName"]) is None:
                self._declare(node, attributes["typeName"])
        made = self._made(body, key, node, "block", **attributes)
        for attribute, path in (("typeName", "variant"), ("instanceName", "variable")):
            value = node.get("data", path, "name")
            if value is not None:
                made.places[attribute] = self.text.content(value)
        inputs = [edge.text("targetHandle") for edge in self.into.get(key, ())]
        outputs = self.leaving.get(key, [])
        first = node.text("data", "inputConnector", "id")
        pins = made.child("inputVariables")
        for pin in self._pins(node, "input", [name or first for name in inputs], key):
            variable = pins.child("variable", formalParameter=pin)
            wires = [e for e in self.into.get(key, ()) if (e.text("targetHandle") or first) == pin]
            point = self._connections(variable, wires)
            value = self.on_pins.get((key, pin))
            if value is not None:
                point.child("expression", self.text.content(value))
        pins = made.child("outputVariables")
        for pin in self._pins(node, "output", outputs, key):
            point = pins.child("variable", formalParameter=pin).child("connectionPointOut")
            value = self.on_pins.get((key, pin))
            if value is not None:
                point.child("expression", self.text.content(value))

    def _declare(self, node: Value, type_: str) -> None:
        """Make the pins of a function block known that is declared in another file: they are drawn here."""
        pins: Pins = {section: () for section in _SECTIONS.values()}
        for pin in node.items("data", "variant", "variables"):
            name, section = pin.get("name"), _SECTIONS.get(pin.text("class"))
            if section and name is not None and not (name.data in ("EN", "ENO") and self._has_enable(node)):
                span = self.text.content(name)
                type_of_pin = ast.NamedType(pin.text("type", "value"), None, span)
                pins[section] += (ast.VarDecl(pin.text("name"), None, type_of_pin, None, span, span),)
        self.drawings.more.interfaces.setdefault(type_.upper(), pins)

    def _has_enable(self, node: Value) -> bool:
        return node.flag("data", "executionControl")

    def _pins(self, node: Value, side: str, wired: Iterable[str], key: str) -> list[str]:
        drawn = [handle.text("id") for handle in node.items("data", f"{side}Handles")]
        declared = [v.text("name") for v in node.items("data", "variant", "variables")
                    if v.text("class") == side or side == "input" and v.text("class") == "inOut"]
        return [pin for pin in dict.fromkeys((*(drawn or declared), *wired)) if pin]

    def _texts_on_pins(self) -> None:
        """Variables in LD stand at a pin: at the other end of their edge, else where they say; old files
        have the list of the block alone."""
        for key, node in self.nodes.items():
            if node.text("type") == "block":
                for entry in node.items("data", "connectedVariables"):
                    self._on_pin((key, entry.text("handleId")), entry.get("variable", "name"))
        for key, node in self.nodes.items():
            if node.text("type") not in _ON_PINS:
                continue
            name = node.get("data", "variable", "name")
            block = node.get("data", "block")
            if block is not None:
                self._on_pin((block.text("id"), block.text("handleId")), name)
        for edge in self.rung.items("edges"):
            source, target = (self.nodes.get(edge.text(end)) for end in ("source", "target"))
            if source is not None and source.text("type") in _ON_PINS:
                self._on_pin((edge.text("target"), edge.text("targetHandle")),
                             source.get("data", "variable", "name"))
            elif target is not None and target.text("type") in _ON_PINS:
                self._on_pin((edge.text("source"), edge.text("sourceHandle")),
                             target.get("data", "variable", "name"))

    def _on_pin(self, pin: tuple[str, str], name: Value | None) -> None:
        if name is not None and isinstance(name.data, str) and name.data.strip():
            self.on_pins[pin] = name

    # ---- wires

    def _connect(self, made: Drawn, key: str) -> None:
        self._connections(made, self.into.get(key, ()))

    def _connections(self, made: Drawn, edges: Iterable[Value]) -> Drawn:
        point = made.child("connectionPointIn")
        for source, edge in dict.fromkeys((s, e) for edge in edges for s, e in self._sources(edge)):
            at = edge.get("source")
            point.child("connection", self.text.content(at) if at is not None else None, refLocalId=source,
                        formalParameter=edge.text("sourceHandle"))
        return point

    def _sources(self, edge: Value) -> Iterable[tuple[str, Value]]:
        """The elements that feed an edge, with the edges by which they do; parallels are wires."""
        seen: set[str] = set()
        work = [edge]
        while work:
            edge = work.pop()
            self.drawings.wires += 1
            if self.drawings.wires > MAX_WIRES:
                break
            source = edge.text("source")
            node = self.nodes.get(source)
            kind = node.text("type") if node is not None else ""
            if kind == "parallel":
                if source not in seen:
                    seen.add(source)
                    work += reversed(self.into.get(source, ()))
            elif kind not in _ON_PINS:
                yield self.ids.get(source, source or "?"), edge
        if self.drawings.wires == MAX_WIRES + 1:
            self.reading.too_large(self._place(self.rung), MAX_WIRES, "wires in parallel")
