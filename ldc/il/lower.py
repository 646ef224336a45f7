"""The series/parallel tree of a rung to IL (SPEC section 9, step 3).

Power that is a plain function of contacts stays an expression until something needs it, so that it
comes out in the fewest instructions; coils, blocks and edges fix the order.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from ldc.expr import TRUE, Apply, Const, FieldStep, Load, Place
from ldc.graph.memory import Memories
from ldc.graph.rung import RungGraph
from ldc.graph.tree import Leaf, Parallel, Series, SPTree, Step, Tap, Tree
from ldc.il.emit import Emitter, Held, Value, can_fault, conjunction, disjunction, negation
from ldc.il.program import Instr, RungCode
from ldc.library import functions
from ldc.model.elements import Block, Coil, Contact, Jump, PinOut
from ldc.symbols import Variable
from ldc.types import BOOL, Elementary, Type, default, storage

_DIVISIONS = frozenset(("DIV", "MOD", "DIVTIME"))


@dataclass(frozen=True, slots=True)
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
        self.outputs = {(index, pin): net for index, pin, net in tree.outputs}
        self.memories = memories
        self.emit = emit
        self.nets: dict[int, Value] = {}
        self.jumps: list[tuple[int, str | None, Value]] = []
        self._pure: dict[int, tuple[Tree, bool]] = {}

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
        match tree:
            case Leaf():
                return self._leaf(tree, power, needed)
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
            element = self.graph.elements[tree.index]
            return (isinstance(element, Contact) and element.kind not in ("rising", "falling")
                    and not can_fault(element.expr))
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
                out = self._block(leaf.index, element, pins, power, needed)
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

    # -- blocks

    def _block(self, index: int, block: Block, pins: dict[str, Value], power: Value, needed: bool) -> Value:
        sources = [(p.pin, p.type, pins[p.pin] if isinstance(p.source, int) else p.source) for p in block.inputs]
        if block.is_function:
            return self._function(index, block, sources, power)
        return self._instance(index, block, sources, power, needed)

    def _instance(self, index: int, block: Block, sources, power: Value, needed: bool) -> Value:
        emit = self.emit
        instance = emit.place(block.instance)
        if block.power_in is not None:
            sources = [(block.power_in, BOOL, power), *sources]
        if any(_reads(value, instance.root) for _, _, value in sources[1:]):
            sources = [(name, type_, self._spilled(value)) for name, type_, value in sources]
        for name, type_, value in sources:
            emit.value(value)
            emit.store(_member(instance, name, type_))
        emit.put("CAL", instance, instance.type)
        for pin in block.outputs:
            emit.value(Load(_member(instance, pin.pin, pin.type)))
            self._deliver(index, pin)
        if block.power_out is None or not needed:
            return TRUE
        emit.value(Load(_member(instance, block.power_out, BOOL)))
        return emit.hold()

    def _spilled(self, value: Value) -> Held:
        held = self.emit.held(value)
        self.emit.held_place(held)
        return held

    def _deliver(self, index: int, pin: PinOut) -> None:
        """Stores the accumulator, of the pin's type, to the pin's target."""
        if isinstance(pin.target, int):
            self._keep(self._net(index, pin), self.emit.hold(pin.type))
            return
        source, target = storage(pin.type), storage(pin.target.type)
        if source != target and isinstance(source, Elementary) and isinstance(target, Elementary):
            self.emit.put("FN", None, target, functions.conversion(source, target))
        self.emit.store(pin.target)

    def _net(self, index: int, pin: PinOut) -> int:
        return self.outputs.get((index, pin.pin), pin.target)

    def _keep(self, net: int, value: Value) -> None:
        """Feeds a net; what a loop needs of it in the next execution is remembered."""
        known = self.nets.get(net)
        self.nets[net] = value if known is None else self._settled(disjunction([known, value]))
        memory = self.memories.nets.get(net)
        if memory is not None:
            self.emit.value(self.nets[net])
            self.emit.store(Place(memory, value.type))

    def _function(self, index: int, block: Block, sources, power: Value) -> Value:
        """``LD en / ST t / JMPCN skip / … / skip:``; what EN = FALSE leaves alone is not touched."""
        emit = self.emit
        enable = power if block.power_in == "EN" else TRUE
        for name, _, value in sources:
            if name == "EN":
                enable = value
        sources = [source for source in sources if source[0] != "EN"]
        if block.power_in not in (None, "EN"):
            order = {p.name: n for n, p in enumerate(block.signature.inputs)}
            sources.append((block.power_in, BOOL, power))
            sources.sort(key=lambda source: order[source[0]])
        args = tuple(value for _, _, value in sources)
        block_outputs = tuple(self._indexed(p) for p in block.outputs)
        net_temps = self._zeroed(block)
        checked = block.callee in _DIVISIONS and _eno_drawn(block) and not (
            isinstance(args[1], Const) and args[1].value != 0)
        guard: Place | None = None
        skip = emit.label() if checked or enable != TRUE else ""
        if skip:
            guard, args = self._guard(enable, args, skip, checked)
        taken = self._call(block, block_outputs, args)
        self._take_results(index, block, block_outputs, net_temps, taken)
        if skip:
            emit.put("LABEL", name=skip)
        eno: Value = TRUE if guard is None else Load(guard)
        return self._after(index, block, block_outputs, net_temps, eno)

    def _indexed(self, pin: PinOut) -> PinOut:
        """The pin with the index of its target computed, before anything is skipped."""
        return pin if isinstance(pin.target, int) else replace(pin, target=self.emit.place(pin.target))

    def _guard(self, power: Value, args, skip: str, checked: bool):
        """Jumps over the call without power, and (``checked``) when the divisor is zero."""
        emit = self.emit
        enabled = emit.temp(BOOL)
        if power != TRUE:
            emit.value(power)
            emit.store(enabled)
            emit.put("JMPCN", name=skip)
        if checked:
            divisor = emit.simple(args[1])
            zero = Const(default(args[1].type), args[1].type)
            operand = divisor if isinstance(divisor, Const) else Load(divisor)
            emit.value(Apply("NE", (operand, zero), BOOL))
            emit.store(enabled)
            emit.put("JMPCN", name=skip)
            args = (args[0], operand)
        return enabled, args

    def _zeroed(self, block: Block) -> dict[str, Place]:
        """Temporaries of the nets that the function feeds, FALSE (0) when it does not run."""
        emit, temps = self.emit, {}
        wanted = [(p.pin, p.type) for p in block.outputs if isinstance(p.target, int)]
        if block.power_out is not None:
            wanted.append((block.power_out, BOOL))
        for name, type_ in wanted:
            if name != "ENO" and name not in temps:
                temps[name] = emit.temp(type_)
                emit.value(Const(default(type_), type_))
                emit.store(temps[name])
        return temps

    def _call(self, block: Block, outputs: tuple[PinOut, ...], args: tuple[Value, ...]) -> dict[str, Place]:
        """Calls; the result is in the accumulator, further output pins in the places returned."""
        emit, signature = self.emit, block.signature
        names = {p.pin for p in outputs} | {block.power_out}
        taken = {p.name: emit.temp(p.type) for p in signature.outputs if p.name in names and p.name != "ENO"}
        call = Apply(block.callee, args, signature.result, block.span, not signature.standard)
        if not taken:
            emit.value(call)
            return taken
        rest = tuple(emit.simple(a) for a in args[1:])
        for first in args[:1]:
            emit.value(first)
        emit.put("FN", None, call.type, call.op, rest, tuple(taken.items()))
        return taken

    def _take_results(self, index: int, block: Block, outputs: tuple[PinOut, ...], net_temps: dict[str, Place],
                      taken: dict[str, Place]) -> None:
        """Stores the results: first what is in the accumulator, then the other pins."""
        emit = self.emit
        if "OUT" in net_temps:
            emit.store(net_temps["OUT"])
        for pin in sorted(outputs, key=lambda p: p.pin != "OUT"):
            if pin.pin == "ENO" or isinstance(pin.target, int):
                continue
            if pin.pin != "OUT":
                emit.value(Load(taken[pin.pin]))
            elif "OUT" in net_temps:
                emit.value(Load(net_temps["OUT"]))
            self._deliver(index, pin)
        for name, place in taken.items():
            if name in net_temps:
                emit.value(Load(place))
                emit.store(net_temps[name])

    def _after(self, index: int, block: Block, outputs: tuple[PinOut, ...], net_temps: dict[str, Place],
               eno: Value) -> Value:
        """Feeds the nets, stores ENO, gives the power that leaves."""
        for pin in outputs:
            if pin.pin == "ENO":
                self.emit.value(eno)
                self._deliver(index, pin)
            elif isinstance(pin.target, int):
                self._keep(self._net(index, pin), Load(net_temps[pin.pin]))
        if block.power_out in (None, "ENO"):
            return eno
        return Load(net_temps[block.power_out])


def _and(power: Value, item: Value) -> Value:
    if power == TRUE:
        return item
    return power if item == TRUE else Apply("AND", (power, item), BOOL)


def _edge(kind: str, now: Value, memory: Load) -> Value:
    if kind == "rising":
        return Apply("AND", (now, negation(memory)), BOOL)
    return Apply("AND", (memory, negation(now)), BOOL)


def _member(instance: Place, name: str, type_: Type) -> Place:
    return Place(instance.root, type_, (*instance.steps, FieldStep(name)), instance.is_global)


def _eno_drawn(block: Block) -> bool:
    return block.power_out == "ENO" or any(p.pin == "ENO" for p in block.outputs)


def _reads(value: Value, root: str) -> bool:
    """Whether an expression that is still to be computed reads a variable."""
    stack: list[Value] = [value]
    while stack:
        match stack.pop():
            case Load(place):
                if place.root.upper() == root.upper():
                    return True
                stack.extend(i for s in place.steps if hasattr(s, "indexes") for i in s.indexes)
            case Apply(args=args):
                stack.extend(args)
    return False
