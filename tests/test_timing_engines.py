"""Tasks that take virtual time: vm and native give the same order of pieces, events, figures and values."""

from __future__ import annotations

import random

import native
from hypothesis import given, settings
from hypothesis import strategies as st
from il_build import program, simple, unit, var

from ldc.expr import Place
from ldc.il.flat import flatten
from ldc.il.pieces import pieces
from ldc.il.program import Program, Run, Task
from ldc.types import BOOL, INT, TIME, Array, Instance
from runtime.cost import Cost
from runtime.machine import Machine
from runtime.timing import Timing
from runtime.vm.paced import Machine as PacedMachine

pytestmark = native.needs_gcc

MS = 1_000_000
GO = Place("%IX0.0", BOOL, is_global=True)
EMPTY = ""


def both(source: Program, cost: Cost, period_ns: int | None = None) -> tuple[Machine, Machine]:
    return PacedMachine(source, period_ns=period_ns, cost=cost), native.paced_machine(source, cost, period_ns)


def executed(machine: Machine, **values: object) -> list[int]:
    """What each piece of one execution of the first task cost."""
    for name, value in values.items():
        machine.set(name, value)
    schedule = machine.begin()[0]
    found = list(machine.pieces(schedule))
    machine.end()
    return found


def same_pieces(source: Program, cost: Cost, *scans: dict[str, object]) -> list[list[int]]:
    machines = both(source, cost)
    found = [[executed(machine, **values) for values in scans] for machine in machines]
    assert found[0] == found[1] and machines[0].checksum() == machines[1].checksum()
    assert machines[0].faults == machines[1].faults
    return found[0]


# ---- what is a piece, and what it costs

def test_a_rung_that_begins_with_what_another_left_is_a_piece_with_it() -> None:
    """Its instructions count too."""
    source = simple([var("a"), var("b"), var("n", INT)], "LD a", "ST b; LD n", "ADD 1; ST n", "LD n; ST n")
    assert same_pieces(source, Cost(instruction=1), {}, {"a": True}) == [[5, 2]] * 2
    assert pieces(flatten(source.unit("main"))).rungs == (0, 3)


def test_rungs_without_code_are_no_pieces_and_rungs_without_statements_are() -> None:
    source = simple([var("a"), var("n", INT)], EMPTY, "LD n; ADD 1; ST n", EMPTY, "LD a", EMPTY)
    assert same_pieces(source, Cost(instruction=7), {}, {}) == [[21, 7]] * 2
    assert same_pieces(simple([var("a")]), Cost(instruction=5), {}) == [[0]]
    assert same_pieces(simple([var("a")], EMPTY, EMPTY), Cost(instruction=5), {}) == [[0]]


def test_a_jump_back_to_another_rung_costs_what_is_executed_again() -> None:
    """Each piece once for each time, and not a second time as a pass of the loop."""
    source = simple([var("n", INT)], ("r0", "LD 0; ST n"), ("r1", "LD n; ADD 1; ST n", "again"), "LD n; ST n",
                    ("r3", "LD n; LT 3; JMPC again"), "LD n; ST n")
    assert same_pieces(source, Cost(instruction=1), {}) == [[2] + [3, 2, 3] * 3 + [2]]


def test_a_jump_into_the_middle_of_another_rung_begins_a_piece() -> None:
    rungs = ("LD a; JMPC middle", "LD n; ADD 1; ST n; LABEL middle; LD n; ADD 10; ST n", "LD n; ST n")
    source = simple([var("a"), var("n", INT)], *rungs)
    assert same_pieces(source, Cost(instruction=1), {}, {"a": True}) == [[2, 6, 2], [2, 6, 2]]


def test_passes_of_loops_in_rungs_blocks_and_functions_cost_when_they_are_made() -> None:
    loop = "LABEL again; LD n; ADD 1; ST n; LT most; JMPC again"
    inside = [var("n", INT), var("most", INT, kind="input")]
    block = unit("FUNCTION_BLOCK", "spin", inside, "LD 0; ST n", loop)
    names = [var("n", INT), var("most", INT), var("s", Instance("spin"))]
    main = unit("PROGRAM", "main", names, "LD 0; ST n", loop, "LD most; ST s.most; CAL s", units=[block])
    found = same_pieces(program(block, main), Cost(instruction=1, call=100), {}, {"most": 3}, {"most": 1})
    assert found == [[2, 5, 109], [2, 15, 119], [2, 5, 109]]


def test_temporaries_live_through_all_pieces_of_an_execution_and_begin_anew_in_the_next() -> None:
    """One that only one rung of two writes lives in the frame of the execution."""
    names = [var("a"), var("n", INT), var("t", INT, kind="temp", initial=7)]
    source = simple(names, "LD a; JMPCN over", "LD 3; ST t", ("r2", "LD t; ST n", "over"))
    one, two = both(source, Cost(instruction=1))
    for machine in (one, two):
        assert executed(machine, a=False) == [2, 2] and machine.get("n") == 7
        assert executed(machine, a=True) == [2, 2, 2] and machine.get("n") == 3
        assert executed(machine, a=False) == [2, 2] and machine.get("n") == 7


def test_backward_jumps_are_counted_through_all_pieces_of_a_task() -> None:
    loop = "LABEL again; LD n; ADD 1; ST n; LD TRUE; LD n; LT 10; JMPC again"
    tasks = (Task("main", watchdog=15),)
    source = simple([var("n", INT)], "LD 0; ST n", loop, "LD 0; ST n", loop, tasks=tasks)
    (found,) = same_pieces(source, Cost(instruction=1), {})
    assert found == [2, 70, 2, 0], "the watchdog comes in the second loop"


def test_the_first_scan_of_one_task_is_not_that_of_another_which_begins_later() -> None:
    """The slow task is still in its first execution, for which FIRST_SCAN is TRUE, when others begin."""
    slow = unit("PROGRAM", "slow", [var("n", INT)], *["LD n; ADD 1; ST n"] * 6)
    quick = unit("PROGRAM", "quick", [var("f"), var("n", INT)], "LD %FIRST_SCAN; ST f; LD n; ADD 1; ST n")
    source = program(slow, quick, tasks=(Task("s", 100 * MS, 5), Task("q", 10 * MS, 1)),
                     runs=(Run("slow", "slow", "s"), Run("quick", "quick", "q")))
    for machine in both(source, Cost(instruction=MS)):
        timing, seen = Timing(machine), []
        for _ in range(5):
            timing.scan()
            seen.append(machine.get("quick.f"))
        assert seen == [True, False, False, False, False]


# ---- random programs of several tasks

def random_rungs(chance: random.Random, number: int) -> list:
    """Rungs that look at what other tasks do, jump in both directions, loop, call, and may fault."""
    count = chance.randint(0, 12) if number else chance.randint(1, 3)
    rungs = []
    for k in range(count):
        label = f"l{number}_{k}" if chance.random() < 0.4 else None
        pick = chance.random()
        code = "LD all; MUL 3; ADD {k}; ST all"
        if pick < 0.15 and k + 1 < count:
            code = f"LD go; {chance.choice(['JMPC', 'JMPCN'])} m{number}_{chance.randint(k + 1, count - 1)}"
        elif pick < 0.25:
            code = f"LD left; SUB 1; ST left; GT 0; JMPC m{number}_{chance.randint(0, k)}"
        elif pick < 0.4:
            code = f"LD 0; ST n; LABEL w{k}; LD n; ADD 1; ST n; LT left; JMPC w{k}; LD n; ADD all; ST all"
        elif pick < 0.5:
            code = "LD all; ST block.a; CAL block; LD block.q; ST all"
        elif pick < 0.6:
            code = "LD %NOW; ST seen; LD %FIRST_SCAN; ST first"
        elif pick < 0.64:
            code = "LD go; RETC"
        elif pick < 0.65:
            code = "LD 100; DIV all; ST n"
        elif pick < 0.66:
            code = "LD list[n]; ADD 1; ST list[1]"
        elif pick < 0.85:
            code = f"LD go; JMPCN e{k}; LD {k + 5}; ST t; LABEL e{k}; LD t; ADD all; ST all"
        rungs.append([f"r{k}", f"LABEL m{number}_{k}; " + code.format(k=k), label])
    return [tuple(rung) for rung in rungs]


def random_program(chance: random.Random) -> Program:
    loop = "LD 0; ST i; LABEL w; LD i; ADD 1; ST i; LT 3; JMPC w"
    inside = [var("a", INT, kind="input"), var("q", INT, kind="output"), var("i", INT)]
    block = unit("FUNCTION_BLOCK", "mix", inside, loop, "LD q; ADD a; ADD i; ST q")
    units, runs, tasks = [block], [], []
    for number in range(chance.randint(2, 3)):
        names = [var("go", BOOL, at="%IX0.0"), var("all", INT, at="%MW0"), var("left", INT, initial=4),
                 var("n", INT), var("seen", TIME), var("first"), var("block", Instance("mix")),
                 var("list", Array(((0, 3),), INT)), var("t", INT, kind="temp", initial=2)]
        units.append(unit("PROGRAM", f"p{number}", names, *random_rungs(chance, number), units=[block]))
        runs.append(Run(f"p{number}", f"p{number}", f"t{number}"))
        interval = chance.choice([None, 20 * MS, 40 * MS]) if number else 10 * MS
        tasks.append(Task(f"t{number}", interval, chance.randint(1, 3) if number else chance.randint(0, 1),
                          GO if chance.random() < 0.2 else None, watchdog=chance.choice([30, 1000, 1000])))
    return program(*units, tasks=tuple(tasks), runs=tuple(runs))


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2 ** 32), st.sampled_from([0, 100_000, 300_000, MS]))
def test_random_tasks_pre_empt_each_other_alike_on_both_engines(seed: int, instruction: int) -> None:
    chance = random.Random(seed)
    source = random_program(chance)
    cost = Cost(instruction=instruction, arithmetic=instruction * 2, call=7, task=11)
    logs: tuple[list, list] = [], []
    timings = [Timing(machine, {"T0": 25 * MS}, log)
               for machine, log in zip(both(source, cost, 10 * MS), logs, strict=True)]
    one, two = (timing.machine for timing in timings)
    for _ in range(8):
        value = chance.random() < 0.5
        for timing in timings:
            timing.machine.set("p0.go", value)
            timing.scan()
        assert [one.get(path) for path, _ in one.paths()] == [two.get(path) for path, _ in one.paths()]
        assert one.checksum() == two.checksum()
    assert logs[0] == logs[1]
    assert timings[0].rows() == timings[1].rows()
    assert one.faults == two.faults
