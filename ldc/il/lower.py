"""The series/parallel tree of a rung to IL (SPEC section 9, step 3).

Power that is a plain function of contacts stays an expression until something needs it, so that it
comes out in the fewest instructions; coils, blocks and edges fix the order.
"""

from __future__ import annotations

from ldc.expr import TRUE, Apply, Const, Load, Place
from ldc.graph.memory import Memories
from ldc.graph.rung import RungGraph
from ldc.graph.tree import Leaf, Parallel, Series, SPTree, Step, Tap, Tree
from ldc.il.emit import Emitter
from ldc.il.lower_blocks import BlockLowering
from ldc.il.program import Instr, RungCode
from ldc.il.values import Value, can_fault, conjunction, disjunction, negation
from ldc.library import functions
from ldc.model.elements import Block, Coil, Contact, Jump
from ldc.records import record
from ldc.symbols import Variable
from ldc.types import BOOL


@record
class Lowered:
    """A rung's code and the variables that it needs beside the declared ones."""

    code: RungCode
    temps: tuple[Variable, ...]
    hidden: tuple[Variable, ...]


def lower(graph: RungGraph, tree: SPTree, memories: Memories, *, label: str | None = None,
          max_paren_depth: int | None = None) -> Lowered:
    """IL of one rung. ``label`` is set when a jump leads to the rung; ``max_paren_depth`` limits
    the nesting of deferred operators, deeper ones go through temporaries.
    """
    lowering = _Lowering(graph, tree, memories, Emitter(graph.key, max_paren_depth))
    for step in tree.steps:
        lowering.step(step)
    code = lowering.finish()
    rung = RungCode(graph.key, code, label, graph.title, graph.name, "none", graph.span)
    return Lowered(rung, tuple(lowering.emit.temps.values()), memories.variables())


class _Lowering:
    def __init__(self, graph: RungGraph, tree: SPTree, memories: Memories, emit: Emitter) -> None:
        self.graph = graph
        self.memories = memories
        self.emit = emit
        self.blocks = BlockLowering(emit, self._keep, {(index, pin): net for index, pin, net in tree.outputs})
        self.nets: dict[int, Value] = {}
        self.jumps: list[tuple[int, str | None, Value]] = []
        self._pure: dict[int, tuple[Tree, bool]] = {}
        self._pure_elements: dict[int, bool] = {}

    def step(self, step: Step) -> None:
        power = self.power(step.tree, TRUE, step.net is not None)
        if step.net is not None:
            self._keep(step.net, self._settled(power))

    def finish(self) -> tuple[Instr, ...]:
        """Takes the jumps after the rest of the rung, the first in drawing order first."""
        for index, label, power in sorted(self.jumps, key=lambda jump: jump[0]):
            self._at(index)
            op = "RET" if label is None else "JMP"
            if power == TRUE:
                self.emit.put(op, name=label or "")
            else:
                self.emit.value(power)
                self.emit.put(op + "C", name=label or "")
        return self.emit.finish()

    def _at(self, index: int) -> None:
        self.emit.element, self.emit.span = index, self.graph.elements[index].span

    # -- power through a tree

    def power(self, tree: Tree, power: Value, needed: bool = True) -> Value:
        """The power that leaves ``tree`` when ``power`` enters; effects are emitted on the way.

        What comes back may be an expression that is still to be computed; the caller does so before
        any effect that could change it. ``needed`` False: nobody looks at the result.
        """
        if type(tree) is Leaf:
            return self._leaf(tree, power, needed)
        match tree:
            case Tap(net, previous):
                return _and(power, self._tap(net, previous))
            case Series(children):
                return self._series(children, power, needed)
            case Parallel(children):
                return self._parallel(children, power, needed)

    def _tap(self, net: int, previous: bool) -> Value:
        if previous:
            name = self.memories.nets[net]
            return Load(Place(name, self.memories.types.get(name, BOOL)))
        return TRUE if net == 0 else self.nets[net]

    def _series(self, children: tuple[Tree, ...], power: Value, needed: bool) -> Value:
        items: list[Value] = [] if power == TRUE else [power]
        last = len(children) - 1
        for n, child in enumerate(children):
            if self.pure(child):
                item = self.power(child, TRUE)
                if item != TRUE:
                    items.append(item)
            else:
                out = self.power(child, conjunction(items) if items else TRUE, needed or n != last)
                items = [] if out == TRUE else [out]
        return conjunction(items) if items else TRUE

    def _parallel(self, children: tuple[Tree, ...], power: Value, needed: bool) -> Value:
        if all(self.pure(child) for child in children):
            return _and(power, disjunction([self.power(child, TRUE) for child in children]))
        power = self._settled(power)
        impure_after = [False] * len(children)
        for n in range(len(children) - 2, -1, -1):
            impure_after[n] = impure_after[n + 1] or not self.pure(children[n + 1])
        results = []
        for child, effects_follow in zip(children, impure_after):
            if not needed and self.pure(child):
                continue
            result = self.power(child, power, needed)
            if needed:
                results.append(self._settled(result) if effects_follow else result)
        return disjunction(results) if results else TRUE

    def _settled(self, value: Value) -> Value:
        """The value, computed now unless nothing that follows can change it."""
        if isinstance(value, Const) or isinstance(value, Load) and value.place.root in self.emit.temps:
            return value
        return self.emit.held(value)

    def pure(self, tree: Tree) -> bool:
        """Whether the tree only reads: contacts that cannot fault, and kept powers."""
        if isinstance(tree, Tap):
            return True
        if isinstance(tree, Leaf):
            known = self._pure_elements.get(tree.index)
            if known is None:
                element = self.graph.elements[tree.index]
                known = self._pure_elements[tree.index] = (
                    isinstance(element, Contact) and element.kind not in ("rising", "falling")
                    and not can_fault(element.expr))
            return known
        known = self._pure.get(id(tree))
        if known is None:
            result = True
            for child in tree.children:
                if not self.pure(child):
                    result = False
                    break
            known = self._pure[id(tree)] = tree, result
        return known[1]

    # -- elements

    def _leaf(self, leaf: Leaf, power: Value, needed: bool) -> Value:
        self._at(leaf.index)
        element = self.graph.elements[leaf.index]
        match element:
            case Contact():
                out = self._contact(leaf.index, element, power)
            case Coil():
                out = self._coil(leaf.index, element, power)
            case Jump(label):
                out = self._settled(power)
                self.jumps.append((leaf.index, label, out))
            case Block():
                power, pins = self._pins(leaf, power)
                out = self.blocks.lower(leaf.index, element, pins, power, needed)
        return out

    def _pins(self, leaf: Leaf, power: Value) -> tuple[Value, dict[str, Value]]:
        """The networks at the pins of a block; what was pending before their effects is computed first."""
        if not all(self.pure(tree) for _, tree in leaf.pins):
            power = self._settled(power)
            pins = {}
            for name, tree in leaf.pins:
                pins[name] = self._settled(self.power(tree, TRUE))
        else:
            pins = {name: self.power(tree, TRUE) for name, tree in leaf.pins}
        self._at(leaf.index)
        for pin in self.graph.elements[leaf.index].inputs:
            types = self.graph.widening(pin) if pin.pin in pins else None
            if types is not None:
                pins[pin.pin] = Apply(functions.conversion(*types), (pins[pin.pin],), types[1])
        return power, pins

    def _contact(self, index: int, contact: Contact, power: Value) -> Value:
        emit = self.emit
        if contact.kind in ("rising", "falling"):
            now, memory = contact.expr, Load(Place(self.memories.edges[index], BOOL))
            if isinstance(now, Load):
                now = Load(emit.place(now.place))
            edge = _edge(contact.kind, now, memory)
            emit.value(edge)
            edge = emit.hold()
            emit.held_place(edge)
            emit.value(now)
            emit.store(memory.place)
            return _and(power, edge)
        item = emit.own(negation(contact.expr) if contact.kind == "closed" else contact.expr)
        if power == TRUE or not can_fault(contact.expr):
            return _and(power, item)
        result, skip = emit.temp(BOOL), emit.label()
        emit.value(power)
        emit.store(result)
        emit.put("JMPCN", name=skip)
        emit.value(item)
        emit.store(result)
        emit.put("LABEL", name=skip)
        return Load(result)

    def _coil(self, index: int, coil: Coil, power: Value) -> Value:
        emit = self.emit
        place = emit.place(coil.place)
        if coil.kind in ("rising", "falling"):
            memory = Load(Place(self.memories.edges[index], BOOL))
            power = emit.held(power)
            emit.value(_edge(coil.kind, power, memory))
            emit.store(place)
            emit.value(power)
            emit.store(memory.place)
            return power
        emit.value(power)
        held = emit.hold()
        emit.store(place, {"normal": "ST", "negated": "STN", "set": "S", "reset": "R"}[coil.kind])
        return TRUE if power == TRUE else held

    def _keep(self, net: int, value: Value) -> None:
        """Feeds a net; what a loop needs of it in the next execution is remembered."""
        known = self.nets.get(net)
        self.nets[net] = value if known is None else self._settled(disjunction([known, value]))
        memory = self.memories.nets.get(net)
        if memory is not None:
            self.emit.value(self.nets[net])
            self.emit.store(Place(memory, value.type))


def _and(power: Value, item: Value) -> Value:
    if power == TRUE:
        return item
    return power if item == TRUE else Apply("AND", (power, item), BOOL)


def _edge(kind: str, now: Value, memory: Load) -> Value:
    if kind == "rising":
        return Apply("AND", (now, negation(memory)), BOOL)
    return Apply("AND", (memory, negation(now)), BOOL)
