"""Boxes of variables in drawings, with negation, edges and storage; continuous function charts."""

from __future__ import annotations

import pytest
from plcopen_xml import block, coil, contact, element, fbd, ladder, pou, project, rail, result, value, wires
from test_plcopen import built, compiled, run, said

BOOLS = "a b q w : BOOL; t : TON"


def both(id_: int, text: str, sources, at=None, **attributes) -> str:
    inner = f"{wires(sources)}<connectionPointOut/><expression>{text}</expression>"
    return element("inOutVariable", id_, inner, at, **attributes)


def anded(*outputs: str) -> str:
    """`a AND b`, which goes to output variables that are written as given."""
    return fbd(BOOLS, value(1, "a"), value(2, "b"), block(4, "AND", {"IN1": 1, "IN2": 2}, ("OUT",)), *outputs)


CASES = {
    "a box that is read negated": (fbd(BOOLS, value(1, "a"), both(2, "q", 1, negatedOut="true"),
                                       result(3, "w", 2)), "1 0 1", "10 01 10"),
    "a box that is written negated": (fbd(BOOLS, value(1, "a"), both(2, "q", 1, negatedIn="true"),
                                          result(3, "w", 2)), "1 0 1", "00 11 00"),
    "both": (fbd(BOOLS, value(1, "a"), both(2, "q", 1, negatedIn="1", negatedOut="1"), result(3, "w", 2)),
             "1 0 1", "01 10 01"),
    "an output variable that sets": (fbd(BOOLS, value(1, "a"), result(2, "q", 1, storage="set")),
                                     "0 1 0", "00 10 10"),
    "and resets": (anded(result(5, "q", "4.OUT", storage="reset")).replace(
        '<variable name="q"><type><BOOL/></type>', '<variable name="q"><type><BOOL/></type><initialValue>'
        '<simpleValue value="TRUE"/></initialValue>'), "0 1 0", "10 00 00"),
    "negated as well": (fbd(BOOLS, value(1, "a"), result(2, "q", 1, storage="set", negated="true")),
                        "1 0 1", "00 10 10"),
    "an input variable with an edge": (fbd(BOOLS, value(1, "a", edge="rising"), result(2, "q", 1)),
                                       "0 1 1 0 1", "00 10 00 00 10"),
    "falling": (fbd(BOOLS, value(1, "a", edge="falling"), result(2, "q", 1)), "0 1 1 0 1", "00 00 00 10 00"),
    "an output variable that waits for an edge": (anded(result(5, "q", "4.OUT", edge="rising")),
                                                  "0 1 1 0", "00 10 00 00"),
    "an edge for a block": (fbd(f"{BOOLS}; n : CTU", value(1, "a", edge="rising"), value(2, "2"), block(
        3, "CTU", {"CU": 1, "PV": 2}, ("Q", "CV"), "n"), result(4, "q", "3.Q")), "1 0 1", "00 00 10"),
    "no edge and no storage": (fbd(BOOLS, value(1, "a", edge="none", storage="none"),
                                   result(2, "q", 1, edge="none", storage="none")), "0 1", "00 10"),
}


@pytest.mark.parametrize("xml, a, gives", CASES.values(), ids=CASES)
def test_modifiers_of_boxes(xml: str, a: str, gives: str) -> None:
    rows = run(xml, [{"a": int(one), "b": 1} for one in a.split()], "q w")
    assert [row.replace(" ", "") for row in rows] == gives.split()


@pytest.mark.parametrize("xml, name", [
    (fbd(BOOLS, value(1, "a"), both(2, "q", 1, storageIn="set")),
     'inOutVariable 2 `q` at (20, 10) has storageIn="set"'),
    (fbd(BOOLS, value(1, "a", storage="set"), result(2, "q", 1)),
     'input variable 1 `a` at (10, 10) has storage="set"'),
    (anded(result(5, "q", "4.OUT")).replace('formalParameter="OUT">', 'formalParameter="OUT" edge="rising">'),
     'block 4 `AND` at (40, 10) has edge="rising" at its pin OUT'),
    (ladder(BOOLS, rail(), contact(2, "a", edge="both"), coil(3, "q", 2)),
     'contact 2 `a` at (20, 10) has edge="both"'),
    (ladder(BOOLS, rail(), contact(2, "a", storage="set"), coil(3, "q", 2)),
     'contact 2 `a` at (20, 10) has storage="set"'),
    (ladder(BOOLS, rail(), contact(2, "a"), coil(3, "q", 2, storage="keep")),
     'coil 3 `q` at (30, 10) has storage="keep"')])
def test_modifiers_that_nothing_means_are_told(xml: str, name: str) -> None:
    (found,) = compiled(xml).diagnostics
    assert (found.code, found.message) == ("LD0145", f"main: {name}")


def test_modifiers_may_have_capitals() -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a", edge="Rising"), coil(3, "q", 2, storage="SET"))
    assert run(xml, [{"a": 0}, {"a": 1}, {"a": 0}], "q") == ["0", "1", "1"]


def test_several_points_that_feed_an_element() -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a"), contact(3, "b"),
                 element("coil", 4, f"{wires(2)}{wires(3)}<variable>q</variable>"))
    assert run(xml, [{"a": 0, "b": 0}, {"b": 1}, {"a": 1, "b": 0}], "q") == ["0", "1", "1"]


def test_boxes_in_which_no_variable_is_named() -> None:
    xml = fbd(BOOLS, value(1, "a"), value(2, "T#0s"), value(6, "???"),
              block(3, "TON", {"IN": 1, "PT": 2}, ("Q", "ET"), "t"), result(4, "q", "3.Q"),
              result(5, "???", "3.ET"))
    assert not said(built(xml))
    assert run(xml, [{"a": 1}], "q") == ["1"]
    (found,) = compiled(ladder(BOOLS, rail(), contact(2, "a"), coil(3, "???", 2))).diagnostics
    assert (found.code, found.message) == ("LD0144", "main: coil 3 `???` at (30, 10) has no variable")


# ---- edges and pins


@pytest.mark.parametrize("negated, gives", [("false", "11122"), ("true", "01112")])
@pytest.mark.parametrize("drawn", [
    lambda pin: fbd("a : BOOL; i : INT; n : CTU", value(1, "a"), *counted(1, pin)),
    lambda pin: fbd("a : BOOL; i : INT; n : CTU", value(1, "a AND TRUE"), *counted(1, pin)),
    lambda pin: ladder("a : BOOL; i : INT; n : CTU", rail(9), contact(1, "a", 9), *counted(1, pin))],
    ids=["a variable", "an expression", "a wire"])
def test_edges_at_pins(drawn, negated: str, gives: str) -> None:
    xml = drawn({"CU": f'edge="rising" negated="{negated}"'})
    assert "".join(run(xml, [{"a": a} for a in (1, 0, 0, 1, 0)], "i")) == gives


def counted(source: int, pins: dict[str, str]) -> tuple[str, ...]:
    return (value(5, "9"), block(6, "CTU", {"CU": source, "PV": 5}, ("Q", "CV"), "n", modified=pins),
            result(7, "i", "6.CV"))


@pytest.mark.parametrize("outputs, wire_", [((), "2.Q"), (("Q",), "2"), ((), "2")])
def test_an_output_that_only_a_wire_names(outputs: tuple[str, ...], wire_: str) -> None:
    xml = fbd("a q : BOOL; r : R_TRIG", value(1, "a"), block(2, "R_TRIG", {"CLK": 1}, outputs, "r"),
              result(3, "q", wire_))
    assert run(xml, [{"a": 1}, {"a": 1}], "q") == ["1", "0"]


def test_outputs_that_only_wires_name_beside_others() -> None:
    xml = ladder("a q w : BOOL; t : TON; i : INT", rail(), contact(2, "a"), value(3, "T#0s"), block(
        4, "TON", {"IN": 2, "PT": 3}, ("ET",), "t"), coil(5, "q", "4.Q"), contact(6, "a", at=(9, 90)), value(
        7, "5", at=(9, 95)), block(8, "MOVE", {"EN": 6, "IN": 7}, ("OUT",), at=(20, 90)), result(
        9, "i", "8.Out1", at=(30, 95)), coil(10, "w", "8.ENO", at=(30, 90)))
    assert run(xml, [{"a": 0}, {"a": 1}], "q w i") == ["0 0 0", "1 1 5"]
    xml = fbd("a q : BOOL; r : R_TRIG", value(1, "a"), block(2, "R_TRIG", {"CLK": 1}, ("Q",), "r"),
              result(3, "q", "2.QQ"))
    assert "has no pin `QQ`" in said(compiled(xml))


def test_what_an_editor_says_of_a_body_is_no_title() -> None:
    def vendor(id_: int, text: str, data: str) -> str:
        return (f'<vendorElement localId="{id_}"><alternativeText><p>{text}</p></alternativeText><addData>'
                f'<data name="x">{data}</data></addData></vendorElement>')

    xml = fbd("a q : BOOL", vendor(8, "FBD Implementation Attributes", "<fbdattributes/>"),
              vendor(9, "lamp", "<ElementType>networktitle</ElementType>"), value(1, "a"), result(2, "q", 1))
    (rung,) = compiled(xml).project.files[0].pous[0].body.rungs
    assert rung.title == "lamp"


@pytest.mark.parametrize("type_", ["<BIT/>", '<derived name="BIT"/>'])
def test_a_bit_is_a_bool(type_: str) -> None:
    declared = f'<variable name="b"><type>{type_}</type></variable></localVars>'
    xml = project(pou("<ST>b := TRUE; q := b;</ST>", "q : BOOL").replace("</localVars>", declared))
    assert run(xml, [{}], "q") == ["1"]


# ---- continuous function charts

CFC = "http://www.3s-software.com/plcopenxml/cfc"


def chart(*elements: str) -> str:
    """A body that is a continuous function chart: additional data beside an empty body."""
    drawn = f'<data name="{CFC}" handleUnknown="implementation"><CFC>{"".join(elements)}</CFC></data>'
    return f"<ST/><addData>{drawn}</addData>"


def wire(id_: int, source) -> str:
    """What such charts draw between all elements: a connector without a name."""
    return element("connector", id_, wires(source), name="")


def test_a_continuous_function_chart() -> None:
    drawn = chart(value(1, "a"), wire(2, 1), value(3, "b"), wire(4, 3),
                  block(5, "AND", {"In1": 2, "In2": 4}, ("Out1",), executionOrderId=0), wire(6, "5.Out1"),
                  result(7, "q", 6, executionOrderId=1), result(8, "w", 6, negated="true", executionOrderId=2))
    xml = project(pou(drawn, BOOLS))
    assert not said(built(xml))
    assert run(xml, [{"a": 1, "b": 1}, {"b": 0}], "q w") == ["1 0", "0 1"]


def test_its_order_counts_from_0() -> None:
    """The second counter has run when the first line copies it, though it is drawn below."""
    def drawn(first: int, second: int) -> str:
        return project(pou(chart(
            value(1, "i"), value(2, "1"), block(3, "ADD", {"In1": 1, "In2": 2}, ("Out1",), at=(50, 90),
                                                executionOrderId=first),
            result(4, "i", "3.Out1", at=(80, 90), executionOrderId=first + 1),
            value(5, "i"), block(6, "MOVE", {"In1": 5}, ("Out1",), at=(50, 10), executionOrderId=second),
            result(7, "j", "6.Out1", at=(80, 10), executionOrderId=second + 1)), "i j : INT"))

    assert run(drawn(0, 2), [{}], "i j") == ["1 1"]
    assert run(drawn(2, 0), [{}], "i j") == ["1 0"]


def test_what_is_executed_before_what_feeds_it_is_told() -> None:
    def drawn(block_: int, result_: int, source) -> str:
        return project(pou(chart(value(1, "a"), block(
            2, "AND", {"In1": 1, "In2": source}, ("Out1",), executionOrderId=block_), block(
            3, "NOT", {"In1": "2.Out1"}, ("Out1",), executionOrderId=result_), result(
            4, "q", "3.Out1", executionOrderId=2)), BOOLS))

    assert not said(built(drawn(0, 1, 1)))
    assert said(built(drawn(1, 0, 1))) == ("warning LD0159 main: block 3 `NOT` at (30, 10) is executed before "
                                           "block 2 `AND` at (20, 10), which feeds it")
    assert run(drawn(1, 0, 1), [{"a": 1}, {"a": 0}], "q") == ["0", "1"]
    loop = drawn(1, 0, "3.Out1")
    assert said(built(loop)).startswith("note LD0316")
    assert run(loop, [{"a": 1}, {}, {}], "q") == ["1", "0", "1"]


def test_a_loop_that_is_read_before_it_is_fed() -> None:
    xml = project(pou(chart(value(1, "a"), block(
        2, "AND", {"In1": 1, "In2": "3.Out1"}, ("Out1",), executionOrderId=0), result(
        4, "q", "3.Out1", executionOrderId=1), block(3, "NOT", {"In1": "2.Out1"}, ("Out1",), executionOrderId=2)),
        BOOLS))
    assert [d.message for d in compiled(xml).diagnostics if d.code == "LD0159"] == [
        "main: output variable 4 `q` at (40, 10) is executed before block 3 `NOT` at (30, 10), which feeds it"]
    assert run(xml, [{"a": 1}, {}, {}, {}], "q") == ["1", "0", "1", "0"]


def test_an_action_of_a_chart_as_a_continuous_function_chart() -> None:
    body = chart(value(1, "a"), wire(2, 1), result(3, "q", 2, executionOrderId=0))
    steps = element("step", 1, "<connectionPointOut/>", name="s", initialStep="true") + element(
        "actionBlock", 2, wires(1) + '<action localId="3" qualifier="N"><reference name="act"/></action>')
    xml = project(pou(f"<SFC>{steps}</SFC>", BOOLS).replace(
        "<body>", f'<actions><action name="act"><body>{body}</body></action></actions><body>', 1))
    assert run(xml, [{"a": 1}, {"a": 0}], "q") == ["1", "0"]
