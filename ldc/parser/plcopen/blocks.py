"""A block of a graphical body: what stands at its pins, and by which of them the power goes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ldc.library import blocks, functions
from ldc.parser import ast
from ldc.parser.plcopen import findings, kinds, texts, wires
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.drawing import RAIL, Element, Input, is_conditional
from ldc.parser.plcopen.pins import NO_WIRE, OpenPins, usual
from ldc.parser.plcopen.structured import statements
from ldc.records import replace
from ldc.source import Span
from ldc.types import Elementary

if TYPE_CHECKING:
    from ldc.parser.plcopen.rung import RungWriter

_VARIABLES = (ast.Name, ast.Direct, ast.Member, ast.Index)


class Pins:
    """Writes one block. The power goes by EN and ENO of a function, and by the first pins of a function
    block that are wired to power; everything else is written at the pins."""

    def __init__(self, writer: RungWriter, element: Element) -> None:
        self.writer, self.element, self.node = writer, element, element.node
        self.type = element.node.get("typeName").strip()
        self.is_function = not element.node.get("instanceName").strip()
        self.holder: Span | None = None
        if self.type.upper().rpartition(".")[2].strip() in writer.drawing.more.actions:
            self._action()
        self.signature = None if self.is_function else blocks.signature(self.type.upper())
        self.executes = next(element.node.descendants("STCode"), None)
        self.pins: list[ast.Pin] = []
        self.open: list[tuple[str, Span]] = []
        self.reads: list[str] = []
        self.writes: list[str] = []
        self.power_in: str | None = NO_WIRE
        self.power_out: str | None = NO_WIRE
        self.head = self.tail = None
        self.result: Elementary | None = None
        self.bits = 0
        self.mixed = False

    def _action(self) -> None:
        """A type `action`, `Pou.action` or `instance.action` is a call of an action, which has EN and ENO."""
        where = self.node.attribute("typeName")
        holder, _, name = where.text.rpartition(".")
        self.is_function, self.type = True, name.strip()
        if self.node.get("instanceName").strip():
            self.holder = self.node.attribute("instanceName")
        elif holder.strip().upper() not in ("", self.writer.drawing.where.upper()):
            self.holder = Span(where.source, where.start, where.start + len(holder))

    def write(self) -> None:
        writer, span = self.writer, self.node.span
        instance = None
        writer.failed |= not self._known()
        if not self.type:
            return
        if self.executes is not None:
            instance = self._execute(self.executes)
        elif self.holder is not None:
            instance = writer.expression(self.holder, self.element)
        elif not self.is_function:
            instance = writer.expression(self.node.attribute("instanceName"), self.element)
            if writer.drawing.is_guarded(self.element) and isinstance(instance, ast.Name):
                self.type = writer.drawing.more.guard(instance.name, self.type, span)
                self.signature = None
        for pin in self.element.inputs:
            self._input(pin)
        if self.is_function:
            self._open_inputs()
            self._mixed()
        after = [step for pin in self.element.outputs for step in self._output(pin)]
        conditional = [step for step in after if not step[4]] if is_conditional(self.element) else []
        enable = self._executed(after) if conditional else None
        sides = self.is_function, self.signature
        block = ast.Block(instance, self.type, tuple(self.pins), usual(self.power_in, "in", *sides),
                          usual(self.power_out, "out", *sides), span)
        writer.add(block, self.head, self.tail, self.reads, self.writes)
        for step in after:
            writer.function(*step[:3], span, *step[3:], enable=enable if step in conditional else None)

    def _executed(self, after: list[tuple]) -> str:
        """The net of ENO; a variable that stands at that pin gets its value ``after`` the block."""
        if self.power_out == "ENO":
            return self.tail
        found = next((p for p in self.pins if p.output and p.name == "ENO"), None)
        if found is not None and isinstance(found.value, ast.Junction):
            return found.value.name
        net, span = self.writer.fresh(), self.node.span
        if found is not None:
            self.pins.remove(found)
            after.append(("MOVE", ast.Junction(net, span), found.value, (net,), ()))
        self.writes.append(net)
        self.pins.append(ast.Pin("ENO", ast.Junction(net, span), True, span))
        return net

    def _execute(self, code: Node) -> ast.Name:
        """A block that holds statements becomes an instance of a function block of its own."""
        writer, span = self.writer, self.node.span
        instance = writer.drawing.more.fresh(texts.label(f"execute_{self.element.id}", "execute"))
        self.is_function, self.type = False, texts.label(f"{writer.drawing.where}_{instance}", "execute")
        body = statements(code.body, writer.diagnostics)
        self.pins += writer.drawing.more.execute(self.type, instance, body, span)
        return ast.Name(instance, span)

    def _known(self) -> bool:
        """Whether the block has a type that can be written at all."""
        if texts.is_name(self.type):
            return True
        if "." in self.type:
            where = f"{self.writer.drawing.where}: {self.element.describe()}"
            findings.unsupported(self.writer.diagnostics, self.node.span, f"{where} calls `{self.type[:80]}`",
                                 "no block or action of the files", "methods are not read: call a function block")
            return False
        return texts.name(self.node, self.writer.diagnostics, "typeName") is not None

    # ---- inputs

    def _input(self, pin: Input) -> None:
        if pin.name.upper() == "EN" and self._superfluous(pin):
            return
        name = pin.name or None
        span = pin.node.span
        value = self._value(pin)
        if value is None and pin.sources and pin.sources != frozenset((RAIL,)) or pin.edge and not value:
            self._wired(pin)
            return
        if value is None and RAIL in pin.sources and not pin.negated and self._takes_power(pin):
            self.power_in, self.head = pin.name, ""
            return
        if value is None and RAIL in pin.sources:
            value = texts.true(span, not pin.negated)
        elif value is None and pin.cut and pin.name.upper() == "EN":
            value = texts.true(span, pin.negated)
        elif value is not None and pin.negated:
            value = texts.negated(value)
        if value is not None:
            self.pins.append(ast.Pin(name, self._fitting(pin.name, value), False, span))
        elif pin.name.upper() != "EN":
            self.open.append((pin.name, span))

    def _open_inputs(self) -> None:
        """A function cannot keep what an input had: an open one gets a value."""
        where = f"{self.writer.drawing.where}: {self.element.describe()}"
        made = OpenPins(where, self.writer.diagnostics)
        own = self.writer.drawing.more.functions.get(self.type.upper())
        if own is None:
            self.pins = made.standard(self.type, self.pins, self.open)
        else:
            self.pins = made.own(own["VAR_INPUT"], self.pins, self.node.span)

    def _fitting(self, name: str, value: ast.Expr | ast.Branches) -> ast.Expr | ast.Branches:
        """A value for a pin whose type is known, converted as other editors do by themselves."""
        numbers = self.writer.drawing.more.numbers
        if not numbers or isinstance(value, ast.Branches):
            return value
        source, target = kinds.kind(value, numbers), self._number(name)
        if not kinds.needed(source, target):
            return value
        findings.converted(self.writer.diagnostics, value.span, source.type.name, target.name)
        return kinds.converted(value, source.type, target)

    def _number(self, name: str) -> Elementary | None:
        """The type of a pin of a function block, or of an input of an own function, when it is a number."""
        type_ = wires.pin_type(self.type, self.is_function, name, self.writer.drawing.more)
        return type_ if type_ is not None and type_.name in kinds.NUMBERS else None

    def _mixed(self) -> None:
        """The operands of an operator, when bit strings are among numbers. Keeps what it gives (``result``),
        from operands of how many ``bits``, and whether some were converted (``mixed``)."""
        numbers, type_ = self.writer.drawing.more.numbers, self.type.upper()
        values = [pin for pin in self.pins if (pin.name or "").upper() != "EN"]
        self.result = kinds.result(type_)
        if not numbers or not values or type_ not in kinds.OPERATORS or any(
                isinstance(pin.value, ast.Branches | ast.Junction) for pin in values):
            return
        found = {id(pin): kinds.kind(pin.value, numbers) for pin in values}
        if any(found[id(pin)] is None and not kinds.untyped(pin.value) for pin in values):
            return
        known = [one for one in found.values() if one is not None]
        target = None if type_ == "MOVE" else kinds.common(known, type_ in kinds.COMPARING)
        if known and type_ not in kinds.COMPARING:
            self.result = target or max((one.type for one in known), key=lambda one: one.bits)
            self.bits = max(one.bits for one in known)
        if target is None:
            return
        self.mixed = True
        for pin in values:
            one = found[id(pin)]
            if one is not None and one.type != target and not functions.widens(one.type, target):
                findings.converted(self.writer.diagnostics, pin.value.span, one.type.name, target.name)
        self.pins = [replace(pin, value=kinds.converted(pin.value, one.type, target))
                     if (one := found.get(id(pin))) is not None else pin for pin in self.pins]

    def _conversion(self, pin: str, place: ast.Expr) -> str:
        """The function that brings an output to a variable: MOVE, or a conversion."""
        numbers = self.writer.drawing.more.numbers
        source = self.result if self.is_function else self._number(pin)
        target = kinds.kind(place, numbers) if numbers and source is not None else None
        if target is None or pin.upper() == "ENO":
            return "MOVE"
        if not kinds.needed(kinds.Kind(source, self.bits or source.bits), target.type):
            return "MOVE"
        if not self.mixed:
            findings.converted(self.writer.diagnostics, place.span, source.name, target.type.name)
        return f"{source.name}_TO_{target.type.name}"

    def _superfluous(self, pin: Input) -> bool:
        """Whether this is EN of a function block that has none, and always on."""
        more = self.writer.drawing.more
        made = self.type.upper() in more.pous
        return not (self.is_function or made or pin.cut or more.has_pin(self.type, "EN"))

    def _value(self, pin: Input) -> ast.Expr | ast.Branches | ast.Junction | None:
        """The expression that an input takes, if it takes one; an edge of a variable as a contact."""
        at = self.writer.value_at(pin)
        if at is None:
            return None
        value = self.writer.expression(at, self.element) if isinstance(at, Span) else self.writer.value(at)
        if pin.edge:
            if not isinstance(value, _VARIABLES):
                net = self.writer.edge(self.writer.signal(value, value.span), pin, self.element)
                self.reads.append(net)
                return ast.Junction(net, value.span)
            contact = ast.Contact("P" if pin.edge == "R_TRIG" else "N", value, value.span)
            return ast.Branches((ast.Path((contact,), value.span),), value.span)
        return value

    def _takes_power(self, pin: Input) -> bool:
        if self.power_in != NO_WIRE or any(self._comes_back(id_) for id_, _ in pin.sources):
            return False
        if self.is_function:
            return pin.name.upper() == "EN"
        elements = self.writer.drawing.elements
        return bool(pin.name) and all(o == RAIL or wires.is_power(elements[o[0]], o[1]) for o in pin.sources)

    def _comes_back(self, id_: str) -> bool:
        """Whether this is a block that has its turn not before this one, as one of any loop of blocks has:
        power that goes in a circle would come from nowhere."""
        source = self.writer.drawing.elements.get(id_)
        return source is not None and source.kind == "block" and source.order >= self.element.order

    def _wired(self, pin: Input) -> None:
        writer, span = self.writer, pin.node.span
        net = writer.net(pin)
        if pin.edge:
            net = writer.edge(net, pin, self.element)
        if pin.negated:
            net = writer.inverted(net, span)
        if net is None:
            return
        if self._takes_power(pin):
            self.power_in, self.head = pin.name, net
            return
        net = self._carried(net, pin)
        self.reads.append(net)
        self.pins.append(ast.Pin(pin.name or None, ast.Junction(net, span), False, span))

    def _carried(self, net: str, pin: Input) -> str:
        """The net in the type of the pin that it goes to; a new one behind a conversion."""
        writer, span = self.writer, pin.node.span
        if len(pin.sources) != 1 or pin.negated or pin.edge:
            return net
        (id_, output), = pin.sources
        more = writer.drawing.more
        target = wires.pin_type(self.type, self.is_function, pin.name, more)
        if target is None:
            return net
        source = wires.carried(writer.drawing.elements[id_], output, more)
        conversion = wires.conversion(source, target)
        if conversion is None:
            return net
        if not functions.widens(source, target):
            findings.converted(writer.diagnostics, span, source.name, target.name)
        new = writer.fresh()
        writer.function(conversion, ast.Junction(net, span), ast.Junction(new, span), span, (net,), (new,))
        return new

    # ---- outputs

    def _output(self, pin) -> list[tuple]:
        """Writes an output; what has to follow the block (function, source, target, nets read, written)."""
        writer, span = self.writer, pin.node.span
        key = pin.name.upper()
        output = (self.element.id, key)
        name = self._result(pin.name)
        targets = [e for e in writer.readers(output) if writer.attached(e)]
        texts_ = [t.node.find("expression").content for t in targets if t.node.find("expression") is not None]
        if pin.text is not None:
            texts_.append(pin.text)
        places = [writer.expression(text, self.element) for text in texts_]
        wanted = [e for e in writer.readers(output) if e not in targets]
        net = writer.tail(output, span) if wanted else None
        after: list[tuple] = []
        if net is None and not places:
            return after
        if pin.negated:
            raw, goal = writer.fresh(), net
            target = ast.Junction(goal, span) if goal is not None else places.pop()
            after.append(("NOT", ast.Junction(raw, span), target, (raw,), (goal,) if goal else ()))
            net, places = raw, []
        if net is None and (conversion := self._conversion(pin.name, places[0])) != "MOVE":
            raw = writer.fresh()
            self.writes.append(raw)
            self.pins.append(ast.Pin(name, ast.Junction(raw, span), True, span))
            return [(conversion, ast.Junction(raw, span), places[0], (raw,), ())]
        if net is None:
            self.pins.append(ast.Pin(name, places[0], True, span))
            return after
        power = name == "ENO" if self.is_function else all(e.kind in ("contact", "coil", "jump", "return")
                                                            for e in wanted) or wires.is_power(self.element, key)
        if self.power_out == NO_WIRE and power and not pin.negated:
            self.power_out, self.tail = name, net
        else:
            self.writes.append(net)
            self.pins.append(ast.Pin(name, ast.Junction(net, span), True, span))
        after += [(self._conversion(pin.name, place), ast.Junction(net, span), place, (net,), ())
                  for place in places]
        return after

    def _result(self, name: str) -> str:
        """The result of a function is OUT, the output of statements ENO, whatever an editor calls it."""
        key = name.upper()
        if self.executes is not None:
            return "ENO"
        if self.is_function and key != "ENO" and (
                key in ("", self.type.upper()) or functions.lookup(self.type.upper()) is not None):
            return "OUT"
        return key if key == "ENO" else name
