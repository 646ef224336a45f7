"""From the drawn rung to nets and elements: what is joined, what is numbered, what a rung is known by."""

from __future__ import annotations

import networkx as nx
import pytest
from graph_tools import drawn, graph_of

from ldc.diagnostics import Diagnostics
from ldc.graph.dump import graph_dot, graph_text
from ldc.graph.keys import rung_keys
from ldc.model.elements import Block, Contact
from ldc.parser import parse_file
from ldc.source import SourceFile
from ldc.types import BOOL, INT


def ends(text: str) -> list[tuple[int, int]]:
    graph = graph_of(text)
    return list(zip(graph.heads, graph.tails))


def test_series_and_branches() -> None:
    assert ends("{ [a0] | [a1] [a2] } [a3] (q0)") == [(0, 1), (0, 2), (2, 1), (1, 3), (3, 4)]


def test_same_junction_is_one_net_and_two_names_join() -> None:
    graph = graph_of("[a0] @x [a1] (q0); @x @y; [a2] @y")
    assert graph.heads == (0, 1, 2, 0) and graph.tails == (1, 2, 3, 1)
    assert graph.net_names == ("rail", "x", "#2", "#3")


def test_junction_names_are_case_insensitive() -> None:
    assert ends("[a0] @Warm; @wARM (q0)") == [(0, 1), (1, 2)]


def test_junction_in_branch_lies_where_it_is_drawn() -> None:
    assert ends("[a0] { [a1] @m [a2] | [a3] } (q0); @m (q1)") == [
        (0, 1), (1, 2), (2, 3), (1, 3), (3, 4), (2, 5)]


def test_branch_that_begins_with_a_junction_starts_before_the_braces() -> None:
    assert ends("[a0] { @x [a1] | [a2] } (q0); @x (q1)") == [(0, 1), (1, 2), (1, 2), (2, 3), (1, 4)]


def test_pin_network_starts_at_the_rail_and_comes_before_its_block() -> None:
    graph = graph_of("[a0] <u0: CTUD(R := { [a1] | [a2] }, PV := 3)> (q0)")
    assert [type(e) for e in graph.elements[1:4]] == [Contact, Contact, Block]
    block = graph.elements[3]
    (pin,) = (p for p in block.inputs if p.pin == "R")
    assert graph.heads[1:3] == (0, 0) and graph.tails[1:3] == (pin.source, pin.source)
    assert graph.sources(3) == (graph.heads[3], pin.source)


def test_path_of_a_pin_network_may_start_at_a_junction() -> None:
    graph = graph_of("[a0] @x (q0); [a1] <u0: CTUD(R := { @x [a2] | [a3] }, PV := 3)> (q1)")
    assert graph.heads[3:5] == (1, 0)


def test_block_without_power_input_starts_at_the_rail() -> None:
    graph = graph_of("<u0: CTUD(CD := { [a0] }, PV := 3) in=_> (q0)")
    assert graph.heads[1] == 0 and graph.sources(1) == (graph.tails[0],)


def test_value_net_has_the_type_of_its_source() -> None:
    graph = graph_of("[a0] <MOVE(IN := i0, OUT => @v)>; <ADD(IN1 := @v, IN2 := 1, OUT => i1)>")
    (net,) = (n for n in range(len(graph.net_names)) if graph.net_names[n] == "v")
    assert graph.net_type(net) == INT and graph.net_type(1) == BOOL
    assert graph.incoming[net] == (1,) and graph.outgoing[net] == (2,)


def test_elements_without_meaning_abandon_the_rung_but_all_are_reported() -> None:
    text = "PROGRAM main\nVAR q : BOOL; END_VAR\nRUNG [first] [second] (q)\nEND_PROGRAM\n"
    graph, found = None, Diagnostics()
    file = parse_file(SourceFile("x.ld", text), found)
    from ldc.graph.build import build
    from ldc.model import Scope, resolve
    from ldc.parser import ast

    scope = Scope(resolve(ast.Project((file,)), found), "main")
    graph = build(file.pous[0].body.rungs[0], "r", scope, found)
    assert graph is None and len(found) == 2


def test_networkx_view_has_an_edge_for_each_way_through_an_element() -> None:
    graph = graph_of("[a0] @x <u0: CTUD(R := @x, PV := 3, QD => @y)> (q0); @y (q1)")
    view = graph.graph
    assert isinstance(view, nx.MultiDiGraph) and view.number_of_nodes() == len(graph.net_names)
    assert sorted(key for *_, key in view.edges(keys=True) if key[0] == 1) == [
        (1, 0, 0), (1, 0, 1), (1, 1, 0), (1, 1, 1)]


def test_text_and_dot_name_nets_pins_and_order() -> None:
    graph = graph_of("{ [a0] @x [/a1] | [P a2] @y [a3 AND NOT a4 OR i0 + 1 > 2] } (S q0); "
                     "@x <u0: CTUD(R := @y, PV := 3, CV => i0)> [a5] @y")
    assert drawn("[a0] @x")[0] is None
    loop = graph_of("[a0] @x <u0: CTUD(R := { @y [a1] }, PV := 3, CV => i0)> @y; @y (q1)")
    assert graph_text(loop) == """rung r
  nets rail @x @y #3 #4
  0 rail -> @x  [a0]
  1 @y -> #3  [a1]
  2 @x -> @y  <u0: CTUD(R := #3, PV := 3, CV => i0) in=CU out=QU>
  3 @y -> #4  (q1)
  order 0 2(1) 1 3
"""
    text = graph_text(graph)
    assert "[a3 AND NOT a4 OR i0 + 1 > 2]" in text and "(S q0)" in text
    dot = graph_dot(loop)
    assert dot.startswith('digraph "r" {') and 'e2 [shape=box, label="<u0: CTUD(' in dot
    assert 'n3 -> e2 [style=dashed, label="R"];' in dot


# -- keys


def keys(*rungs: str) -> tuple[tuple[str, ...], list[str]]:
    text = "PROGRAM main\nVAR a, b, q : BOOL; END_VAR\n" + "\n".join(rungs) + "\nEND_PROGRAM\n"
    found = Diagnostics()
    file = parse_file(SourceFile("x.ld", text), found)
    return rung_keys(file.pous[0].body.rungs, found), [d.code for d in found]


def test_name_is_the_key() -> None:
    assert keys("RUNG first [a] (q)", "RUNG second [b] (q)") == (("first", "second"), [])


def test_digest_ignores_layout_title_and_comments_but_not_content() -> None:
    (plain, spread, titled, respelled, other), _ = keys(
        "RUNG [a] (q)", "RUNG\n   [ a ]  (* why *)  (q) ;", 'RUNG "title" [a] (q)', "RUNG [A] (Q)", "RUNG [b] (q)")
    stem, _, ordinal = plain.rpartition("_")
    assert ordinal == "1" and len(stem) == 9 and stem[0] == "r"
    assert spread == f"{stem}_2" and titled == f"{stem}_3" and respelled == f"{stem}_4"
    assert not other.startswith(stem) and other.endswith("_1")


def test_keys_of_others_stay_when_a_rung_is_added() -> None:
    (first, second), _ = keys("RUNG [a] (q)", "RUNG [b] (q)")
    (_, *rest), _ = keys("RUNG [a] [b] (q)", "RUNG [a] (q)", "RUNG [b] (q)")
    assert rest == [first, second]


def test_name_that_looks_like_a_digest_is_not_given_twice() -> None:
    (key,), _ = keys("RUNG [a] (q)")
    found, codes = keys("RUNG [a] (q)", f"RUNG {key} [b] (q)")
    assert len(set(found)) == 2 and not codes


@pytest.mark.parametrize("second", ["fill", "FILL"])
def test_two_rungs_of_one_name(second: str) -> None:
    found, codes = keys("RUNG fill [a] (q)", f"RUNG {second} [b] (q)")
    assert codes == ["LD0314"] and len(set(found)) == 2
