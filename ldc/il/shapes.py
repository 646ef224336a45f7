"""Rungs of equal shape are compiled and proved once.

Two rungs have the same shape when they differ in nothing but names: which variables (and bits of the process
image) they use, not in how often and where each of them occurs. Constants at pins of standard function
blocks, which nothing looks at, count as names too. Reduction, lowering and self-check ask about variables
only whether two are the same, so what they give for one rung they give for the other with its names;
docs/architecture-of-the-check.md says why that is a proof. What is not surely so is of no shape and is compiled
by itself: overlapping locations, indexes, expressions, loops.
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
    """``key``: equal for rungs of equal shape. ``roots``: the variables by their numbers, each of which occurs
    as often as ``uses`` says; ``constants``: those at pins by their numbers."""

    def __init__(self, graph: RungGraph, locations: Mapping[str, Location]) -> None:
        self._locations = locations
        self._numbers: dict[tuple[bool, str], int] = {}
        self._bits: set[tuple[str, int]] = set()
        self.roots: list[Place] = []
        self.uses: list[int] = []
        self.constants: list[Const] = []
        self._of_constants: dict[tuple, int] = {}
        self._once: frozenset[object] = frozenset()
        # What a POU of the project may see when it is called: then it matters where a variable is kept.
        blocks = [e for e in graph.elements if type(e) is Block]
        self._seen = any(not e.signature.standard for e in blocks)
        # Function blocks of the standard take constants as they are; of others their values may matter.
        self._handed_on = not self._seen and all(e.instance is not None for e in blocks)
        self.key = self._graph(graph)

    def remember(self, hidden: Memories) -> None:
        """The edge memories are variables of the rung too."""
        for name in hidden.edges.values():
            self.place(Place(name, BOOL))

    def family(self, graph: RungGraph) -> tuple:
        """Equal for rungs whose trees are one, and right when it is right for one of them.

        They differ in no more than this: which contacts are closed, of those whose variables occur nowhere
        else. A drawing and its tree both ask such a contact for one value that nothing else depends on: that
        it is the opposite exchanges assignments, of which all are compared. To be asked for first.
        """
        if self._seen:
            return self.key
        self._once = frozenset(n * 8 for n, uses in enumerate(self.uses) if uses == 1)
        found = self._graph(graph)
        self._once = frozenset()
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
                tuple([(p.pin, p.type, p.source if isinstance(p.source, int) else (self._pin(p.source),))
                       for p in block.inputs]),
                tuple([(p.pin, p.type, p.target if isinstance(p.target, int) else (self.place(p.target),))
                       for p in block.outputs]))

    def _pin(self, expr: Expr) -> object:
        """A constant that is handed on is only told from others; code has BOOLs and zeros of its own."""
        if type(expr) is not Const or not self._handed_on or expr.type is BOOL or (
                expr.value == default(expr.type)):
            return self._expr(expr)
        const = _const(expr)
        number = self._of_constants.get(const)
        if number is None:
            number = self._of_constants[const] = len(self.constants)
            self.constants.append(expr)
        return "constant", number, expr.type

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
        if type(operand) is Place:
            return self.place(operand)
        number = self.constant(operand)
        return _const(operand) if number is None else ("constant", number, operand.type)

    def constant(self, operand: Operand | None) -> int | None:
        """The place of a constant in ``constants``; None for what is none of them."""
        return self._of_constants.get(_const(operand)) if type(operand) is Const else None


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
    (-1: none, or a temporary; from -2 down: which constant); ``proved``: the code that the verdict is about,
    with numbers for names."""

    made: Made
    numbers: tuple[int, ...]
    proved: tuple

    def another(self, graph: RungGraph, shape: Shape, label: str | None) -> Made | None:
        """The same for a rung of this shape: the IL with its own names. It is read back and compared with
        what was proved; None when it is something else."""
        made, elements, roots, constants = self.made, graph.elements, shape.roots, shape.constants
        hidden = memories(graph, made.turns)
        shape.remember(hidden)
        code = tuple([
            Instr(i.op,
                  _renamed(i.operand, roots[n]) if n >= 0 else i.operand if n == -1 else constants[-2 - n],
                  i.type, i.name, (), (), i.element, elements[i.element].span)
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

    def number(operand: Operand | None) -> int:
        if type(operand) is Place:
            return shape.index(operand) if operand.root not in temps else -1
        constant = shape.constant(operand)
        return -1 if constant is None else -2 - constant

    numbers = tuple([number(i.operand) for i in code])
    try:
        return Known(made, numbers, shape.code(code))
    except _NoShape:
        return None


def _renamed(place: Place, root: Place) -> Place:
    if not place.steps and not root.steps:
        return root
    return Place(root.root, place.type, place.steps, root.is_global)
