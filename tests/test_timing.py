"""Tasks that take virtual time: costs of rungs, pre-emption, watchdogs, figures of `ldc run`."""

from __future__ import annotations

import csv
import io
import shutil
from pathlib import Path

import native
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from il_build import program, simple, unit, var

from ldc.cli.main import main
from ldc.expr import Place
from ldc.il.program import Run, Task
from ldc.types import BOOL, INT, TIME, Instance
from runtime.cost import Cost, Costs
from runtime.timing import Timing
from runtime.vm.machine import Machine
from runtime.vm.paced import Machine as PacedMachine

MS = 1_000_000
SAMPLES = Path(__file__).resolve().parent.parent / "samples"
GO = Place("%IX0.0", BOOL, is_global=True)


def timed(source, cost: Cost, watchdogs=None, log=None, **options) -> Timing:
    return Timing(PacedMachine(source, cost=cost, **options), watchdogs, log)


def costs(source, cost: Cost) -> list[int]:
    """What each piece of the first task costs."""
    machine = PacedMachine(source, cost=cost)
    (schedule,) = machine.begin()
    return list(machine.pieces(schedule))


# ---- what a rung costs

def test_instructions_cost_by_their_group_and_calls_with_what_they_call() -> None:
    block = unit("FUNCTION_BLOCK", "inv", [var("a", kind="input"), var("q", kind="output")], "LDN a; ST q")
    main_ = unit("PROGRAM", "main", [var("i", Instance("inv")), var("n", INT), var("b")],
                 "LD n; ADD 1; ST n", "LD n; GT 3; ST b", "LD n; FN ABS:INT; ST n", "CAL i", units=[block])
    cost = Cost(instruction=1, arithmetic=10, comparison=100, function=1000, call=10_000, task=100_000)
    assert costs(program(block, main_), cost) == [100_012, 102, 1002, 10_002]
    assert costs(program(block, main_), Cost(instruction=2)) == [6, 6, 6, 6]


def test_a_further_pass_of_a_loop_costs_when_it_is_made() -> None:
    count = "count", "LD n; ADD 1; ST n; LT most; JMPC count", "count"
    source = simple([var("n", INT), var("most", INT)], count, "LD 0; ST n")
    machine = PacedMachine(source, cost=Cost(instruction=10))
    for most, passes in ((0, 1), (5, 5), (2, 2)):
        machine.set("most", most)
        (schedule,) = machine.begin()
        assert list(machine.pieces(schedule)) == [50 * passes, 20]
        machine.end()


def test_rungs_that_are_jumped_over_cost_nothing_and_a_return_ends_the_task() -> None:
    names = [var("a"), var("b"), var("n", INT)]
    source = simple(names, "LD a; JMPC last", "LD n; ADD 1; ST n", "LD b; RETC", ("r3", "LD n; ST n", "last"),
                    "LD n; ADD 1; ST n; ADD 1; ST n")
    machine = PacedMachine(source, cost=Cost(instruction=1))

    def pieces() -> list[int]:
        (schedule,) = machine.begin()
        return list(machine.pieces(schedule))

    assert pieces() == [2, 3, 2, 2, 5]
    machine.set("a", True)
    assert pieces() == [2, 2, 5]
    machine.set("a", False), machine.set("b", True)
    assert pieces() == [2, 3, 2]


def test_an_empty_program_is_a_piece_without_cost() -> None:
    assert costs(simple([var("a")]), Cost(instruction=5)) == [0]


def test_costs_of_many_loops_are_found_in_linear_time() -> None:
    loop = "LD n; ADD 1; ST n; LT 0; JMPC {0}"
    rungs = [(f"r{k}", loop.format(f"l{k}"), f"l{k}") for k in range(500)]
    assert sum(costs(simple([var("n", INT)], *rungs), Cost(instruction=1))) == 2500


# ---- tasks that pre-empt each other

def preempting():
    """A fast task that counts, and a slow one whose rungs look at the count and at the time."""
    fast = unit("PROGRAM", "fast", [var("n", INT, at="%MW0")], "LD n; ADD 1; ST n")
    looks = [f"LD n; ST n{k}; LD %NOW; ST t{k}; LD %FIRST_SCAN; ST f{k}" for k in range(4)]
    seen = [var(f"{name}{k}", type_) for name, type_ in (("n", INT), ("t", TIME), ("f", BOOL)) for k in range(4)]
    slow = unit("PROGRAM", "slow", [var("n", INT, at="%MW0"), *seen], *looks)
    tasks = (Task("quick", 10 * MS, 0), Task("idle", 40 * MS, 5))
    return program(fast, slow, tasks=tasks, runs=(Run("fast", "fast", "quick"), Run("slow", "slow", "idle")))


def test_a_task_of_higher_priority_executes_between_two_rungs() -> None:
    log: list = []
    timing = timed(preempting(), Cost(instruction=1 * MS), log=log)
    for _ in range(4):
        timing.scan()
    machine = timing.machine
    # Ticks at 0, 10, 20, 30; fast takes 3 ms, a rung of slow 6: rungs begin at 3, 9, 18 (fast was at 15), 27.
    assert [machine.get(f"slow.n{k}") for k in range(4)] == [1, 1, 2, 3]
    assert {machine.value(machine.symbols.find(f"slow.t{k}")) for k in range(4)} == {3 * MS}
    assert all(machine.get(f"slow.f{k}") for k in range(4)), "still its first execution"
    said = [(e.time_ns // MS, e.what) for e in log if e.thread == "idle"]
    assert said == [(3, "began"), (15, "preempted"), (18, "resumed"), (24, "preempted"), (27, "resumed"),
                    (33, "ended")]


def test_the_figures_of_the_tasks() -> None:
    timing = timed(preempting(), Cost(instruction=1 * MS))
    for _ in range(40):
        timing.scan()
    quick, idle = timing.rows()
    assert (quick.task, quick.executions, quick.missed, quick.utilisation_percent) == ("quick", 40, 0, 30.0)
    assert (idle.executions, idle.preemptions, idle.response_worst_us) == (10, 20, 33000)
    assert idle.utilisation_percent == 60.0


INTERVALS = st.sampled_from([None, 10 * MS, 20 * MS, 30 * MS])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(INTERVALS, st.integers(0, 2), st.booleans()), min_size=1, max_size=4),
       st.lists(st.booleans(), min_size=1, max_size=8), st.sampled_from([0, 1, 1000]))
def test_tasks_in_time_do_what_they_do_at_once(drawn, inputs, cost) -> None:
    """In every scan all variables are those of the machine that takes no time, also after an overflow."""
    go = var("go", BOOL, at="%IX0.0")
    units, runs, tasks = [], [], []
    for k, (interval, priority, single) in enumerate(drawn):
        names = [go, var("all", INT, at="%MW0"), var("n", INT), var("seen", INT)]
        units.append(unit("PROGRAM", f"p{k}", names, f"LD all; MUL 3; ADD {k}; ST all", "LD n; ADD 1; ST n",
                          "LD all; DIV n; ST seen"))
        runs.append(Run(f"p{k}", f"p{k}", f"t{k}"))
        tasks.append(Task(f"t{k}", interval, priority, GO if single else None))
    source = program(*units, tasks=tuple(tasks), runs=tuple(runs))
    plain = Machine(source, period_ns=10 * MS)
    timing = timed(source, Cost(instruction=cost), period_ns=10 * MS)
    for value in inputs:
        for machine in (plain, timing.machine):
            machine.set("p0.go", value)
        plain.scan()
        timing.scan()
        assert plain.checksum() == timing.machine.checksum()
        assert plain.now_ns == timing.machine.now_ns and plain.scans == timing.machine.scans


def test_a_task_by_an_edge_that_comes_while_it_executes_starts_once_more() -> None:
    count = unit("PROGRAM", "p", [var("n", INT), var("go", at="%IX0.0")], "LD n; ADD 1; ST n")
    source = program(count, tasks=(Task("t", None, 0, GO),), runs=(Run("p", "p", "t"),))
    timing = timed(source, Cost(instruction=10 * MS), period_ns=10 * MS)
    for value in (1, 0, 1, 0, 1, 0, 0, 0):
        timing.machine.set("go", value)
        timing.scan()
    (row,) = timing.rows()
    # Edges at 0, 20 and 40 ms, an execution takes 30 ms: the second waits until 30, the third until 60.
    assert (timing.machine.get("n"), row.executions, row.lost) == (3, 2, 0)


# ---- faults

def test_a_fault_between_two_preemptions_stops_its_task_alone() -> None:
    names = [var("n", INT), var("on", at="%QX0.0")]
    bad = unit("PROGRAM", "bad", names, "LD TRUE; ST on", "LD 1; DIV n; ST n")
    good = unit("PROGRAM", "good", [var("n", INT)], "LD n; ADD 1; ST n")
    source = program(bad, good, tasks=(Task("b", 20 * MS, 1), Task("g", 10 * MS, 0)),
                     runs=(Run("bad", "bad", "b"), Run("good", "good", "g")))
    timing = timed(source, Cost(instruction=MS))
    for _ in range(4):
        timing.scan()
    (fault,) = timing.machine.faults
    assert (fault.code, fault.task, str(fault.place)) == ("LD0801", "b", "bad, rung r1, instruction 1")
    assert timing.machine.get("good.n") == 4 and timing.machine.get("bad.on") is False


@pytest.mark.parametrize(("limit", "stopped"), [(30, False), (29, True), (11, True), (5, True)])
def test_a_task_that_takes_longer_than_its_watchdog_stops_at_the_next_rung(limit: int, stopped: bool) -> None:
    """It begins at 3 ms and ends at 33 ms, its rungs are over at 9, 15, 24 and 33 ms."""
    timing = timed(preempting(), Cost(instruction=MS), {"IDLE": limit * MS})
    for _ in range(8):
        timing.scan()
    assert [fault.code for fault in timing.machine.faults] == ["LD0831"] * stopped
    assert timing.machine.get("fast.n") == 8
    assert bool(timing.machine.get("slow.n3")) is (limit >= 29)


# ---- ldc run

PROJECT = {
    "ldc.toml": '[tasks.fast]\ninterval = "1ms"\nprograms = ["one"]\n'
                '[tasks.slow]\ninterval = "4ms"\npriority = 1\nprograms = ["two"]\n[cost]\ninstruction = "100us"\n',
    "main.ld": "PROGRAM one\nVAR a, b : BOOL; END_VAR\nRUNG [a] (b)\nEND_PROGRAM\n"
               "PROGRAM two\nVAR a, b, c, d, e, f : BOOL; END_VAR\n"
               + "".join(f"RUNG [a] [b] [c] ({q})\n" for q in "def") + "END_PROGRAM\n",
}


@pytest.fixture
def project(tmp_path: Path, monkeypatch) -> Path:
    for name, text in PROJECT.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_run_tells_what_tasks_took(project: Path, capsys) -> None:
    assert main(["run", ".", "--for", "8ms", "--watch", "one.a", "--timing", "t.csv"]) == 0
    rows = list(csv.DictReader(io.StringIO((project / "t.csv").read_text(encoding="utf-8"))))
    assert [row["task"] for row in rows] == ["fast", "slow"]
    assert {row["executions"] for row in rows} == {"8", "2"} and rows[0]["utilisation_percent"] == "20.0"
    assert rows[1]["preemptions"] == "2" and rows[1]["response_worst_us"] == "1600.0"
    assert "preempted" in capsys.readouterr().err


@native.needs_gcc
def test_the_same_run_is_the_same_file_on_both_engines(project: Path, capsys) -> None:
    shown = []
    for engine in ("vm", "vm", "native"):
        assert main(["run", ".", "--scans", "50", "--timing", "-", "--trace", "x.csv", "--engine", engine]) == 0
        shown.append((capsys.readouterr().out, Path("x.csv").read_bytes()))
    assert shown[0] == shown[1] == shown[2] and shown[0][0].startswith("processor,task,executions,")


@native.needs_gcc
@pytest.mark.parametrize(("cost", "overruns", "engine"), [("3us", 0, "vm"), ("20us", 30, "vm"),
                                                          ("20us", 30, "native")])
def test_a_master_with_slaves_takes_time_too(
        tmp_path: Path, monkeypatch, capfd, cost: str, overruns: int, engine: str) -> None:
    """A scan of about 840 instructions; in time the logic does what it does at once (slaves are told 3 ms later),
    else every other scan is missed, and the watchdog ends everything."""
    shutil.copytree(SAMPLES / "injection_machine", tmp_path / "machine")
    monkeypatch.chdir(tmp_path / "machine")
    assert main(["run", ".", "--scans", "60", "--trace", "before.csv"]) == 0
    with Path("ldc.toml").open("a", encoding="utf-8") as file:
        file.write(f'\n[cost]\ninstruction = "{cost}"\n')
    status = main(["run", ".", "--scans", "60", "--trace", "after.csv", "--timing", "t.csv", "--engine", engine])
    assert status == int(overruns > 0) and capfd.readouterr().err.count("LD0844") == status
    text = Path("t.csv").read_text(encoding="utf-8")
    rows = {row["task"]: row for row in csv.DictReader(io.StringIO(text)) if row["processor"] == "master"}
    assert int(rows["control"]["overruns"]) == int(rows["control"]["missed"]) == overruns
    before, after = (list(csv.DictReader(Path(name).read_text(encoding="utf-8").splitlines()))
                     for name in ("before.csv", "after.csv"))
    if not overruns:
        logic = [name for name in before[0] if "position" not in name]
        assert [[row[n] for n in logic] for row in before] == [[row[n] for n in logic] for row in after]
    else:
        assert {row["green"] for row in after[5:]} == {"0"}, "outputs are safe from the third miss on"
    assert len(after) == 60


def test_a_task_that_is_late_three_times_in_a_row_is_stopped_and_others_go_on() -> None:
    """R3 on a machine alone: 12 ms of rungs every 10 ms; at the third missed period its outputs are safe."""
    late = unit("PROGRAM", "late", [var("q", at="%QX0.0")], *["LD TRUE; ST q"] * 6)
    fine = unit("PROGRAM", "fine", [var("n", INT)], "LD n; ADD 1; ST n")
    tasks = (Task("slow", 10 * MS, 5), Task("quick", 100 * MS, 0))
    source = program(late, fine, tasks=tasks, runs=(Run("late", "late", "slow"), Run("fine", "fine", "quick")))
    timing = timed(source, Cost(instruction=1 * MS))
    lamps = []
    for _ in range(40):
        timing.scan()
        lamps.append(timing.machine.get("late.q"))
    (fault,) = timing.machine.faults
    assert (fault.code, fault.task) == ("LD0844", "slow")
    assert "3 periods of 10 ms missed in a row" in fault.message
    scan = fault.scan
    assert all(lamps[:scan]) and not any(lamps[scan:])
    assert timing.machine.get("fine.n") == 4


def test_timing_without_a_cost_is_refused(project: Path, capsys) -> None:
    (project / "ldc.toml").write_text("", encoding="utf-8")
    assert main(["run", ".", "--timing", "t.csv"]) == 2
    assert "[cost]" in capsys.readouterr().err and not (project / "t.csv").exists()


def test_wrong_costs_are_told_where_they_stand(project: Path, capsys) -> None:
    (project / "ldc.toml").write_text('[cost]\ninstruction = "0ns"\nrung = "1us"\n', encoding="utf-8")
    assert main(["run", "."]) == 1
    shown = capsys.readouterr().err
    assert "[LD0612]" in shown and "[LD0611]" in shown and "ldc.toml:2:15" in shown


def test_the_units_of_a_program_cost_what_their_rungs_cost() -> None:
    source = simple([var("a")], "LD a; ST a", "LD a")
    assert Costs(source, Cost(instruction=3)).rungs(source.unit("main")) == (6, 3)
