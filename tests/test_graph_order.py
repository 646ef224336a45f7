"""The order in which elements are evaluated: DESIGN section 3, rules 2 and 5."""

from __future__ import annotations

import time

import pytest
from graph_tools import drawn, drawn_unchecked, graph_of, plain_graph, texts
from hypothesis import given, settings

from ldc.graph.memory import memories
from ldc.graph.order import Turn, schedule
from ldc.model.elements import Block


def order(text: str) -> list[int]:
    turns = schedule(graph_of(text))
    assert not any(turn.stale for turn in turns)
    return [turn.element for turn in turns]


def test_text_order_where_power_is_there() -> None:
    assert order("{ [a0] (q0) | [a1] } [a2] (q1); [a3] (q2)") == [0, 1, 2, 3, 4, 5, 6]


def test_first_element_in_drawing_order_whose_nets_are_complete() -> None:
    assert order("@x [a0] (q0); [a1] (q1); [a2] @x; [a3] (q2)") == [2, 3, 4, 0, 1, 5, 6]


def test_bridge() -> None:
    assert order("{ [a0] @x [a1] | [a2] @y [a3] } (q0); @x [a4] @y") == [0, 1, 2, 5, 3, 4]


def test_block_waits_for_its_pins() -> None:
    assert order("[a0] <u0: CTUD(R := @r, PV := 1)> (q0); [a1] (q1) @r") == [0, 3, 4, 1, 2]


def test_pin_networks_come_before_their_block() -> None:
    assert order("[a0] <u0: CTUD(R := { [a1] (q1) }, PV := 1)> (q0)") == [0, 1, 2, 3, 4]


def test_loop_opens_at_its_first_block() -> None:
    turns = schedule(graph_of(
        "[a0] @x <t0: TON(PT := T#1s)> @y [a1] <t1: TON(PT := T#1s)> [a2] @x; @y (q0)"))
    assert turns == (Turn(0), Turn(1, (4,)), Turn(2), Turn(3), Turn(4), Turn(5))


def test_loop_that_waits_for_another_comes_later_though_drawn_first() -> None:
    text = ("@l1 <t0: TON(PT := T#1s)> [a0] @l1; @m [a1] @l1;"
            "[a3] @k <t1: TON(PT := T#1s)> @m; @m [a2] @k")
    graph = graph_of(text)
    turns = schedule(graph)
    blocks = [turn for turn in turns if isinstance(graph.elements[turn.element], Block)]
    assert [(turn.element, turn.stale) for turn in blocks] == [(4, (5,)), (0, (1,))]


def test_two_free_loops_in_drawing_order() -> None:
    turns = schedule(graph_of("[a0] @x <t0: TON(PT := T#1s)> [a1] @x; [a2] @y <t1: TON(PT := T#1s)> [a3] @y; "
                              "@x (q0); @y (q1)"))
    assert [turn.element for turn in turns if turn.stale] == [1, 4]


def test_loops_inside_one_another_open_one_by_one() -> None:
    turns = schedule(graph_of(
        "[a0] @x <t0: TON(PT := T#1s)> @y <t1: TON(PT := T#1s)> @z (q0); @z [a1] @y; @z [a2] @x"))
    assert [(turn.element, turn.stale) for turn in turns if turn.stale] == [(1, (5,)), (2, (4,))]


def test_block_that_feeds_its_own_pin() -> None:
    assert schedule(graph_of("[a0] <u0: CTUD(R := @x, PV := 1, QD => @x)> (q0)"))[1] == Turn(1, (1,))


def test_loop_without_a_block_has_no_order() -> None:
    with pytest.raises(ValueError, match="loop without a block"):
        schedule(drawn_unchecked("[a0] @x [a1] @y (q0); @y [a2] @x"))


def naive(graph) -> list[tuple[int, tuple[int, ...]]]:
    """Rules 2 and 5 word by word, in polynomial time."""
    count = len(graph.elements)
    done: list[int] = []
    result = []
    before = {e: {f for n in graph.sources(e) if n for f in graph.incoming[n]} for e in range(count)}
    while len(done) < count:
        ready = [e for e in range(count) if e not in done and before[e] <= set(done)]
        if ready:
            result.append((ready[0], ()))
            done.append(ready[0])
            continue
        rest = [e for e in range(count) if e not in done]
        behind = {e: _closure(e, before, rest) for e in rest}
        loops = [e for e in rest if e in behind[e] and all(e in behind[f] for f in behind[e])]
        block = next(e for e in loops if isinstance(graph.elements[e], Block))
        result.append((block, tuple(sorted(before[block] - set(done)))))
        done.append(block)
    return result


def _closure(start: int, before: dict[int, set[int]], among: list[int]) -> set[int]:
    """The elements among which ``start`` waits for, directly or not."""
    found: set[int] = set()
    work = [start]
    while work:
        for e in before[work.pop()] & set(among):
            if e not in found:
                found.add(e)
                work.append(e)
    return found


@settings(max_examples=120, deadline=None)
@given(texts(loops=True))
def test_schedule_is_what_the_rules_say(text: str) -> None:
    graph, _ = drawn(text)
    if graph is not None:
        assert [(t.element, t.stale) for t in schedule(graph)] == naive(graph)


def test_many_loops_in_a_row_are_fast() -> None:
    count = 2000
    elements = [(0, 1)]
    for k in range(count):
        net = 2 * k + 1
        elements += [(net, net + 1, "block"), (net + 1, net), (net + 1, net + 2)]
    graph = plain_graph(elements)
    start = time.process_time()
    turns = schedule(graph)
    assert sum(bool(turn.stale) for turn in turns) == count
    assert time.process_time() - start < 5


# -- hidden memories


def test_edge_memories_are_named_by_key_kind_operand_and_ordinal() -> None:
    graph = graph_of("[P a0] [N a0] { [P a0] | [P a1] } (P q0) (N q0)")
    assert list(memories(graph, schedule(graph)).edges.values()) == [
        "_ldc_r_P_a0_1", "_ldc_r_N_a0_1", "_ldc_r_P_a0_2", "_ldc_r_P_a1_1",
        "_ldc_r_PC_q0_1", "_ldc_r_NC_q0_1"]


def test_loop_memories_are_one_for_each_power_that_comes_late() -> None:
    graph = graph_of("[a0] @x <t0: TON(PT := T#1s)> @y (q0); @y [a1] @x; @y [a2] @x")
    found = memories(graph, schedule(graph))
    assert list(found.powers.items()) == [((3, 1), "_ldc_r_L1"), ((4, 1), "_ldc_r_L2")]
    assert [(v.name, v.kind) for v in found.variables()] == [("_ldc_r_L1", "hidden"), ("_ldc_r_L2", "hidden")]


def test_memory_of_a_value_in_a_loop_has_its_type() -> None:
    graph = graph_of("[a0] <MOVE(IN := @w, OUT => @v)> (q0); [a1] <ADD(IN1 := @v, IN2 := i0, OUT => @w)>")
    (variable,) = memories(graph, schedule(graph)).variables()
    assert str(variable.type) == "INT"
