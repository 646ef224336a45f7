"""The reference meaning of a rung: DESIGN section 3 on the RungGraph, for any domain of values.

Everything else (the SP tree, the IL, the engines) is compared with this. A domain says what powers
and values are: bit-parallel integers for the proof, Python values for the interpreter in the tests.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol, TypeVar

from ldc.expr import Expr, Place
from ldc.graph.memory import Memories, stale_nets
from ldc.graph.order import Turn
from ldc.graph.rung import RAIL, RungGraph
from ldc.model.elements import Block, Coil, Contact, Jump, Net
from ldc.types import BOOL, Elementary, Type, storage

B = TypeVar("B")
V = TypeVar("V")


class Domain(Protocol[B, V]):
    """Powers ``B`` and values ``V`` (of a BOOL expression or pin: a ``B``), and what acts on them.

    ``contact``: a BOOL expression now; where ``power`` is false it is not evaluated and counts FALSE.
    ``value``: an expression at a pin, evaluated only where ``when``; elsewhere it may be anything.
    ``store``: place := value where ``when``; the value has the type of the place.
    ``call_block``: always runs the instance; ``inputs`` are the pins that are wired or given, in
    declared order, the others keep their values; returns every output (and in_out) pin.
    ``call_function``: runs where ``enable``; ``inputs`` has every pin but EN. Returns ENO, which is
    FALSE where ``enable`` is, or where the function's own division is by zero and ENO is drawn; and
    the output pins (the result is OUT), of which only the part where ENO holds is used.
    ``recall``/``remember``: a hidden memory by name, FALSE at first; for a memory of a net that carries
    a value they get its type as a further argument, and it is 0 at first.
    ``choose``: the first value where ``when``, else the second. ``convert``: a value to another type.
    Both are asked only about values that are not BOOL.
    """

    true: B
    false: B

    def and_(self, a: B, b: B) -> B: ...
    def or_(self, a: B, b: B) -> B: ...
    def not_(self, a: B) -> B: ...
    def contact(self, expr: Expr, power: B) -> B: ...
    def value(self, expr: Expr, when: B) -> B | V: ...
    def zero(self, type_: Type) -> V: ...
    def choose(self, when: B, yes: V, no: V) -> V: ...
    def convert(self, value: V, source: Type, target: Type) -> V: ...
    def store(self, place: Place, value: B | V, when: B) -> None: ...
    def recall(self, name: str, *type_: Type) -> B | V: ...
    def remember(self, name: str, value: B | V, *type_: Type) -> None: ...
    def call_block(self, index: int, block: Block, inputs: Mapping[str, B | V]) -> Mapping[str, B | V]: ...
    def call_function(
        self, index: int, block: Block, enable: B, inputs: Mapping[str, B | V],
    ) -> tuple[B, Mapping[str, B | V]]: ...
    def jump(self, index: int, label: str | None, when: B) -> None: ...


def evaluate(graph: RungGraph, turns: tuple[Turn, ...], domain: Domain, memories: Memories) -> dict[Net, Any]:
    """Executes the rung once; returns the power (or value) of every net.

    Rule 1: a net is the OR of its incoming elements, the rail TRUE. Rule 2: each element once, in the
    order of ``turns``. Rule 5: at a block in a loop what was not evaluated yet counts as it was.
    """
    powers: dict[Net, Any] = {RAIL: domain.true}
    for turn in turns:
        index = turn.element
        stale = {net: stale_power(graph, turn, net, powers.get(net), domain, memories)
                 for net in stale_nets(graph, turn)} if turn.stale else {}

        def net_power(net: Net, stale: Mapping[Net, Any] = stale) -> Any:
            return stale[net] if net in stale else power_of(graph, powers, net, domain)

        given = execute(graph, index, net_power, domain, memories)
        for net, power in given:
            if net != RAIL:
                powers[net] = join(domain, powers.get(net), power)
        if memories.powers:
            remember_powers(graph, index, given, domain, memories)
    for net in range(len(graph.net_names)):
        powers.setdefault(net, no_power(graph, net, domain))
    return powers


def execute(
    graph: RungGraph, index: int, net_power: Callable[[Net], Any], domain: Domain, memories: Memories,
) -> list[tuple[Net, Any]]:
    """Evaluates one element; returns what it gives to which net (a net may occur twice)."""
    element = graph.elements[index]
    if isinstance(element, Block):
        enter = net_power(graph.heads[index]) if element.power_in is not None else domain.true
        pins = widened(graph, element, {p.pin: net_power(p.source) for p in element.inputs
                                        if isinstance(p.source, int)}, domain)
        leave, outputs = run_block(index, element, enter, pins, domain)
        given = [] if element.power_out is None else [(graph.tails[index], leave)]
        return given + outputs
    power = run_plain(index, element, net_power(graph.heads[index]), domain, memories)
    return [(graph.tails[index], power)]


def widened(graph: RungGraph, block: Block, pins: Mapping[str, Any], domain: Domain) -> Mapping[str, Any]:
    """What nets bring to pins, in the types of the pins."""
    found = {p.pin: graph.widening(p) for p in block.inputs if isinstance(p.source, int)}
    if not any(found.values()):
        return pins
    return {pin: value if found[pin] is None else domain.convert(value, *found[pin])
            for pin, value in pins.items()}


def run_plain(
    index: int, element: Contact | Coil | Jump, power: Any, domain: Domain, memories: Memories,
) -> Any:
    """A contact, coil or jump with ``power`` at its head; returns the power at its tail."""
    if isinstance(element, Contact):
        return _contact(index, element, power, domain, memories)
    if isinstance(element, Coil):
        _coil(index, element, power, domain, memories)
    else:
        domain.jump(index, element.label, power)
    return power


def _contact(index: int, contact: Contact, power: Any, domain: Domain, memories: Memories) -> Any:
    """Rules 2 and 3: the operand now; an expression only under power. Rule 4: an edge contact takes
    note of its operand on every execution."""
    kind = contact.kind
    if kind == "expression":
        return domain.and_(power, domain.contact(contact.expr, power))
    now = domain.contact(contact.expr, domain.true)
    if kind in ("rising", "falling"):
        now = _edge(kind, memories.edges[index], now, domain)
    elif kind == "closed":
        now = domain.not_(now)
    return domain.and_(power, now)


def _edge(kind: str, memory: str, now: Any, domain: Domain) -> Any:
    before = domain.recall(memory)
    domain.remember(memory, now)
    if kind == "rising":
        return domain.and_(now, domain.not_(before))
    return domain.and_(domain.not_(now), before)


def _coil(index: int, coil: Coil, power: Any, domain: Domain, memories: Memories) -> None:
    kind = coil.kind
    if kind == "set":
        domain.store(coil.place, domain.true, power)
    elif kind == "reset":
        domain.store(coil.place, domain.false, power)
    elif kind in ("rising", "falling"):
        domain.store(coil.place, _edge(kind, memories.edges[index], power, domain), domain.true)
    else:
        domain.store(coil.place, domain.not_(power) if kind == "negated" else power, domain.true)


def run_block(
    index: int, block: Block, enter: Any, pins: Mapping[str, Any], domain: Domain,
) -> tuple[Any, list[tuple[Net, Any]]]:
    """A block with ``enter`` at its power input and ``pins`` at the pins that nets feed; returns the
    power that leaves it and what its output pins give to nets.

    Rule 3: an FB is called whatever its power, only EN = FALSE suppresses a function. A function
    gives FALSE (0) to nets and leaves its variables alone where ENO is FALSE, but for a variable at
    ENO itself.
    """
    if block.is_function:
        return _function(index, block, enter, pins, domain)
    values = {p.pin: pins[p.pin] if p.pin in pins else domain.value(p.source, domain.true)
              for p in block.inputs}
    if block.power_in is not None:
        values = _declared_order({**values, block.power_in: enter}, block)
    results = domain.call_block(index, block, values)
    given = _deliver(block, results, domain.true, domain)
    return (domain.true if block.power_out is None else results[block.power_out]), given


def _function(
    index: int, block: Block, enter: Any, pins: Mapping[str, Any], domain: Domain,
) -> tuple[Any, list[tuple[Net, Any]]]:
    enable = domain.true
    for pin in block.inputs:
        if pin.pin == "EN":
            enable = pins["EN"] if "EN" in pins else domain.value(pin.source, domain.true)
    if block.power_in == "EN":
        enable = enter
    values = {p.pin: pins[p.pin] if p.pin in pins else domain.value(p.source, enable)
              for p in block.inputs if p.pin != "EN"}
    if block.power_in not in (None, "EN"):
        values = _declared_order({**values, block.power_in: enter}, block)
    eno, results = domain.call_function(index, block, enable, values)
    given = _deliver(block, results, eno, domain)
    if block.power_out in (None, "ENO"):
        return eno, given
    return domain.and_(results[block.power_out], eno), given


def _deliver(block: Block, results: Mapping[str, Any], when: Any, domain: Domain) -> list[tuple[Net, Any]]:
    """Stores or passes on the output pins in declared order."""
    given = []
    for pin in block.outputs:
        is_eno = block.is_function and pin.pin == "ENO"
        value = when if is_eno else results[pin.pin]
        if not isinstance(pin.target, int):
            domain.store(pin.target, _as(value, pin.type, pin.target.type, domain),
                         domain.true if is_eno else when)
        elif block.is_function and not is_eno:
            given.append((pin.target, domain.and_(value, when) if pin.type == BOOL
                          else domain.choose(when, value, domain.zero(pin.type))))
        else:
            given.append((pin.target, value))
    return given


def _as(value: Any, source: Type, target: Type, domain: Domain) -> Any:
    source, target = storage(source), storage(target)
    if source != target and isinstance(source, Elementary) and isinstance(target, Elementary):
        return domain.convert(value, source, target)
    return value


def _declared_order(values: dict[str, Any], block: Block) -> dict[str, Any]:
    order = {p.name: n for n, p in enumerate((*block.signature.inputs, *block.signature.in_outs))}
    return dict(sorted(values.items(), key=lambda item: order.get(item[0], len(order))))


def join(domain: Domain, known: Any, power: Any) -> Any:
    """What a net has when one more element feeds it; a net that carries a value has one source."""
    return power if known is None else domain.or_(known, power)


def no_power(graph: RungGraph, net: Net, domain: Domain) -> Any:
    type_ = graph.net_type(net)
    return domain.false if type_ == BOOL else domain.zero(type_)


def power_of(graph: RungGraph, powers: Mapping[Net, Any], net: Net, domain: Domain) -> Any:
    return powers[net] if net in powers else no_power(graph, net, domain)


def stale_power(
    graph: RungGraph, turn: Turn, net: Net, known: Any, domain: Domain, memories: Memories,
) -> Any:
    """An incomplete net at a block in a loop: what is there, and what the rest gave last time."""
    for feeder in graph.incoming[net]:
        if feeder in turn.stale:
            known = join(domain, known, recall(memories.powers[feeder, net], domain, memories))
    return known


def remember_powers(
    graph: RungGraph, index: int, given: list[tuple[Net, Any]], domain: Domain, memories: Memories,
) -> None:
    for net in dict.fromkeys(graph.targets(index)):
        name = memories.powers.get((index, net))
        if name is None:
            continue
        total = None
        for target, power in given:
            if target == net:
                total = join(domain, total, power)
        remember(name, total, domain, memories)


def recall(name: str, domain: Domain, memories: Memories) -> Any:
    type_ = memories.types.get(name, BOOL)
    return domain.recall(name) if type_ == BOOL else domain.recall(name, type_)


def remember(name: str, value: Any, domain: Domain, memories: Memories) -> None:
    type_ = memories.types.get(name, BOOL)
    if type_ == BOOL:
        domain.remember(name, value)
    else:
        domain.remember(name, value, type_)
