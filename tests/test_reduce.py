"""Series/parallel trees: equal to the drawing in effect and order, small, and fast."""

from __future__ import annotations

import time
from random import Random

import pytest
from graph_tools import Recorder, drawn, graph_of, plain_graph, texts, variables
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import junction_rungs, sp_rungs

from ldc.graph.dump import net_name, tree_text
from ldc.graph.evaluate import evaluate
from ldc.graph.memory import memories
from ldc.graph.order import schedule
from ldc.graph.reduce import reduce
from ldc.graph.rung import RungGraph
from ldc.graph.tree import Leaf, Parallel, Series, SPTree, Step, Tap
from ldc.graph.tree_eval import evaluate_tree
from ldc.graph.walk import LEAF, TAP, operations
from ldc.parser.unparse import rung_text


def reduced(text: str) -> SPTree:
    graph = graph_of(text)
    return reduce(graph, schedule(graph))


def steps(text: str) -> list[str]:
    """The steps on one line each: ``x := [a]``, ``run {[a] | [b]} (q)``."""
    graph = graph_of(text)
    tree = reduce(graph, schedule(graph))

    def net(number: int) -> str:
        return net_name(graph, number).lstrip("@")

    def show(node) -> str:
        match node:
            case Leaf(index, pins):
                text = graph.elements[index].span.text
                shown = "".join(f" {name} := {show(pin)}" for name, pin in pins)
                return f"{text.split('(')[0]}{shown}>" if pins else text
            case Tap(number, previous):
                return ("previous " if previous else "") + net(number)
            case Series(children):
                return " ".join(map(show, children))
            case Parallel(children):
                return "{" + " | ".join(map(show, children)) + "}"

    return [("run " if s.net is None else f"{net(s.net)} := ") + show(s.tree) for s in tree.steps]


def test_series_parallel_rung_is_one_step() -> None:
    assert steps("{ [a0] | [a1] [a2] } [/a3] (q0)") == ["run {[a0] | [a1] [a2]} [/a3] (q0)"]


def test_chains_are_flat() -> None:
    tree = reduced("[a0] { [a1] { [a2] | [a3] } | { { [a4] | [a5] } | [a1] } } (q0)")
    assert isinstance(tree.steps[0].tree, Series) and len(tree.steps[0].tree.children) == 3
    assert [type(c) for c in tree.steps[0].tree.children[1].children] == [Series, Leaf, Leaf, Leaf]


def test_bridge_needs_one_temporary() -> None:
    assert steps("{ [a0] @x [a1] | [a2] @y [a3] } (q0); @x [a4] @y") == [
        "x := [a0]", "run {x [a1] | {[a2] | x [a4]} [a3]} (q0)"]


def test_paths_without_a_common_net_are_steps_of_their_own() -> None:
    assert steps("[a0] (q0); [a1] (q1)") == ["run [a0] (q0)", "run [a1] (q1)"]


def test_junctions_that_are_series_parallel_need_no_temporary() -> None:
    assert steps("[a0] @x; [a1] @x; @x { (q0) | [a2] (q1) }") == ["run {[a0] | [a1]} {(q0) | [a2] (q1)}"]


def test_pin_that_alone_uses_a_net_gets_its_tree() -> None:
    assert steps("[a0] <u0: CTUD(R := { [a1] | [a2] }, PV := 1)> (q0)") == [
        "run [a0] <u0: CTUD R := {[a1] | [a2]}> (q0)"]
    assert steps("[a1] @r; [a2] @r; [a0] <u0: CTUD(R := @r, PV := 1)> (q0)") == [
        "run [a0] <u0: CTUD R := {[a1] | [a2]}> (q0)"]


def test_net_of_a_pin_and_of_others_is_kept() -> None:
    assert steps("[a0] @r <u0: CTUD(R := @r, PV := 1)> (q0)") == [
        "r := [a0]", "run r <u0: CTUD R := r> (q0)"]


def test_output_pin_is_tapped() -> None:
    assert steps("[a0] <u0: CTUD(PV := 1, QD => @d)> (q0); @d [a1] (q1)") == [
        "run [a0] <u0: CTUD(PV := 1, QD => @d)> (q0)", "run d [a1] (q1)"]


def test_contact_does_not_move_past_a_coil() -> None:
    assert steps("[a0] @n (q0); [q0] (q1); @n [q1] (q2)") == [
        "n := [a0]", "run n (q0)", "run [q0] (q1)", "run n [q1] (q2)"]


def test_pin_network_drawn_before_a_coil_is_evaluated_before_it() -> None:
    assert steps("[a0] @r; [a1] (a0); [a2] <u0: CTUD(R := @r, PV := 1)> (q0)") == [
        "r := [a0]", "run [a1] (a0)", "run [a2] <u0: CTUD R := r> (q0)"]


def test_loop_reads_what_was_before() -> None:
    assert steps("[a0] @x <t0: TON(PT := T#1s)> @y (q0); @y [a1] @x") == [
        "%2 := [a0]", "y := {%2 | previous %1} <t0: TON(PT := T#1s)>", "run y (q0)", "%1 := y [a1]"]


def test_loop_with_one_feeder_keeps_its_net() -> None:
    text = "<u0: CTUD(CD := a0, R := @x, PV := 1) in=_> [a1] @x"
    assert reduced(text).previous == (1,)
    assert steps(text) == ["x := <u0: CTUD R := previous x> [a1]"]


def test_text_of_a_tree() -> None:
    graph = graph_of("{ [a0] @x [a1] | [a2] @y [a3] } <u0: CTUD(R := { [a5] }, PV := 2)> (q0); @x [a4] @y")
    assert tree_text(graph, reduce(graph, schedule(graph))) == """rung r
  keep @x
    [a0]
  run
    series
      parallel
        series
          @x
          [a1]
        series
          parallel
            [a2]
            series
              @x
              [a4]
          [a3]
      <u0: CTUD(R := #4, PV := 2) in=CU out=QU>
        R := [a5]
      (q0)
"""


# -- equal to the drawing


def agree(graph: RungGraph, seed: int, executions: int = 5) -> SPTree:
    """Runs drawing and tree side by side from random variables; stores, calls, jumps, their order, the
    hidden memories and the powers that are kept must be the same."""
    turns = schedule(graph)
    hidden, tree = memories(graph, turns), reduce(graph, turns)
    leaves = [what.index for step in tree.steps for op, what in operations(step.tree) if op == LEAF]
    assert sorted(leaves) == list(range(len(graph.elements)))
    one, other, random = Recorder({}), Recorder({}), Random(seed)
    for _ in range(executions):
        values = variables(random)
        one.values.update(values)
        other.values.update(values)
        powers = evaluate(graph, turns, one, hidden)
        kept = evaluate_tree(graph, tree, turns, other, hidden)
        assert one.events == other.events and one.values == other.values and one.hidden == other.hidden
        assert all(kept[net] == powers[net] for net in kept if net in powers and graph.outgoing[net])
    return tree


def taps(tree: SPTree) -> int:
    return sum(op == TAP for step in tree.steps for op, _ in operations(step.tree))


@settings(max_examples=300, deadline=None)
@given(texts(loops=True), st.integers())
def test_tree_is_the_drawing(text: str, seed: int) -> None:
    graph, _ = drawn(text)
    if graph is not None:
        agree(graph, seed)


@settings(max_examples=150, deadline=None)
@given(texts(loops=True), st.integers())
def test_tree_is_small(text: str, seed: int) -> None:
    graph, _ = drawn(text)
    if graph is not None:
        tree = agree(graph, seed, 2)
        uses = sum(len(graph.sources(index)) for index in range(len(graph.elements)))
        assert taps(tree) + len(tree.steps) <= 2 * (len(graph.elements) + uses)


@settings(max_examples=100, deadline=None)
@given(sp_rungs() | junction_rungs(), st.integers())
def test_tree_is_the_drawing_for_networks_of_contacts_and_coils(rung, seed: int) -> None:
    graph, _ = drawn(rung_text(rung).split(maxsplit=1)[1])
    if graph is not None:
        agree(graph, seed)


@settings(max_examples=60, deadline=None)
@given(sp_rungs(contact_kinds=("", "/"), coil_kinds=("",), inner_coils=False))
def test_branches_alone_need_no_temporary(rung) -> None:
    graph, _ = drawn(rung_text(rung).split(maxsplit=1)[1])
    if graph is not None:
        tree = reduce(graph, schedule(graph))
        assert not taps(tree) and all(step.net is None for step in tree.steps)


# -- large rungs


def bridges(count: int) -> list[tuple]:
    elements, rail = [], 0
    for k in range(count):
        x, y, end = 3 * k + 1, 3 * k + 2, 3 * k + 3
        elements += [(rail, x), (x, end), (rail, y), (y, end), (x, y)]
        rail = end
    return elements


def nested(depth: int) -> list[tuple]:
    """A seal-in within a seal-in, and so on: n(k+1) = n(k) [a] OR [b]."""
    return [(0, 1), *(pair for k in range(1, depth) for pair in ((k, k + 1), (0, k + 1)))]


LARGE = {
    "bridges": (bridges(3000), 6000),
    "parallel": ([(0, 1)] * 10_000, 0),
    "series": ([(k, k + 1) for k in range(10_000)], 0),
    "nested": (nested(2000), 0),
    "deep": (nested(10_000), 0),
}


@pytest.mark.parametrize("name", LARGE)
def test_large_rungs_take_linear_time_and_size(name: str) -> None:
    elements, temporaries = LARGE[name]
    graph = plain_graph(elements)
    turns = schedule(graph)
    start = time.process_time()
    tree = reduce(graph, turns)
    assert time.process_time() - start < 4
    assert len([s for s in tree.steps if s.net is not None]) <= temporaries
    assert taps(tree) <= 2 * temporaries


def test_many_loops_through_one_net_take_linear_size() -> None:
    count = 300
    graph = plain_graph([(0, 1), *(arc for k in range(count) for arc in ((1, k + 2, "block"), (k + 2, 1)))])
    tree = agree(graph, 1, 2)
    assert taps(tree) + len(tree.steps) <= 10 * count


def test_many_coils_out_of_order_take_linear_size() -> None:
    count = 300
    paths = [f"[a0] @n{k} (q0)" for k in range(count)] + [f"@n{k} [a1] (q1)" for k in range(count)]
    text = ";\n".join(paths)
    graph = graph_of(text)
    tree = agree(graph, 1, 1)
    assert taps(tree) == 2 * count and len(tree.steps) == 3 * count


def test_steps_are_what_the_contract_says() -> None:
    tree = reduced("[a0] (q0)")
    assert tree == SPTree((Step(None, Series((Leaf(0), Leaf(1)))),))
