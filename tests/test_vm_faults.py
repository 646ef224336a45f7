"""Run-time faults: where they are, what stops, what goes on, and which outputs become safe."""

from __future__ import annotations

import pytest
from il_build import program, simple, unit, var

from ldc.diagnostics import Invalid
from ldc.il.program import Run, Task
from ldc.types import BOOL, DINT, INT, REAL, TIME, Array, Instance
from runtime.vm.machine import Machine


def faulty() -> Machine:
    block = unit(
        "FUNCTION_BLOCK",
        "half",
        [var("n", INT, kind="input"), var("by", INT, kind="input"), var("r", INT, kind="output")],
        ("calm", "LD n; ST r"),
        ("split", "LD 1; DIV by; ST r"),
    )
    bad = unit(
        "PROGRAM",
        "bad",
        [
            var("h", Instance("half")),
            var("d", INT, initial=2),
            var("out", at="%QX0.0"),
            var("speed", INT, at="%QW2"),
            var("lamp", at="%QX0.1"),
            var("n", INT),
        ],
        ("write", "LD TRUE; ST out; ST %QX0.7; LD 7; ST speed; LD n; ADD 1; ST n"),
        ("call", "LD d; ST h.by; CAL h"),
        ("after", "LD TRUE; ST lamp"),
        units=[block],
    )
    good = unit(
        "PROGRAM", "good", [var("n", INT), var("other", at="%QX0.2")], "LD n; ADD 1; ST n; LD TRUE; ST other"
    )
    return Machine(
        program(
            block,
            bad,
            good,
            tasks=(Task("t1"), Task("t2")),
            safe=(("bad.speed", 3), ("%QX0.1", True)),
            runs=(Run("bad", "bad", "t1"), Run("good", "good", "t2")),
        )
    )


def test_a_fault_stops_its_task_and_makes_its_outputs_safe() -> None:
    machine = faulty()
    machine.scan()
    assert not machine.faults and machine.get("bad.speed") == 7
    machine.set("bad.d", 0)
    for _ in range(3):
        machine.scan()
    (fault,) = machine.faults
    assert (
        fault.code,
        fault.task,
        fault.place.pou,
        fault.place.rung,
        fault.place.instruction,
        fault.scan,
    ) == ("LD0801", "t1", "half", "split", 1, 1)
    assert [(p.pou, p.rung, p.instruction) for p in fault.calls] == [("bad", "call", 2)]
    assert "division by zero" in fault.diagnostic().message and "t1" in fault.diagnostic().message
    assert [machine.get(n) for n in ("bad.out", "%QX0.7", "bad.speed", "bad.lamp", "bad.n")] == [
        False,
        False,
        3,
        True,
        2,
    ]
    assert machine.get("good.n") == 4 and machine.get("good.other") is True


def test_an_output_stays_safe_when_another_task_writes_it() -> None:
    bad = unit(
        "PROGRAM", "bad", [var("out", at="%QX0.0"), var("n", INT)], "LD TRUE; ST out; LD 1; DIV n; ST n"
    )
    good = unit("PROGRAM", "good", [var("out", at="%QX0.0")], "LD TRUE; ST out")
    machine = Machine(
        program(
            bad,
            good,
            tasks=(Task("t1"), Task("t2")),
            runs=(Run("bad", "bad", "t1"), Run("good", "good", "t2")),
        )
    )
    machine.scan()
    assert machine.get("%QX0.0") is False
    machine.scan()
    assert machine.get("%QX0.0") is False


@pytest.mark.parametrize(
    "code, at",
    [
        ("LD r; DIV s; ST r", 1),
        ("LD r; ADD( r; DIV s; ); ST r", 2),
        ("LD n; MOD z; ST n", 1),
        ("LD n; FN DIV:INT z; ST n", 1),
        ("LD t; DIV u; ST t", 1),
    ],
)
def test_every_division_by_zero_is_a_fault(code: str, at: int) -> None:
    names = [
        var("r", REAL, initial=1.0),
        var("s", REAL),
        var("n", INT, initial=1),
        var("z", INT),
        var("t", TIME, initial=5),
        var("u", TIME),
    ]
    machine = Machine(simple(names, code))
    machine.scan()
    assert [(f.code, f.place.instruction) for f in machine.faults] == [("LD0801", at)]


@pytest.mark.parametrize("index", [-1, 0, 4, 32767, -32768])
@pytest.mark.parametrize("code", ["LD a[i]; ST n", "LD 1; ST a[i]"])
def test_an_index_out_of_range_is_a_fault(code: str, index: int) -> None:
    names = [var("a", Array(((1, 3),), INT)), var("i", INT, initial=index), var("n", INT)]
    machine = Machine(simple(names, ("calm", "LD 5; ST n"), ("wild", code)))
    machine.scan()
    (fault,) = machine.faults
    assert fault.code == "LD0802" and f"index {index} is outside 1..3" in fault.message
    assert fault.place.rung == "wild" and fault.place.instruction == code.startswith("LD 1")


def test_a_store_that_is_not_made_checks_no_index() -> None:
    machine = Machine(simple([var("a", Array(((1, 3),), BOOL)), var("i", INT), var("go")], "LD go; S a[i]"))
    machine.scan()
    assert not machine.faults
    machine.set("go", 1)
    machine.scan()
    assert machine.faults


def test_the_watchdog_ends_an_endless_loop() -> None:
    source = simple(
        [var("n", DINT)],
        ("loop", "LD n; ADD 1:DINT; ST n; JMP loop", "loop"),
        tasks=(Task("main", watchdog=100),),
    )
    machine = Machine(source)
    machine.scan()
    (fault,) = machine.faults
    assert fault.code == "LD0803" and machine.get("n") == 101 and fault.place.rung == "loop"
    machine.scan()
    assert machine.get("n") == 101 and machine.scans == 2


def test_a_safe_value_that_does_not_fit_is_said_at_the_start() -> None:
    with pytest.raises(Invalid, match="LD0804 the safe value of `%QX0.0` does not fit"):
        Machine(simple([var("q", at="%QX0.0")], "LD q; ST q", safe=(("%QX0.0", 3), ("other.q", 1))))
