"""From the graph to series/parallel trees (SPEC section 9 step 2, DESIGN section 3 rules 6 and 7).

Two-terminal reduction by a worklist; where it is stuck, the blocking junction nearest the rail is kept
in a temporary. The order in which the trees execute the elements is then compared with the schedule;
if it is not equivalent, the reduction is repeated with the misplaced elements cut off. Every attempt is
linear, and there are few.
"""

from __future__ import annotations

from collections.abc import Sequence
from heapq import heapify, heappop, heappush

from ldc.graph.network import PARALLEL, SINK
from ldc.graph.order import Turn
from ldc.graph.plan import Choice, Plan
from ldc.graph.rung import RAIL, RungGraph
from ldc.graph.ropes import grow, strands
from ldc.graph.sequence import executed, misplaced
from ldc.graph.tree import SPTree, Step, Tap
from ldc.graph.walk import LEAF, TAP, operations
from ldc.model.elements import Block, Net

_ATTEMPTS = 8


def reduce(graph: RungGraph, turns: tuple[Turn, ...]) -> SPTree:
    """The trees of a rung that ``rules.check`` accepted. Every element is the leaf of exactly one tree;
    taps are at most as many as elements and pins (times a small constant)."""
    choice = Choice()
    for _ in range(_ATTEMPTS):
        tree, wrong = _attempt(graph, turns, choice)
        if not wrong:
            return tree
        choice = _stricter(graph, turns, choice, wrong)
    tree, wrong = _attempt(graph, turns, _everything(graph))
    assert not wrong, "one step per element, in the order of the schedule"
    return tree


def _attempt(graph: RungGraph, turns: tuple[Turn, ...], choice: Choice) -> tuple[SPTree, Sequence[int]]:
    """The trees under a choice, and the elements that are out of order in them (then not a result)."""
    position = [0] * len(graph.elements)
    for at, turn in enumerate(turns):
        position[turn.element] = at
    plan = Plan(graph, turns, choice)
    network = plan.network
    kept = network.reduce(_by_completion(graph, position))
    ends = network.after[RAIL]

    def pins_of(index: int):
        pins = plan.pins.get(index)
        return pins and [(name, ends[rope] if isinstance(rope, int) else rope) for name, rope in pins]

    ropes = [*plan.steps, *kept]
    ropes += [(net, rope) for net, rope in ends.items() if net != SINK and net not in plan.pin_nets]
    if SINK in ends:
        ropes += [(None, rope) for rope in strands(PARALLEL, ends[SINK])]
    grown = []
    for net, rope in ropes:
        tree, first = grow(rope, pins_of, position)
        grown.append((first, Step(net, tree)))
    steps, stuck = _arrange(graph, grown, plan)
    if stuck:
        return SPTree(()), stuck
    order, early = executed(graph, plan, steps)
    wrong = early or misplaced(graph, turns, order)
    stale = {feeder for turn in turns for feeder in turn.stale}
    return SPTree(tuple(steps), tuple(sorted(stale)), tuple(plan.outputs)), wrong


def _by_completion(graph: RungGraph, position: Sequence[int]) -> Sequence[Net]:
    """The nets in a topological order: that in which the schedule completes them."""
    if graph.in_order:
        last = [feeders[-1] if feeders else -1 for feeders in graph.incoming]
    else:
        last = [max((position[f] for f in feeders), default=-1) for feeders in graph.incoming]
    return sorted(range(1, len(last)), key=last.__getitem__)


def _arrange(graph: RungGraph, grown: list[tuple[int, Step]], plan: Plan) -> tuple[list[Step], list[int]]:
    """The steps in order of their first element as far as what they need is kept by then; and, when
    some need each other, the blocks in these."""
    if len(grown) == 1:
        return [grown[0][1]], []
    writers: dict[Net, list[int]] = {}
    readers: list[tuple[int, Tap]] = []
    blocks: list[list[int]] = [[] for _ in grown]
    outputs = {(index, pin): net for index, pin, net in plan.outputs}
    for n, (_, step) in enumerate(grown):
        if step.net is not None:
            writers.setdefault(step.net, []).append(n)
        for op, what in operations(step.tree):
            if op == TAP:
                readers.append((n, what))
            elif op == LEAF and type(graph.elements[what.index]) is Block:
                blocks[n].append(what.index)
                for pin in graph.elements[what.index].outputs:
                    if isinstance(pin.target, int):
                        net = outputs.get((what.index, pin.pin), pin.target)
                        writers.setdefault(net, []).append(n)
    after: list[list[int]] = [[] for _ in grown]
    waits = [0] * len(grown)
    for reader, tap in readers:
        for writer in writers.get(tap.net, ()):
            first, second = (reader, writer) if tap.previous else (writer, reader)
            if first != second:
                after[first].append(second)
                waits[second] += 1
    # A step of taps alone has no first element: it comes as soon as it can.
    rank = [first if first < len(graph.elements) else -1 for first, _ in grown]
    ready = [(rank[n], n) for n in range(len(grown)) if not waits[n]]
    heapify(ready)
    steps = []
    while ready:
        _, n = heappop(ready)
        steps.append(grown[n][1])
        for later in after[n]:
            waits[later] -= 1
            if not waits[later]:
                heappush(ready, (rank[later], later))
    return steps, [index for n, found in enumerate(blocks) if waits[n] for index in found]


def _stricter(graph: RungGraph, turns: Sequence[Turn], choice: Choice, wrong: Sequence[int]) -> Choice:
    """Cuts off the elements in ``wrong``; if they are already, those that come next in the schedule,
    since the tree around them has to be divided there."""
    stricter = _cut_off(graph, choice, wrong)
    if stricter == choice:
        moved = set(wrong)
        after = [b.element for a, b in zip(turns, turns[1:]) if a.element in moved and b.element not in moved]
        stricter = _cut_off(graph, choice, after)
    return _everything(graph) if stricter == choice else stricter


def _cut_off(graph: RungGraph, choice: Choice, wrong: Sequence[int]) -> Choice:
    """Keeps the net before each element in ``wrong`` that does not just follow another one there; one
    whose net is kept already gets a step of its own."""
    cuts, alone, moved = set(choice.cuts), set(choice.alone), set(wrong)
    for index in wrong:
        element = graph.elements[index]
        head = RAIL if isinstance(element, Block) and element.power_in is None else graph.heads[index]
        if head != RAIL and moved.issuperset(graph.incoming[head]):
            continue
        if head == RAIL or head in choice.cuts:
            alone.add(index)
            cuts.add(graph.tails[index])
        cuts.add(head)
    return Choice(frozenset(cuts), frozenset(alone))


def _everything(graph: RungGraph) -> Choice:
    return Choice(frozenset(range(1, len(graph.net_names))), frozenset(range(len(graph.elements))))
