"""What the rules say to the user: LD03xx, one function per code (DESIGN section 9)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ldc.diagnostics import Diagnostics, Label
from ldc.graph.rung import RAIL, JunctionUse, RungGraph
from ldc.model.elements import Block, Coil, Contact, Element, Net, PinIn
from ldc.similar import similar
from ldc.source import Span

_MOST = 4


def _kind(element: Element) -> str:
    if isinstance(element, Contact):
        return "contact"
    if isinstance(element, Coil):
        return "coil"
    return "block" if isinstance(element, Block) else "jump"


def _labels(spans: Iterable[Span], text: str) -> tuple[Label, ...]:
    return tuple(Label(span, text) for span in list(spans)[:_MOST])


def _names(graph: RungGraph, net: Net, text: str) -> tuple[Label, ...]:
    """Where the drawing names the net."""
    return _labels([use.span for use in graph.junctions if use.net == net], text)


def _net(graph: RungGraph, net: Net) -> str:
    if net == RAIL:
        return "the left rail"
    name = graph.net_names[net]
    return "this net" if name.startswith("#") else f"`@{name}`"


def short(graph: RungGraph, index: int, diagnostics: Diagnostics) -> None:
    element, net = graph.elements[index], graph.tails[index]
    where = "to the left rail" if net == RAIL else "to one net"
    diagnostics.error(
        "LD0301", f"a wire bridges this {_kind(element)}", element.span, f"both ends are joined {where}",
        secondary=_names(graph, net, "joined here"),
        help="power would always pass beside it: take away the wire, or give its ends different junctions")


def feeds_rail(graph: RungGraph, index: int, span: Span, diagnostics: Diagnostics) -> None:
    diagnostics.error(
        "LD0302", f"this {_kind(graph.elements[index])} feeds the left rail", span,
        "its power would flow back into the left rail",
        secondary=_names(graph, RAIL, "this junction is the left rail"),
        help="the left rail is always TRUE: end the path at another junction (a junction that begins a "
             "branch of the first braces lies at the rail)")


def loop_without_block(graph: RungGraph, loop: Sequence[int], diagnostics: Diagnostics) -> None:
    first, *others = [graph.elements[index].span for index in loop]
    diagnostics.error(
        "LD0303", "power runs in a circle without a block", first,
        "power that has passed here comes back to it", secondary=_labels(others, "on the same loop"),
        help="power flows from left to right only: draw a seal-in as a contact of the coil's variable "
             "in parallel, `{ [start] | [motor] } (motor)`")


def dangling(graph: RungGraph, loose: Sequence[int], diagnostics: Diagnostics) -> None:
    first, *others = [graph.elements[index].span for index in loose]
    diagnostics.error(
        "LD0304", "the power of this contact reaches no coil, block or jump", first, "ends here",
        secondary=_labels(others, "ends at the same place"),
        help="end the path with a coil, a block, a jump or a junction that leads to one")


def never_fed(graph: RungGraph, net: Net, diagnostics: Diagnostics) -> None:
    uses = [use.span for use in graph.junctions if use.net == net]
    users = [graph.elements[user].span for user in graph.outgoing[net]]
    first, *others = uses or users
    fed = {use.name for use in graph.junctions if graph.incoming[use.net]}
    near = similar(graph.net_names[net], sorted(fed), 1)
    help = f"did you mean `@{near[0]}`?" if near else (
        "let a path end at this junction, or begin the path at the left rail")
    diagnostics.error(
        "LD0305", f"no power comes to {_net(graph, net)}", first, "nothing feeds this net",
        secondary=_labels([*others, *(users if uses else ())], "waits for it"),
        help=help)


def single_use(use: JunctionUse, diagnostics: Diagnostics) -> None:
    diagnostics.warning(
        "LD0306", f"junction `@{use.name}` joins nothing", use.span, "the only place with this name",
        help="name it at the other end too, or take it away")


def empty(graph: RungGraph, diagnostics: Diagnostics) -> None:
    diagnostics.error("LD0307", "the rung has no elements", graph.span, "nothing is drawn here",
                      help="draw at least a coil, a block or a jump, or take the rung away")


def after_jump(graph: RungGraph, index: int, diagnostics: Diagnostics) -> None:
    users = [graph.elements[user].span for user in graph.outgoing[graph.tails[index]]]
    diagnostics.error(
        "LD0308", "something is drawn behind a jump", graph.elements[index].span,
        "the power ends in this jump", secondary=_labels(users, "drawn behind it"),
        help="end the path with the jump and draw the rest as a branch or a path of its own")


def no_power_out(graph: RungGraph, index: int, diagnostics: Diagnostics) -> None:
    users = [graph.elements[user].span for user in graph.outgoing[graph.tails[index]]]
    diagnostics.error(
        "LD0309", "no power leaves this block", graph.elements[index].span, "has no power output",
        secondary=_labels(users, "waits for its power"),
        help="choose a BOOL output with `out=PIN`, or draw the rest as a path of its own")


def value_as_power(graph: RungGraph, net: Net, users: Sequence[int], diagnostics: Diagnostics) -> None:
    first, *others = [graph.elements[user].span for user in users]
    type_ = graph.net_type(net)
    diagnostics.error(
        "LD0311", f"{_net(graph, net)} carries {type_}, not power", first, f"would get {type_} as its power",
        secondary=(*_labels(others, "and this"), *_names(graph, net, f"carries {type_}")),
        help="a value can only go to pins: store it in a variable and compare it, `[variable > 0]`")


def two_sources(graph: RungGraph, net: Net, spans: Sequence[Span], diagnostics: Diagnostics) -> None:
    first, *others = spans
    diagnostics.error(
        "LD0312", f"{_net(graph, net)} carries {graph.net_type(net)} and has several sources", first,
        "feeds it", secondary=_labels(others, "feeds it too"),
        help="a net that is not BOOL has one source: use a second junction, and choose with `SEL` or `MUX`")


def net_mismatch(graph: RungGraph, pin: PinIn, conversion: str | None, diagnostics: Diagnostics) -> None:
    given = graph.net_type(pin.source)
    help = f"give the pin {pin.type}"
    if conversion is not None:
        help = f"convert it between: `<{conversion}(IN := @a, OUT => @b)>`"
    diagnostics.error(
        "LD0313", f"pin {pin.pin} takes {pin.type}, the net carries {given}", pin.span, f"{given} comes here",
        secondary=_names(graph, pin.source, f"carries {given}"), help=help)


def bridge(graph: RungGraph, kept: Sequence[Net], diagnostics: Diagnostics) -> None:
    count = f"{len(kept)} temporar{'y' if len(kept) == 1 else 'ies'}"
    named = [use.span for use in graph.junctions if use.net in set(kept)]
    diagnostics.note(
        "LD0315", f"the rung is not series-parallel in its drawing order: compiled through {count}",
        graph.span, "",
        secondary=_labels(named, "kept in a temporary"),
        help="nothing needs to be done; a rung drawn with branches only needs no temporary")


def loop_through_block(graph: RungGraph, loop: Sequence[int], diagnostics: Diagnostics) -> None:
    block = next(index for index in loop if isinstance(graph.elements[index], Block))
    others = [graph.elements[index].span for index in loop if index != block]
    diagnostics.note(
        "LD0316", "a loop through a block uses power of the previous execution", graph.elements[block].span,
        "evaluated first: what comes back to it counts as it was in the previous execution",
        secondary=_labels(others, "on the same loop"),
        help="nothing needs to be done; to make the memory visible, use a variable instead of the wire")


def no_path(graph: RungGraph, lost: Sequence[int], diagnostics: Diagnostics) -> None:
    first, *others = [graph.elements[index].span for index in lost]
    diagnostics.error(
        "LD0317", "no path leads here from the left rail", first, "never gets power",
        secondary=_labels(others, "nor does this"),
        help="the loop feeds only itself: let a path from the left rail end at one of its junctions")
