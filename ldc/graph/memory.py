"""Names of the hidden memories of a rung: edges and loops (DESIGN section 3, rules 4 and 5).

An edge memory is ``_ldc_<key>_<kind>_<operand>_<ordinal>``: kind P or N for contacts, PC or NC for
coils; of the operand's text only letters and digits are kept, so that a name is read from the right
without doubt and no two rungs of a POU share one. A loop memory is ``_ldc_<key>_L<ordinal>``.
"""

from __future__ import annotations

from ldc.expr import Load
from ldc.graph.order import Turn
from ldc.graph.rung import RungGraph
from ldc.model.elements import Block, Coil, Contact, Net
from ldc.records import field, record
from ldc.symbols import Variable
from ldc.types import BOOL, Type

_CONTACT = {"rising": "P", "falling": "N"}
_COIL = {"rising": "PC", "falling": "NC"}


@record
class Memories:
    """``edges``: element index to the name of the memory of its previous operand (contact) or power
    (coil). ``powers``: (element, net) to the memory of what the element gave the net. ``nets``: the
    same memories by the net that the SP tree keeps them under (``Tap``, ``Step``, outputs).
    ``types``: the type of each loop memory, BOOL but for a net that carries a value."""

    edges: dict[int, str] = field(default_factory=dict)
    powers: dict[tuple[int, Net], str] = field(default_factory=dict)
    nets: dict[Net, str] = field(default_factory=dict)
    types: dict[str, Type] = field(default_factory=dict)

    def variables(self) -> tuple[Variable, ...]:
        """The declarations: hidden members of the POU's instance, initially FALSE (0)."""
        names = (*self.edges.values(), *self.powers.values())
        return tuple(Variable(name, self.types.get(name, BOOL), "hidden") for name in names)


def memories(graph: RungGraph, turns: tuple[Turn, ...]) -> Memories:
    """The hidden memories that the rung needs, in drawing order."""
    edges: dict[int, str] = {}
    counts: dict[tuple[str, str], int] = {}
    for index, element in enumerate(graph.elements):
        if isinstance(element, Contact):
            kind = _CONTACT.get(element.kind)
            operand = element.expr.place if isinstance(element.expr, Load) else "constant"
        elif isinstance(element, Coil):
            kind, operand = _COIL.get(element.kind), element.place
        else:
            continue
        if kind is None:
            continue
        plain = "".join(filter(str.isalnum, str(operand)))
        ordinal = counts[kind, plain.upper()] = counts.get((kind, plain.upper()), 0) + 1
        edges[index] = f"_ldc_{graph.key}_{kind}_{plain}_{ordinal}"
    powers, nets, types = {}, {}, {}
    for ordinal, (source, kept) in enumerate(loop_nets(graph, turns).items(), 1):
        powers[source] = nets[kept] = name = f"_ldc_{graph.key}_L{ordinal}"
        types[name] = graph.net_type(source[1])
    return Memories(edges, powers, nets, types)


def loop_nets(graph: RungGraph, turns: tuple[Turn, ...]) -> dict[tuple[int, Net], Net]:
    """For each (stale element, net) the net number that the SP tree keeps its power under: the net
    itself when nothing else feeds it, else a number of its own from ``len(graph.net_names)`` on."""
    pairs = sorted({(net, feeder) for turn in turns if turn.stale for net in graph.sources(turn.element)
                    for feeder in turn.stale if net and feeder in graph.incoming[net]})
    kept: dict[tuple[int, Net], Net] = {}
    fresh = len(graph.net_names)
    for net, feeder in pairs:
        if graph.incoming[net] == (feeder,):
            kept[feeder, net] = net
        else:
            kept[feeder, net] = fresh
            fresh += 1
    return kept


def stale_nets(graph: RungGraph, turn: Turn) -> set[Net]:
    """The nets of a turn that are not complete when it comes."""
    if not turn.stale or not isinstance(graph.elements[turn.element], Block):
        return set()
    stale = set(turn.stale)
    return {net for net in graph.sources(turn.element) if net and not stale.isdisjoint(graph.incoming[net])}
