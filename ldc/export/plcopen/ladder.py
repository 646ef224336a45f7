"""A ladder as an LD body: elements with ids, places and wires; each rung has its rails.

An input names what feeds its net, and the net's wire is drawn from the input to each of them. The order of
evaluation is written as `executionOrderId`: it is that of the text, which places do not always show.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from ldc.draw.labels import BlockPins
from ldc.export.plcopen.places import GAP, HALF, LINE, RAIL_WIDTH, Box, Places, places, value_width
from ldc.export.plcopen.tags import add, code, formatted, number, prose
from ldc.graph.rung import RAIL, RungGraph
from ldc.model import elements
from ldc.parser import ast
from ldc.parser.unparse import expr_text
from ldc.records import record

_EDGE = {"P": "rising", "N": "falling"}
_STORAGE = {"S": "set", "R": "reset"}
_LABEL_HEIGHT, _ABOVE = 20, 60


@record
class Source:
    """An output: of an element (its pin, or ""), where its wire begins, and the column of its net."""

    id: int
    pin: str
    x: int
    y: int
    column: int


@dataclass(slots=True)
class Drawn:
    """A rung in the body: the ids of all that belongs to it, in the order of evaluation."""

    rung: ast.Rung
    ids: list[int]


class Body:
    """Draws rungs one below the other. ``pins_of``: the pins of a block's type."""

    def __init__(self, pou: Element, pins_of: Callable[[ast.Block], BlockPins | None]) -> None:
        self.body = add(pou, "body")
        self.ladder = add(self.body, "LD")
        self.pins_of = pins_of
        self.last = self.turns = 0
        self.y = GAP
        self.drawn: list[Drawn] = []

    def rung(self, rung: ast.Rung, graph: RungGraph) -> None:
        self.drawn.append(_Rung(self, rung, graph).draw())

    def id(self) -> int:
        self.last += 1
        return self.last

    def turn(self) -> int:
        self.turns += 1
        return self.turns


class _Rung:
    def __init__(self, body: Body, rung: ast.Rung, graph: RungGraph) -> None:
        self.body, self.rung, self.graph = body, rung, graph
        self.items = tuple(in_order(rung))
        self.ids: list[int] = []
        self.y = 0
        self.places: Places
        self.rails: dict[int, tuple[int, int]] = {}
        self.feeds: dict[int, list[Source]] = {}

    def draw(self) -> Drawn:
        body, top = self.body, self.body.y
        if self.rung.title:
            width = min(value_width(self.rung.title), 800)
            comment = self._element("comment", GAP, body.y, width, _LABEL_HEIGHT)
            formatted(comment, "content", prose(self.rung.title))
            body.y += _LABEL_HEIGHT + 5
        if self.rung.name:
            width = value_width(self.rung.name)
            self._element("label", GAP, body.y, width, _LABEL_HEIGHT, label=self.rung.name)
            body.y += _LABEL_HEIGHT + 5
        self.y = body.y + (_ABOVE - LINE if body.y == top else GAP)
        self.places = places(self.rung, body.pins_of)
        self._rails()
        self.element_ids = [body.id() for _ in self.items]
        for index, item in enumerate(self.items):
            self._outputs(index, item)
        for index, item in enumerate(self.items):
            if isinstance(item, ast.Block):
                self._block(index, item)
            else:
                self._simple(index, item)
        self._right_rail()
        body.y = self.y + self.places.height + LINE
        return Drawn(self.rung, self.ids)

    # ---- elements

    def _element(self, tag: str, x: int, y: int, width: int, height: int, id_: int | None = None,
                 turn: int | None = None, **attributes: object) -> Element:
        id_ = self.body.id() if id_ is None else id_
        self.ids.append(id_)
        made = add(self.body.ladder, tag, localId=id_, width=number(width), height=number(height),
                   executionOrderId=turn, **attributes)
        add(made, "position", x=number(x), y=number(y))
        return made

    def _box(self, item: ast.Item) -> Box:
        return self.places.boxes[id(item)]

    def _rails(self) -> None:
        """The left rail, with a connection point at every line that begins there, and rails of networks that
        begin further right."""
        wires: dict[int, list[int]] = {}
        for index, item in enumerate(self.items):
            box = self._box(item)
            if self.graph.heads[index] == RAIL and _has_power(self.graph.elements[index]):
                wires.setdefault(box.head_x - RAIL_WIDTH if box.local else 0, []).append(box.wire)
            elif isinstance(item, ast.Block):
                wires.setdefault(0, [])
        for x, lines in sorted({0: [0], **wires}.items()):
            top, bottom = (min(lines), max(lines)) if x else (0, self.places.height - LINE)
            rail = self._element("leftPowerRail", x, self.y + top - HALF, RAIL_WIDTH, bottom - top + 2 * HALF)
            self.rails[x] = (int(rail.get("localId")), x + RAIL_WIDTH)
            for line in sorted(set(lines)) or [top]:
                point = add(rail, "connectionPointOut", formalParameter="")
                add(point, "relPosition", x=number(RAIL_WIDTH), y=number(line - top + HALF))

    def _right_rail(self) -> None:
        """The right rail, for the coils that nothing follows."""
        ends = [i for i, e in enumerate(self.graph.elements)
                if isinstance(e, elements.Coil) and not self.graph.outgoing[self.graph.tails[i]]]
        if not ends:
            return
        lines = {i: self._box(self.items[i]).wire for i in ends}
        top = min(lines.values())
        rail = self._element("rightPowerRail", self.places.width, self.y + top - HALF, RAIL_WIDTH,
                             max(lines.values()) - top + 2 * HALF)
        for index in sorted(ends, key=lines.get):
            box, y = self._box(self.items[index]), lines[index]
            point = add(rail, "connectionPointIn")
            add(point, "relPosition", x="0", y=number(y - top + HALF))
            source = Source(self.element_ids[index], "", box.right, self.y + y, 0)
            _wire(point, (self.places.width, self.y + y), 0, source)

    def _simple(self, index: int, item: ast.Contact | ast.Coil | ast.Jump) -> None:
        box, attributes = self._box(item), {}
        tag = type(item).__name__.lower()
        if isinstance(item, ast.Jump):
            attributes = {"label": item.target}
            if item.target == "RETURN":
                tag, attributes = "return", {}
        else:
            attributes = {"negated": "true" if item.modifier == "/" else "false",
                          "edge": _EDGE.get(item.modifier, "none"),
                          "storage": _STORAGE.get(item.modifier, "none")}
        made = self._element(tag, box.x, self.y + box.y, box.width, box.height, self.element_ids[index],
                             self.body.turn(), **attributes)
        self._input(made, self.graph.heads[index], box, box.wire, box.head_x)
        if not isinstance(item, ast.Jump):
            point = add(made, "connectionPointOut")
            add(point, "relPosition", x=number(box.width), y=number(HALF))
            operand = item.expr if isinstance(item, ast.Contact) else item.target
            add(made, "variable", code(expr_text(operand)))

    # ---- wires

    def _outputs(self, index: int, item: ast.Item) -> None:
        """What an element feeds, by net."""
        box, element, id_ = self._box(item), self.graph.elements[index], self.element_ids[index]
        if not isinstance(element, elements.Block):
            source = Source(id_, "", box.right, self.y + box.wire, box.tail_x)
            self.feeds.setdefault(self.graph.tails[index], []).append(source)
            return
        if element.power_out is not None:
            source = Source(id_, element.power_out, box.right, self.y + box.wire, box.tail_x)
            self.feeds.setdefault(self.graph.tails[index], []).append(source)
        rows = self._rows(item, element)[1]
        for pin in element.outputs:
            if isinstance(pin.target, int):
                y = self.y + box.wire + rows[pin.pin.upper()]
                source = Source(id_, pin.pin, box.right, y, box.right + GAP)
                self.feeds.setdefault(pin.target, []).append(source)

    def _input(self, parent: Element, net: int | None, box: Box, line: int, column: int) -> Element:
        """The connection point of an input at a line, wired to all that feeds its net."""
        point = add(parent, "connectionPointIn")
        add(point, "relPosition", x="0", y=number(line - box.y))
        if net == RAIL:
            id_, x = self.rails[box.head_x - RAIL_WIDTH if box.local and line == box.wire else 0]
            _wire(point, (box.x, self.y + line), 0, Source(id_, "", x, self.y + line, 0))
        elif net is not None:
            for source in self.feeds.get(net, ()):
                _wire(point, (box.x, self.y + line), column, source, self.y + self.places.height)
        return point

    # ---- blocks

    def _rows(self, item: ast.Block, element: elements.Block) -> tuple[dict[str, int], dict[str, int]]:
        """How far below the power wire the pins of each side are, by name in capitals."""
        rows, known = self._box(item).rows, self.body.pins_of(item)
        sides = []
        for names, power in ((known.inputs, element.power_in), (known.outputs, element.power_out)):
            usual = known.power_in if names is known.inputs else known.power_out
            first = (power or usual or "").upper()
            order = [first, *(name.upper() for name in names if name.upper() != first)]
            sides.append({name: rows[at] if at < len(rows) else rows[-1] + (at - len(rows) + 1) * LINE
                          for at, name in enumerate(order)})
        return sides[0], sides[1]

    def _block(self, index: int, item: ast.Block) -> None:
        box, element = self._box(item), self.graph.elements[index]
        instance = None if item.instance is None else code(expr_text(item.instance))
        texts = _pin_texts(item, element)
        values = self._values(item, element, texts)
        made = self._element("block", box.x, self.y + box.y, box.width, box.height, self.element_ids[index],
                             self.body.turn(), typeName=item.type, instanceName=instance)
        groups = ("inputVariables", "inOutVariables", "outputVariables")
        inputs, both, outputs = (add(made, group) for group in groups)
        given = {pin.pin: pin for pin in element.inputs}
        left, right = self._rows(item, element)
        in_outs = {parameter.name for parameter in element.signature.in_outs}
        for name in _names(element, self.body.pins_of(item).inputs, "EN"):
            pin = add(both if name in in_outs else inputs, "variable", formalParameter=name)
            line = box.wire + left[name.upper()]
            if name == element.power_in:
                self._input(pin, self.graph.heads[index], box, line, box.head_x)
                continue
            source = given[name].source if name in given else None
            point = self._input(pin, source if isinstance(source, int) else None, box, line, box.x - GAP // 2)
            if name in values:
                _wire(point, (box.x, self.y + line), 0, values[name])
        for name in _names(element, self.body.pins_of(item).outputs, "ENO"):
            point = add(add(outputs, "variable", formalParameter=name), "connectionPointOut")
            add(point, "relPosition", x=number(box.width), y=number(box.wire + right[name.upper()] - box.y))
        self._targets(element, texts, box, right, self.element_ids[index])

    def _values(self, item: ast.Block, element: elements.Block, texts: dict[str, str]) -> dict[str, Source]:
        """Draws the values at input pins."""
        box, rows, found = self._box(item), self._rows(item, element)[0], {}
        for pin in element.inputs:
            if isinstance(pin.source, int) or pin.pin not in texts:
                continue
            text = texts[pin.pin]
            width, y = value_width(text), self.y + box.wire + rows[pin.pin.upper()]
            made = self._element("inVariable", box.x - GAP - width, y - LINE // 2 + 2, width, LINE - 4,
                                 negated="false")
            point = add(made, "connectionPointOut")
            add(point, "relPosition", x=number(width), y=number(LINE // 2 - 2))
            add(made, "expression", code(text))
            found[pin.pin] = Source(int(made.get("localId")), "", box.x - GAP, y, 0)
        return found

    def _targets(self, element: elements.Block, texts: dict[str, str], box: Box, rows: dict[str, int],
                 id_: int) -> None:
        """Draws the variables that output pins are written to."""
        both = {parameter.name for parameter in element.signature.in_outs}
        for pin in element.outputs:
            if isinstance(pin.target, int) or pin.pin in both:
                continue
            text, y = texts[pin.pin], self.y + box.wire + rows[pin.pin.upper()]
            width = value_width(text)
            made = self._element("outVariable", box.right + GAP, y - LINE // 2 + 2, width, LINE - 4,
                                 turn=self.body.turn(), negated="false")
            point = add(made, "connectionPointIn")
            add(point, "relPosition", x="0", y=number(LINE // 2 - 2))
            _wire(point, (box.right + GAP, y), 0, Source(id_, pin.pin, box.right, y, 0))
            add(made, "expression", code(text))


def in_order(rung: ast.Rung) -> Iterator[ast.Item]:
    """The elements in the order of the rung's graph: networks of pins before their block."""
    for path in rung.paths:
        yield from _path(path)


def _path(path: ast.Path) -> Iterator[ast.Item]:
    for item in path.items:
        if isinstance(item, ast.Branches):
            for inner in item.paths:
                yield from _path(inner)
        elif not isinstance(item, ast.Junction):
            if isinstance(item, ast.Block):
                for pin in item.pins:
                    for inner in pin.value.paths if isinstance(pin.value, ast.Branches) else ():
                        yield from _path(inner)
            yield item


def _has_power(element: elements.Element) -> bool:
    return not isinstance(element, elements.Block) or element.power_in is not None


def _pin_texts(item: ast.Block, element: elements.Block) -> dict[str, str]:
    """What is written at pins, by the declared name of the pin."""
    declared = {p.name.upper(): p.name for group in (element.signature.inputs, element.signature.outputs,
                                                     element.signature.in_outs) for p in group}
    free = iter([p.name for p in element.signature.inputs if p.name != element.power_in])
    texts = {}
    for pin in item.pins:
        name = next(free) if pin.name is None else declared.get(pin.name.upper(), pin.name.upper())
        if not isinstance(pin.value, ast.Branches | ast.Junction):
            texts[name] = expr_text(pin.value)
    return texts


def _names(element: elements.Block, names: Sequence[str], enable: str) -> list[str]:
    """The pins that are drawn: all of a function block; EN and ENO of a function only when one is used."""
    used = {element.power_in, element.power_out, *(p.pin for p in (*element.inputs, *element.outputs))}
    return [name for name in names if not element.is_function or name != enable or used & {"EN", "ENO"}]


def _wire(point: Element, to: tuple[int, int], column: int, source: Source, below: int = 0) -> None:
    """A connection, drawn from the input to the output: along the input's line to the net's column, along the
    output's line to the output. One that leads back goes under the rung, along the line ``below``."""
    made = add(point, "connection", refLocalId=source.id, formalParameter=source.pin or None)
    path = [to]
    if source.x >= to[0]:
        left, right = to[0] - GAP // 2, source.x + GAP // 2
        path += [(left, to[1]), (left, below), (right, below), (right, source.y)]
    elif source.y != to[1]:
        columns = (column, source.column, (source.x + to[0]) // 2)
        x = next((x for x in columns if source.x < x < to[0]), columns[-1])
        path += [(x, to[1]), (x, source.y)]
    for x, y in (*path, (source.x, source.y)):
        add(made, "position", x=number(x), y=number(y))
