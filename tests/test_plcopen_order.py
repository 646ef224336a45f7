"""PLCopen drawings of blocks: loops, boxes that are written and read, functions with EN."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from plcopen_xml import block, coil, contact, fbd, ladder, rail, result, value
from test_plcopen import built, run, said
from test_plcopen_boxes import both

BOOLS = "a b c q w : BOOL; n : CTU; k t : CTD"


def test_an_output_that_goes_back_to_an_input_of_its_block() -> None:
    xml = fbd(BOOLS, value(1, "a"), value(2, "2"), block(
        3, "CTU", {"CU": 1, "R": "3.Q", "PV": 2}, ("Q", "CV"), "n"), result(4, "q", "3.Q"))
    rows = run(xml, [{"a": a} for a in (1, 0, 1, 0, 1)], "q n.CV")
    assert rows == ["0 1", "0 1", "1 2", "0 0", "0 1"]


def test_blocks_in_a_ring_that_nothing_else_feeds() -> None:
    xml = fbd(BOOLS, value(1, "1"), block(2, "CTD", {"CD": "3.Q", "PV": 1}, ("Q",), "k"), block(
        3, "CTD", {"CD": "2.Q", "PV": 1}, ("Q",), "t"), result(4, "q", "2.Q"), result(5, "w", "3.Q"))
    assert not [d for d in built(xml).diagnostics if d.code == "LD0316"]  # an output is read as a variable
    assert run(xml, [{}, {}], "q w k.CV t.CV") == ["1 1 -1 0", "1 1 -1 -1"]


def test_the_way_back_from_what_is_written_ends_where_a_loop_begins() -> None:
    """Places do not say it: a latch and the timer that resets it, one of them some points higher."""
    for high, low in ((10, 20), (20, 10)):
        xml = fbd("a q : BOOL; l : SR; t : TON", value(1, "a"), value(4, "T#20ms"), block(
            2, "SR", {"S1": 1, "R": "3.Q"}, ("Q1",), "l", at=(20, high)), block(
            3, "TON", {"IN": "2.Q1", "PT": 4}, ("Q",), "t", at=(60, low)), result(5, "q", "3.Q", at=(90, 10)))
        rows = run(xml, [{"a": 1}, {"a": 0}, {}, {}], "l.Q1 t.IN q")
        assert rows == ["1 1 0", "1 1 0", "1 1 1", "0 0 0"]
    xml = fbd(BOOLS, block(2, "NOT", {"IN": "3.OUT"}, ("OUT",), at=(10, 10)),
              block(3, "AND", {"IN1": "2.OUT", "IN2": 1}, ("OUT",), at=(50, 10)), value(1, "a"),
              result(4, "w", "2.OUT", at=(90, 10)), result(5, "q", "3.OUT", at=(90, 40)))
    assert run(xml, [{"a": 1}, {}, {}], "w q") == ["1 0", "0 1", "1 0"]


def test_contacts_on_the_way_back_from_a_function_are_read_in_this_scan() -> None:
    """Only the value of the function is of the scan before; a contact that something else reads too stands twice."""
    for reads_too in (False, True):
        xml = ladder("a b c q w : BOOL", rail(), contact(2, "a"), contact(3, "b"), contact(4, "c", "6.OUT"),
                     block(5, "OR", {"IN1": 2, "IN2": 4}, ("OUT",)),
                     block(6, "AND", {"IN1": "5.OUT", "IN2": 3}, ("OUT",)), coil(7, "q", "6.OUT"),
                     coil(8, "w", 4 if reads_too else 1))
        rows = [{"a": 1, "b": 1, "c": 0}, {"a": 0, "c": 1}, {}, {"c": 0}, {"c": 1}]
        assert run(xml, rows, "q AND_6_OUT") == ["1 1", "1 1", "1 1", "0 0", "0 0"]
        assert not reads_too or run(xml, rows, "w") == ["0", "1", "1", "0", "0"]


def test_a_way_back_goes_through_contacts_as_often_as_it_meets_them() -> None:
    """The XOR needs what the contact gives, and so the timer first, though the way comes from that contact."""
    xml = ladder("a c q : BOOL; t : TON", rail(), value(9, "T#0s"), contact(2, "a", ("3.OUT", "4.Q")),
                 contact(5, "c"), block(3, "XOR", {"IN1": 5, "IN2": 2}, ("OUT",)),
                 block(4, "TON", {"IN": 2, "PT": 9}, ("Q",), "t"), coil(6, "q", 2))
    assert run(xml, [{"a": 1, "c": 1}, {"a": 0}], "q t.IN XOR_3_OUT") == ["1 0 1", "0 0 1"]


def test_the_code_of_a_loop_is_the_same_in_every_process(tmp_path: Path) -> None:
    """Sets of texts have another order in each: contacts with one number in a loop changed places."""
    outputs, source = ("6.OUT", "7.OUT", "9.OUT"), tmp_path / "loop.xml"
    source.write_text(ladder(
        "a b c d e q w : BOOL", rail(), contact(2, "a"), contact(3, "b"), contact(4, "c", outputs),
        contact(10, "d", outputs[1:]), contact(11, "e", 10),
        block(5, "OR", {"IN1": 2, "IN2": 4, "IN3": 11}, ("OUT",)), coil(8, "q", outputs[:2]), coil(12, "w", 4),
        *(block(id_, name, {"IN1": "5.OUT", "IN2": 3}, ("OUT",)) for id_, name in ((6, "AND"), (7, "XOR"), (9, "OR")))))
    found = {subprocess.run([sys.executable, "-m", "ldc.cli", "compile", str(source)], capture_output=True, check=True,
                            env={**os.environ, "PYTHONHASHSEED": str(seed)}).stdout for seed in range(5)}
    assert len(found) == 1


def test_operators_behind_a_loop_know_their_types() -> None:
    """None of the operands that are written decides between INT and DINT."""
    xml = fbd("d e : DINT; i : INT; n : CTU; q : BOOL", value(1, "d"), value(2, "7"), value(10, "1"),
              block(3, "MAX", {"IN1": "4.OUT", "IN2": 2}, ("OUT",)), result(9, "e", "3.OUT"),
              block(4, "MUL", {"IN1": 1, "IN2": 2}, ("OUT",)),
              block(5, "GT", {"IN1": "3.OUT", "IN2": 2}, ("OUT",)),
              block(6, "CTU", {"CU": "7.OUT", "R": "5.OUT", "PV": 10}, ("Q", "CV"), "n"),
              block(7, "NOT", {"IN": "6.Q"}, ("OUT",)), result(8, "q", "6.Q"))
    assert run(xml, [{"d": 100_000}, {"d": 0}, {}], "e q") == ["700000 0", "7 0", "7 0"]


def test_a_box_is_read_behind_where_it_is_written() -> None:
    for at in ((5, 1), (90, 90)):
        xml = fbd(BOOLS, value(1, "a"), block(2, "NOT", {"IN": 1}, ("OUT",), at=(30, 20)),
                  both(3, "q", "2.OUT", at=(40, 20)), result(4, "w", 3, at=at))
        assert run(xml, [{"a": 0}, {"a": 1}, {"a": 0}], "q w") == ["1 1", "0 0", "1 1"]


@pytest.mark.parametrize("loop", [False, True])
def test_a_coil_reads_a_box_behind_where_it_is_written(loop: bool) -> None:
    """Also in a rung with a loop of functions, which has an order of its own."""
    for high, low in ((10, 50), (50, 10)):
        xml = ladder("a b q w : BOOL", rail(1), contact(2, "a", 1, at=(20, 60)),
                     both(3, "q", "4.OUT", at=(60, high)), coil(5, "w", 3, at=(90, low)),
                     block(4, "NOT", {"IN": 2}, ("OUT",), at=(30, 60)),
                     block(6, "AND", {"IN1": "4.OUT", "IN2": "7.OUT" if loop else 1}, ("OUT",),
                           at=(30, 90)),
                     block(7, "NOT", {"IN": "6.OUT"}, ("OUT",), at=(60, 90)),
                     coil(8, "b", "7.OUT", at=(90, 90)))
        rows = run(xml, [{"a": 0}, {"a": 1}, {"a": 0}, {"a": 0}], "q w b")
        assert [row[:3] for row in rows] == ["1 1", "0 0", "1 1", "1 1"]
        assert [row[4:] for row in rows] == list("1101" if loop else "0100")


def test_a_box_that_is_fed_by_what_it_feeds() -> None:
    xml = fbd("i j : INT", both(2, "i", "3.OUT"), value(4, "1"),
              block(3, "ADD", {"IN1": 2, "IN2": 4}, ("OUT",)), result(5, "j", 2))
    assert run(xml, [{}, {}, {}], "i j") == ["1 1", "2 2", "3 3"]


def test_numbers_against_the_wires_are_told() -> None:
    xml = fbd(BOOLS, value(1, "a"), block(2, "NOT", {"IN": 1}, ("OUT",), executionOrderId=2),
              block(3, "NOT", {"IN": "2.OUT"}, ("OUT",), executionOrderId=1),
              result(4, "q", "3.OUT", executionOrderId=3))
    assert said(built(xml)) == ("warning LD0159 main: block 3 `NOT` at (30, 10) is executed before "
                                "block 2 `NOT` at (20, 10), which feeds it")
    assert run(xml, [{"a": 1}, {"a": 0}], "q") == ["1", "0"]


CONDITIONAL = {
    "two variables at one output": (
        "ADD", (value(3, "i"), value(4, "1")), (result(6, "j", "5.OUT"), result(7, "k", "5.OUT")), {},
        "j k", ["4 4", "9 9", "5 5"]),
    "a variable, a box that is read and ENO": (
        "ADD", (value(3, "i"), value(4, "1")), (
            result(6, "j", "5.OUT"), both(7, "k", "5.OUT"), result(8, "q", "5.ENO")), {},
        "j k q", ["4 4 1", "9 9 0", "5 5 1"]),
    "a variable that is written negated": (
        "AND", (value(3, "b"), value(4, "TRUE")), (result(6, "q", "5.OUT", negated="true"),), {}, "q",
        ["0", "0", "1"]),
    "a negated output": (
        "AND", (value(3, "b"), value(4, "TRUE")), (result(6, "q", "5.OUT"), result(7, "w", "5.ENO")),
        {"OUT": 'negated="true"'}, "q w", ["0 1", "0 0", "1 1"]),
    "a conversion": (
        "MOVE", (value(3, "u"),), (result(6, "j", "5.OUT"), result(7, "w", "5.ENO")), {}, "j w",
        ["5 1", "9 0", "6 1"]),
}


@pytest.mark.parametrize("case", CONDITIONAL)
def test_what_a_function_with_en_gives_is_written_when_it_is_executed(case: str) -> None:
    name, values, boxes, modified, watch, rows = CONDITIONAL[case]
    pins = {"IN": 3} if len(values) == 1 else {"IN1": 3, "IN2": 4}
    drawn = block(5, name, {"EN": 2, **pins}, ("ENO", "OUT"))
    for pin, more in modified.items():
        drawn = drawn.replace(f'"{pin}"><connectionPointOut', f'"{pin}" {more}><connectionPointOut')
    xml = ladder("a b q w : BOOL; i j k : INT; u : WORD", rail(), contact(2, "a"), *values, drawn, *boxes)
    inputs = [{"a": 1, "b": 1, "i": 3, "u": 5}, {"a": 0, "b": 0, "i": 4, "u": 6, "j": 9, "k": 9}, {"a": 1}]
    assert run(xml, inputs, watch) == rows
