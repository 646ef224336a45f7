"""Compiled ladder on the virtual machine does what the drawings say: held to the oracle, scan by scan."""

from __future__ import annotations

from random import Random

import pytest
import strategies
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from reference import ReferenceMachine

from ldc import pipeline
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile
from ldc.types import BOOL
from runtime.vm.machine import Machine

MS = 1_000_000
PLANT = """
TYPE point : STRUCT x : INT; lit : BOOL; END_STRUCT; END_TYPE

FUNCTION half : INT
VAR_INPUT n : INT; END_VAR
VAR_OUTPUT odd : BOOL; END_VAR
RUNG [n MOD 2 <> 0] (odd)
RUNG <DIV(IN1 := n, IN2 := 2, OUT => half)>
END_FUNCTION

FUNCTION_BLOCK pulse
VAR_INPUT go : BOOL; limit : INT := 3; END_VAR
VAR_OUTPUT out : BOOL; n : INT; END_VAR
VAR edge : R_TRIG; END_VAR
RUNG [go] <edge: R_TRIG()> <ADD(IN1 := n, IN2 := 1, OUT => n)>
RUNG [n >= limit] (out) <MOVE(IN := 0, OUT => n)>
END_FUNCTION_BLOCK

PROGRAM main
VAR
    a AT %IX0.0 : BOOL; b AT %IX0.1 : BOOL; c AT %IX0.2 : BOOL; d AT %IX0.3 : BOOL; level AT %IW1 : INT;
    q AT %QX0.0 : BOOL; r AT %QX0.1 : BOOL; s AT %QX0.2 : BOOL; u AT %QX0.3 : BOOL; speed AT %QW1 : INT;
    on_delay : TON; off_delay : TOF; one : TP; up : CTU; both : CTUD; fall : F_TRIG; latch : SR; p : pulse;
    rows : ARRAY [0..3] OF INT; spot : point; i : INT; odd : BOOL; ok : BOOL; real_ : REAL;
END_VAR
RUNG { [a] | [q] } [/b] (q)
RUNG [a] <on_delay: TON(PT := T#30ms)> { (r) | [P b] (S s) | [N c] (R s) }
RUNG [c] <off_delay: TOF(PT := T#25ms)> [d] <one: TP(PT := T#40ms)> (/u)
RUNG [P a] <up: CTU(R := { [d] | [b] [c] }, PV := 3, CV => i)> (ok)
RUNG [a] <both: CTUD(CD := b, R := c, LD := d, PV := 2)> (P r)
RUNG { [a] @x [b] | [c] @y [d] } (spot.lit); @x [/s] @y
RUNG [level <> 0] [100 / level > 3] <p: pulse(limit := 2)> (ok)
RUNG [c] <half(n := level, odd => odd, OUT => speed)> (N s)
RUNG skip [d] [/a] >>after
RUNG [level >= 0] [level < 4] <MOVE(IN := level + 1, OUT => rows[level])> (spot.lit)
RUNG <DIV(IN1 := 12, IN2 := rows[1], OUT => spot.x)> (ok)
RUNG after <latch: SR(R := b)> { (u)
    | [latch.Q1] [/c] <MUL(IN1 := REAL#1.1, IN2 := INT_TO_REAL(level), OUT => real_)> }
RUNG [a] [b] [c] >>RETURN
RUNG [d] <fall: F_TRIG()> (S q)
END_PROGRAM
"""


def built(text: str) -> pipeline.Compiled:
    result = pipeline.compile_project(
        Sources((SourceFile("main.ld", text),), Settings(), None), pipeline.Options(verify=False)
    )
    errors = [f"{d.code} {d.message}" for d in result.diagnostics if d.severity == "error"]
    assert all(e.startswith("LD03") for e in errors), errors
    return result


def held(result: pipeline.Compiled, random: Random, scans: int) -> None:
    """Random inputs for some scans; all variables but the compiler's must agree after each."""
    machine = Machine(result.program, period_ns=10 * MS)
    graphs = {pou: [b.graph for b in builds] for pou, builds in result.units.items()}
    oracle = ReferenceMachine(result.model, graphs)
    inputs = [s for s in machine.symbols.all() if s.area == "I"]
    compared = [path for path, _ in machine.paths() if not of_standard_block(path, oracle)]
    for scan in range(scans):
        for symbol in inputs:
            value = random.random() < 0.5 if symbol.type == BOOL else random.randint(-1, 6)
            machine.set(symbol.path, value)
            oracle.set(symbol.path, value)
        machine.scan()
        oracle.scan(scan * 10 * MS)
        assert not machine.faults
        assert {p: machine.get(p) for p in compared} == {p: oracle.get(p) for p in compared}, f"scan {scan}"


def of_standard_block(path: str, oracle: ReferenceMachine) -> bool:
    """Whether a standard block keeps the variable inside, where its model has something else."""
    try:
        oracle.get(path)
    except (LookupError, AttributeError):
        assert path.count(".") > 1, path
        return True
    return False


@settings(max_examples=120, deadline=None)
@given(strategies.programs(), st.integers(0, 2**32))
def test_random_ladder(text: str, seed: int) -> None:
    result = built(text)
    assume(result.program is not None)
    held(result, Random(seed), 12)


PLANT_BUILT: list[pipeline.Compiled] = []


@pytest.mark.parametrize("seed", range(8))
def test_blocks_functions_jumps_and_bridges(seed: int) -> None:
    if not PLANT_BUILT:
        PLANT_BUILT.append(built(PLANT))
    held(PLANT_BUILT[0], Random(seed), 150)
