"""One rung of a graphical body as steps between nets, which paths.py then writes down.

Inputs name their sources, and several sources mean OR of exactly these. So there is one net per set of
sources; an output that belongs to several sets has a net of its own, from which a contact `[TRUE]` leads to
each.
"""

from __future__ import annotations

from collections.abc import Mapping

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.plcopen import backwards, boxes, findings, kinds, paths, texts
from ldc.parser.plcopen.blocks import Pins
from ldc.parser.plcopen.drawing import (
    CALLED, KEPT, RAIL, Drawing, Element, Input, Output, is_conditional, output_of,
)
from ldc.parser.plcopen.paths import RAIL_NET, Step
from ldc.parser.plcopen.pins import NO_WIRE
from ldc.source import Span

_MODIFIERS = {"rising": "P", "falling": "N"}
_OPPOSITE = {"": "/", "P": "N", "N": "P"}
_STORAGE = {"set": "S", "reset": "R"}
_BOXES = ("outVariable", "inOutVariable")
_TAKE_VALUES = ("block", *_BOXES)
_GIVE_VALUES = ("inVariable", "inOutVariable", CALLED, KEPT)


class RungWriter:
    """Collects the steps of one rung. ``failed``: a part could not be read (a finding tells), the rung is
    only good to be shown."""

    def __init__(
        self, drawing: Drawing, group: list[Element], labels: dict[str, str], diagnostics: Diagnostics
    ) -> None:
        self.drawing, self.group, self.labels = drawing, group, labels
        self.diagnostics = diagnostics
        self.steps: list[Step] = []
        self.sets: dict[frozenset[Output], str] = {}
        self.feeds: dict[Output, list[frozenset[Output]]] = {}
        self.failed = False
        self.count = 0
        self.awaited: tuple[str, ...] = ()
        self._readers = self._read()

    def rung(self, name: str | None, title: str | None) -> ast.Rung | None:
        self._enable()
        pins = {element.id: Pins(self, element) for element in self.group if element.kind == "block"}
        for element in self.group:
            values = element.kind in _TAKE_VALUES
            for pin in element.inputs:
                if not values or self.value_at(pin) is None and not self.attached(element):
                    self.want(pin)
        for element in self.group:
            self.at = element.order
            if element.kind == "block":
                pins[element.id].write()
            else:
                _WRITERS[element.kind](self, element)
        self._values()
        if not self.steps:
            return None
        if self.group[0].order[0] == 0:  # numbers come first
            backwards.tell(self.drawing, self.group, self.diagnostics)
        span = self.group[0].node.span
        return ast.Rung(name, title, paths.write(self.steps), span, None)

    # ---- nets

    def fresh(self) -> str:
        self.count += 1
        return f"n{self.count}"

    def want(self, pin: Input) -> None:
        """Make the net of an input known before anything feeds it."""
        sources = pin.sources
        if sources and RAIL not in sources and sources not in self.sets:
            self.sets[sources] = self.fresh()
            for output in sources:
                self.feeds.setdefault(output, []).append(sources)

    def net(self, pin: Input) -> str | None:
        """The net that feeds an input; None when nothing does."""
        if RAIL in pin.sources:
            return RAIL_NET
        return self.sets.get(pin.sources)

    def tail(self, output: Output, span: Span) -> str | None:
        """The net that an output feeds; None when nothing reads it."""
        sets = self.feeds.get(output, ())
        if not sets:
            return None
        if len(sets) == 1:
            return self.sets[sets[0]]
        own = self.sets.get(frozenset((output,))) or self.fresh()
        for wider in sets:
            if self.sets[wider] != own:
                self.add(ast.Contact("", texts.true(span), span), own, self.sets[wider])
        return own

    def add(self, item: ast.Item, head: str | None, tail: str | None, reads=(), writes=()) -> None:
        order = (*self.at, len(self.steps))
        self.steps.append(Step(order, item, head, tail, (*reads, *self.awaited), tuple(writes)))
        self.awaited = ()

    # ---- expressions

    def expression(self, span: Span | None, element: Element) -> ast.Expr:
        """What is written there; when that cannot be read, a name that shows it."""
        if span is not None and (name := texts.named(span)) is not None:
            return name
        if span is None or span.start == span.end or span.text == boxes.NOT_NAMED:
            findings.malformed(self.diagnostics, element.node.span,
                               f"{self.drawing.where}: {element.describe()} has no variable",
                               "name a variable in the editor that the file comes from")
            self.failed = True
            return ast.Name("?", element.node.span)
        found = texts.expression(span, self.diagnostics)
        self.failed |= found is None
        return ast.Name(texts.line(span.text), span) if found is None else found

    def value(self, output: Output) -> ast.Expr:
        """The expression in an input variable; the output of a function block that is called elsewhere."""
        element = self.drawing.elements[output[0]]
        if element.kind == CALLED:
            pin = next(pin for pin in element.outputs if pin.name.upper() == output[1])
            holder = self.expression(element.node.attribute("instanceName"), element)
            found = ast.Member(holder, pin.name, element.node.span)
            return texts.negated(found) if pin.negated else found
        if element.kind == KEPT:
            return ast.Name(element.node.get("name"), element.node.span)
        text = element.node.find("expression")
        if element.inputs and element.inputs[0].sources:
            self.awaited += (_written(element),)
        found = self.expression(text.content if text is not None else None, element)
        return texts.negated(found) if boxes.is_negated(element.node, reads=True) else found

    def value_at(self, pin: Input) -> Output | Span | None:
        """What is written at a pin instead of a wire: of which element (`value`), or a place."""
        if pin.text is not None and not pin.sources:
            return pin.text
        if len(pin.sources) == 1:
            (output,) = pin.sources
            if output != RAIL and self.drawing.elements[output[0]].kind in _GIVE_VALUES:
                return output
        return None

    def _values(self) -> None:
        """Input variables where power is read: contacts at the left rail."""
        for output in list(self.feeds):
            element = self.drawing.elements[output[0]]
            if element.kind not in _GIVE_VALUES:
                continue
            self.at = (*min(user.order for user in self.readers(output)), -1)
            contact = ast.Contact("", self.value(output), element.node.span)
            self.add(contact, RAIL_NET, self.tail(output, element.node.span))

    # ---- elements

    def _modifier(self, element: Element, name: str, known: Mapping[str, str]) -> str:
        """What an attribute `edge` or `storage` of a contact or coil means; what is not known is told."""
        text = boxes.modifier(element.node, name)
        if not text or text in known:
            return known.get(text, "")
        self.failed = True
        findings.unsupported(self.diagnostics, element.node.span,
                             f'{self.drawing.where}: {element.describe()} has {name}="{text[:20]}"', "drawn here",
                             "edges are rising or falling; a coil sets or resets")
        return ""

    def _contact(self, element: Element) -> None:
        node, span = element.node, element.node.span
        expr = self.expression(node.words("variable"), element)
        if (compares := node.get("typeName").strip().upper()) not in ("", "NONE"):
            expr = self._compared(element, compares, expr)
        modifier = self._modifier(element, "edge", _MODIFIERS)
        self._modifier(element, "storage", {})
        if node.flag("negated"):
            modifier = _OPPOSITE[modifier]
            if modifier == "/" and not isinstance(expr, (ast.Name, ast.Member, ast.Index, ast.Direct)):
                modifier, expr = "", texts.negated(expr)
        item = ast.Contact(modifier, expr, span)
        self.add(item, self.net(element.inputs[0]), self.tail((element.id, ""), span))

    def _compared(self, element: Element, function: str, left: ast.Expr) -> ast.Expr:
        """A contact that compares two values, ``typeName="EQ_UDINT"`` with ``<variable1>``, as one editor
        draws it."""
        node = element.node
        operator = kinds.COMPARING.get(function.partition("_")[0])
        if operator is None:
            self.failed = True
            message = f'{self.drawing.where}: {element.describe()} has typeName="{function[:20]}"'
            findings.unsupported(self.diagnostics, node.span, message, "drawn here",
                                 "a contact compares by EQ, NE, LT, LE, GT or GE")
            return left
        right = self.expression(node.words("variable1"), element)
        return ast.Binary(operator, left, right, node.span)

    def _coil(self, element: Element) -> None:
        node = element.node
        target = self.expression(node.words("variable"), element)
        modifier = (self._modifier(element, "storage", _STORAGE)
                    or self._modifier(element, "edge", _MODIFIERS))
        net, tail = self.net(element.inputs[0]), self.tail((element.id, ""), node.span)
        if node.flag("negated") and modifier:
            if tail is not None:  # power goes by as it is
                self.add(ast.Contact("", texts.true(node.span), node.span), net, tail)
            net, tail = self.inverted(net, node.span), None
        elif node.flag("negated"):
            modifier = "/"
        self.add(ast.Coil(modifier, target, node.span), net, tail)

    def _transition(self, element: Element) -> None:
        """What is wired to the condition of a transition goes to the variable with its name."""
        node = element.node
        target = ast.Name(node.get("name"), node.span)
        item = ast.Coil("/" if node.flag("negated") else "", target, node.span)
        self.add(item, self.net(element.inputs[0]), None)

    def _keep(self, element: Element) -> None:
        span = element.node.span
        self.add(ast.Coil("", ast.Name(element.node.get("name"), span), span), self.net(element.inputs[0]), None)

    def _outVariable(self, element: Element) -> None:
        pin, node = element.inputs[0], element.node
        if self.attached(element):
            return
        negated = boxes.is_negated(node, reads=False)
        text = node.find("expression")
        target = self.expression(text.content if text is not None else None, element)
        value, function = self.value_at(pin), "NOT" if negated else "MOVE"
        enable = self.net(element.inputs[1]) if len(element.inputs) > 1 else None
        if value is not None:
            source = self.expression(value, element) if isinstance(value, Span) else self.value(value)
            self.function(function, source, target, node.span)
        elif enable or len(pin.sources) == 1 and self._is_block(next(iter(pin.sources))) and not negated:
            net = self.net(pin)
            junction = ast.Junction(net, node.span)
            self.function(function, junction, target, node.span, reads=(net,), enable=enable)
        else:
            self.add(ast.Coil("/" if negated else "", target, node.span), self.net(pin), None)

    def _inOutVariable(self, element: Element) -> None:
        if element.inputs[0].sources:
            self._outVariable(element)
            self.steps[-1].writes += (_written(element),)

    def attached(self, element: Element) -> bool:
        """Whether an output variable is the only reader of a block's output: it is written at the pin."""
        pin = element.inputs[0]
        if element.kind != "outVariable" or element.node.flag("negated") or len(pin.sources) != 1:
            return False
        (output,) = pin.sources
        if not self._is_block(output):
            return False
        block = self.drawing.elements[output[0]]
        return not any(o.name.upper() == output[1] and o.negated for o in block.outputs) and (
            len(self.readers(output)) == 1)

    def readers(self, output: Output) -> list[Element]:
        return self._readers.get(output, [])

    def _read(self) -> dict[Output, list[Element]]:
        found: dict[Output, list[Element]] = {}
        for element in self.group:
            for pin in element.inputs:
                for output in pin.sources:
                    found.setdefault(output, []).append(element)
        return found

    def _enable(self) -> None:
        """Output variables that do not stand at the pin of their function are written when that is executed:
        those of one with EN are also wired to its ENO."""
        boxes_ = [e for e in self.group if e.kind in _BOXES and len(e.inputs[0].sources) == 1
                  and self._is_conditional(*e.inputs[0].sources) and not self.attached(e)]
        for element in boxes_:
            (id_, _), = element.inputs[0].sources
            output_of(self.drawing.elements[id_], "ENO")
            element.inputs.append(Input("EN", element.node, frozenset(((id_, "ENO"),))))
        if boxes_:
            self._readers = self._read()

    def _is_conditional(self, output: Output) -> bool:
        """Whether this is a value of a function that is wired to EN."""
        return self._is_block(output) and output[1] != "ENO" and (
            is_conditional(self.drawing.elements[output[0]]))

    def _is_block(self, output: Output) -> bool:
        return output != RAIL and self.drawing.elements[output[0]].kind == "block"

    def _jump(self, element: Element) -> None:
        label = texts.label(element.node.get("label"), "label")
        self._leave(element, self.labels.get(label.upper(), label))

    def _return(self, element: Element) -> None:
        self._leave(element, "RETURN")

    def _leave(self, element: Element, target: str) -> None:
        head = self.net(element.inputs[0])
        span = element.node.span
        if element.node.flag("negated"):
            head = self.inverted(head, span)
        self.add(ast.Jump(target, span), head, None)

    # ---- functions that stand for what an element has no word for

    def function(self, name: str, source, target, span: Span, reads=(), writes=(), enable=None) -> None:
        """``enable``: the net at EN, None for a function that is always executed."""
        pins = (ast.Pin("IN", source, False, span), ast.Pin("OUT", target, True, span))
        power_in = NO_WIRE if enable is None else None
        self.add(ast.Block(None, name, pins, power_in, NO_WIRE, span), enable, None, reads, writes)

    def inverted(self, net: str | None, span: Span) -> str:
        """A net with the opposite power."""
        new = self.fresh()
        source = ast.Junction(net, span) if net else texts.true(span, net == RAIL_NET)
        self.function("NOT", source, ast.Junction(new, span), span, (net,) if net else (), (new,))
        return new

    def signal(self, value: ast.Expr, span: Span) -> str:
        """A net with the power that an expression is."""
        new = self.fresh()
        self.add(ast.Contact("", value, span), RAIL_NET, new)
        return new

    def edge(self, net: str | None, pin: Input, element: Element) -> str:
        """A net with the edge of another: a block whose instance is added to the POU."""
        span, new = pin.node.span, self.fresh()
        name = self.drawing.more.fresh(texts.label(f"edge_{element.id}_{pin.name}", "edge"))
        made = ast.VarDecl(name, None, ast.NamedType(pin.edge, None, span), None, span, span)
        self.drawing.more.variables.append(made)
        source = ast.Junction(net, span) if net else texts.true(span, net == RAIL_NET)
        pins = (ast.Pin("CLK", source, False, span), ast.Pin("Q", ast.Junction(new, span), True, span))
        block = ast.Block(ast.Name(name, span), pin.edge, pins, NO_WIRE, NO_WIRE, span)
        self.add(block, None, None, (net,) if net else (), (new,))
        return new


def _written(box: Element) -> str:
    """What stands for a net from a box of a variable that is written to the elements that read it there: they
    have their turn behind it."""
    return f"box {box.id}"


_WRITERS = {kind: getattr(RungWriter, f"_{kind}") for kind in (
    "contact", "coil", "keep", "transition", "outVariable", "inOutVariable", "jump", "return")}
