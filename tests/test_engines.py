"""Random programs: the VM, the stepping mode and the IL read back do what the drawing means.

The reference interprets the drawings (tests/reference.py); traces of all visible variables must agree
scan by scan, over inputs and times drawn at random.
"""

from __future__ import annotations

import math

import strategies
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from reference import Fault, ReferenceMachine

from ldc import pipeline
from ldc.il import text as il_text
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile
from runtime.cost import Cost
from runtime.vm.machine import Machine
from runtime.vm.paced import Machine as PacedMachine
from runtime.vm.stepping import Stepper

PERIOD = 10_000_000


def compiled(text: str, path: str = "random.ld", **options) -> pipeline.Compiled:
    sources = Sources((SourceFile(path, text),), Settings(), None)
    result = pipeline.compile_project(sources, pipeline.Options(**options))
    # A drawing at random may have contacts that lead nowhere.
    assume(not any(d.code in ("LD0304", "LD0305") for d in result.diagnostics))
    assert not result.diagnostics.has_errors, (text, [f"{d.code} {d.message}" for d in result.diagnostics])
    return result



def same(a, b) -> bool:
    if isinstance(a, float) and isinstance(b, float) and math.isnan(a):
        return math.isnan(b)
    return type(a) is type(b) and a == b


def compare(text: str, stimuli: list[dict[str, object]]) -> None:
    """Runs all engines side by side and compares every variable after every scan."""
    result = compiled(text)
    read_back = compiled(il_text.print_program(result.program), "random.il").program
    shallow = compiled(text, max_paren_depth=0, verify=False).program
    reference = ReferenceMachine(result.model, {n: [b.graph for b in bs] for n, bs in result.units.items()})
    machines = {"vm": Machine(result.program, period_ns=PERIOD), "read back": Machine(read_back, period_ns=PERIOD),
                "depth 0": Machine(shallow, period_ns=PERIOD),
                "pieces": PacedMachine(result.program, period_ns=PERIOD, cost=Cost(instruction=50))}
    stepped = Machine(result.program, period_ns=PERIOD)
    scans = {name: machine.scan for name, machine in machines.items()} | {"stepping": Stepper(stepped).scan}
    machines["stepping"] = stepped
    names = [path.partition(".")[2] for path, _ in machines["vm"].paths() if path.count(".") == 1]
    for number, values in enumerate(stimuli):
        for path, value in values.items():
            reference.set(path, value)
            for machine in machines.values():
                machine.set(path, value)
        try:
            reference.scan(number * PERIOD)
        except Fault:
            for name, scan in scans.items():
                scan()
                assert machines[name].faults, f"{name} has no fault in scan {number}\n{text}"
            return
        for name, scan in scans.items():
            scan()
            assert not machines[name].faults, (name, machines[name].faults, text)
            for path in names:
                expected, got = reference.get(path), machines[name].get(path)
                assert same(expected, got), f"{name}: {path} is {got!r}, not {expected!r} in scan {number}\n{text}"


BOOLS = [f"a{n}" for n in range(5)]
booleans = st.fixed_dictionaries({name: st.booleans() for name in strategies.inputs(6)})


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=120)
@given(strategies.programs(), st.lists(booleans, min_size=1, max_size=6))
def test_networks_of_contacts_and_coils(text: str, stimuli: list) -> None:
    compare(text, stimuli)


# ---- programs with blocks, values, expressions and jumps, as text

DECLARATIONS = """PROGRAM main
VAR
    a0, a1, a2, a3, a4, q0, q1, q2, q3 : BOOL;
    i0, i1, i2 : INT; d0 : DINT; r0, r1 : REAL; w0 : WORD; s0 : SINT; u0 : USINT;
    v : ARRAY [0..3] OF INT; g : ARRAY [1..4] OF BOOL;
    t0 : TON; t1 : TOF; t2 : TP; c0 : CTU; c1 : CTD; c2 : CTUD; b0 : SR; b1 : RS; e0 : R_TRIG; e1 : F_TRIG;
    m0 : MINE; m1 : MINE;
END_VAR
"""
MINE = """FUNCTION_BLOCK MINE
VAR_INPUT go : BOOL; inc : INT := 2; END_VAR
VAR_OUTPUT hit : BOOL; sum : INT; END_VAR
VAR inner : TON; END_VAR
RUNG [P go] <ADD(IN1 := sum, IN2 := inc, OUT => sum)>
RUNG [go] <inner: TON(PT := T#20ms)> { [sum > 3] | [N go] } (hit)
END_FUNCTION_BLOCK

FUNCTION TWICE : INT
VAR_INPUT x : INT; up : BOOL; END_VAR
VAR_OUTPUT big : BOOL; END_VAR
RUNG [up] <MUL(IN1 := x, IN2 := 2, OUT => TWICE)>
RUNG [/up] <MOVE(IN := x, OUT => TWICE)>
RUNG [TWICE > 100] (big)
END_FUNCTION

"""

bit = st.sampled_from([*BOOLS, "q0", "q1", "q2", "g[1]", "g[2]", "w0.3", "t0.Q", "c0.Q", "m0.hit"])
target = st.sampled_from(["q0", "q1", "q2", "q3", "g[1]", "g[2]", "w0.3", "a4"])
integer = st.sampled_from(["i0", "i1", "i2", "v[0]", "v[1]", "c0.CV", "m0.sum", "3", "-7", "100"])
number = st.recursive(integer, lambda x: st.builds("({} {} {})".format, x, st.sampled_from("+-*"), x)
                      | st.builds("LIMIT(-5, {}, 60)".format, x) | st.builds("MAX({}, {})".format, x, x)
                      | st.builds("SEL({}, {}, {})".format, bit, x, x) | st.builds("TWICE({}, {})".format, x, bit),
                      max_leaves=4)
faulty = st.builds("({} / {})".format, integer, integer) | st.builds("({} MOD {})".format, integer, integer) | \
    st.builds("v[{}]".format, integer.filter(lambda t: not t.lstrip("-").isdigit()))
condition = st.builds("{} {} {}".format, number, st.sampled_from(["<", ">", "=", "<>", ">=", "<="]), number) | \
    st.builds("{} {} {}".format, bit, st.sampled_from(["AND", "OR", "XOR"]), bit) | \
    st.builds("r0 {} r1".format, st.sampled_from("<>")) | st.builds("{} > 2".format, faulty)
contact = st.builds("[{}{}]".format, st.sampled_from(["", "", "/", "P ", "N "]), bit) | condition.map("[{}]".format)
coil = st.builds("({}{})".format, st.sampled_from(["", "", "/", "S ", "R ", "P ", "N "]), target)
network = st.recursive(contact, lambda x: st.lists(x, min_size=1, max_size=3).map(" ".join)
                       | st.lists(x, min_size=1, max_size=3).map(lambda p: "{ " + " | ".join(p) + " }"), max_leaves=5)
pin = network.map("{{ {} }}".format)
time = st.sampled_from(["T#0s", "T#10ms", "T#25ms", "T#40ms"])
block = (
    st.builds("<{}(PT := {})>".format, st.sampled_from(["t0: TON", "t1: TOF", "t2: TP"]), time)
    | st.builds("<c0: CTU(R := {}, PV := {}, CV => {})>".format, pin, number, st.sampled_from(["i0", "d0", "v[2]"]))
    | st.builds("<c1: CTD(LD := {}, PV := 3)>".format, pin)
    | st.builds("<c2: CTUD(CD := {}, R := {}, PV := 2, QD => {})>".format, pin, bit, target)
    | st.builds("<b0: SR(R := {})>".format, pin) | st.builds("<b1: RS(R1 := {})>".format, bit)
    | st.sampled_from(["<e0: R_TRIG()>", "<e1: F_TRIG()>"])
    | st.builds("<{}: MINE(inc := {}, sum => {})>".format, st.sampled_from(["m0", "m1"]), number,
                st.sampled_from(["i1", "d0"]))
    | st.builds("<MOVE(IN := {}, OUT => {})>".format, number, st.sampled_from(["i0", "i1", "v[1]", "d0"]))
    | st.builds("<{}(IN1 := {}, IN2 := {}, OUT => {})>".format, st.sampled_from(["ADD", "SUB", "MUL", "DIV", "MOD"]),
                number, number, st.sampled_from(["i0", "i2", "v[0]"]))
    | st.builds("<DIV(IN1 := r0, IN2 := r1, OUT => r0, ENO => {})>".format, target)
    | st.builds("<SHL(IN := w0, N := {}, OUT => w0)>".format, st.sampled_from(["1", "3", "i0"]))
    | st.builds("<INT_TO_SINT(IN := {}, OUT => s0)>".format, number)
    | st.builds("<INT_TO_REAL(IN := {}, OUT => {})>".format, number, st.sampled_from(["r0", "r1"]))
    | st.builds("<TWICE(x := {}, up := {}, big => {}, OUT => i2)>".format, number, bit, target)
    | st.builds("<GT(IN1 := {}, IN2 := {}) out=OUT>".format, number, number)
    | st.builds("<AND(IN2 := {}) in=IN1 out=OUT>".format, bit))
element = network | network | coil | block
series = st.lists(element, min_size=1, max_size=4).map(" ".join)
split = st.builds("{} {{ {} {} | {} {} }}".format, series, series, coil, series, coil)
junctions = st.builds("{} @x {} {};\n    {} @y {};\n    @x {} @y".format, network, element, coil, network, coil, network)
loop = st.builds("{} @x <t0: TON(PT := {})> @y {};\n    @y {} @x".format, network, time, coil, network)
values = st.builds("{} <ADD(IN1 := {}, IN2 := i0, OUT => @s)> <MOVE(IN := @s, OUT => i1)> {}".format, network, integer, coil)
skip = st.builds("{} {} >>last".format, network, coil)
rungs = st.lists(st.builds("{} {}".format, series, coil) | split | junctions | loop | values | skip, min_size=1, max_size=4)
changes = st.fixed_dictionaries({name: st.booleans() for name in BOOLS}, optional={
    "i0": st.integers(-300, 300), "i1": st.integers(-32768, 32767), "r0": st.sampled_from([0.0, 1.5, -2.25, 2.0**127]),
    "r1": st.sampled_from([0.0, 0.125, 7.0]), "w0": st.integers(0, 65535)})


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=150)
@given(rungs, st.lists(changes, min_size=1, max_size=6))
def test_blocks_values_and_jumps(lines: list[str], stimuli: list) -> None:
    body = "".join(f"RUNG r{n}\n    {line}\n" for n, line in enumerate(lines))
    compare(f"{MINE}{DECLARATIONS}{body}RUNG last [a0] (q3)\nEND_PROGRAM\n", stimuli)
