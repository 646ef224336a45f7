"""From the rung as drawn to its graph: nets are found by union-find, elements come from the model.

Rules (DESIGN section 2): a path starts at the left rail unless its first item is a junction; a
junction names the net at its place, so the same name at several places is one net; all branches
start at the net before the brace and end at the net after it; a network at a pin is a rung of its
own that ends at the pin.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from ldc.diagnostics import Diagnostics
from ldc.graph.rung import RAIL, JunctionUse, RungGraph
from ldc.model.elements import Block, Element, Net
from ldc.parser import ast
from ldc.source import Span
from ldc.types import BOOL, Type


class ElementScope(Protocol):
    """What the graph needs of ``ldc.model.Scope``."""

    def element(
        self, item: ast.Contact | ast.Coil | ast.Block | ast.Jump,
        net_of: Callable[[ast.Branches | ast.Junction], Net], diagnostics: Diagnostics,
    ) -> Element | None: ...


def build(rung: ast.Rung, key: str, scope: ElementScope, diagnostics: Diagnostics) -> RungGraph | None:
    """The graph of ``rung``, or None when an element has no meaning (``diagnostics`` then tells).

    ``key`` is the rung's identity (see ``keys.rung_keys``). Nothing is judged here but the elements:
    ``rules.check`` does that. Source: SPEC section 9 step 1.
    """
    drawing = _Drawing()
    for path in rung.paths:
        drawing.path(path, None)
    nets = _Nets(drawing)
    elements, heads, tails = [], [], []
    early = _typed_early(drawing, nets, scope, diagnostics)
    for index, (item, head, tail) in enumerate(drawing.items):
        head, tail = nets.number(head), nets.number(tail)
        element = early[index] if index in early else scope.element(item, nets, diagnostics)
        if element is None:
            nets.failed = True
            continue
        if isinstance(element, Block):
            nets.learn(element)
            head = RAIL if element.power_in is None else head
        elements.append(element)
        heads.append(head)
        tails.append(tail)
    if nets.failed:
        return None
    junctions = tuple(JunctionUse(name, nets.number(net), span) for name, net, span in drawing.uses)
    names = ["rail"] + [f"#{net}" for net in range(1, len(nets.numbers))]
    for use in reversed(junctions):
        if use.net != RAIL:
            names[use.net] = use.name
    types = tuple(nets.types.get(net, BOOL) for net in range(len(names))) if nets.valued else ()
    return RungGraph(key, rung.name, rung.title, tuple(elements), tuple(heads), tuple(tails),
                     tuple(names), rung.span, types, junctions)


def _typed_early(
    drawing: _Drawing, nets: _Nets, scope: ElementScope, diagnostics: Diagnostics
) -> dict[int, Element | None]:
    """Elements that tell the type of a net which stands at a pin before them in the text, as in a loop; by
    their place. What they read goes before them."""
    tells: dict[int, int] = {}
    reads: dict[int, list[int]] = {}
    for index, (item, _, _) in enumerate(drawing.items) if drawing.at_pin else ():
        for pin in item.pins if type(item) is ast.Block else ():
            if type(pin.value) is ast.Junction:
                net = drawing.find(drawing.at_pin[id(pin.value)])
                if pin.output:
                    tells.setdefault(net, index)
                else:
                    reads.setdefault(index, []).append(net)
    feeders = {index: [tells[net] for net in found if net in tells] for index, found in reads.items()}
    early: dict[int, Element | None] = {}
    begun: set[int] = set()
    for index, found in feeders.items():
        work = [feeder for feeder in reversed(found) if feeder > index]
        while work:
            at = work[-1]
            if at not in begun:
                begun.add(at)
                work += [one for one in reversed(feeders.get(at, ())) if one not in begun]
                continue
            work.pop()
            if at not in early:
                item, head, tail = drawing.items[at]
                nets.number(head), nets.number(tail)
                early[at] = element = scope.element(item, nets, diagnostics)
                if isinstance(element, Block):
                    nets.learn(element)
    return early


class _Drawing:
    """The walk over the text: provisional nets, joined as links are met."""

    def __init__(self) -> None:
        self.items: list[tuple[ast.Item, int, int]] = []
        self.at_pin: dict[int, int] = {}
        self.uses: list[tuple[str, int, Span]] = []
        self._parent = [RAIL]
        self._named: dict[str, int] = {}

    def net(self) -> int:
        self._parent.append(len(self._parent))
        return len(self._parent) - 1

    def find(self, net: int) -> int:
        parent = self._parent
        while parent[net] != net:
            parent[net] = net = parent[parent[net]]
        return net

    def join(self, a: int, b: int) -> None:
        """The older net stands for both, so the rail stays net 0."""
        a, b = self.find(a), self.find(b)
        if a != b:
            self._parent[max(a, b)] = min(a, b)

    def junction(self, node: ast.Junction) -> int:
        key = node.name.upper()
        if key not in self._named:
            self._named[key] = self.net()
        self.uses.append((node.name, self._named[key], node.span))
        return self._named[key]

    def path(self, path: ast.Path, start: int | None) -> int:
        """The net that ``path`` ends at. ``start`` None: the rail, or the junction it begins with."""
        items = path.items
        if start is None:
            start = RAIL
            if items and isinstance(items[0], ast.Junction):
                start, items = self.junction(items[0]), items[1:]
        net = start
        for item in items:
            kind = type(item)
            if kind is ast.Junction:
                self.join(net, self.junction(item))
            elif kind is ast.Branches:
                net = self.branches(item, net)
            else:
                if kind is ast.Block:
                    self.pins(item)
                tail = self.net()
                self.items.append((item, net, tail))
                net = tail
        return net

    def branches(self, node: ast.Branches, start: int | None) -> int:
        end = self.net()
        for path in node.paths:
            self.join(end, self.path(path, start))
        return end

    def pins(self, block: ast.Block) -> None:
        for pin in block.pins:
            if isinstance(pin.value, ast.Branches):
                self.at_pin[id(pin.value)] = self.branches(pin.value, None)
            elif isinstance(pin.value, ast.Junction):
                self.at_pin[id(pin.value)] = self.junction(pin.value)


class _Nets:
    """The final numbers of nets, in order of appearance; called with a pin's node by the model."""

    def __init__(self, drawing: _Drawing) -> None:
        self._drawing = drawing
        self.numbers: dict[int, Net] = {RAIL: RAIL}
        self.types: dict[Net, Type] = {}
        self.failed = False
        self._powered: set[Net] | None = None

    def number(self, net: int) -> Net:
        return self.numbers.setdefault(self._drawing.find(net), len(self.numbers))

    def __call__(self, node: ast.Branches | ast.Junction) -> Net:
        return self.number(self._drawing.at_pin[id(node)])

    def type_of(self, node: ast.Branches | ast.Junction) -> Type | None:
        """The type of the net at a pin: what the blocks before told, BOOL when power flows in, or None."""
        net = self(node)
        if net not in self.types and self._powered is None:
            self._powered = {self.number(tail) for _, _, tail in self._drawing.items} | {RAIL}
        return self.types[net] if net in self.types else BOOL if net in self._powered else None

    @property
    def valued(self) -> bool:
        """Whether a net carries something else than power."""
        return any(type_ != BOOL for type_ in self.types.values())

    def learn(self, block: Block) -> None:
        for pin in block.outputs:
            if isinstance(pin.target, int):
                self.types.setdefault(pin.target, pin.type)
