"""Blocks to IL: calls of function blocks, functions with EN and ENO (DESIGN sections 2 and 3)."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ldc.expr import TRUE, Apply, Const, FieldStep, IndexStep, Load, Place, nodes
from ldc.il.emit import Emitter
from ldc.il.values import Held, Value
from ldc.library import functions
from ldc.model.elements import Block, PinOut
from ldc.records import replace
from ldc.types import BOOL, Elementary, Type, default, storage

DIVISIONS = frozenset(("DIV", "MOD", "DIVTIME"))
# Name, type and value of each input pin that is given.
Sources = list[tuple[str, Type, Value]]


class BlockLowering:
    """``keep(net, value)`` feeds a net; ``outputs``: nets of output pins that differ from the drawn ones."""

    def __init__(self, emit: Emitter, keep: Callable[[int, Value], None],
                 outputs: Mapping[tuple[int, str], int]) -> None:
        self.emit = emit
        self.keep = keep
        self.outputs = outputs

    def lower(self, index: int, block: Block, pins: Mapping[str, Value], power: Value, needed: bool) -> Value:
        """Emits block ``index`` with ``power`` at its power pin and ``pins`` at those that nets feed; gives
        the power that leaves it."""
        sources = [(p.pin, p.type, pins[p.pin] if isinstance(p.source, int) else p.source)
                   for p in block.inputs]
        if block.is_function:
            return self.function(index, block, sources, power)
        return self.instance(index, block, sources, power, needed)

    def instance(self, index: int, block: Block, sources: Sources, power: Value, needed: bool) -> Value:
        emit = self.emit
        instance = self._steady(block)
        if block.power_in is not None:
            sources = [(block.power_in, BOOL, power), *sources]
        if any(_reads(value, instance.root) for _, _, value in sources[1:]):
            sources = [(name, type_, self._spilled(value)) for name, type_, value in sources]
        for name, type_, value in sources:
            emit.value(value)
            emit.store(_member(instance, name, type_))
        emit.put("CAL", instance, instance.type)
        for output in block.outputs:
            pin = self._indexed(output)
            emit.value(Load(_member(instance, pin.pin, pin.type)))
            self._deliver(index, pin)
        if block.power_out is None or not needed:
            return TRUE
        emit.value(Load(_member(instance, block.power_out, BOOL)))
        return emit.hold()

    def _steady(self, block: Block) -> Place:
        """The instance, its indexes computed once: the call and its outputs may change their variables. A
        block of the project may reach each that is global or lies in the process image."""
        instance = self.emit.place(block.instance)
        standard = block.signature.standard
        changed = {p.target.root.upper() for p in block.outputs if isinstance(p.target, Place)}
        changed.add(instance.root.upper())

        def steady(index: Const | Load) -> Const | Load:
            if isinstance(index, Const) or index.place.root in self.emit.temps or (
                    standard and index.place.root.upper() not in changed):
                return index
            self.emit.value(index)
            spill = self.emit.temp(index.type)
            self.emit.store(spill)
            return Load(spill)

        steps = tuple(replace(s, indexes=tuple(map(steady, s.indexes))) if isinstance(s, IndexStep) else s
                      for s in instance.steps)
        return instance if steps == instance.steps else replace(instance, steps=steps)

    def _spilled(self, value: Value) -> Held:
        held = self.emit.held(value)
        self.emit.held_place(held)
        return held

    def _deliver(self, index: int, pin: PinOut) -> None:
        """Stores the accumulator, of the pin's type, to the pin's target."""
        if isinstance(pin.target, int):
            self.keep(self._net(index, pin), self.emit.hold(pin.type))
            return
        source, target = storage(pin.type), storage(pin.target.type)
        if source != target and isinstance(source, Elementary) and isinstance(target, Elementary):
            self.emit.put("FN", None, target, functions.conversion(source, target))
        self.emit.store(pin.target)

    def _net(self, index: int, pin: PinOut) -> int:
        return self.outputs.get((index, pin.pin), pin.target)

    def function(self, index: int, block: Block, sources: Sources, power: Value) -> Value:
        """``LD en / ST t / JMPCN skip / … / skip:``; what EN = FALSE leaves alone is not touched."""
        emit = self.emit
        enable = power if block.power_in == "EN" else TRUE
        for name, _, value in sources:
            if name == "EN":
                enable = value
        sources = [source for source in sources if source[0] != "EN"]
        if block.power_in not in (None, "EN"):
            order = {p.name: n for n, p in enumerate((*block.signature.inputs, *block.signature.in_outs))}
            sources.append((block.power_in, BOOL, power))
            sources.sort(key=lambda source: order[source[0]])
        args = tuple(value for _, _, value in sources)
        block_outputs = tuple(self._indexed(p) for p in block.outputs)
        net_temps = self._zeroed(block)
        checked = block.callee in DIVISIONS and eno_drawn(block) and not (
            isinstance(args[1], Const) and args[1].value != 0)
        guard: Place | None = None
        skip = emit.label() if checked or enable != TRUE else ""
        if skip:
            guard, args = self._guard(enable, args, skip, checked)
        taken = self._perform(block) if block.is_action else self._call(block, block_outputs, args)
        self._take_results(index, block, block_outputs, net_temps, taken)
        if skip:
            emit.put("LABEL", name=skip)
        eno: Value = TRUE if guard is None else Load(guard)
        return self._after(index, block, block_outputs, net_temps, eno)

    def _indexed(self, pin: PinOut) -> PinOut:
        """The pin with the index of its target computed: before anything is skipped, and before its value is
        in the accumulator."""
        return pin if isinstance(pin.target, int) else replace(pin, target=self.emit.place(pin.target))

    def _guard(self, power: Value, args: tuple[Value, ...], skip: str, checked: bool
               ) -> tuple[Place, tuple[Value, ...]]:
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

    def _perform(self, block: Block) -> dict[str, Place]:
        """An action of the POU itself, or of an instance, which is told by a pin; it has no outputs."""
        emit = self.emit
        if block.instance is None:
            emit.put("ACT", name=block.callee)
            return {}
        chosen = next(pin for pin in block.inputs if pin.pin != "EN")
        instance = self._steady(block)
        pin = _member(instance, chosen.pin, chosen.type)
        emit.value(chosen.source)
        emit.store(pin)
        emit.put("CAL", instance, instance.type)
        emit.value(Const(0, chosen.type))
        emit.store(pin)
        return {}

    def _call(self, block: Block, outputs: tuple[PinOut, ...], args: tuple[Value, ...]) -> dict[str, Place]:
        """Calls; the result is in the accumulator, further output pins in the places returned."""
        emit, signature = self.emit, block.signature
        names = {p.pin for p in outputs} | {block.power_out}
        taken = {p.name: emit.temp(p.type) for p in signature.outputs if p.name in names and p.name != "ENO"}
        copies = {p.name: emit.temp(p.type) for p in signature.in_outs}
        first = len(args) - len(copies)
        for arg, copy in zip(args[first:], copies.values(), strict=True):
            emit.value(arg)
            emit.store(copy)
        args = (*args[:first], *map(Load, copies.values()))
        taken |= copies
        call = Apply(block.callee, args, signature.result, block.span, not signature.standard)
        if not taken:
            emit.value(call)
            return taken
        rest = tuple(emit.simple(a) for a in args[1:])
        for first in args[:1]:
            emit.value(first)
        emit.put("FN", None, call.type, call.op, rest, tuple(taken.items()))
        return taken

    def _take_results(self, index: int, block: Block, outputs: tuple[PinOut, ...],
                      net_temps: dict[str, Place],
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
                self.keep(self._net(index, pin), Load(net_temps[pin.pin]))
        if block.power_out in (None, "ENO"):
            return eno
        return Load(net_temps[block.power_out])


def _member(instance: Place, name: str, type_: Type) -> Place:
    return Place(instance.root, type_, (*instance.steps, FieldStep(name)), instance.is_global)


def eno_drawn(block: Block) -> bool:
    """Whether something is wired to ENO, which then tells of a division by zero."""
    return block.power_out == "ENO" or any(p.pin == "ENO" for p in block.outputs)


def _reads(value: Value, root: str) -> bool:
    """Whether an expression that is still to be computed reads a variable."""
    return any(type(node) is Load and node.place.root.upper() == root.upper() for node in nodes(value))
