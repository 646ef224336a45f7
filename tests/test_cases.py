"""The papers' sequences of events: traces that show them, and what is told of traces that do not (SPEC
6.3)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.processors.cases import (
    CASE_ONE, CASE_TWO, CASES, VISUAL_FLOW, Case, Mark, Overlap, Repeated, violations)
from runtime.units import UNITS, UnitEvent, named

ROLES = {"module 1": 0, "module 2": 1, "algorithm 1": 11, "algorithm 2": 12, "message": 64, "module": 0,
         "algorithm": 11}


def trace(text: str) -> list[UnitEvent]:
    """`unit index detail`, one a line, the last two may be left out; a line is 1 ms."""
    found = []
    for number, line in enumerate(text.strip().splitlines()):
        unit, index, detail, *_ = [*line.split(), "", ""]
        found.append(UnitEvent(number * 1_000_000, "", unit, int(index or 0), detail))
    return found


ONE = """
C.LOGIC
C.START 0
C.LOGIC
C.SEND 11 START
A.START 11
A.DEFRAME 11
A.EXEC 11
A.FEEDBACK 11
C.FEEDBACK 11
A.EXEC 11
A.FEEDBACK 11
C.FEEDBACK 11
A.END 11
C.FEEDBACK 11 end
C.LOGIC
C.END 0
C.START 1
C.LOGIC
C.SEND 12 START
A.START 12
A.DEFRAME 12
A.EXEC 12
A.END 12
C.FEEDBACK 12 end
C.END 1
"""

TWO = """
C.LOGIC
C.START 0
C.SEND 11 START
A.START 11
A.DEFRAME 11
A.EXEC 11
C.LOGIC
C.BCAST 64
C.MSG 64
C.START 1
C.LOGIC
C.SEND 12 START
A.START 12
A.DEFRAME 12
A.EXEC 12
A.END 11
C.FEEDBACK 11 end
A.END 12
C.FEEDBACK 12 end
"""

VISUAL = """
V.RX
V.STORE
C.START 0
V.DEFRAME 0
C.LOGIC
C.DEFRAME 0
C.SEND 11 START
A.START 11
A.DEFRAME 11
A.EXEC 11
A.FEEDBACK 11
C.FEEDBACK 11
V.RX
V.STORE
V.DEFRAME 0
C.DEFRAME 0
C.SEND 11 UPDATE
A.DEFRAME 11
A.EXEC 11
A.END 11
C.END 0
"""

GOOD = pytest.mark.parametrize(("case", "text"), [(CASE_ONE, ONE), (CASE_TWO, TWO), (VISUAL_FLOW, VISUAL)],
                               ids=["one", "two", "visual"])


@GOOD
def test_good_traces(case: Case, text: str) -> None:
    assert violations(case, trace(text), ROLES) == []


@GOOD
def test_an_empty_trace_and_one_backwards_show_nothing(case: Case, text: str) -> None:
    assert violations(case, [], ROLES)
    assert violations(case, trace(text)[::-1], ROLES)


@pytest.mark.parametrize(("case", "text", "change", "words"), [
    (CASE_ONE, ONE, ("A.DEFRAME 12\n", ""),
     "A.DEFRAME(algorithm 2) never happens (wanted after A.START(algorithm 2)"),
    (CASE_ONE, ONE, ("C.SEND 11 START\nA.START 11\n", "A.START 11\nC.SEND 11 START\n"),
     "A.START(algorithm 1) happens at 3000000 ns, and not after C.SEND(algorithm 1, START) at 4000000 ns"),
    (CASE_ONE, ONE, ("A.END 11\n", "A.START 12\nA.END 11\n"),
     "A.START(algorithm 2) at 12000000 ns is before C.FEEDBACK(algorithm 1, end)"),
    (CASE_ONE, ONE, ("C.FEEDBACK 12 end", "C.FEEDBACK 12"), "C.FEEDBACK(algorithm 2, end) never happens"),
    (CASE_ONE, ONE, ("A.FEEDBACK 11\nC.FEEDBACK 11\n", "C.FEEDBACK 11\nA.FEEDBACK 11\n"),
     "C.FEEDBACK(algorithm 1) at 7000000 ns has no A.FEEDBACK(algorithm 1) before it"),
    (CASE_TWO, TWO, ("C.BCAST 64\nC.MSG 64\n", "C.MSG 64\nC.BCAST 64\n"), "C.MSG(message) happens at"),
    (CASE_TWO, TWO, ("C.MSG 64", "C.MSG 65"), "C.MSG(message) never happens"),
    (CASE_TWO, TWO, ("A.EXEC 12\nA.END 11\n", "A.END 11\nA.EXEC 12\n"), "do not overlap"),
    (VISUAL_FLOW, VISUAL, ("C.SEND 11 UPDATE\n", "C.SEND 11 UPDATE\nA.START 11\n"),
     "A.START(algorithm) happens again at 17000000 ns"),
    (VISUAL_FLOW, VISUAL, ("C.START 0\n", ""), "C.START(module) never happens"),
    (VISUAL_FLOW, VISUAL, ("A.END 11\nC.END 0", "C.END 0\nA.END 11"), "C.END(module) happens at"),
])
def test_bad_traces_are_told_in_words(case: Case, text: str, change: tuple[str, str], words: str) -> None:
    assert change[0] in text
    told = violations(case, trace(text.replace(*change, 1)), ROLES)
    assert any(words in line for line in told), told


@pytest.mark.parametrize(("units", "told"), [
    ("a b c b c d", []), ("a b b c c d", []), ("x b a b c b b c d c", []),
    ("a b c d", ["b < c happens 1 times, 2 are wanted, after a at 0 ns"]),
    ("a b c b d c", ["b < c happens 1 times, 2 are wanted, after a at 0 ns"]),
    ("a b c c b d", ["c at 3000000 ns has no b before it, after a at 0 ns"]),
])
def test_a_repetition(units: str, told: list[str]) -> None:
    case = Case("c", ((Mark("a"), Repeated((Mark("b"), Mark("c")), 2), Mark("d")),))
    assert violations(case, trace(units.replace(" ", "\n")), {}) == told


def test_an_end_at_the_time_of_the_begin_is_no_overlap() -> None:
    def both(begin: int) -> list[str]:
        events = [UnitEvent(at, "", unit) for at, unit in ((0, "a"), (begin, "c"), (5, "b"), (9, "d"))]
        overlap = Overlap((Mark("a"), Mark("b")), (Mark("c"), Mark("d")))
        return violations(Case("c", (), overlaps=(overlap,)), events, {})

    assert both(4) == [] and both(5) == ["a to b and c to d do not overlap: 0 ns"]


marks = st.sampled_from("abcd").map(Mark)


@given(st.lists(marks, max_size=5), st.text("abcd", max_size=8))
def test_a_chain_of_marks_is_a_subsequence(chain: list[Mark], units: str) -> None:
    rest = iter(units)
    expected = all(any(mark.unit == unit for unit in rest) for mark in chain)
    events = [UnitEvent(n, "", unit) for n, unit in enumerate(units)]
    assert (violations(Case("c", (tuple(chain),)), events, {}) == []) == expected


def test_units_of_cases_are_units() -> None:
    known = {unit.name for unit in UNITS}
    for case in CASES:
        for chain in case.chains:
            for item in chain:
                for mark in item.marks if isinstance(item, Repeated) else (item,):
                    assert mark.unit in known and (not mark.role or mark.role in ROLES)


def test_what_the_papers_call_them() -> None:
    assert named("S0", "C4") == ("C.SEND",) and named("S2", "C2") == ("C.SEND",)
    assert named("S2", "C3") == ("C.FEEDBACK", "C.END") and named("S1", "M1") == ("A.START", "A.DEFRAME")
    assert named("S0", "V3") == ("V.DEFRAME",) and named("S2", "V3") == ()
    for paper, count in (("s0", 14), ("s1", 9), ("s2", 9)):
        assert len({getattr(unit, paper) for unit in UNITS} - {""}) == count
