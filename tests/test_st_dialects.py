"""What texts of other editors have beside the 2nd edition: read, executed on all engines, or told by name."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, compiled, trace

from ldc.diagnostics import Diagnostics
from ldc.parser import parse_file
from ldc.parser.format import format_file
from ldc.source import SourceFile

DECLARED = """{attribute 'qualified_only'}
TYPE
    Mode : (Idle, Running := 5, Stopped) INT := Running;
    Level : USINT (low := 1, high := 200);
    Point : STRUCT
        x, y : INT;
        row : ARRAY [0..2] OF INT := 4, 2(5);
    END_STRUCT
END_TYPE
TYPE Line : STRUCT a : Point; b : Point := (x := 7); END_STRUCT END_TYPE
VAR_GLOBAL PERSISTENT RETAIN kept : INT := 3; END_VAR
VAR_GLOBAL PERSISTENT persistent : INT; END_VAR
(* an outer (* an inner *) comment *)
FUNCTION twice /* no result */
VAR_INPUT CONSTANT n : INT; END_VAR
VAR_OUTPUT m : INT; END_VAR
    m := +n * 2;
END_FUNCTION
FUNCTION clear : VOID
VAR_IN_OUT n : INT; END_VAR
    n := 0;
END_FUNCTION
PROGRAM main
{region 'declarations'}
VAR
    {attribute 'hide'}
    mode : Mode; level : Level := high; line : Line;
    grid : ARRAY [0..1, 0..2] OF INT := [[1, 2, 3], [4, 2(5)]];
    field : ARRAY [1..4] OF INT := 3(7);
    a, b, q, bit : BOOL; w : WORD := 16#8; i, n, sum : INT; t : LTIME; {info 'x'}
END_VAR
{endregion}
    twice(n := kept, m => n);
    IF mode = Running THEN sum := sum + n END_IF
    FOR i := 1 TO 3 DO
        IF i = 2 THEN CONTINUE; END_IF
        sum := sum + field[i] + grid[1, i - 1] + line.b.x + line.a.row[0];
    END_FOR
    clear(n := kept);
    q S= a;
    q R= b AND NOT a;
    bit := w.%X3;
    w.%X3 := NOT w.%X3;
    t := t + LTIME#1s;
END_PROGRAM
"""


def test_one_text_with_most_of_it(tmp_path: Path) -> None:
    text = DECLARED.replace("sum := sum + n END_IF", "sum := sum + n; END_IF")
    rows = trace(tmp_path, text, "main.st", [{"a": 1}, {"a": 0}, {"b": 1}, {"a": 1}],
                 ("sum", "n", "q", "bit", "w", "t", "mode", "level"))
    loops = 2 * 7 + 4 + 5 + 2 * 7 + 2 * 4
    second = 1_000_000_000
    assert rows == [(6 + loops, 6, True, True, 0, second, 5, 200), (6 + 2 * loops, 0, True, False, 8, 2 * second, 5, 200),
                    (6 + 3 * loops, 0, False, True, 0, 3 * second, 5, 200),
                    (6 + 4 * loops, 0, True, False, 8, 4 * second, 5, 200)]


def test_a_missing_semicolon_behind_a_statement_is_told_still() -> None:
    assert [d.code for d in checked(DECLARED, "main.st").diagnostics] == ["LD0132"]


def test_the_canonical_form_keeps_pragmas_and_comments() -> None:
    text = DECLARED.replace("sum := sum + n END_IF", "sum := sum + n; END_IF")
    once = format_file(parse_file(SourceFile("a.st", text), Diagnostics()))
    assert format_file(parse_file(SourceFile("a.st", once), Diagnostics())) == once
    for kept in ("{attribute 'qualified_only'}", "{region 'declarations'}", "{info 'x'}", "/* no result */",
                 "(* an outer (* an inner *) comment *)", "(Idle, Running := 5, Stopped) INT"):
        assert once.count(kept) == 1, kept
    assert compiled(once, "a.st").image.digest == compiled(text, "a.st").image.digest


def test_a_comment_that_opens_another_and_closes_once_is_that_of_the_second_edition() -> None:
    text = "PROGRAM main VAR n : INT; END_VAR (* a (* b *) n := 1; (* c *) n := 2; // (*\n END_PROGRAM"
    assert trace_of(text) == 2


def trace_of(text: str) -> int:
    from runtime.vm.machine import Machine

    machine = Machine(compiled(text, "main.st").program)
    machine.scan()
    return machine.get("n")


@pytest.mark.parametrize(("body", "wanted"), [
    ("b Q= a;", ["LD0133"]), ("n := w.%B1;", ["LD0240"]), ("n := w.%Y1;", ["LD0101"]), ("n S= a;", ["LD0403"]),
    ("{IF defined (x)} n := 1;", ["LD0118"]),
    ("{extern void f(int, T*); f(0, data__);} n := 1;", ["LD0118"]), ("{{ f(x); if (y) { z(); } }} n := 1;", ["LD0118"]), ("/* open n := 1;", ["LD0103", "LD0132"]),
])
def test_what_is_wrong_is_told(body: str, wanted: list[str]) -> None:
    text = f"PROGRAM main VAR a, b : BOOL; n : INT; w : WORD; END_VAR {body} END_PROGRAM"
    assert [d.code for d in checked(text, "main.st").diagnostics] == wanted


@pytest.mark.parametrize(("type_", "wanted"), [
    ("(a := 300) USINT", ["LD0208"]), ("(a, b) REAL", ["LD0208"]), ("(a, b) Nothing", ["LD0205"]),
    ("INT (a := 1, a := 2)", ["LD0201"]), ("INT (a, b)", []), ("ARRAY [0..1, 0..1] OF INT := [[1, 2, 3]]", ["LD0210"]),
    ("ARRAY [0..1, 0..1] OF INT := [[1, 2], [3, 4], [5, 6]]", ["LD0210"]), ("ARRAY [0..1] OF INT := 1, 2, 3", ["LD0210"]),
    ("ARRAY [0..1] OF INT := [[1], 2]", ["LD0210"]), ("INT := 2(4)", ["LD0210"]),
])
def test_types_that_are_wrong_are_told(type_: str, wanted: list[str]) -> None:
    text = f"TYPE T : {type_}; END_TYPE PROGRAM main VAR t : T; END_VAR ; END_PROGRAM"
    assert [d.code for d in checked(text, "main.st").diagnostics] == wanted


OBJECTS = """INTERFACE IMotor METHOD Go : BOOL END_METHOD END_INTERFACE
FUNCTION_BLOCK ABSTRACT Base IMPLEMENTS IMotor, Other
VAR n : INT; p : POINTER TO INT; r : REFERENCE TO INT; END_VAR
    n := n + 1;
    METHOD PUBLIC Go : BOOL VAR_INPUT x : INT; END_VAR n := x; END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Motor EXTENDS Base
VAR m : INT; END_VAR
VAR_STAT k : INT; END_VAR
PROPERTY Speed : INT GET m := 1; END_GET END_PROPERTY
    THIS^.m := 2;
    k := m + unheard;
END_FUNCTION_BLOCK
PROGRAM main VAR f : Motor; n : INT; END_VAR f(); f.Stop(); n := f.Speed; n := ADR(n); END_PROGRAM
"""


def test_objects_and_pointers_are_told_by_name_and_nothing_else() -> None:
    found = checked(OBJECTS, "main.st").diagnostics
    told = [d.message.split(" are ")[0] for d in found if d.code == "LD0237"]
    assert told == ["interfaces", "interfaces", "pointers", "references", "methods", "function blocks that extend others",
                    "variables that all instances share", "properties", "pointers"]
    assert [d.code for d in found if d.code != "LD0237"] == []


def test_words_of_objects_are_names_elsewhere() -> None:
    text = """PROGRAM main VAR method, property, pointer, union, abstract, extends : INT; END_VAR
    method := property + pointer; union := abstract; extends := 1; END_PROGRAM (* END_METHOD END_PROPERTY *)"""
    assert compiled(text, "main.st")


def test_a_number_times_a_time(tmp_path: Path) -> None:
    text = """FUNCTION twice : INT VAR_INPUT n : INT; END_VAR twice := 2 * n; END_FUNCTION
FUNCTION long : TIME VAR_INPUT n : INT; END_VAR long := n * T#1m; END_FUNCTION
PROGRAM main VAR n : INT := 3; u : UINT := 7; x : REAL := 0.5; t : TIME := T#4s; l : LTIME;
    a, b, c, d, e, f : TIME;
END_VAR
    a := n * T#1s; b := x * t; c := 2 * t + n * u * T#1ms; d := MUL(n, t); e := 2.5 * T#1s; f := twice(n) * long(2);
    l := 2 * LTIME#1s;
END_PROGRAM
"""
    found = trace(tmp_path, text, "main.st", [{}], ("a", "b", "c", "d", "e", "f", "l"))
    assert found == [tuple(10**6 * ms for ms in (3_000, 2_000, 8_021, 12_000, 2_500, 720_000, 2_000))]
    for wrong, code in (("a := t * t;", "LD0410"), ("a := n / t;", "LD0410"), ("a := TRUE * t;", "LD0410"),
                        ("n := n * t;", "LD0403")):
        assert code in [d.code for d in checked(text.replace("a := n * T#1s;", wrong), "main.st").diagnostics]


def test_the_bounds_of_an_array_are_constants(tmp_path: Path) -> None:
    text = """PROGRAM main VAR a : ARRAY [2..5, -1..1] OF INT; i, n : INT; d : DINT; END_VAR
    FOR i := 2 TO 5 DO n := n + i; END_FOR;
    d := LOWER_BOUND(a, 2) + 10 * UPPER_BOUND(a, 1);
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}], ("n", "d")) == [(14, 49)]
    wrong = text.replace("(a, 2)", "(a, 3)")
    assert [d.code for d in checked(wrong, "main.st").diagnostics] == ["LD0405"]


def test_masks_of_literals_have_the_size_of_what_they_mask(tmp_path: Path) -> None:
    """`w AND NOT 16#4` clears a bit: the literal is no BOOL there."""
    text = """PROGRAM main
VAR w : WORD := 16#FF; u : WORD := 16#F0F0; v, y : WORD; d : DWORD := 16#FFFF; q, p : BOOL; END_VAR
    w := w AND NOT 16#0004;
    u := NOT 16#30 AND u OR SHL(1, 3);
    v := 16#F AND NOT 16#3;
    y := SHL(2#101, 3);
    d := d AND NOT SHL(1, 3) XOR 16#10000;
    q := (w AND NOT 16#3) = 16#F8;
    p := q AND NOT 1;
END_PROGRAM
"""
    names = ("w", "u", "v", "y", "d", "q", "p")
    assert trace(tmp_path, text, "main.st", [{}], names) == [
        (0xFB, 0xF0C8, 0xC, 0x28, 0x1FFF7, True, False)]


def test_constants_of_other_integer_types_and_assignments_in_a_row(tmp_path: Path) -> None:
    text = """VAR_GLOBAL CONSTANT
    most : UINT := 5; size : UDINT := most * 2; room : INT := 16; short : USINT := room;
END_VAR
TYPE
    Item  : STRUCT name : STRING(room); values : ARRAY [1..most] OF INT; END_STRUCT;
    Small : INT (0..most);
END_TYPE
PROGRAM main
VAR
    i : UINT := 11; a, b, c : INT; d : DINT; part : Small; items : ARRAY [0..size - 1] OF Item; k : INT := 1;
    text : STRING[short]; w : WORD;
END_VAR
    CASE i OF
        most: c := 1;
        0..most - 1: c := 2;
        most + 1..size: c := 3;
        size + 1: c := 4;
    END_CASE;
    d := items[size - 1].values[most] := a := b := b + 1;
    items[k].values[k] := k := 2;
    text := 'a text'; w.%B0 := 3;
    i := i - 3;
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{}, {}, {}, {}], (
        "c", "a", "b", "d", "items[9].values[5]", "k", "items[2].values[2]", "text", "part"))
    assert [row[0] for row in rows] == [4, 3, 1, 2]
    assert rows[0][1:] == (1, 1, 1, 1, 2, 2, "a text", 0)


@pytest.mark.parametrize(("body", "wanted"), [
    ("IF a THEN JMP done; END_IF; done: n := 1;", ["LD0237", "LD0237"]), ("done: f : INT;", ["LD0237", "LD0101"]),
    ("n := a := 3;", ["LD0403", "LD0402"]), ("n := w := ;", ["LD0101"]), ("CASE w OF 70000: n := 1; END_CASE;", ["LD0402"]),
])
def test_jumps_and_wrong_rows_are_told(body: str, wanted: list[str]) -> None:
    text = f"PROGRAM main VAR a, b : BOOL; n : INT; w : WORD; END_VAR {body} END_PROGRAM"
    assert [d.code for d in checked(text, "main.st").diagnostics if d.severity == "error"] == wanted


@pytest.mark.parametrize("text", ["UNION a : INT; b : WORD; END_UNION END_TYPE", "UNION a : INT; END_UNION; END_TYPE",
                                  "UNION a : INT;"])
def test_a_union_is_told_once(text: str) -> None:
    found = checked(f"TYPE U : {text} PROGRAM main VAR b : BOOL; u1 : U; END_VAR b := TRUE; END_PROGRAM", "main.st")
    assert [d.code for d in found.diagnostics if d.severity == "error"][0] == "LD0237"
    assert text[-1] == ";" or [d.code for d in found.diagnostics if d.severity == "error"] == ["LD0237"]


def test_a_call_by_name_need_not_be_complete(tmp_path: Path) -> None:
    """What is left out is the default of its type, with a warning; a call by position is an error."""
    text = """FUNCTION mixed : INT
VAR_INPUT a : INT; b : INT := 5; c : BOOL; END_VAR
    mixed := a + b;
    IF c THEN mixed := -mixed; END_IF;
END_FUNCTION
FUNCTION moved : INT
VAR_INPUT a : INT; END_VAR
VAR_OUTPUT twice : INT; END_VAR
    moved := a + 1; twice := a * 2;
END_FUNCTION
PROGRAM main
VAR x, y, z, t : INT := 9; END_VAR
    x := mixed(b := 2);
    y := mixed(EN := x > 0, b := 3, c := TRUE);
    z := moved(twice => t);
END_PROGRAM
"""
    told = compiled(text, "main.st").diagnostics
    assert [(d.code, d.severity) for d in told] == [("LD0171", "warning")] * 3
    assert trace(tmp_path, text, "main.st", [{}], ["x", "y", "z", "t"]) == [(2, -3, 1, 0)]
    assert "LD0507" in [d.code for d in checked(text.replace("b := 2", "2"), "main.st").diagnostics]


def test_trunc_is_of_the_integer_type_that_is_asked_for(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR r : REAL := 70000.9; n : INT; u : UINT; w : WORD; d : DINT; l : LINT; END_VAR
    n := TRUNC(-7.9 + r * 0.0);
    u := TRUNC(r);
    w := INT_TO_WORD(TRUNC(r / 10.0));
    d := TRUNC(r);
    l := TRUNC(r) + d;
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}], list("nuwdl")) == [(-7, 65535, 7000, 70000, 140000)]


def test_blocks_of_editors_are_there_in_texts(tmp_path: Path) -> None:
    """Those of annex F and of Util, as the pins that the text names tell; a component may have the same name."""
    text = """PROGRAM main
VAR
    h : HYSTERESIS; i : INTEGRAL; b : BLINK; c : PID; level, sum, out : REAL; high : BOOL;
END_VAR
    level := level + 1.0;
    h(XIN1 := level, XIN2 := 2.0, EPS := 0.5);
    high := h.Q;
    i(RUN := TRUE, R1 := FALSE, XIN := 100.0, X0 := 0.0, CYCLE := T#10ms);
    sum := i.XOUT;
    b(ENABLE := TRUE, TIMELOW := T#10ms, TIMEHIGH := T#10ms);
    c(AUTO := FALSE, PV := 1.0, SP := 2.0, X0 := 7.0, KP := 1.0, TR := 1.0, TD := 0.0, CYCLE := T#10ms);
    out := c.XOUT;
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{}] * 4, ["high", "sum", "out"])
    assert rows == [(False, 1.0, 7.0), (False, 2.0, 7.0), (True, 3.0, 7.0), (True, 4.0, 7.0)]
    own = "PROGRAM main VAR c : PID; END_VAR c(enable := TRUE, setpoint := 1.0, kp := 2.0); END_PROGRAM"
    assert "CYCLE" not in [v.name for u in compiled(own, "main.st").program.units for v in u.variables]


def test_debug_lines_that_openplc_appends_are_comments() -> None:
    """Each holds a line of C; casts to pointers have the end of a comment in them, or the beginning of one."""
    program = "PROGRAM main VAR n : INT; END_VAR n := 1; END_PROGRAM\n"
    lines = ("char md5[] = \"51af\";", "/**", " */", "#include <stdbool.h>", "", "    default:",
             "        return (void *)&((__IEC_BOOL_t *) ptr)->value;", "    void (*call)(int) = 0; // Don't")
    text = program + "".join(f"(*DBG:{line}*)\n" for line in lines) + "FUNCTION f : INT f := 2; END_FUNCTION\n"
    assert [unit.name for unit in compiled(text, "main.st").program.units] == ["main", "f"]
    formatted = format_file(parse_file(SourceFile("main.st", text), Diagnostics()))
    assert all(f"(*DBG:{line}*)\n" in formatted for line in lines)
    broken = checked(program + "(*DBG: a*) n := 1; (* b *) m\n", "main.st").diagnostics
    assert [d.code for d in broken] == ["LD0115"]


_COUNTED = """FUNCTION place : INT VAR_INPUT n : INT; END_VAR VAR_IN_OUT calls : DINT; END_VAR
    calls := 10 * calls + 1; place := n;
END_FUNCTION
FUNCTION long : TIME VAR_INPUT n : INT; END_VAR VAR_IN_OUT calls : DINT; END_VAR
    calls := 10 * calls + 2; long := n * T#1s;
END_FUNCTION
FUNCTION pure : TIME VAR_INPUT n : INT; END_VAR pure := n * T#1s; END_FUNCTION
PROGRAM main
VAR field : ARRAY [0..3] OF INT := [2(1), 5, 1]; times : ARRAY [0..1] OF TIME := [T#0s, T#3s]; t : TIME;
    calls : DINT; END_VAR
    calls := 0;
    t := %s;
END_PROGRAM
"""


@pytest.mark.parametrize("product, result", [
    ("long(2, calls) * field[place(2, calls)]", (10 * 10**9, 21)),
    ("field[place(2, calls)] * pure(3)", (15 * 10**9, 1)),
    ("field[place(2, calls)] * times[1]", (15 * 10**9, 1)),
])
def test_a_number_times_a_time_calls_functions_from_left_to_right(tmp_path: Path, product: str, result) -> None:
    assert trace(tmp_path, _COUNTED % product, "main.st", [{}], ("t", "calls")) == [result]


@pytest.mark.parametrize("product", [
    "field[place(2, calls)] * long(1, calls)", "place(2, calls) * long(1, calls)",
    "place(2, calls) * times[place(1, calls)]"])
def test_a_number_times_a_time_is_refused_where_the_order_of_calls_would_change(product: str) -> None:
    """The library takes the TIME first; that must not turn round two calls that write variables."""
    found = checked(_COUNTED % product, "main.st").diagnostics
    assert [(d.code, d.help) for d in found if d.severity == "error"] == [
        ("LD0410", "write the TIME first, or put one of them into a variable before: both call functions that write")]


def test_own_functions_and_blocks_take_the_place_of_standard_ones(tmp_path: Path) -> None:
    """Everywhere that the project says the name; blocks of the library call the standard ones as before."""
    text = """FUNCTION MAX : INT
VAR_INPUT a, b : INT; END_VAR
    MAX := a - b;
    IF MAX < 0 THEN MAX := MAX + b; END_IF;
END_FUNCTION
FUNCTION twice : INT
VAR_INPUT x : INT; END_VAR
    twice := MAX(2 * x, 0) + MIN(x, 0);
END_FUNCTION
FUNCTION_BLOCK TON
VAR_INPUT IN : BOOL; END_VAR
VAR_OUTPUT Q : BOOL; n : INT; END_VAR
    n := n + 1;
    Q := IN AND n >= 2;
END_FUNCTION_BLOCK
PROGRAM main
VAR go : BOOL; t : TON; late : TOF; x, y, z, n : INT; q, off : BOOL; END_VAR
    t(IN := go, Q => q);
    n := t.n;
    late(IN := q, PT := T#20ms);
    off := late.Q;
    x := MAX(7, 5);
    y := MAX(b := 5, a := 1);
    MAX(9, x, OUT => z);
    z := z + twice(4);
END_PROGRAM
"""
    told = compiled(text, "main.st").diagnostics
    assert [d.code for d in told] == ["LD0180"] * 2
    scans = [{"go": True}, {}, {"go": False}, {}, {}, {}]
    rows = trace(tmp_path, text, "main.st", scans, ["q", "off", "n", "x", "y", "z"])
    assert [row[:3] for row in rows] == [(False, False, 1), (True, True, 2), (False, True, 3), (False, True, 4),
                                         (False, False, 5), (False, False, 6)]
    assert {row[3:] for row in rows} == {(2, 1, 15)}


def test_own_functions_that_call_each_other_in_a_circle_are_told_by_any_name() -> None:
    text = """FUNCTION LEN : INT
VAR_INPUT s : STRING; END_VAR
    LEN := size(s);
END_FUNCTION
FUNCTION size : INT
VAR_INPUT s : STRING; END_VAR
    size := LEN(s);
END_FUNCTION
"""
    assert [d.code for d in checked(text, "main.st").diagnostics if d.severity == "error"] == ["LD0216"]


def test_pi_is_known_unless_the_project_declares_it(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR CONSTANT full : LREAL := 2 * PI; END_VAR
VAR a, b : REAL; c : LREAL; i : INT := 3; END_VAR
    a := SIN(PI / 6.0);
    b := i * pi;
    c := full - PI;
END_PROGRAM
"""
    (row,) = trace(tmp_path, text, "main.st", [{}], ["a", "b", "c"])
    assert row == pytest.approx((0.5, 9.424778, 3.141592653589793), rel=1e-6)
    own = text.replace("a, b", "PI : INT := 4; a, b").replace("SIN(PI / 6.0)", "PI")
    assert compiled(own.replace("2 * PI", "8.0"), "main.st").program
    assert [d.code for d in checked(text.replace("a := SIN", "PI := SIN"), "main.st").diagnostics] == ["LD0404"]


@pytest.mark.parametrize(("value", "what"), [
    ("n^3", "powers"), ("n^m", "powers"), ("2^(m + 1)", "powers"), ("n^", "pointers"), ("n^.m", "pointers"),
    ("n^ + 1", "pointers"), ("n^[2]", "pointers"),
])
def test_a_roof_is_told_as_what_it_is(value: str, what: str) -> None:
    told = list(checked(f"PROGRAM main VAR n, m : INT; END_VAR n := {value}; END_PROGRAM", "main.st").diagnostics)
    assert [(d.code, d.message.split()[0]) for d in told] == [("LD0237", what)]


def test_what_is_computed_from_an_enumeration_and_stored_in_it_is_told_once() -> None:
    text = """TYPE mode : (idle, run, stop); END_TYPE
PROGRAM main
VAR state : mode; n : INT; END_VAR
    state := state + 1;
    state := n;
END_PROGRAM
"""
    told = checked(text, "main.st").diagnostics
    assert [(d.code, d.message) for d in told] == [("LD0241", "a value of mode counts as INT here"),
                                                   ("LD0241", "INT counts as a value of mode here")]


def test_pins_of_standard_blocks_have_the_names_of_codesys_too(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR a, b : BOOL; reset : RS; set : SR; up : CTU; down : CTD; both : CTUD; n, m, k : INT; END_VAR
    reset(SET := a, RESET1 := b);
    set(SET1 := a, RESET := b);
    up(CU := a, RESET := b, PV := 3, CV => n);
    down(CD := a, LOAD := b, PV := 3, CV => m);
    both.RESET := FALSE;
    both(CU := a, CD := FALSE, LOAD := b, PV := 7, CV => k);
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{"a": True}, {"a": False, "b": True}], ["reset.Q1", "set.Q1", "n", "m", "k"])
    assert rows == [(True, True, 1, -1, 1), (False, False, 0, 3, 7)]
    told = checked(text.replace("RESET1", "RESET"), "main.st").diagnostics
    assert [d.code for d in told] == ["LD0505"]


def test_words_of_charts_are_names_where_no_chart_can_be_meant(tmp_path: Path) -> None:
    """Before another name they stay reserved; a printed IL calls them otherwise."""
    text = """TYPE record : STRUCT Step : INT; END_STRUCT; END_TYPE
FUNCTION_BLOCK sequence
VAR_OUTPUT Step : INT; END_VAR
VAR From, On : INT; END_VAR
    From := Step;
    IF Step >= 3 THEN Step := 0; ELSE Step := Step + 1; END_IF;
    On := From;
END_FUNCTION_BLOCK
PROGRAM main
VAR
    q : sequence; Action, With, n : INT; Transition : ARRAY [0..3] OF BOOL; x : BOOL; part : record;
END_VAR
    q();
    part.Step := part.Step + 2;
    n := q.Step + 10 * part.Step;
    Action := q.Step;
    Transition[Action] := NOT Transition[Action];
    CASE Action OF 1: With := 10; 2, 3: With := Action; END_CASE;
    x := Transition[1] AND With > 0;
END_PROGRAM
"""
    told = checked(text, "main.st").diagnostics
    assert not list(told)
    rows = trace(tmp_path, text, "main.st", [{}] * 4, ["n", "x"])
    assert rows == [(21, True), (42, True), (63, True), (80, True)]
    chart = """PROGRAM main
VAR step : INT; END_VAR
INITIAL_STEP begin: END_STEP
STEP wait: count(P1); END_STEP
TRANSITION FROM begin TO wait := step < 2; END_TRANSITION
TRANSITION go FROM wait TO begin := TRUE; END_TRANSITION
ACTION count: step := step + 1; END_ACTION
END_PROGRAM
"""
    assert not list(checked(chart, "main.st").diagnostics)


def test_pins_of_a_program_may_have_addresses(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR_INPUT start AT %IX0.0 : BOOL; END_VAR
VAR_OUTPUT run AT %QX0.0 : BOOL; END_VAR
    run := start OR run;
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}, {"start": True}, {"start": False}], ["run"]) == [
        (False,), (True,), (True,)]
    block = text.replace("PROGRAM", "FUNCTION_BLOCK")
    assert {d.code for d in checked(block, "main.st").diagnostics} == {"LD0213"}
