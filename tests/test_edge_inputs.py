"""Inputs with R_EDGE and F_EDGE: an edge memory of the instance, at the call (IEC 61131-3, 2.5.2.2)."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import PERIOD, checked, compiled, trace
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from runtime.vm.machine import Machine

HEAD = """FUNCTION_BLOCK count
VAR_INPUT
    up, down : BOOL R_EDGE;
    off : BOOL F_EDGE;
END_VAR
VAR_OUTPUT
    n : INT;
    lamp : BOOL;
END_VAR
"""
MAIN = """PROGRAM main
VAR
    a, b, c, called : BOOL := TRUE;
    n : INT;
    k : ARRAY [1..2] OF count;
END_VAR
RUNG
    [/called] >>RETURN
RUNG
    <k[1]: count(up := a, down := b, off := c, n => n) in=_ out=_>
END_PROGRAM
"""
BODIES = {
    "ladder.ld": "RUNG [up] <ADD(IN1 := n, IN2 := 1, OUT => n)>\n"
                 "RUNG [down] <SUB(IN1 := n, IN2 := 1, OUT => n)>\n"
                 "RUNG [off] (S lamp)\n",
    "text.st": "IF up THEN n := n + 1; END_IF;\nIF down THEN n := n - 1; END_IF;\nlamp := lamp OR off;\n",
    "list.il": "LD up\nJMPCN other\nLD n\nADD 1\nST n\nother:\n"
               "LD down\nJMPCN last\nLD n\nSUB 1\nST n\nlast:\n"
               "LD off\nS lamp\n",
}


def program(name: str) -> str:
    """One block in the language of the file, called from a program in it."""
    block = f"{HEAD}{BODIES[name]}END_FUNCTION_BLOCK\n"
    if name.endswith(".ld"):
        return block + MAIN
    call = {"text.st": "IF called THEN k[1](up := a, down := b, off := c, n => n); END_IF;\n",
            "list.il": "LD called\nRETCN\nLD a\nST k[1].up\nLD b\nST k[1].down\nLD c\nST k[1].off\nCAL k[1]\n"
                       "LD k[1].n\nST n\n"}[name]
    return f"{block}{MAIN[:MAIN.index('RUNG')]}{call}END_PROGRAM\n"


@pytest.mark.parametrize("name", sorted(BODIES))
def test_the_body_sees_the_edge_and_its_caller_the_value(name: str, tmp_path: Path) -> None:
    scans = [{"b": False}, {"b": True}, {"b": False, "c": False}, {"a": False, "called": False},
             {"a": True}, {"called": True, "b": True}]
    rows = trace(tmp_path, program(name), name, scans, ("n", "k[1].lamp", "k[1].up"))
    # In the first call a is TRUE already, and nothing falls. While the block is not called it sees nothing.
    assert rows == [(1, False, True), (0, False, True), (0, True, True), (0, True, True), (0, True, True),
                    (-1, True, True)]


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=40)
@given(st.lists(st.fixed_dictionaries(dict.fromkeys(("a", "b", "c", "called"), st.booleans())), max_size=8))
def test_it_is_the_trigger_that_the_standard_says_it_stands_for(scans: list[dict[str, bool]]) -> None:
    triggers = """PROGRAM main
VAR a, b, c, called : BOOL; n : INT; lamp : BOOL; ra, rb : R_TRIG; fc : F_TRIG; END_VAR
IF called THEN
    ra(CLK := a); rb(CLK := b); fc(CLK := c);
    IF ra.Q THEN n := n + 1; END_IF;
    IF rb.Q THEN n := n - 1; END_IF;
    lamp := lamp OR fc.Q;
END_IF;
END_PROGRAM
"""
    one = Machine(compiled(program("ladder.ld"), "main.ld").program, period_ns=PERIOD)
    other = Machine(compiled(triggers, "main.st").program, period_ns=PERIOD)
    for values in scans:
        for machine in (one, other):
            for name, value in values.items():
                machine.set(name, value)
            machine.scan()
        assert (one.get("n"), one.get("k[1].lamp")) == (other.get("n"), other.get("lamp"))


def test_the_input_is_not_written_in_the_body() -> None:
    text = program("ladder.ld").replace("(S lamp)", "(S up)")
    assert [d.code for d in checked(text, "main.ld").diagnostics] == ["LD0503"]
