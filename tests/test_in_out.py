"""VAR_IN_OUT pins: copied in before the call and out after it, whatever calls and however it is compiled."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, trace

from ldc import pipeline
from ldc.il.text import print_program
from ldc.il.typecheck import check_unit
from runtime.trace import record
from runtime.vm.machine import Machine
from runtime.vm.stepping import Stepper

TEXT = """
TYPE Row : STRUCT n : INT; END_STRUCT; END_TYPE

FUNCTION advance : INT
VAR_IN_OUT
    total : INT;
    row   : ARRAY [0..1] OF INT;
END_VAR
VAR_INPUT
    plus : INT := 1;
END_VAR
VAR_OUTPUT
    odd : BOOL;
END_VAR
RUNG
    <ADD(total, plus, OUT => total)>;
    <ADD(row[1], total, OUT => row[1])>;
    <MUL(total, 2, OUT => advance)>;
    [total MOD 2 = 1] (odd)
END_FUNCTION

FUNCTION_BLOCK bump
VAR_IN_OUT
    total : INT;
END_VAR
RUNG
    <ADD(total, 10, OUT => total)>
END_FUNCTION_BLOCK

PROGRAM main
VAR
    go AT %IX0.0 : BOOL := TRUE;
    sum, double, tens : INT;
    rows : ARRAY [0..1] OF INT;
    lamp : BOOL;
    more : bump;
END_VAR
RUNG call
    [go] <advance(plus := 3, total := sum, row := rows, OUT => double, odd => lamp)>
RUNG
    <more: bump(total := tens) in=_ out=_>
END_PROGRAM
"""
WATCHED = ("sum", "double", "rows[1]", "lamp", "tens")
EXPECTED = "scan,t_ms,sum,double,rows[1],lamp,tens\n0,0,3,6,3,1,10\n1,10,6,12,9,0,20\n2,20,9,18,18,1,30\n"


def compiled(path: Path, text: str, depth: int | None = None) -> pipeline.Compiled:
    path.write_text(text, encoding="utf-8")
    result = pipeline.compile_paths([str(path)], pipeline.Options(max_paren_depth=depth))
    assert result.program is not None, [d.message for d in result.diagnostics]
    assert [check_unit(unit) for unit in result.program.units] == [[] for _ in result.program.units]
    return result


@pytest.mark.parametrize("depth", [None, 0])
def test_a_variable_is_copied_in_and_out(tmp_path: Path, depth: int | None) -> None:
    result = compiled(tmp_path / "main.ld", TEXT, depth)
    assert {b.code.proof for builds in result.units.values() for b in builds} == {"proof"}
    assert record(Machine(result.program), WATCHED, 3) == EXPECTED


def test_stepping_gives_the_same(tmp_path: Path) -> None:
    machine = Machine(compiled(tmp_path / "main.ld", TEXT).program)
    stepper = Stepper(machine)
    for _ in range(3):
        stepper.scan()
    assert [machine.get(name) for name in WATCHED] == [9, 18, 18, True, 30]


def test_il_text_comes_back_the_same(tmp_path: Path) -> None:
    printed = print_program(compiled(tmp_path / "main.ld", TEXT).program)
    again = compiled(tmp_path / "main.il", printed)
    assert print_program(again.program) == printed
    assert record(Machine(again.program), WATCHED, 3) == EXPECTED


def test_nothing_is_copied_without_power(tmp_path: Path) -> None:
    machine = Machine(compiled(tmp_path / "main.ld", TEXT.replace("BOOL := TRUE", "BOOL")).program)
    machine.scan()
    assert machine.get("sum") == 0 and machine.get("tens") == 10


@pytest.mark.parametrize("call", ["    LD 3\n    advance\n", "    advance(plus := 3, total := sum)\n"])
def test_il_that_leaves_one_out_is_told(tmp_path: Path, call: str) -> None:
    function = TEXT[TEXT.index("FUNCTION advance"): TEXT.index("RUNG")] + "    LD 0\n    ST advance\nEND_FUNCTION\n"
    path = tmp_path / "main.il"
    path.write_text(f"{function}PROGRAM main\nVAR sum : INT; END_VAR\n{call}    ST sum\nEND_PROGRAM\n")
    assert [d.code for d in pipeline.compile_paths([str(path)]).diagnostics] == ["LD0507"]


def test_two_globals_are_copied_out_by_one_call(tmp_path: Path) -> None:
    """The second value comes from the call, not from the globals after the first was stored."""
    text = TEXT.replace("PROGRAM main\nVAR\n", "VAR_GLOBAL\n    sum, double, tens : INT;\n"
                        "    rows : ARRAY [0..1] OF INT;\nEND_VAR\nPROGRAM main\nVAR_EXTERNAL\n"
                        "    sum, double, tens : INT;\n    rows : ARRAY [0..1] OF INT;\nEND_VAR\nVAR\n")
    text = text.replace("    sum, double, tens : INT;\n    rows : ARRAY [0..1] OF INT;\n    lamp", "    lamp")
    result = compiled(tmp_path / "main.ld", text)
    assert {b.code.proof for builds in result.units.values() for b in builds} == {"proof"}
    assert record(Machine(result.program), WATCHED, 3) == EXPECTED


def test_an_instance_keeps_what_its_last_call_left(tmp_path: Path) -> None:
    """Which may be read by name, and not written; so ST that was printed from a ladder is read back."""
    text = TEXT[TEXT.index("FUNCTION_BLOCK"):TEXT.index("PROGRAM")] + """PROGRAM main
VAR more : bump; tens, seen, doubled : INT; END_VAR
RUNG
    <MUL(more.total, 2, OUT => doubled)>
RUNG
    <more: bump(total := tens) in=_ out=_>; <SUB(more.total, 1, OUT => seen)>
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.ld", [{}] * 3, ["tens", "seen", "doubled"]) == [
        (10, 9, 0), (20, 19, 20), (30, 29, 40)]
    told = checked(text.replace("OUT => seen", "OUT => more.total"), "main.ld")
    assert [d.code for d in told.diagnostics] == ["LD0503"]


@pytest.mark.parametrize("order", ["i := i, t := ts[i], v := vs[i], n => i", "n => i, v := vs[i], t := ts[i], i := i"])
def test_the_element_that_was_given_comes_back_though_the_call_changes_the_index(tmp_path: Path, order: str) -> None:
    text = f"""FUNCTION_BLOCK following
VAR_INPUT i : INT; END_VAR
VAR_OUTPUT n : INT; END_VAR
VAR_IN_OUT t : TON; v : INT; END_VAR
    t(IN := TRUE, PT := T#20ms); v := v + 1;
    n := i + 1;
END_FUNCTION_BLOCK
PROGRAM main
VAR f : following; ts : ARRAY [0..9] OF TON; vs : ARRAY [0..9] OF INT; i : INT; END_VAR
    i := 0;
    f({order});
END_PROGRAM
"""
    names = ("ts[0].IN", "ts[1].IN", "vs[0]", "vs[1]", "i")
    assert trace(tmp_path, text, "main.st", [{}] * 2, names)[-1] == (True, False, 2, 0, 1)


def test_values_without_names_go_to_pins_in_declared_order(tmp_path: Path) -> None:
    """A VAR_IN_OUT that is declared first takes the first value, whatever section follows."""
    text = """FUNCTION take : INT VAR_IN_OUT from : INT; END_VAR VAR_INPUT n : INT; END_VAR VAR_IN_OUT into : INT; END_VAR
    from := from - n; into := into + n; take := n;
END_FUNCTION
FUNCTION_BLOCK mover VAR_IN_OUT from : INT; END_VAR VAR_INPUT n : INT; END_VAR
    from := from + 100 * n;
END_FUNCTION_BLOCK
PROGRAM main VAR a : INT := 10; b : INT := 20; k : INT := 3; got : INT; m : mover; END_VAR
    got := take(a, k, b);
    m(b, k);
END_PROGRAM
""".replace("from", "source").replace("into", "target")
    assert trace(tmp_path, text, "main.st", [{}], ("a", "b", "k", "got")) == [(7, 323, 3, 3)]


def test_values_without_names_pass_over_what_chooses_an_action(tmp_path: Path) -> None:
    text = """FUNCTION_BLOCK mover VAR_IN_OUT source : INT; END_VAR VAR_INPUT n : INT; END_VAR
    source := source + 100 * n;
ACTION Clear: n := 0; END_ACTION
END_FUNCTION_BLOCK
PROGRAM main VAR b : INT := 20; k : INT := 3; m : mover; END_VAR
    m(b, k);
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}], ("b",)) == [(320,)]
