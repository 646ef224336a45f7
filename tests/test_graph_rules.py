"""What may be wired: every rule with a drawing that breaks it, and ones near it that do not."""

from __future__ import annotations

import pytest
from graph_tools import codes, drawn, texts
from hypothesis import given, settings

WRONG = {
    "bridged contact": ("[a0] { [a1] | @x } (q0); @x (q1)", ["LD0301"]),
    "contact between two places of one junction": ("[a0] @x [a1] @x (q0)", ["LD0301"]),
    "contact joined to the rail at both ends": ("{ [a0] | @x } (q0); @x (q1)", ["LD0301"]),
    "block joined to itself": ("[a0] @x <t0: TON(PT := T#1s)> @x (q0)", ["LD0301"]),
    "path that ends at the rail": ("{ [a0] | @x [a1] } (q0); [a2] [a3] @x", ["LD0302"]),
    "output pin at the rail": ("{ [a0] | @x [a1] } <u0: CTUD(PV := 1, QD => @x)> (q0)", ["LD0302"]),
    "circle of contacts": ("[a0] @x [a1] @y (q0); @y [a2] @x", ["LD0303"]),
    "circle with a coil": ("[a0] @x (q0) @y; @y [a2] @x", ["LD0303"]),
    "circle of contacts beside a loop through a block": (
        "[a0] @x [a1] @y <t0: TON(PT := T#1s)> @z (q0); @z [a3] @x; @y [a2] @x", ["LD0303"]),
    "loose contact": ("[a0]", ["LD0304"]),
    "loose branch": ("[a0] { (q0) | [a1] }", ["LD0304"]),
    "loose contacts at one place": ("{ [a0] | [a1] }", ["LD0304"]),
    "contact before a block that takes no power": ("[a0] <u0: CTUD(PV := 1) in=_> (q0)", ["LD0304"]),
    "junction that nothing feeds": ("@x [a0] (q0); @x (q1)", ["LD0305"]),
    "pin at a junction that nothing feeds": ("[a0] <u0: CTUD(R := @x, PV := 1)> (q0)", ["LD0305"]),
    "junctions only": ("@x @y", ["LD0307"]),
    "contact behind a jump": ("[a0] >>other [a1] (q0)", ["LD0308"]),
    "jump in a branch that goes on": ("{ [a0] >>other | [a1] } (q0)", ["LD0308"]),
    "jump in a pin network": ("[a0] <u0: CTUD(R := { [a1] >>other }, PV := 1)> (q0)", ["LD0308"]),
    "coil behind a block that gives no power": ("[a0] <u0: CTUD(PV := 1) out=_> (q0)", ["LD0309"]),
    "value at a contact": ("[a0] <MOVE(IN := i0, OUT => @v)>; @v [a1] (q0)", ["LD0311"]),
    "value with two sources": (
        "[a0] <MOVE(IN := i0, OUT => @v)>; [a1] <MOVE(IN := i1, OUT => @v)>; <MOVE(IN := @v, OUT => i2)>",
        ["LD0312"]),
    "value and power joined": (
        "[a0] <MOVE(IN := i0, OUT => @v)>; [a1] @v; <MOVE(IN := @v, OUT => i2)>", ["LD0312"]),
    "value at a pin of another type": (
        "[a0] <MOVE(IN := i0, OUT => @v)>; [a1] <t0: TON(PT := @v)> (q0)", ["LD0313"]),
    "power at a value pin": ("[a0] @x (q1); [a1] <t0: TON(PT := @x)> (q0)", ["LD0313"]),
    "loop that nothing feeds": ("@x [a0] <t0: TON(PT := T#1s)> @y (q0); @y [a1] @x", ["LD0317"]),
}
FINE = {
    "bridge": "{ [a0] @x [a1] | [a2] @y [a3] } (q0); @x [a4] @y",
    "coil alone": "(q0)",
    "coils in the middle": "[a0] (q0) [a1] (q1)",
    "block without wires": "<u0: CTUD(CD := a0, PV := 1) in=_ out=_>",
    "block that feeds a pin of a later one":
        "[a0] <u0: CTUD(PV := 1, QD => @d)>; [a1] <u1: CTUD(R := @d, PV := 2)>",
    "jump beside a coil": "[a0] { (q0) | >>other }",
    "return": "[a0] >>RETURN",
    "power at two places of one name": "[a0] @x; [a1] @x; @x (q0)",
    "pin of the rail": "{ @one [a0] | [a1] } <u0: CTUD(R := @one, PV := 1)> (q0)",
    "value through several pins": "[a0] <MOVE(IN := i0, OUT => @v)>; <ADD(IN1 := @v, IN2 := @v, OUT => i1)>",
    "coil that feeds a junction": "[a0] (q0) @x; @x (q1)",
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong(name: str) -> None:
    text, expected = WRONG[name]
    graph, found = drawn(text)
    assert [d.code for d in found] == expected and graph is None


@pytest.mark.parametrize("name", FINE)
def test_fine(name: str) -> None:
    graph, found = drawn(FINE[name])
    assert graph is not None and not found


def test_unused_junction_is_a_warning() -> None:
    graph, found = drawn("[a0] @x [a1] (q0)")
    assert graph is not None and [(d.code, d.severity) for d in found] == [("LD0306", "warning")]


def test_loop_through_a_block_is_a_note() -> None:
    graph, found = drawn("[a0] @x <t0: TON(PT := T#1s)> @y (q0); @y [a1] @x")
    assert graph is not None and [(d.code, d.severity) for d in found] == [("LD0316", "note")]
    assert found[0].primary.span.text.startswith("<t0: TON")


def test_findings_point_at_the_elements() -> None:
    (found,) = drawn("[a0] @x [a1] @y (q0); @y [a2] @x")[1]
    assert found.primary.span.text == "[a1]" and [label.span.text for label in found.secondary] == ["[a2]"]
    (found,) = drawn("[a0] @warm (q0); @worm [a1] (q1); @warm (q2)")[1][:1]
    assert found.primary.span.text == "@worm" and "`@warm`" in found.help


def test_several_findings_in_one_rung() -> None:
    assert codes("[a0]; @x [a1] (q0); [a2] >>other (q1)") == ["LD0304", "LD0305", "LD0308"]


@settings(max_examples=150, deadline=None)
@given(texts(loops=True))
def test_any_drawing_is_judged(text: str) -> None:
    graph, found = drawn(text)
    assert (graph is None) == any(d.severity == "error" for d in found)
