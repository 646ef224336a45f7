"""Forces: what is held in a scan, in which order, and how it goes on in another program."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import native
from online_programs import loaded
from runtime.online.checks import Limits
from runtime.online.controller import Controller, prepare
from runtime.stimuli import Stimuli
from runtime.symbols import UnknownSymbol
from runtime.vm.stepping import Stepper

TEXT = """PROGRAM main
VAR
    a AT %IX0.0 : BOOL;
    b AT %IX0.1 : BOOL;
    bits AT %IW2 : WORD;
    q AT %QX0.0 : BOOL;
    seen, both : BOOL;
    n, copy : INT;
    t : TON;
END_VAR
RUNG both
    [a] (seen) [b] (both) (q)
RUNG copies
    <MOVE(IN := n, OUT => copy)>
RUNG counts
    <ADD(IN1 := n, IN2 := 1, OUT => n)>
RUNG waits
    [b] <t: TON(PT := T#30ms)>
END_PROGRAM
"""
ENGINES = ("vm", pytest.param("native", marks=native.needs_gcc))


@pytest.fixture(params=ENGINES)
def machine(request):
    return loaded(TEXT, request.param).machine


def test_a_forced_input_ignores_what_comes_in_until_it_is_let_go(machine) -> None:
    machine.set("a", True)
    machine.forces.add("a", "0")
    machine.scan()
    assert not machine.get("a") and not machine.get("seen")
    machine.set("%IX0.0", True)
    machine.scan()
    assert not machine.get("seen")
    machine.forces.remove("%IX0.0")
    assert machine.get("a"), "what came in meanwhile"
    machine.scan()
    assert machine.get("seen")


def test_a_forced_output_and_a_forced_variable_are_held_before_and_after_the_code(machine) -> None:
    machine.forces.add("q", "TRUE")
    machine.forces.add("n", "7")
    for _ in range(3):
        machine.scan()
        assert machine.get("q") and machine.get("n") == 7 and machine.get("copy") == 7
    machine.forces.remove("n")
    machine.scan()
    assert machine.get("n") == 8


def test_bits_and_members_of_blocks_are_forced(machine) -> None:
    machine.forces.add("bits.3", "1")
    machine.set("bits", 0x8001)
    machine.scan()
    assert machine.get("bits") == 0x8009
    machine.forces.add("t.Q", "1")
    machine.scan()
    assert machine.get("t.Q")
    assert [(row.path, row.shown) for row in machine.forces.rows] == [("main.bits.3", "1"),
                                                                         ("main.t.Q", "1")]


def test_a_second_force_of_one_variable_changes_the_first(machine) -> None:
    machine.forces.add("a", "0")
    machine.forces.add("main.A", "1")
    assert [row.shown for row in machine.forces.rows] == ["1"]
    assert machine.forces.remove("q") is None


def test_a_stepped_scan_holds_forces_too() -> None:
    machine = loaded(TEXT).machine
    machine.forces.add("a", "1")
    machine.forces.add("q", "1")
    stepper = Stepper(machine)
    stepper.scan()
    assert machine.get("seen") and machine.get("q")


CHANGED = TEXT.replace("seen, both", "other, seen, both").replace("n, copy : INT", "n, copy : DINT")


@pytest.mark.parametrize("engine", ENGINES)
def test_forces_go_on_by_path_in_another_program_and_back(engine: str) -> None:
    old = loaded(TEXT, engine)
    new = loaded(TEXT.replace("seen, both", "other, seen, both"), engine, old)
    controller = Controller(old)
    old.machine.forces.add("seen", "1")
    old.machine.forces.add("a", "1")
    controller.scan()
    controller.stage(prepare(old, new, old.digest, "me", Limits()))
    controller.test("me")
    controller.machine.set("a", False)
    controller.machine.set("b", True)
    controller.scan()
    assert controller.machine is new.machine and controller.machine.get("q")
    controller.machine.forces.add("other", "1")
    controller.machine.forces.remove("seen")
    controller.scan()
    controller.untest("me")
    controller.scan()
    assert controller.machine is old.machine
    assert [row.path for row in controller.machine.forces.rows] == ["main.a"]
    controller.machine.forces.remove("a")
    assert not controller.machine.get("a")


def test_what_another_program_cannot_hold_is_told() -> None:
    old, new = loaded(TEXT).machine, loaded(CHANGED.replace("both : BOOL", "both2 : BOOL")
                                            .replace("(both)", "(both2)")).machine
    for path in ("n", "both", "a"):
        old.forces.add(path, "1")
    lost = [(path, str(was), None if now is None else str(now)) for path, was, now in old.forces.lost(new)]
    assert lost == [("main.n", "INT", "DINT"), ("main.both", "BOOL", None)]
    assert [row.path for row in old.forces.follow(new).rows] == ["main.a"]


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(("set", "force", "free", "scan", "keep")), st.booleans()),
                max_size=25))
def test_an_input_reads_as_forced_and_else_as_it_was_last_set(steps) -> None:
    """Against a model of two values; a checkpoint, as a test of a change takes it, alters nothing."""
    machine, outside, forced = SHARED, False, None
    machine.forces.rows.clear()
    machine.set("a", False)
    machine.scan()
    for step, value in steps:
        if step == "set":
            machine.set("a", value)
            outside = value
        elif step == "force":
            machine.forces.add("a", "1" if value else "0")
            forced = value
        elif step == "free":
            machine.forces.remove("a")
            forced = None
        elif step == "keep":
            machine.checkpoint()
        else:
            machine.scan()
            assert machine.get("a") == machine.get("seen") == (outside if forced is None else forced)


SHARED = loaded(TEXT).machine


def test_stimuli_do_not_reach_a_forced_input(machine) -> None:
    symbol = machine.symbols.find("a")
    machine.forces.add("a", "0")
    stimuli = Stimuli({0: ((symbol, True),)}, 0)
    stimuli.apply(machine)
    machine.scan()
    assert not machine.get("seen")


@settings(max_examples=300, deadline=None)
@given(st.one_of(st.text(max_size=12), st.text("an.[]0123,-% ", max_size=10),
                 st.sampled_from(("n", "t.PT", "bits", "a", "x", "s", "row[1]"))),
       st.one_of(st.text(max_size=12), st.text("0123456789eE.-+#T_msd$'", max_size=12)))
def test_whatever_is_forced_it_is_done_or_told(path: str, text: str) -> None:
    machine = TYPED
    try:
        machine.forces.add(path, text)
    except (UnknownSymbol, ValueError):
        pass
    machine.scan()
    machine.forces.rows.clear()


@pytest.mark.parametrize("path", ("row[1,]", "row[-]", "row[,]", "a." + "9" * 5000, "a" * 5000, "row[--1]"))
def test_what_is_no_path_is_told(path: str) -> None:
    with pytest.raises(UnknownSymbol):
        TYPED.symbols.find(path)


MORE = "t : TON; x : REAL; s : STRING[3]; row : ARRAY [0..2] OF LREAL;"
TYPED = loaded(TEXT.replace("t : TON;", MORE)).machine
