"""Online change: what becomes of values, of time, of faults; who may do what when (DESIGN section 7)."""

from __future__ import annotations

import io

import pytest

import native
from ldc.diagnostics import Diagnostics, Invalid
from ldc.source import SourceFile
from online_programs import loaded
from runtime.online.checks import Limits
from runtime.online.controller import Controller, Event, prepare
from runtime.stimuli import read
from runtime.trace import Trace

ENGINES = ["vm", pytest.param("native", marks=native.needs_gcc)]


def program(variables: str, *rungs: str, before: str = "", after: str = "") -> str:
    body = "\n".join(f"RUNG r{n}\n{rung}" for n, rung in enumerate(rungs))
    return f"{before}\nPROGRAM main\nVAR\n{variables}\nEND_VAR\n{body}\nEND_PROGRAM\n{after}"


def begun(text: str, scans: int = 1, engine: str = "vm") -> Controller:
    controller = Controller(loaded(text, engine))
    for _ in range(scans):
        controller.scan()
    return controller


def staged(controller: Controller, text: str, owner: str = "me", limits: Limits = Limits()):
    old = controller.running
    engine = "native" if hasattr(old.machine, "native") else "vm"
    change = prepare(old, loaded(text, engine, old), old.digest, owner, limits)
    controller.stage(change)
    return change.plan


def codes(error: pytest.ExceptionInfo) -> list[str]:
    return [d.code for d in error.value.diagnostics]


def refusals(old: str, new: str, limits: Limits = Limits()) -> list[str]:
    with pytest.raises(Invalid) as error:
        staged(begun(old), new, limits=limits)
    return codes(error)


# ---- values ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ENGINES)
def test_members_of_blocks_structures_and_arrays_are_kept_one_by_one(engine: str) -> None:
    def text(member: str, size: int) -> str:
        before = (f"TYPE pair : STRUCT a : INT := 1; {member} END_STRUCT; END_TYPE\n"
                  f"FUNCTION_BLOCK sum\nVAR_INPUT run : BOOL; END_VAR\nVAR_OUTPUT q : BOOL; total : INT; {member} END_VAR\n"
                  "RUNG add\n[run] <ADD(IN1 := total, IN2 := 1, OUT => total)>\nEND_FUNCTION_BLOCK")
        return program(f"g : sum; p : pair; f : ARRAY[1..{size}] OF INT; deep : ARRAY[1..2] OF pair;",
                       "[TRUE] <g: sum()>", "[TRUE] <MOVE(IN := g.total, OUT => f[2])>",
                       "[TRUE] <MOVE(IN := g.total, OUT => p.a)>", "[TRUE] <MOVE(IN := g.total, OUT => deep[2].a)>",
                       before=before)

    controller = begun(text("", 2), 5, engine)
    plan = staged(controller, text("extra : DINT := 7;", 4))
    assert set(plan.initialised) == {"main.g.extra", "main.p.extra", "main.f[3]", "main.f[4]",
                                     "main.deep[1].extra", "main.deep[2].extra"}
    controller.test("me")
    assert [controller.machine.get(n) for n in ("g.total", "p.a", "f[2]", "deep[2].a")] == [5] * 4
    assert [controller.machine.get(n) for n in ("g.extra", "p.extra", "deep[1].extra", "f[4]")] == [7, 7, 7, 0]
    controller.scan()
    assert controller.machine.get("g.total") == 6
    controller.untest("me")
    assert controller.machine.get("deep[2].a") == 6


@pytest.mark.parametrize("engine", ENGINES)
def test_an_output_with_another_name_keeps_its_value_and_one_that_moves_takes_it_along(engine: str) -> None:
    old = program("a AT %IX0.0 : BOOL; m AT %QX0.0 : BOOL; w AT %QW1 : INT; t AT %QX9.0 : BOOL;",
                  "[a] (S m) (S t) <MOVE(IN := 1200, OUT => w)>")
    new = program("b AT %IX0.0 : BOOL; n AT %QX0.0 : BOOL; w AT %QW3 : INT; x AT %QB9 : BYTE; t AT %QX9.0 : BOOL;",
                  "[b] (S n)")
    controller = Controller(loaded(old, engine))
    controller.machine.set("a", True)
    controller.scan()
    plan = staged(controller, new)
    controller.test("me")
    assert plan.kept == ("main.b", "main.n", "main.w", "main.t")
    assert [controller.machine.get(n) for n in ("b", "n", "w", "t", "x")] == [True, True, 1200, True, 1]


@pytest.mark.parametrize(("old", "new"), [
    ("x : INT;", "x : DINT;"), ("x : TON;", "x : TOF;"), ("x : INT;", "x : ARRAY[1..2] OF INT;"),
    ("x : STRING[5];", "x : STRING[4];"), ("x : BOOL;", "x : TON;"), ("x AT %QW0 : INT;", "x AT %QW0 : WORD;"),
    ("x : ARRAY[1..2] OF INT;", "x : ARRAY[1..2] OF REAL;"), ("x : ARRAY[1..2] OF INT;", "x : ARRAY[1..2, 1..2] OF INT;")])
def test_a_symbol_cannot_change_its_type(old: str, new: str) -> None:
    assert refusals(program(old + " a : BOOL;", "(a)"), program(new + " a : BOOL;", "(a)"))[0] == "LD0820"


def test_memory_and_tasks_are_those_of_the_start() -> None:
    old, new = program("a AT %QX0.0 : BOOL;", "(a)"), program("a AT %QX8.0 : BOOL; big : ARRAY[1..99] OF LINT;", "(a)")
    assert refusals(old, new, Limits(image_bytes=8, data_bytes=100)) == ["LD0822", "LD0822"]

    def tasks(text: str) -> str:
        return program("a : BOOL;", "(a)", after=(
            f"CONFIGURATION c\nRESOURCE r ON master\n{text} PROGRAM p WITH t : main;\nEND_RESOURCE\nEND_CONFIGURATION"))

    first = tasks("TASK t(INTERVAL := T#10ms); TASK u(INTERVAL := T#50ms);")
    assert refusals(first, tasks("TASK t(INTERVAL := T#20ms); TASK u(INTERVAL := T#50ms);")) == ["LD0821"]
    assert refusals(first, tasks("TASK t(INTERVAL := T#10ms);")) == ["LD0821"]
    for interval in ("4ms", "25ms"):
        more = f"TASK t(INTERVAL := T#10ms); TASK u(INTERVAL := T#50ms); TASK v(INTERVAL := T#{interval});"
        assert refusals(first, tasks(more)) == ["LD0821"], "scans come every 10 ms"
    staged(begun(first), tasks("TASK t(INTERVAL := T#10ms); TASK u(INTERVAL := T#50ms); TASK v(INTERVAL := T#5s);"))


# ---- edges and time ----------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("level", (False, True))
def test_a_new_edge_shows_none_in_its_first_execution(engine: str, level: bool) -> None:
    """Contacts and coils, in a program and in an instance, whatever the operand is by then."""
    counts = "".join(f"n{n} : INT; " for n in range(4))
    rungs = ["[P a] <ADD(IN1 := n0, IN2 := 1, OUT => n0)>", "[N a] <ADD(IN1 := n1, IN2 := 1, OUT => n1)>",
             "[a] (P c)\n", "[a] (N d)\n", "[c] <ADD(IN1 := n2, IN2 := 1, OUT => n2)>",
             "[d] <ADD(IN1 := n3, IN2 := 1, OUT => n3)>"]
    block = ("FUNCTION_BLOCK watch\nVAR_INPUT a : BOOL; END_VAR\nVAR_OUTPUT q, c, d : BOOL; " + counts + "END_VAR\n"
             + "\n".join(f"RUNG w{n}\n{rung}" for n, rung in enumerate(rungs)) + "\nEND_FUNCTION_BLOCK")
    old = program("a AT %IX0.0 : BOOL; b : BOOL;", "[a] (b)")
    new = program(f"a AT %IX0.0 : BOOL; b : BOOL; c, d : BOOL; {counts} w : watch;", "[a] (b)", *rungs,
                  "[a] <w: watch()>", before=block)
    controller = begun(old, 3, engine)
    staged(controller, new)
    controller.test("me")
    controller.machine.set("a", level)  # seen by the first execution only
    names = [f"{p}n{n}" for p in ("", "w.") for n in range(4)]
    controller.scan()
    assert [controller.machine.get(n) for n in names] == [0] * 8
    controller.machine.set("a", not level)
    controller.scan()
    assert [controller.machine.get(n) for n in names] == [int(not level), int(level)] * 4


def test_tasks_keep_their_time_and_a_new_one_begins_at_its_own() -> None:
    def text(more: str = "") -> str:
        names = ["fast", "slow", *(["new"] if more else [])]
        pous = "".join(f"PROGRAM {n}\nVAR k : INT; END_VAR\nRUNG\n<ADD(IN1 := k, IN2 := 1, OUT => k)>\nEND_PROGRAM\n"
                       for n in names)
        return (f"{pous}CONFIGURATION c\nRESOURCE r ON master\nTASK f(INTERVAL := T#10ms);\nTASK s(INTERVAL := T#70ms);\n"
                f"{more}PROGRAM fast1 WITH f : fast;\nPROGRAM slow1 WITH s : slow;\n"
                + ("PROGRAM new1 WITH n : new;\n" if more else "") + "END_RESOURCE\nEND_CONFIGURATION\n")

    controller = begun(text(), 5)
    staged(controller, text("TASK n(INTERVAL := T#40ms);\n"))
    controller.test("me")
    counts = []
    for _ in range(10):
        controller.scan()
        counts.append([controller.machine.get(f"{n}1.k") for n in ("fast", "slow", "new")])
    # Scans 5 to 14: slow is due at 0, 70, 140 ms, new at 80, 120 ms.
    assert [row[0] for row in counts] == list(range(6, 16))
    assert [row[1] for row in counts] == [1, 1, 2, 2, 2, 2, 2, 2, 2, 3]
    assert [row[2] for row in counts] == [0, 0, 0, 1, 1, 1, 1, 2, 2, 2]


def test_a_task_that_a_fault_stopped_stays_stopped() -> None:
    controller = begun(program("a AT %QX0.0 : BOOL; n, z : INT;", "(a)", "<ADD(IN1 := n, IN2 := 1, OUT => n)>",
                               "[n / z > 1] (a)"), 3)
    assert len(controller.machine.faults) == 1
    staged(controller, program("a AT %QX0.0 : BOOL; n, z : INT;", "(a)", "<ADD(IN1 := n, IN2 := 1, OUT => n)>"))
    controller.test("me")
    controller.scan()
    assert (controller.machine.get("n"), controller.machine.get("a")) == (1, False)
    assert controller.state == "testing" and len(controller.machine.faults) == 1


# ---- the end of a test -------------------------------------------------------------------------------

LATCH = program("go AT %IX0.0 : BOOL; run AT %QX0.0 : BOOL; n, z : INT; e : INT;", "{ [go] | [run] } (run)",
                "<ADD(IN1 := n, IN2 := 1, OUT => n)>", "[P run] <ADD(IN1 := e, IN2 := 1, OUT => e)>")


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("at", (0, 1, 4))
def test_a_fault_in_a_test_is_undone(engine: str, at: int) -> None:
    """The outputs hold, nothing is counted twice, the scan is not missed: as if nobody had tested."""
    events: list[Event] = []
    controller = Controller(loaded(LATCH, engine), events.append)
    controller.machine.set("go", True)
    controller.scan()
    controller.machine.set("go", False)
    faulty = LATCH.replace("END_PROGRAM", f"RUNG bad\n[n > {at + 3}] [10 / z > 1] (bad)\nEND_PROGRAM").replace("e : INT;", "e : INT; bad : BOOL;")
    staged(controller, faulty)
    controller.scan()
    controller.scan()
    controller.test("me")
    new = controller.running.digest
    for scan in range(3, 10):
        controller.between()
        controller.scan()
        machine = controller.machine
        assert [machine.get(n) for n in ("n", "run", "e")] == [scan + 1, True, 1]
        assert machine.scans == scan + 1
    assert controller.state == "running" and controller.running.digest != new and not machine.faults
    assert [(e.action, [f.code for f in e.faults]) for e in events][-1] == ("reverted", ["LD0801"])


def test_a_test_that_nobody_commits_ends_in_time_and_can_be_repeated() -> None:
    events: list[Event] = []
    controller = begun(LATCH, 2)
    controller.note = events.append
    staged(controller, LATCH.replace("IN2 := 1", "IN2 := 100").replace("e : INT;", "e : INT; extra : INT := 3;")
           .replace("END_PROGRAM", "RUNG more\n<ADD(IN1 := extra, IN2 := 1, OUT => extra)>\nEND_PROGRAM"))
    for _ in range(2):
        before = controller.machine.get("n")
        controller.test("me", 30_000_000)
        assert controller.machine.get("extra") == 3
        for _ in range(3):
            controller.between()
            controller.scan()
        assert controller.machine.get("n") == before + 300 and controller.state == "testing"
        controller.between()
        assert controller.state == "staged"
        controller.scan()
        assert controller.machine.get("n") == before + 301
    assert [e.action for e in events] == ["staged", "testing", "reverted", "testing", "reverted"]


def test_what_only_the_old_program_has_stands_during_a_test() -> None:
    controller = begun(program("a, b : INT;", "<ADD(IN1 := a, IN2 := 1, OUT => a)> <ADD(IN1 := b, IN2 := 1, OUT => b)>"), 4)
    staged(controller, program("a : INT;", "<ADD(IN1 := a, IN2 := 1, OUT => a)>"))
    controller.test("me")
    controller.scan()
    controller.untest("me")
    assert (controller.machine.get("a"), controller.machine.get("b")) == (5, 4)


# ---- turns -------------------------------------------------------------------------------------------


def test_each_step_has_its_turn_and_its_owner() -> None:
    controller = begun(LATCH)
    for action in (controller.test, controller.untest, controller.commit, controller.cancel):
        with pytest.raises(Invalid) as error:
            action("me")
        assert codes(error) == ["LD0824"]
    changed = LATCH.replace("IN2 := 1", "IN2 := 2")
    staged(controller, changed)
    for action in (controller.untest, controller.commit):
        with pytest.raises(Invalid) as error:
            action("me")
        assert codes(error) == ["LD0824"]
    for act in (lambda: controller.test("you"), lambda: controller.cancel("you"), lambda: staged(controller, changed, "you")):
        with pytest.raises(Invalid) as error:
            act()
        assert codes(error) == ["LD0825"]
    controller.test("me")
    for act in (lambda: controller.test("me"), lambda: staged(controller, LATCH)):
        with pytest.raises(Invalid) as error:
            act()
        assert codes(error) == ["LD0824"]
    controller.cancel("you", force=True)
    assert controller.state == "running"
    controller.scan()
    assert controller.machine.get("n") == 2


def test_a_change_for_a_program_that_ran_before_is_refused() -> None:
    controller = begun(LATCH)
    old = controller.running
    late = prepare(old, loaded(LATCH.replace("IN2 := 1", "IN2 := 3"), "vm", old), old.digest, "me")
    staged(controller, LATCH.replace("IN2 := 1", "IN2 := 2"))
    controller.test("me")
    controller.commit("me")
    with pytest.raises(Invalid) as error:
        controller.stage(late)
    assert codes(error) == ["LD0823"]
    with pytest.raises(Invalid) as error:
        prepare(controller.running, late.new, old.digest, "me")
    assert codes(error) == ["LD0823"]


# ---- those who look on -------------------------------------------------------------------------------


def test_inputs_and_traces_follow_to_a_program_with_further_instances() -> None:
    old = program("a : BOOL; k : INT; gone : INT; b AT %IX0.0 : BOOL;", "[a] <ADD(IN1 := k, IN2 := 1, OUT => k)>")
    new = program("a : BOOL; k : INT; b AT %IX0.0 : BOOL;", "[a] [b] <ADD(IN1 := k, IN2 := 1, OUT => k)>",
                  after="PROGRAM more\nVAR a : BOOL; k : INT; END_VAR\nRUNG\n[a] <ADD(IN1 := k, IN2 := 1, OUT => k)>\nEND_PROGRAM")
    controller = Controller(loaded(old))
    machine, found = controller.machine, Diagnostics()
    rows = "scan,a,%IX0.0,gone\n0,1,,3\n2,0,1,4\n3,1,1,5\n"
    stimuli = read(SourceFile("in.csv", rows), machine.symbols, found)
    stream = io.StringIO()
    trace = Trace(machine, ("a", "k", "gone", "%IX0.0"), stream)
    for scan in range(4):
        if scan == 2:
            staged(controller, new)
            controller.test("me")
            stimuli = stimuli.follow(machine, controller.machine)
            machine = controller.machine
            trace.follow(machine)
        stimuli.apply(machine)
        controller.scan()
        trace.sample()
    assert stream.getvalue() == "scan,t_ms,a,k,gone,%IX0.0\n0,0,1,1,3,0\n1,10,1,2,3,0\n2,20,0,2,,1\n3,30,1,3,,1\n"
