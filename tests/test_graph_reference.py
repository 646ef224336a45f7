"""The reference meaning of drawings: DESIGN section 3 rule by rule, and every engine against it."""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

import pytest
from graph_tools import DECLARATIONS, drawn, texts
from hypothesis import given, settings
from hypothesis import strategies as st
from reference import Fault, ReferenceMachine

from ldc import pipeline
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile
from runtime.vm.machine import Machine

MS = 1_000_000


def compiled(text: str, **options) -> pipeline.Compiled:
    sources = Sources((SourceFile("p.ld", text),), Settings(), None)
    return pipeline.compile_project(sources, pipeline.Options(**options))


def reference(made: pipeline.Compiled) -> ReferenceMachine:
    graphs = {name: [build.graph for build in builds] for name, builds in made.units.items()}
    return ReferenceMachine(made.model, graphs)


def oracle(body: str, declarations: str = DECLARATIONS, more: str = "") -> ReferenceMachine:
    made = compiled(f"{more}PROGRAM main\n{declarations}{body}\nEND_PROGRAM\n", verify=False)
    assert not made.diagnostics.has_errors, [d.message for d in made.diagnostics]
    return reference(made)


def scans(machine: ReferenceMachine, name: str, values, watch: str = "q0", step: int = 10 * MS) -> list:
    """What ``watch`` is after each scan in which ``name`` has the next of ``values``."""
    seen = []
    for n, value in enumerate(values):
        machine.set(name, value)
        machine.scan(n * step)
        seen.append(machine.get(watch))
    return seen


def test_power_is_or_and_and() -> None:
    machine = oracle("RUNG { [a0] | [a1] } [/a2] (q0)")
    for bits in range(8):
        values = [bool(bits >> n & 1) for n in range(3)]
        for n, value in enumerate(values):
            machine.set(f"a{n}", value)
        machine.scan(0)
        assert machine.get("q0") == ((values[0] or values[1]) and not values[2])


def test_bridge_conducts_left_to_right_only() -> None:
    machine = oracle("RUNG { [a0] @x [a1] | [a2] @y [a3] } (q0); @x [a4] @y")
    for n, value in enumerate((False, True, True, False, True)):
        machine.set(f"a{n}", value)
    machine.scan(0)
    assert machine.get("q0") is False
    for n, value in enumerate((True, False, False, True, True)):
        machine.set(f"a{n}", value)
    machine.scan(0)
    assert machine.get("q0") is True


def test_a_coil_never_makes_an_earlier_contact_be_read_again() -> None:
    machine = oracle("RUNG { [/q0] | [a0] } @x (q0); @x (q1)")
    assert scans(machine, "a0", [False] * 3, "q1") == [True, False, True]
    assert machine.get("q0") == machine.get("q1")


def test_contact_reads_what_a_coil_before_it_wrote() -> None:
    assert scans(oracle("RUNG [a0] (q1); [q1] (q0)"), "a0", [True, False]) == [True, False]
    assert scans(oracle("RUNG [q1] (q0); [a0] (q1)"), "a0", [True, False]) == [False, True]


def test_coils() -> None:
    assert scans(oracle("RUNG [a0] (/q0)"), "a0", [False, True]) == [True, False]
    assert scans(oracle("RUNG [a0] (S q0)"), "a0", [False, True, False]) == [False, True, True]
    assert scans(oracle("RUNG (S q0) [a0] (R q0)"), "a0", [False, True, False]) == [True, False, True]
    assert scans(oracle("RUNG [a0] (P q0)"), "a0", [True, True, False, True]) == [True, False, False, True]
    assert scans(oracle("RUNG [a0] (N q0)"), "a0", [False, True, False, False]) == [False, False, True, False]


def test_power_passes_a_coil_unchanged() -> None:
    assert scans(oracle("RUNG [a0] (/q1) (P q2) (q0)"), "a0", [False, True, True]) == [False, True, True]


def test_rising_edge_may_show_in_the_first_scan_a_falling_one_cannot() -> None:
    assert scans(oracle("RUNG [P a0] (q0)"), "a0", [True, True, False, True]) == [True, False, False, True]
    assert scans(oracle("RUNG [N a0] (q0)"), "a0", [False, True, False, False]) == [False, False, True, False]


def test_edge_contact_in_a_dead_branch_follows_its_operand() -> None:
    machine = oracle("RUNG [a1] [P a0] (q0)")
    machine.set("a1", False)
    assert scans(machine, "a0", [False, True]) == [False, False]
    machine.set("a1", True)
    assert scans(machine, "a0", [True, False, True]) == [False, False, True]


def test_block_in_a_dead_branch_runs_on() -> None:
    machine = oracle("VAR off : TOF; END_VAR RUNG [a0] <off: TOF(PT := T#20ms)> (q0)")
    assert scans(machine, "a0", [True, False, False, False]) == [True, True, True, False]


def test_en_false_keeps_variables_and_gives_nets_nothing() -> None:
    machine = oracle("RUNG [a0] <ADD(IN1 := i0, IN2 := 1, OUT => i0)> (q0)")
    assert scans(machine, "a0", [True, False, True], "i0") == [1, 1, 2]
    machine = oracle("RUNG [a0] <MOVE(IN := 7, OUT => @v)> (q0); <MOVE(IN := @v, OUT => i0)>")
    assert scans(machine, "a0", [True, False], "i0") == [7, 0]


def test_division_by_zero_is_eno_false_where_it_is_drawn_and_a_fault_elsewhere() -> None:
    machine = oracle("RUNG <DIV(IN1 := 6, IN2 := i0, OUT => i1)> (q0)")
    assert scans(machine, "i0", [2, 0, 3]) == [True, False, True]
    assert scans(machine, "i0", [2, 0], "i1") == [3, 3]
    with pytest.raises(Fault):
        oracle("RUNG [6 / i0 > 1] (q0)").scan(0)


def test_expression_without_power_is_not_evaluated() -> None:
    assert scans(oracle("RUNG [i0 <> 0] [6 / i0 > 1] (q0)"), "i0", [0, 2, 6]) == [False, True, False]


def test_jump_is_taken_after_the_rest_and_the_first_wins() -> None:
    machine = oracle("RUNG [a0] { >>second | >>third } ; [a0] (q1)\nRUNG first (q0)\n"
                     "RUNG second (S q2)\nRUNG third (q3)")
    machine.set("a0", True)
    machine.scan(0)
    assert [machine.get(f"q{n}") for n in range(4)] == [False, True, True, True]


def test_return_leaves_the_pou() -> None:
    assert scans(oracle("RUNG [a0] >>RETURN\nRUNG [/a0] (q0)"), "a0", [False, True]) == [True, True]


def test_loop_counts_with_the_power_of_the_previous_execution() -> None:
    machine = oracle("VAR sr : SR; END_VAR RUNG [a0] @x <sr: SR(R := @reset)> @y (q0); @y [a1] @reset")
    machine.set("a1", True)
    assert scans(machine, "a0", [True, True, True, True]) == [True, True, True, True]
    assert scans(machine, "a0", [False, False]) == [False, False]


def test_outputs_of_a_block_are_stored_in_declared_order() -> None:
    machine = oracle("RUNG [a0] <u0: CTUD(PV := 1, QD => q0, CV => i0)> (q1)")
    assert scans(machine, "a0", [False, True]) == [True, False] and machine.get("i0") == 1


BLOCK = """FUNCTION_BLOCK latch
VAR_INPUT set, reset : BOOL; END_VAR
VAR_OUTPUT q : BOOL; times : INT; END_VAR
RUNG { [set] | [q] } [/reset] (q)
RUNG [P q] <ADD(IN1 := times, IN2 := 1, OUT => times)>
END_FUNCTION_BLOCK
FUNCTION twice : INT
VAR_INPUT x : INT; END_VAR
RUNG <MUL(IN1 := x, IN2 := 2, OUT => twice)>
END_FUNCTION
"""


def test_blocks_and_functions_of_the_project() -> None:
    machine = oracle("RUNG [a0] <one: latch(reset := a1, times => i0)> (q0)\nRUNG [twice(i0) = 2] (q1)",
                     DECLARATIONS + "VAR one : latch; END_VAR\n", BLOCK)
    assert scans(machine, "a0", [True, False]) == [True, True]
    assert machine.get("i0") == 1 and machine.get("one.times") == 1 and machine.get("q1") is True
    assert scans(machine, "a1", [True, False]) == [False, False]


def test_places() -> None:
    machine = oracle(
        "RUNG [many[i0]] (many[i0 + 1]) (flags.3)\nRUNG [%IX2.1] (q0)\nRUNG <MOVE(IN := level, OUT => copy)>",
        DECLARATIONS + "VAR many : ARRAY [1..3] OF BOOL; flags : WORD; END_VAR\n"
        "VAR level AT %IW4 : INT; copy AT %QW1 : INT; END_VAR\n")
    machine.set("i0", 1)
    machine.set("many[1]", True)
    machine.set("%IX2.1", True)
    machine.set("level", -2)
    machine.scan(0)
    assert machine.get("many[2]") is True and machine.get("flags") == 8 and machine.get("q0") is True
    assert machine.get("copy") == -2 and bytes(machine.image["Q"][2:4]) == b"\xfe\xff"
    machine.set("i0", 3)
    with pytest.raises(Fault, match="index 4 is outside 1..3"):
        machine.scan(0)


# -- the engines


WATCHED = [*(f"q{n}" for n in range(4)), *(f"u{n}.CV" for n in range(10)), *(f"t{n}.ET" for n in range(10)),
           *(f"u{n}.QD" for n in range(10))]


def same_trace(text: str, seed: int, count: int = 12, watched: Sequence[str] = WATCHED) -> None:
    random = Random(seed)
    for depth in (None, 1):
        made = compiled(text, max_paren_depth=depth)
        assert not made.diagnostics.has_errors, [f"{d.code} {d.message}" for d in made.diagnostics]
        slow, fast = reference(made), Machine(made.program, period_ns=300 * MS)
        for scan in range(count):
            for n in range(6):
                value = random.random() < 0.5
                slow.set(f"a{n}", value)
                fast.set(f"a{n}", value)
            for n in range(2):
                value = random.randint(-1, 2)
                slow.set(f"i{n}", value)
                fast.set(f"i{n}", value)
            slow.scan(scan * 300 * MS)
            fast.scan()
            assert not fast.faults
            for path in watched:
                seen = fast.get(path)
                assert slow.get(path) == seen, f"{path} in scan {scan}"


@settings(max_examples=60, deadline=None)
@given(st.lists(texts(loops=True), min_size=1, max_size=3), st.integers())
def test_virtual_machine_does_what_the_drawing_says(rungs: list[str], seed: int) -> None:
    fine = [text for text in rungs if drawn(text)[0] is not None]
    body = "\n".join(f"RUNG\n{text}" for text in fine)
    same_trace(f"PROGRAM main\n{DECLARATIONS}{body}\nEND_PROGRAM\n", seed)


FUNCTIONS = """VAR x, y : INT; d : DINT; w : WORD; sum : REAL; many : ARRAY [0..3] OF INT; END_VAR
RUNG [a0] <ADD(IN1 := i0, IN2 := i1, OUT => x)> <DIV(IN1 := x, IN2 := i0, OUT => y)> (q0)
RUNG [a1] <MOVE(IN := x, OUT => @v)> (q1); [a2] <MUL(IN1 := @v, IN2 := 3) out=_>; <MOVE(IN := @v, OUT => d)>
RUNG [a3] <GT(IN1 := x, IN2 := y) out=OUT> (q2)
RUNG [a4] <SEL(G := { [a0] | [a1] }, IN0 := x, IN1 := y, OUT => many[2])> (q3)
RUNG [many[2] > 1] [a5] <SHL(IN := w, N := 1, OUT => w)> (S w.0)
RUNG [P a0] >>last
RUNG [a1] <ADD(IN1 := sum, IN2 := 0.1, OUT => sum)>
RUNG last [a2] <MOVE(IN := d, OUT => d)> (P q0)
"""


def test_virtual_machine_agrees_on_functions() -> None:
    for seed in range(5):
        same_trace(f"PROGRAM main\n{DECLARATIONS}{FUNCTIONS}END_PROGRAM\n", seed, 30,
                   ["q0", "q1", "q2", "q3", "x", "y", "d", "w", "sum", "many[2]"])
