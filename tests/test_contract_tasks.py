"""Contract: programs, tasks, shared variables and faults of a whole project (DESIGN sections 2, 5 and 7)."""

from __future__ import annotations

from contract import MS, codes, machine, program, trace

TASKS = """PROGRAM fast
VAR_EXTERNAL total : INT; END_VAR
VAR n, seen : INT; END_VAR
RUNG <ADD(IN1 := n, IN2 := 1, OUT => n)> <MOVE(IN := total, OUT => seen)>
END_PROGRAM

PROGRAM slow
VAR_EXTERNAL total : INT; END_VAR
VAR n : INT; END_VAR
RUNG <ADD(IN1 := n, IN2 := 1, OUT => n)> <MOVE(IN := n, OUT => total)>
END_PROGRAM

PROGRAM once
VAR n : INT; END_VAR
RUNG <ADD(IN1 := n, IN2 := 1, OUT => n)>
END_PROGRAM

CONFIGURATION plant
    VAR_GLOBAL total : INT; go AT %IX0.0 : BOOL; END_VAR
    RESOURCE main ON master
        TASK f(INTERVAL := T#10ms, PRIORITY := 2);
        TASK s(INTERVAL := T#30ms, PRIORITY := 1);
        TASK e(SINGLE := go, PRIORITY := 0);
        PROGRAM pf WITH f : fast;
        PROGRAM ps WITH s : slow;
        PROGRAM pe WITH e : once;
    END_RESOURCE
END_CONFIGURATION
"""


def test_tasks_by_interval_priority_and_edge() -> None:
    rows = trace(TASKS, "pf.n pf.seen ps.n pe.n", "scan,go 0,0 1,1 2,1 3,0 4,1 7,0", period=None)
    assert rows == ["1 1 1 0", "2 1 1 1", "3 1 1 1", "4 2 2 1", "5 2 2 2", "6 2 2 2", "7 3 3 2", "8 3 3 2"]


def test_a_fault_stops_its_task_only_and_is_told_with_its_place() -> None:
    source = """PROGRAM good
VAR n : INT; q AT %QX0.0 : BOOL; END_VAR
RUNG (q) <ADD(IN1 := n, IN2 := 1, OUT => n)>
END_PROGRAM

FUNCTION_BLOCK Divider
VAR_INPUT e : BOOL; k : INT; END_VAR
VAR_OUTPUT o : BOOL; END_VAR
RUNG quotient [e] [5 / k = 5] (o)
END_FUNCTION_BLOCK

PROGRAM bad
VAR k : INT := 1; q AT %QX0.1 : BOOL; level AT %QW2 : INT; d : Divider; END_VAR
RUNG (q) <MOVE(IN := 7, OUT => level)>
RUNG call <d: Divider(k := k)> (q)
END_PROGRAM

CONFIGURATION plant
    RESOURCE main ON master
        TASK a(INTERVAL := T#10ms, PRIORITY := 2);
        TASK b(INTERVAL := T#10ms, PRIORITY := 1);
        PROGRAM pg WITH a : good;
        PROGRAM pb WITH b : bad;
    END_RESOURCE
END_CONFIGURATION
"""
    source = source.replace("<d: Divider", "[q] <d: Divider")
    assert trace(source, "pg.n pg.q pb.q pb.level", "scan,pb.k 0,1 1,0 3,1") == [
        "1 1 1 7", "fault LD0801", "2 1 0 0", "3 1 0 0", "4 1 0 0"]
    running = machine(source)
    running.set("pb.k", 0)
    running.scan()
    (fault,) = running.faults
    found = fault.diagnostic()
    assert (fault.task, fault.place.pou, fault.place.rung) == ("b", "Divider", "quotient")
    assert found.primary.span.text == "5 / k" and "rung quotient of Divider" in found.primary.text
    assert [label.text for label in found.secondary] == ["called from rung call of bad"]


def test_located_variables_are_shared_and_overlap() -> None:
    source = """PROGRAM a
VAR x AT %IX0.3 : BOOL; y AT %QX0.0 : BOOL; w AT %MW2 : WORD; END_VAR
RUNG [x] (y)
RUNG [x] <MOVE(IN := 16#1234, OUT => w)>
END_PROGRAM

PROGRAM b
VAR y AT %QX0.0 : BOOL; low AT %MB4 : BYTE; high AT %MB5 : BYTE; bit AT %MX4.2 : BOOL; o : BOOL; END_VAR
VAR inputs AT %IB0 : BYTE; END_VAR
RUNG [y] [%IX0.3] [bit] (o)
END_PROGRAM
"""
    assert trace(source, "b.low b.high b.bit b.o a.y b.inputs", "scan,%IX0.3 0,1 1,0") == [
        "52 18 1 1 1 8", "52 18 1 0 0 0"]
    assert trace(source, "a.x a.y", "scan,b.inputs 0,8 1,7") == ["1 1", "0 0"]


def test_located_arrays_lie_element_behind_element() -> None:
    rungs = """RUNG [a] <MOVE(IN := 9, OUT => row[i])>
RUNG [%MW3 = 9] (lamps[9])
RUNG [%QX1.1] (seen)
RUNG <MOVE(IN := row, OUT => copy)>
"""
    declared = ("a, seen : BOOL; i : INT; row AT %MW2 : ARRAY [0..2] OF INT := [1, 2, 3];"
                " copy : ARRAY [0..2] OF INT; lamps AT %QX0.0 : ARRAY [0..11] OF BOOL;"
                " reals AT %MD4 : ARRAY [1..2] OF REAL := [0.5, 1.5];")
    watched, inputs = "row[0] row[1] copy[2] lamps[9] seen reals[2]", "scan,a,i 0,0,0 1,1,1 2,1,3"
    assert trace(program(rungs, declared), watched, inputs) == [
        "1 2 3 0 0 1.5", "1 9 3 1 1 1.5", "fault LD0802", "1 9 3 0 1 1.5"]


def test_located_arrays_fit_their_address_and_the_image() -> None:
    def found(declaration: str) -> list[str]:
        return codes(f"PROGRAM main\nVAR {declaration} END_VAR\nEND_PROGRAM\n")

    assert found("v AT %MB0 : ARRAY [0..3] OF INT;") == ["LD0212"]
    assert found("v AT %MW0 : ARRAY [0..3] OF STRING;") == ["LD0212"]
    assert found("v AT %MW0 : ARRAY [0..200000] OF INT;") == ["LD0211"]
    assert found("v AT %QW0 : ARRAY [0..3] OF INT; w AT %QW4 : INT;") == []
    assert found("v AT %QW0 : ARRAY [0..3] OF INT; w AT %QW3 : INT;") == ["LD0214"]


def test_two_programs_of_one_type_have_their_own_variables() -> None:
    source = program("RUNG [P a] <ADD(IN1 := n, IN2 := 1, OUT => n)>", "a : BOOL; n : INT := 5;", after="""
CONFIGURATION plant
    RESOURCE r ON master
        TASK t(INTERVAL := T#10ms, PRIORITY := 1);
        PROGRAM one WITH t : main;
        PROGRAM two WITH t : main;
    END_RESOURCE
END_CONFIGURATION
""")
    inputs = "scan,one.a,two.a 0,1,0 1,1,1 2,0,0 3,1,0"
    assert trace(source, "one.n two.n", inputs) == ["6 5", "6 6", "6 6", "7 6"]


def test_globals_are_shared_and_constants_read() -> None:
    source = """VAR_GLOBAL g : INT := 5; END_VAR
VAR_GLOBAL CONSTANT pace : INT := 2; END_VAR

PROGRAM a
VAR_EXTERNAL g : INT; END_VAR
VAR_EXTERNAL CONSTANT pace : INT; END_VAR
RUNG <ADD(IN1 := g, IN2 := pace, OUT => g)>
END_PROGRAM

PROGRAM b
VAR_EXTERNAL g : INT; END_VAR
VAR RETAIN n : INT; END_VAR
RUNG <SUB(IN1 := g, IN2 := n, OUT => n)>
END_PROGRAM
"""
    assert trace(source, "g b.n", scans=2) == ["7 7", "9 2"]


VALUES = """RUNG <ADD(IN1 := i, IN2 := 1, OUT => i)>
RUNG <SUB(IN1 := u, IN2 := 1, OUT => u)>
RUNG <ADD(IN1 := x, IN2 := 0.1, OUT => x)>
RUNG <CONCAT(IN1 := s5, IN2 := 'xyz', OUT => s5)>
RUNG <ADD(IN1 := t, IN2 := T#1ms500us, OUT => t)>
RUNG <MUL(IN1 := d, IN2 := d, OUT => d)>
RUNG [i < 0] (w.15)
"""


def test_values_at_the_limits_of_their_types() -> None:
    declared = ("i : INT := 32766; u : USINT; x : REAL; s5 : STRING[5] := 'a'; t : TIME;"
                " d : DINT := 65537; w : WORD;")
    assert trace(program(VALUES, declared), "i u x s5 t d w", scans=3) == [
        "32767 255 0.1 axyz 1.5 131073 0", "-32768 254 0.2 axyzx 3 262145 32768",
        "-32767 253 0.3 axyzx 4.5 524289 32768"]


def test_time_is_virtual_and_begins_at_zero() -> None:
    running = machine(program("RUNG (q)", "q : BOOL;"), 25)
    assert running.now_ns == 0
    running.scan()
    assert (running.scans, running.now_ns) == (1, 25 * MS)
