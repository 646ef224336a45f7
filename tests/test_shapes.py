"""Rungs of equal shape are compiled once: what comes out is what comes out of each by itself, and whatever
could make a difference makes another shape."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc import pipeline
from ldc.diagnostics import Severity
from ldc.expr import Load
from ldc.il import shapes
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile

DECLARATIONS = """VAR_GLOBAL g, h : BOOL; END_VAR
TYPE pair : STRUCT x, y : BOOL; END_STRUCT; END_TYPE
FUNCTION_BLOCK latch
VAR_INPUT go : BOOL; END_VAR
VAR_OUTPUT out : BOOL; END_VAR
VAR_EXTERNAL g : BOOL; END_VAR
RUNG { [go] | [out] [/go] [g] } (out)
END_FUNCTION_BLOCK
FUNCTION_BLOCK scale
VAR_INPUT go : BOOL; factor : INT; END_VAR
VAR_OUTPUT out : BOOL; END_VAR
RUNG [go] (out)
END_FUNCTION_BLOCK
PROGRAM p
VAR
    a, b, c, d, q, z : BOOL;
    t, u : TON;
    n : CTU;
    l, m : latch;
    s : scale;
    v, w : pair;
    i, j : INT;
    bits, more : WORD;
    many : ARRAY [0..3] OF BOOL;
    x0 AT %IX0.0 : BOOL;
    x1 AT %IX0.1 : BOOL;
    again AT %IX0.0 : BOOL;
    y0 AT %QX0.0 : BOOL;
    whole AT %IB0 : BYTE;
END_VAR
VAR_EXTERNAL g, h : BOOL; END_VAR
"""


def compiled(*rungs: str) -> pipeline.Compiled:
    text = DECLARATIONS + "".join(f"RUNG {rung}\n" for rung in rungs) + "END_PROGRAM\n"
    result = pipeline.compile_project(Sources((SourceFile("p.ld", text),), Settings(), None))
    assert not result.diagnostics.has_errors, [d.message for d in result.diagnostics if d.severity is Severity.ERROR]
    return result


def shape(rung: str) -> shapes.Shape | None:
    result = compiled(rung)
    (build,) = result.units["p"]
    locations = {v.name.upper(): v.location for v in result.model.pous["P"].variables.values() if v.location}
    return shapes.shape_of(build.graph, locations)


SAME = {
    "names": ("{ [a] | [q] } [/b] (q)", "{ [c] | [z] } [/d] (z)"),
    "order_of_declaration": ("[a] [b] (q)", "[d] [c] (a)"),
    "where_it_is_kept": ("[a] [b] (q)", "[x0] [g] (y0)"),
    "direct_addresses": ("[%IX4.0] [%IX4.1] (q)", "[a] [%MX0.3] (%QX7.7)"),
    "instances": ("[a] <t: TON(PT := T#1s)> (q)", "[b] <u: TON(PT := T#1s)> (z)"),
    "presets": ("[a] <t: TON(PT := T#1s)> <n: CTU(PV := 3)> (q)", "[a] <t: TON(PT := T#2s)> <n: CTU(PV := 4)> (q)"),
    "presets_alike": ("[a] <t: TON(PT := T#1s)> <u: TON(PT := T#1s)> (q)",
                      "[a] <t: TON(PT := T#3s)> <u: TON(PT := T#3s)> (q)"),
    "members": ("[v.x] (q)", "[w.x] (z)"),
    "bits": ("[bits.3] (more.4)", "[more.3] (bits.4)"),
    "edges": ("[P a] (P q)", "[P b] (P z)"),
    "pins": ("<t: TON(IN := { [a] | [b] }, PT := T#1s) in=_> (q)", "<u: TON(IN := { [c] | [d] }, PT := T#1s) in=_> (z)"),
    "globals_at_a_call": ("[g] <l: latch()> (q)", "[h] <m: latch()> (z)"),
}

DIFFERENT = {
    "a_variable_twice": ("[a] [b] (q)", "[a] [a] (q)"),
    "a_coil_read_before": ("[a] [b] (q)", "[a] [q] (q)"),
    "who_is_twice": ("[a] [b] [a] (q)", "[a] [b] [b] (q)"),
    "one_bit_of_the_image": ("[x0] [x1] (q)", "[x0] [%IX0.0] (q)"),
    "negation": ("[a] [/b] (q)", "[a] [b] (q)"),
    "edge": ("[P a] (q)", "[N a] (q)"),
    "coil": ("[a] (S q)", "[a] (R q)"),
    "wiring": ("{ [a] | [b] } [c] (q)", "{ [a] | [b] [c] } (q)"),
    "constant": ("[TRUE] (q)", "[FALSE] (q)"),
    "preset_of_zero": ("[a] <t: TON(PT := T#1s)> (q)", "[a] <t: TON(PT := T#0s)> (q)"),
    "presets_alike": ("[a] <t: TON(PT := T#1s)> <u: TON(PT := T#1s)> (q)",
                      "[a] <t: TON(PT := T#1s)> <u: TON(PT := T#2s)> (q)"),
    "constant_of_a_function": ("[a] <ADD(IN1 := i, IN2 := 1, OUT => i)>", "[a] <ADD(IN1 := i, IN2 := 2, OUT => i)>"),
    "preset_beside_a_function": ("[a] <n: CTU(PV := 1)> <ADD(IN1 := i, IN2 := 1, OUT => i)>",
                                 "[a] <n: CTU(PV := 2)> <ADD(IN1 := i, IN2 := 1, OUT => i)>"),
    "constant_of_a_called_block": ("[a] <s: scale(factor := 1)>", "[a] <s: scale(factor := 2)>"),
    "block": ("[a] <t: TON(PT := T#1s)> (q)", "[a] <l: latch()> (q)"),
    "member": ("[v.x] (q)", "[v.y] (q)"),
    "bit": ("[bits.3] (q)", "[bits.4] (q)"),
    "pin_or_variable": ("[a] [t.Q] <t: TON(PT := T#1s)> (q)", "[a] [u.Q] <t: TON(PT := T#1s)> (q)"),
    "a_global_at_a_call": ("[a] (g) <l: latch()> (q)", "[a] (b) <l: latch()> (q)"),
    "the_image_at_a_call": ("[a] (y0) <l: latch()> (q)", "[a] (b) <l: latch()> (q)"),
    "junction": ("[a] @n [b] (q); @n [c] (z)", "[a] [b] @n (q); @n [c] (z)"),
}

ALONE = {
    "overlapping_locations": "[x0] [again] (q)",
    "bit_and_byte": "[whole.0] [a] (q)",
    "index": "[many[2]] (q)",
    "expression": "[i > 3] (q)",
}


@pytest.mark.parametrize("name", SAME)
def test_names_make_no_difference(name: str) -> None:
    one, other = map(shape, SAME[name])
    assert one.key == other.key


@pytest.mark.parametrize("name", DIFFERENT)
def test_everything_else_does(name: str) -> None:
    one, other = map(shape, DIFFERENT[name])
    assert one is None or other is None or one.key != other.key


@pytest.mark.parametrize("name", ALONE)
def test_what_names_do_not_tell_has_no_shape(name: str) -> None:
    assert shape(ALONE[name]) is None


@pytest.mark.parametrize("name", SAME)
def test_the_second_rung_of_a_shape_is_not_proved_again(name: str, monkeypatch) -> None:
    calls = []
    verify = pipeline.rungs.verify
    monkeypatch.setattr(pipeline.rungs, "verify", lambda *args: calls.append(args) or verify(*args))
    builds = compiled(*SAME[name]).units["p"]
    assert [(build.verdict.kind, build.code.proof) for build in builds] == [("proof", "proof")] * 2
    assert len(calls) == 3, "one for each block, one for both rungs"


RUNGS = (*(rung for pair in (*SAME.values(), *DIFFERENT.values()) for rung in pair), *ALONE.values())
NETWORKS = ("{{ [{0}] | [/{1}] }} [{2}] ({3})", "[P {0}] ({1}) [{2}] (S {3})", "[{0}] {{ [{1}] ({2}) | [/{2}] }} ({3})",
            "<t: TON(IN := {{ [{0}] [{1}] }}, PT := T#1s) in=_ out=_>; [{2}] [t.Q] ({3})",
            "{{ [/{0}] | [{1}] }} [/{2}] ({3})", "[P {0}] ({1}) [/{2}] (S {3})",
            "<t: TON(IN := {{ [{0}] [/{1}] }}, PT := T#2s) in=_ out=_>; [/{2}] [t.Q] ({3})",
            "[{0}] [{1}] <l: latch()> [{2}] ({3})", "{{ [{0}] @n [{1}] | [{2}] @m }} ({3}); @n [d] @m")
NAMES = ("a", "b", "q", "g", "x0", "again", "%IX0.1", "y0", "v.x", "v.y", "bits.1", "many[1]", "t.Q")
OUTPUTS = ("b", "q", "g", "y0", "v.x", "bits.1", "many[1]")


@st.composite
def likes(draw) -> tuple[str, ...]:
    """Rungs of few networks, with variables that are sometimes the same."""
    count = draw(st.integers(2, 8))
    return tuple(
        draw(st.sampled_from(NETWORKS)).format(
            draw(st.sampled_from(NAMES)), draw(st.sampled_from(OUTPUTS)), draw(st.sampled_from(OUTPUTS)),
            draw(st.sampled_from(OUTPUTS))) for _ in range(count))


def by_itself(rungs: tuple[str, ...]) -> pipeline.Compiled:
    """Without any use of shapes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shapes, "shape_of", lambda graph, locations: None)
        return compiled(*rungs)


@settings(deadline=None)
@given(likes())
def test_the_image_is_that_of_each_rung_by_itself(rungs: tuple[str, ...]) -> None:
    one, other = compiled(*rungs), by_itself(rungs)
    assert one.image.data == other.image.data
    assert [(b.verdict, b.tree, b.turns) for b in one.units["p"]] == [
        (b.verdict, b.tree, b.turns) for b in other.units["p"]]
    assert [d.message for d in one.diagnostics] == [d.message for d in other.diagnostics]


def test_the_image_of_all_examples_is_that_of_each_by_itself() -> None:
    assert compiled(*RUNGS).image.data == by_itself(RUNGS).image.data


FAMILIES = {
    "contacts": ("{ [a] | [/b] } [c] (q)", "{ [/d] | [b] } [/c] (q)"),
    "inputs": ("[x0] [/b] (y0)", "[/x0] [b] (q)"),
    "and a constant": ("[a] <t: TON(PT := T#1s)> (q)", "[/a] <u: TON(PT := T#2s)> (q)"),
    "pins": ("[a] <t: TON(PT := T#1s)> [/t.Q] (q)", "[/b] <t: TON(PT := T#3s)> [/t.Q] (q)"),
}
NO_FAMILIES = {
    "read twice": ("[a] [a] (q)", "[a] [/a] (q)"),
    "written": ("{ [a] | [q] } (q)", "{ [a] | [/q] } (q)"),
    "a member": ("[a] <t: TON(PT := T#1s)> [/t.Q] (q)", "[b] <t: TON(PT := T#1s)> [t.Q] (q)"),
    "an edge": ("[a] [b] (q)", "[a] [P b] (q)"),
    "the default": ("[a] <t: TON(PT := T#1s)> (q)", "[a] <t: TON(PT := T#0s)> (q)"),
    "a called block": ("[a] [g] <l: latch()> (q)", "[a] [/g] <l: latch()> (q)"),
    "a function": ("[a] <ADD(IN1 := i, IN2 := 1, OUT => i)>", "[a] <ADD(IN1 := i, IN2 := 2, OUT => i)>"),
    "wiring": ("{ [a] | [b] } [c] (q)", "[a] { [b] | [c] } (q)"),
}


def compared(rungs: tuple[str, ...], monkeypatch) -> list[bool]:
    """Of each rung of the program that is compared with its IL: whether its tree is."""
    trees = []
    verify = pipeline.rungs.verify
    monkeypatch.setattr(pipeline.rungs, "verify", lambda *args: trees.append(args[3] is not None) or verify(*args))
    assert [build.verdict.kind for build in compiled(*rungs).units["p"]] == ["proof"] * len(rungs)
    return trees[2:]


@pytest.mark.parametrize("name", FAMILIES)
def test_rungs_of_a_family_have_one_tree_and_each_its_own_code(name: str, monkeypatch) -> None:
    rungs = FAMILIES[name]
    assert compared(rungs, monkeypatch) == [True, False]
    one, other = compiled(*rungs), by_itself(rungs)
    assert one.image.data == other.image.data
    assert [b.tree for b in one.units["p"]] == [b.tree for b in other.units["p"]]


@pytest.mark.parametrize("name", NO_FAMILIES)
def test_rungs_of_no_family_are_compared_with_their_trees(name: str, monkeypatch) -> None:
    assert compared(NO_FAMILIES[name], monkeypatch) == [True, True]


def test_a_wrong_tree_is_no_example_for_its_family(monkeypatch) -> None:
    right = pipeline.rungs.reduce
    monkeypatch.setattr(pipeline.rungs, "reduce", lambda *args: replace(right(*args), steps=right(*args).steps[:-1]))
    text = DECLARATIONS + "RUNG [a] [b] (q)\nRUNG [/c] [d] (z)\nEND_PROGRAM\n"
    result = pipeline.compile_project(Sources((SourceFile("p.ld", text),), Settings(), None))
    found = [d.message for d in result.diagnostics if "self-check" in str(d.primary)]
    assert len(found) == 4 and all("the tree of this rung" in message for message in found)


def test_a_name_put_in_the_wrong_place_is_noticed(monkeypatch) -> None:
    """No rung is known for which it happens, so a slip is put into the renaming: the rung is compiled anew."""
    right = shapes._renamed
    monkeypatch.setattr(shapes, "_renamed", lambda place, root: replace(right(place, root), root="d"))
    rungs = SAME["names"]
    assert compiled(*rungs).image.data == by_itself(rungs).image.data


def test_a_wrong_rung_is_no_example_for_others(monkeypatch) -> None:
    right = pipeline.rungs.lower

    def wrong(*args, **options):
        lowered = right(*args, **options)
        first, *rest = lowered.code.code
        return replace(lowered, code=replace(lowered.code, code=(replace(first, op="LDN"), *rest)))

    monkeypatch.setattr(pipeline.rungs, "lower", wrong)
    text = DECLARATIONS + "RUNG [a] [b] (q)\nRUNG [c] [d] (z)\nEND_PROGRAM\n"
    result = pipeline.compile_project(Sources((SourceFile("p.ld", text),), Settings(), None))
    found = [d.code for d in result.diagnostics if "self-check" in str(d.primary)]
    assert found == ["LD0901"] * 4, "those of the blocks and both of the program"


def test_every_slip_in_an_operand_makes_another_code() -> None:
    (build,) = compiled("{ [a] | [v.x] } [/b] <t: TON(PT := T#1s)> (q)").units["p"]
    code = build.code.code
    own = shapes.shape_of(build.graph, {})
    places = [e.expr.place for e in build.graph.elements if hasattr(e, "expr") and isinstance(e.expr, Load)]
    for n, instr in enumerate(code):
        for place in places:
            if instr.operand != place and hasattr(instr.operand, "root"):
                other = (*code[:n], replace(instr, operand=place), *code[n + 1:])
                assert own.code(other) != own.code(code)
