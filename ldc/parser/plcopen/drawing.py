"""A graphical body as it is drawn: its elements, and which outputs each of their inputs is wired to."""

from __future__ import annotations

from functools import cached_property
from operator import attrgetter

from ldc.diagnostics import Diagnostics
from ldc.library import blocks
from ldc.library.functions import is_function
from ldc.parser.plcopen import additional, boxes, findings, texts
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.guarded import Additions
from ldc.parser.plcopen.pins import standard_names
from ldc.parser.plcopen.turns import any_loop, in_loops
from ldc.patterns import Pattern
from ldc.records import entity
from ldc.source import Span

Output = tuple[str, str]
"""(localId of the element, pin of the block in capitals or "")."""

RAIL: Output = ("", "")
ELEMENTS = ("contact", "coil", "block", "inVariable", "outVariable", "inOutVariable", "jump", "return",
            "connector", "continuation", "leftPowerRail")
CALLED = "called"
"""The tag of a function block that is called elsewhere: only its outputs are read here."""
KEEP, KEPT = "keep", "kept"
"""The tags of a variable that is added: where it gets the value of a function, and where that is read."""
VALUES = ("inVariable", "leftPowerRail", "continuation", "connector", CALLED, KEPT)
"""What gives a value and does nothing by itself."""
_WIRED = (("connectionPointIn",), ("connectionPointOut",), ("inputVariables", "variable"),
          ("outputVariables", "variable"))
"""What a vendor's element has that takes or gives a value."""
_EDGES = {("rising", False): "R_TRIG", ("falling", False): "F_TRIG",
          ("rising", True): "F_TRIG", ("falling", True): "R_TRIG"}
"""By the direction, and whether the pin is negated: then it is the opposite edge."""
_BOXES = ("inVariable", "outVariable")
_BOTH = {"inVariable": ("storage",), "inOutVariable": ("edgeIn", "storageIn", "edgeOut", "storageOut")}
_BLOCKS = ("block", CALLED)
_IGNORED = ("rightPowerRail", "documentation", "addData")

_POSITION = Pattern(r"<(?:[\w.-]+:)?position\s([^>]*)>")
_COORDINATE = Pattern(r"""\b([xy])\s*=\s*["'](-?\d+(?:\.\d+)?)""")
_NEAR = 100_000
"""Characters behind its beginning in which the last element of a text has its position."""


@entity
class Input:
    """``name``: of the pin. ``text``: an expression that stands at the pin itself. ``cut``: something was
    wired to it, which was left out."""

    name: str
    node: Node
    sources: frozenset[Output] = frozenset()
    negated: bool = False
    edge: str = ""
    text: Span | None = None
    cut: bool = False


@entity
class OutputPin:
    """``texts``: variables that stand at the pin itself."""

    name: str
    node: Node
    negated: bool = False
    text: Span | None = None


class Element:
    """``order``: sorts by execution number (None: it has none), then from top to bottom and left to right, then
    as written, of which ``index`` is the place."""

    __slots__ = ("id", "node", "kind", "position", "order", "inputs", "outputs")

    def __init__(self, id_: str, node: Node, number: int | None, index: int) -> None:
        self.id, self.node, self.kind = id_, node, node.tag
        y, x = self.position = node.position
        self.order: tuple[int, ...] = (1, y, x, index) if number is None else (0, number, index)
        self.inputs: list[Input] = []
        self.outputs: list[OutputPin] = []

    def describe(self) -> str:
        """What the element is called in messages."""
        y, x = self.position
        what = {"inVariable": "input variable", "outVariable": "output variable"}.get(self.kind, self.kind)
        name = self.node.get("instanceName") or self.node.get("typeName") or self.node.get("name")
        text = self.node.words("variable") or self.node.words("expression")
        name = name or (" ".join(text.text.split())[:40] if text is not None else "")
        return f"{what} {self.id}" + (f" `{name}`" if name else "") + (f" at ({x}, {y})" if x or y else "")


class Drawing:
    """The elements of a body by localId, in drawing order. ``where`` names the POU in messages; ``broken``:
    a part could not be read, so that others seem to be loose; ``placeholders``: boxes that an editor draws
    at open pins, in which no variable is named. ``goals``: tags of further elements, which only read."""

    def __init__(self, body: Node, where: str, more: Additions, diagnostics: Diagnostics,
                 goals: tuple[str, ...] = ()) -> None:
        self.body, self.where, self.more, self.diagnostics = body, where, more, diagnostics
        self.elements: dict[str, Element] = {}
        self.notes: list[Node] = []
        self.labels: list[Node] = []
        self.broken = False
        self.placeholders: set[str] = set()
        self._at_rail: set[str] = set()
        self._first = _first_number(body)
        for index, node in enumerate(body.children):
            if node.tag in ELEMENTS or node.tag == CALLED or node.tag in goals:
                if node.tag in _BOXES and not _written(node):
                    self.placeholders.add(node.get("localId").strip())
                else:
                    made = boxes.drawn(node)
                    if made.tag == "contact" and made is not node:
                        self._at_rail.add(made.get("localId").strip())
                    self._element(made, index)
            elif node.tag in ("comment", "vendorElement"):
                self.notes.append(node)
                if node.tag == "vendorElement" and any(node.find(*path) for path in _WIRED):
                    self._own_element(node)
            elif node.tag == "label":
                self.labels.append(node)
            elif node.tag not in _IGNORED:
                self.broken = True
                message = f"{where}: <{node.tag[:40]}> is no element of LD or FBD"
                findings.unsupported(diagnostics, node.span, message, "drawn here",
                                     "draw it with contacts, coils and blocks")
        self.has_rail = any(e.kind == "leftPowerRail" for e in self.elements.values())
        self._connect()
        self.elements = {e.id: e for e in sorted(self.elements.values(), key=attrgetter("order"))}
        self._turns_in_loops()

    def _own_element(self, node: Node) -> None:
        """Tell an element of the editor's own that takes or gives a value."""
        self.broken = True
        text = texts.prose(node.find("alternativeText"))[:40]
        message = f"{self.where}: the element `{text}` of the editor's own has inputs or outputs"
        findings.unsupported(self.diagnostics, node.span, message, "drawn here",
                             "draw it with blocks and variables")

    def _element(self, node: Node, index: int) -> None:
        id_ = node.get("localId").strip()
        if not id_ or id_ in self.elements:
            what = f"two elements have the localId {id_[:20]}" if id_ else f"a {node.tag} has no localId"
            findings.malformed(self.diagnostics, node.span, f"{self.where}: {what}")
            self.broken = True
            return
        if node.tag in _BLOCKS and "." in node.get("typeName"):
            node = self._without_library(node)
        number = node.number("executionOrderId", -1) if self._first is not None else None
        element = Element(id_, node, None if number is None or number < self._first else number, index)
        if node.tag in _BLOCKS:
            drawn = [pin for group in ("inputVariables", "inOutVariables") if (pins := node.find(group))
                     for pin in pins.all("variable")]
            names = standard_names(node.get("typeName").strip(), not node.get("instanceName").strip(),
                                   [pin.get("formalParameter").strip() for pin in drawn])
            element.inputs += map(self._input, drawn, names)
            pins = node.find("outputVariables")
            taken = {pin.name.upper() for pin in element.inputs}
            for pin in pins.all("variable") if pins is not None else ():
                if pin.get("formalParameter").strip().upper() in taken - {""}:
                    continue  # VAR_IN_OUT, which some editors write on both sides
                self._tell_modifiers(element, pin, ("edge", "storage"))
                point = pin.find("connectionPointOut", "expression")
                element.outputs.append(OutputPin(pin.get("formalParameter").strip(), pin, pin.flag("negated"),
                                                 _text(point)))
        elif node.tag not in ("leftPowerRail", "inVariable", "continuation"):
            element.inputs.append(self._input(node, ""))
        if node.tag in _BOTH:
            self._tell_modifiers(element, node, _BOTH[node.tag])
        self.elements[id_] = element

    def _without_library(self, node: Node) -> Node:
        """A block whose type is named with its library (`Standard.TON`), with the name alone."""
        library, _, own = node.get("typeName").strip().rpartition(".")
        key, of = own.upper(), library.upper()
        known = is_function(own) or key in blocks.names() or key in self.more.interfaces or (
            key in self.more.functions or key in additional.NAMES)
        holds_actions = of in self.more.interfaces or of in self.more.local or of == self.where.upper()
        if not known or holds_actions or key in self.more.actions:
            return node
        return node.like(node.tag, node.children, {**node.attributes, "typeName": own})

    def _tell_modifiers(self, element: Element, node: Node, names: tuple[str, ...]) -> None:
        """Tell edges and storage where nothing that is drawn means them."""
        for name in names:
            if boxes.modifier(node, name):
                pin = f" at its pin {node.get('formalParameter')[:40]}" if node.tag == "variable" else ""
                findings.unsupported(
                    self.diagnostics, node.span,
                    f"{self.where}: {element.describe()} has {name}=\"{node.get(name)[:20]}\"{pin}",
                    "drawn here", "draw a contact with that edge, or a coil that sets or resets")

    def _input(self, node: Node, name: str) -> Input:
        text = None if node.usual is not None else _text(node.find("connectionPointIn", "expression"))
        found = Input(name, node, text=text)
        if node.tag == "variable":
            found.negated = node.flag("negated")
            found.edge = _EDGES.get((boxes.modifier(node, "edge"), found.negated), "")
            found.negated &= not found.edge
        return found

    # ---- wires

    def _connect(self) -> None:
        named = {e.node.get("name").strip().upper(): e for e in self.elements.values()
                 if e.kind == "connector"}
        self._indirect = False
        for element in self.elements.values():
            for pin in element.inputs if element.kind != CALLED else ():
                pin.sources = frozenset(self._sources(element, pin))
        if self._indirect:
            self._follow(named)

    def _sources(self, element: Element, pin: Input) -> list[Output]:
        """What is wired to an input; notes whether some of it only passes on what another output gives."""
        found = [RAIL] if element.id in self._at_rail else []
        for number, (id_, name) in enumerate(pin.node.wires()):
            source = self.elements.get(id_)
            kind = source.kind if source is not None else None
            if kind == "contact" or kind == "coil":
                found.append((id_, ""))
            elif kind == "leftPowerRail":
                found.append(RAIL)
            elif kind in _BLOCKS:
                output = RAIL if self._always(source, name) else (id_, output_of(source, name))
                found.append(output)
                self._indirect |= output != RAIL and all(o.name.upper() != output[1] for o in source.outputs)
            elif source is not None:
                found.append((id_, ""))
                self._indirect |= kind in ("connector", "continuation")
            elif id_ not in self.placeholders:
                if id_ not in self._ids:
                    self.broken = True
                    where, wire = f"{self.where}: {element.describe()}", list(pin.node.connections())[number]
                    findings.no_such_element(self.diagnostics, wire.span, where, f"the element {id_[:20]}")
                pin.cut = True
        return found

    @cached_property
    def _ids(self) -> set[str]:
        """The localId of everything that is drawn."""
        return {node.get("localId").strip() for node in self.body.children}

    def _always(self, block: Element, output: str) -> bool:
        """Whether this is ENO of a function block that is called in any case."""
        if output.strip().upper() != "ENO" or not block.node.get("instanceName").strip():
            return False
        return not self.more.has_pin(block.node.get("typeName"), "ENO") and not self.is_guarded(block)

    def is_guarded(self, block: Element) -> bool:
        """Whether a function block that has no pin EN is drawn with a wire to EN."""
        type_ = block.node.get("typeName").strip()
        if not block.node.get("instanceName").strip() or self.more.has_pin(type_, "EN"):
            return False
        enable = next((pin for pin in block.inputs if pin.name.upper() == "EN"), None)
        wires = enable.node.wires() if enable is not None else ()
        sources = [self.elements.get(id_) for id_, _ in wires]
        return bool(sources) and not any(s is not None and s.kind == "leftPowerRail" for s in sources)

    def _turns_in_loops(self) -> None:
        """Elements without numbers that are on a loop change their turns (`turns.in_loops`). What comes back
        from a function block to one that has its turn before it is the output of the scan before."""
        elements = self.elements
        back = [id_ for e in elements.values() for pin in e.inputs for id_, _ in pin.sources  # some of every loop
                if id_ and elements[id_].position[1] >= e.position[1] and elements[id_].kind not in VALUES]
        if not back:
            return
        free = {e.id: e for e in elements.values() if e.order[0] == 1 and e.kind not in VALUES}

        def sources(id_: str) -> list[str]:
            return [id_ for pin in free[id_].inputs for id_ in _as_wired(pin) if id_ in free]

        if not any_loop((id_ for id_ in back if id_ in free), sources):
            return
        turns, loops = in_loops({e.id: e.kind for e in free.values()}, {id_: sources(id_) for id_ in free})
        for id_, order in zip(turns, [e.order for e in free.values()]):
            free[id_].order = order
        for loop in loops:
            for element in map(elements.__getitem__, loop):
                for pin in element.inputs if element.kind != "contact" else ():
                    pin.sources = frozenset(self.of_before(output) if output[0] in loop and (
                        elements[output[0]].order >= element.order) else output for output in pin.sources)
        from ldc.parser.plcopen import looping  # few files need it

        looping.keep(self, loops)
        self.elements = {e.id: e for e in sorted(elements.values(), key=attrgetter("order"))}

    def of_before(self, output: Output) -> Output:
        """An output of a function block, to be read as a variable; another one as it is."""
        block = self.elements[output[0]]
        if not is_call(block.node, self.more):
            return output
        key = f"{block.id} before"
        if key not in self.elements:
            self.elements[key] = made = Element(key, block.node.like(CALLED, block.node.children), None, 0)
            made.outputs = block.outputs
        return key, output[1]

    def _follow(self, named: dict[str, Element]) -> None:
        """Replace continuations by what their connector is wired to, VAR_IN_OUT pins by what feeds them."""
        def behind(output: Output) -> Input | None:
            element = self.elements.get(output[0])
            if element is None:
                return None
            if element.kind == "continuation":
                found = named.get(element.node.get("name").strip().upper())
                return found.inputs[0] if found is not None else None
            if element.kind == "connector":
                return element.inputs[0]
            if element.kind == "block" and not any(o.name.upper() == output[1] for o in element.outputs):
                return next((i for i in element.inputs if i.name.upper() == output[1]), None)
            return None

        known: dict[Output, frozenset[Output]] = {}

        def real(output: Output) -> frozenset[Output]:
            """What feeds an output in the end; a loop of connectors feeds nothing."""
            work = [output]
            while work:
                at = work[-1]
                pin = behind(at)
                if pin is None:
                    known[at] = frozenset((at,))
                elif at not in known:
                    known[at] = frozenset()
                    work += [source for source in pin.sources if source not in known]
                    continue
                elif len(pin.sources) == 1:
                    known[at] = known[next(iter(pin.sources))]
                else:
                    known[at] = frozenset().union(*(known[source] for source in pin.sources))
                work.pop()
            return known[output]

        first = {id(pin): frozenset().union(*map(real, pin.sources)) if pin.sources else pin.sources
                 for element in self.elements.values() for pin in element.inputs}
        for element in self.elements.values():
            for pin in element.inputs:
                pin.sources = frozenset(o for o in first[id(pin)] if o == RAIL
                                        or self.elements[o[0]].kind != "continuation")


def _first_number(body: Node) -> int | None:
    """The least number of an order of execution, None when nothing has any: 0 says that there is none, unless
    they count from there, as those of a continuous function chart do."""
    if body.tag == "CFC":
        return 0
    if body.document.source.text.find("executionOrderId", body.start, body.end) < 0 and type(body) is Node:
        return None
    numbers = [int(text) for node in body.children
               if (text := node.get("executionOrderId").strip()).isdecimal() and len(text) < 10]
    return 0 if len(numbers) > 1 and sorted(numbers) == list(range(len(numbers))) else 1


def position(span: Span) -> str:
    """Where the element that holds the beginning of a span is drawn, in words: `at (40, 60)`."""
    text = span.source.text
    begin = text.rfind("localId", 0, span.end)
    end = text.find(" localId", max(begin, span.end) + 1)
    found = _POSITION.search(text, max(begin, 0), end if end >= 0 else min(len(text), span.end + _NEAR))
    if begin < 0 or found is None:
        return ""
    at = dict(pair[:2] for pair in _COORDINATE.findall(found[1]))
    return f"at ({at.get('x', '0')}, {at.get('y', '0')})"


def output_of(block: Element, name: str) -> str:
    """The output that a wire means; without a name it is the first one. An editor may leave out pins
    that only the wire tells of: these are added. Functions have one result, however it is called."""
    key = name.upper()
    names = [pin.name.upper() for pin in (*block.outputs, *block.inputs)]
    is_function = not block.node.get("instanceName").strip()
    if key in names:
        return key
    if block.outputs and key != "ENO" and (is_function or not key):
        return block.outputs[0].name.upper()
    if not key and (signature := blocks.signature(block.node.get("typeName").strip().upper())) is not None:
        key = name = signature.outputs[0].name
    block.outputs.append(OutputPin(name, block.node))
    return key


def is_call(node: Node, more: Additions) -> bool:
    """Whether this is a call of a function block; one of an action has an instance too."""
    action = node.get("typeName").rpartition(".")[2].strip().upper() in more.actions
    return node.tag == "block" and bool(node.get("instanceName").strip()) and not action


def is_conditional(block: Element) -> bool:
    """Whether this is a function that is executed only while what is wired to its EN is TRUE."""
    return not block.node.get("instanceName").strip() and any(
        pin.name.upper() == "EN" and pin.sources and RAIL not in pin.sources for pin in block.inputs)


def _as_wired(pin: Input) -> list[str]:
    """The elements that an input is wired to, in the order of its wires."""
    if len(pin.sources) < 2:  # nearly all: their wires need not be looked at
        return [id_ for id_, _ in pin.sources]
    found = {id_ for id_, _ in pin.sources}
    wired = [id_ for id_, _ in pin.node.wires() if id_ in found]
    return wired + sorted(found.difference(wired))


def _written(node: Node) -> bool:
    """Whether a variable box of an editor names anything."""
    text = node.find("expression") or node.find("variable")
    return text is not None and _text(text) is not None


def _text(node: Node | None) -> Span | None:
    if node is None:
        return None
    span = node.content
    return span if span.end > span.start and span.text != boxes.NOT_NAMED else None
