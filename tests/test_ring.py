"""The trace ring: which scans it keeps, what triggers, what it costs."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import native
from ldc.diagnostics import Invalid
from online_programs import loaded
from runtime.machine import Machine
from runtime.ring import MOST_CELLS, Ring, trigger
from runtime.trace import record

TEXT = """PROGRAM main
VAR go AT %IX0.0 : BOOL; n : INT; x : REAL; s : STRING[5] := 'ab'; t : TIME; on_ : BOOL; END_VAR
RUNG counts
    <ADD(IN1 := n, IN2 := 1, OUT => n)>
RUNG follows
    [n >= 4] [n < 7] (on_)
END_PROGRAM
"""
ENGINES = ("vm", pytest.param("native", marks=native.needs_gcc))
WATCHED = ("on_", "n")


def traced(machine: Machine, text: str, before: int, after: int, scans: int = 20) -> Ring:
    ring = Ring(machine, WATCHED, text, before, after)
    for _ in range(scans):
        machine.scan()
        ring.sample()
    return ring


@pytest.mark.parametrize("engine", ENGINES)
def test_the_rows_are_those_of_a_trace_around_the_event(engine: str) -> None:
    whole = record(loaded(TEXT, engine).machine, WATCHED, 20).splitlines()
    ring = traced(loaded(TEXT, engine).machine, "on_ rises", 2, 3)
    assert ring.done and ring.event == 3
    assert ring.csv().splitlines() == [whole[0], *whole[2:8]]
    assert ring.csv(0, 2) + ring.csv(2, 100) == ring.csv()


@pytest.mark.parametrize(("text", "event"), [
    ("on_ rises", 3), ("on_ falls", 6), ("main.on_ RISES", 3), ("n > 5", 5), ("n>=5", 4), ("n <= 1", 0),
    ("n = 9", 8), ("n <> 1", 1), ("n < 0", None), ("s = ab", 0),
    ("t >= T#0s", 0), ("on_ = TRUE", 3), ("x > 1.5", None),
    ("go rises", None)])
def test_triggers(text: str, event: int | None) -> None:
    assert traced(loaded(TEXT).machine, text, 0, 0).event == event


@pytest.mark.parametrize(("text", "code"), [
    ("", "LD0857"), ("n", "LD0857"), ("n jumps", "LD0857"), ("n rises", "LD0857"), ("s > a", "LD0857"),
    ("on_ < 1", "LD0857"), ("m rises", "LD0855"), ("n > much", "LD0855"), ("n > 99999", "LD0855"),
    ("> 5", "LD0857")])
def test_what_is_no_trigger_is_told(text: str, code: str) -> None:
    with pytest.raises(Invalid) as caught:
        trigger(text, loaded(TEXT).machine)
    assert [d.code for d in caught.value.diagnostics] == [code]


@pytest.mark.parametrize(("before", "after"),
                         [(-1, 0), (0, -1), (MOST_CELLS, 0), (0, MOST_CELLS), (1 << 60, 1 << 60)])
def test_memory_is_bounded(before: int, after: int) -> None:
    with pytest.raises(Invalid) as caught:
        Ring(loaded(TEXT).machine, ("n",), "n > 1", before, after)
    assert [d.code for d in caught.value.diagnostics] == ["LD0859"]


SHARED = loaded(TEXT).machine
FRESH = SHARED.checkpoint()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 6), st.integers(0, 6), st.integers(1, 12), st.integers(0, 18))
def test_before_and_after_whatever_the_run(before: int, after: int, at: int, scans: int) -> None:
    SHARED.restore(FRESH)
    ring = traced(SHARED, f"n = {at}", before, after, scans)
    rows = [int(line.split(",")[0]) for line in ring.csv().splitlines()[1:]]
    if scans < at:
        assert ring.event is None and rows == list(range(max(0, scans - before), scans))
    else:
        assert rows == list(range(max(0, at - 1 - before), min(scans, at + after)))
    assert ring.done == (scans >= at + after)


def test_a_ring_goes_on_in_another_program() -> None:
    old = loaded(TEXT)
    new = loaded(TEXT.replace("x : REAL;", "").replace("n : INT", "m, n : INT"), "vm", old)
    ring = Ring(old.machine, ("x", "n"), "n = 4", 3, 1)
    for _ in range(2):
        old.machine.scan()
        ring.sample()
    new.machine.take_over(old.machine)
    new.machine.set("n", 2)
    ring.follow(new.machine)
    for _ in range(3):
        new.machine.scan()
        ring.sample()
    assert ring.csv().splitlines()[1:] == ["0,0,0.0,1", "1,10,0.0,2", "2,20,,3", "3,30,,4", "4,40,,5"]
    gone = loaded("PROGRAM main\nVAR k : INT; END_VAR\nEND_PROGRAM\n")
    ring = Ring(old.machine, ("n",), "n = 99", 3, 1)
    ring.follow(gone.machine)
    ring.sample()
    assert ring.lost and ring.csv().splitlines()[1].endswith(",")
