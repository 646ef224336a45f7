"""Rungs of equal shape are compiled and proved once.

Two rungs have the same shape when they differ in nothing but names: which variables (and bits of the process
image) they use, not in how often and where each of them occurs. Reduction, lowering and self-check ask about
variables only whether two are the same, so what they give for one rung they give for the other with its
names; docs/architecture-of-the-check.md says why that is a proof. What is not surely so is of no shape and
is compiled by itself: overlapping locations, indexes, expressions, loops.
"""

from __future__ import annotations

from collections.abc import Mapping

from ldc.expr import BitStep, Const, Expr, FieldStep, Load, Place
from ldc.graph.memory import Memories, memories
from ldc.graph.order import Turn
from ldc.graph.rung import RungGraph
from ldc.graph.tree import SPTree
from ldc.il.lower import Lowered
from ldc.il.program import Instr, Operand, RungCode
from ldc.il.verify import Verdict
from ldc.model.elements import Block, Coil, Contact
from ldc.records import record
from ldc.symbols import Location
from ldc.types import BOOL, Type, default

_AREAS = {"I": 2, "Q": 3, "M": 4}
_PLAIN = ("open", "closed")


class _NoShape(Exception):
    """The rung has something that names alone do not tell."""


class Shape:
    """``key``: equal for rungs of equal shape. ``roots``: the variables by their numbers, of which each occurs so
    often as ``uses`` says."""

    def __init__(self, graph: RungGraph, locations: Mapping[str, Location]) -> None:
        self._locations = locations
        self._numbers: dict[tuple[bool, str], int] = {}
        self._bits: set[tuple[str, int]] = set()
        self.roots: list[Place] = []
        self.uses: list[int] = []
        self._once: frozenset[object] = frozenset()
        self._constants: dict[object, tuple] | None = None
        # What a POU of the project may see when it is called: then it matters where a variable is kept.
        self._seen = any(type(e) is Block and not e.signature.standard for e in graph.elements)
        self.key = self._graph(graph)

    def remember(self, hidden: Memories) -> None:
        """The edge memories are variables of the rung too."""
        for name in hidden.edges.values():
            self.place(Place(name, BOOL))

    def family(self, graph: RungGraph) -> tuple:
        """Equal for rungs whose trees are one, and right when it is right for one of them.

        They differ in no more than this: which contacts are closed, of those whose variables occur nowhere else,
        and which constants stand at pins of standard function blocks. A drawing and its tree both ask such a
        contact for one value that nothing else depends on: that it is the opposite exchanges assignments, of
        which all are compared. They hand such constants on as they are. To be asked for before anything else.
        """
        if self._seen:
            return self.key
        self._once = frozenset(n * 8 for n, uses in enumerate(self.uses) if uses == 1)
        self._constants = {}
        found = self._graph(graph)
        self._once, self._constants = frozenset(), None
        return found

    # -- what a rung is made of, with numbers for names

    def _graph(self, graph: RungGraph) -> tuple:
        rows: list[object] = [self._seen, graph.heads, graph.tails, len(graph.net_names), graph.net_types]
        for element in graph.elements:
            kind = type(element)
            if kind is Contact:
                what = self._expr(element.expr)
                rows += ("once" if what in self._once and element.kind in _PLAIN else element.kind, what)
            elif kind is Coil:
                rows += ("coil", element.kind, self.place(element.place))
            elif kind is Block:
                rows.append(self._block(element))
            else:
                rows += ("jump", element.label)
        names: dict[str, int] = {}
        rows += [(names.setdefault(use.name.upper(), len(names)), use.net) for use in graph.junctions]
        return tuple(rows)

    def _block(self, block: Block) -> tuple:
        return (block.callee, block.signature.result, block.power_in, block.power_out,
                None if block.instance is None else self.place(block.instance),
                tuple([(p.pin, p.type, p.source if isinstance(p.source, int) else (self._pin(block, p.source),))
                       for p in block.inputs]),
                tuple([(p.pin, p.type, p.target if isinstance(p.target, int) else (self.place(p.target),))
                       for p in block.outputs]))

    def _pin(self, block: Block, expr: Expr) -> object:
        if self._constants is None or block.instance is None or type(expr) is not Const or expr.type is BOOL:
            return self._expr(expr)
        is_default = expr.value == default(expr.type)
        return self._constants.setdefault(_const(expr), (len(self._constants), expr.type, is_default))

    def _expr(self, expr: Expr) -> object:
        if type(expr) is Load:
            return self.place(expr.place)
        if type(expr) is Const:
            return _const(expr)
        raise _NoShape

    def place(self, place: Place) -> object:
        """A number that tells one variable from others and where it is kept; with the way into it."""
        number = self.number(place)
        if not place.steps and place.type is BOOL:
            return number
        steps = []
        for step in place.steps:
            if type(step) is FieldStep:
                steps.append(step.name.upper())
            elif type(step) is BitStep:
                steps.append(step.bit)
            else:
                raise _NoShape
        return number, place.type, tuple(steps)

    def number(self, place: Place) -> int:
        name = place.root.upper()
        number = self._numbers.get((place.is_global, name))
        if number is None:
            kept = int(place.is_global)
            location = self._locations.get(name) if name[0] != "%" else Location.parse(name)
            if location is not None:
                bit = location.area, location.byte * 8 + location.bit
                if location.extent != 1 or bit in self._bits:
                    raise _NoShape
                self._bits.add(bit)
                kept = _AREAS[location.area]
            number = self._numbers[place.is_global, name] = len(self.roots) * 8 + (kept if self._seen else 0)
            self.roots.append(place)
            self.uses.append(0)
        self.uses[number // 8] += 1
        return number

    def index(self, place: Place) -> int:
        """The place of its variable in ``roots``."""
        return self.number(place) // 8

    def code(self, code: tuple[Instr, ...]) -> tuple:
        """Instructions with numbers for names; numbers go on behind those of the drawing."""
        return tuple([(i.op, self._operand(i.operand), None if i.type is BOOL else i.type, i.name,
                       tuple(map(self._operand, i.args)) if i.args else ()) for i in code])

    def _operand(self, operand: Operand | None) -> object:
        if operand is None:
            return None
        return self.place(operand) if type(operand) is Place else _const(operand)


def _const(const: Const) -> tuple[str, Type]:
    return repr(const.value), const.type


def shape_of(graph: RungGraph, locations: Mapping[str, Location]) -> Shape | None:
    """The shape of a rung; None when it has none. ``locations``: located variables by name in capitals."""
    try:
        return Shape(graph, locations)
    except _NoShape:
        return None


@record
class Made:
    """What was made of a rung; ``verdict`` is None when nobody asked for one."""

    turns: tuple[Turn, ...]
    tree: SPTree
    lowered: Lowered
    verdict: Verdict | None


@record
class Known:
    """What was made of a rung, for others of its shape. ``numbers``: which variable each instruction names
    (-1: none, or a temporary); ``proved``: the code that the verdict is about, with numbers for names."""

    made: Made
    numbers: tuple[int, ...]
    proved: tuple

    def another(self, graph: RungGraph, shape: Shape, label: str | None) -> Made | None:
        """The same for a rung of this shape: the IL with its own names. It is read back and compared with
        what was proved; None when it is something else."""
        made, elements, roots = self.made, graph.elements, shape.roots
        hidden = memories(graph, made.turns)
        shape.remember(hidden)
        code = tuple([
            Instr(i.op, i.operand if n < 0 else _renamed(i.operand, roots[n]), i.type, i.name, (), (), i.element,
                  elements[i.element].span)
            for i, n in zip(made.lowered.code.code, self.numbers)])
        if shape.code(code) != self.proved:
            return None
        rung = RungCode(graph.key, code, label, graph.title, graph.name, made.lowered.code.proof, graph.span)
        return Made(made.turns, made.tree, Lowered(rung, made.lowered.temps, hidden.variables()), made.verdict)


def known(graph: RungGraph, shape: Shape, hidden: Memories, made: Made) -> Known | None:
    """What can be kept of a rung; None when it is wrong or its code holds more than names to change."""
    code, elements = made.lowered.code.code, graph.elements
    if not graph.in_order or made.verdict is not None and made.verdict.kind == "wrong":
        return None
    if any(i.op == "LABEL" or i.args or i.outputs or i.element < 0 or i.span != elements[i.element].span
           for i in code):
        return None
    shape.remember(hidden)
    temps = {v.name for v in made.lowered.temps}
    numbers = tuple([shape.index(i.operand) if type(i.operand) is Place and i.operand.root not in temps else -1
                     for i in code])
    try:
        return Known(made, numbers, shape.code(code))
    except _NoShape:
        return None


def _renamed(place: Place, root: Place) -> Place:
    if not place.steps and not root.steps:
        return root
    return Place(root.root, place.type, place.steps, root.is_global)
