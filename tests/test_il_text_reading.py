"""IL text is understood: what every instruction of the standard becomes, and what is said to mistakes."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.il_text import code, read, read_all

from ldc.il.typecheck import check_unit


def test_logic_with_operands_on_the_line_and_on_the_next() -> None:
    written = code("""
        LD a
        OR( b
        AND c
        )
        AND(
        LDN a
        OR b
        )
        ANDN c   (* not *)
        & b      // the same as AND
        &N a
        XOR b
        STN c
    """)
    assert written == [
        "LD BOOL a", "OR( BOOL b", "AND BOOL c", ") BOOL", "AND( BOOL", "LDN BOOL a", "OR BOOL b", ") BOOL",
        "ANDN BOOL c", "AND BOOL b", "ANDN BOOL a", "XOR BOOL b", "STN BOOL c",
    ]


def test_a_closing_parenthesis_may_stand_on_the_line_of_the_last_operand() -> None:
    assert code("LD a\nAND( b\nOR c )\nST a") == ["LD BOOL a", "AND( BOOL b", "OR BOOL c", ") BOOL", "ST BOOL a"]
    assert code("LD a\nAND(b)\nST a") == ["LD BOOL a", "AND( BOOL b", ") BOOL", "ST BOOL a"]


def test_words_and_names_in_any_case() -> None:
    assert code("ld A\nandn B\nst C") == ["LD BOOL a", "ANDN BOOL b", "ST BOOL c"]


def test_a_semicolon_may_end_a_line() -> None:
    """As the example of IEC 61131-10 has it; elsewhere it does not belong there."""
    assert code("LD a;\nAND( b ; // and\nOR c\n);\nST a ;\nCALC delay(IN := a, PT := T#1s);") == code(
        "LD a\nAND( b\nOR c\n)\nST a\nCALC delay(IN := a, PT := T#1s)")


def test_jumps_and_labels() -> None:
    assert code("LD a\nJMPC Over\nLD b\nST c\nJMP end\nover: LD c\nRETCN\nEND:\nRETURN") == [
        "LD BOOL a", "JMPC BOOL over", "LD BOOL b", "ST BOOL c", "JMP BOOL END", "over:", "LD BOOL c",
        "RETCN BOOL", "END:", "RET BOOL",
    ]


def test_a_label_does_not_change_the_result() -> None:
    """What every way to the label leaves goes on behind it, by a temporary."""
    assert code("LD a\nJMPC no\nLD i\nADD 1\nJMP out\nno: LD most\nout:\nST d\nST i") == [
        "LD BOOL a", "JMPC BOOL no", "LD INT i", "ADD INT 1", "ST INT _ldc_x_1", "JMP BOOL out", "no:",
        "LD INT most", "ST INT _ldc_x_1", "out:", "LD INT _ldc_x_1", "ST INT _ldc_x_2", "FN DINT INT_TO_DINT",
        "ST DINT d", "LD INT _ldc_x_2", "ST INT i"]
    assert code("LD a\nJMPC l\nNOT\nl: AND b\nST c") == [
        "LD BOOL a", "ST BOOL _ldc_x_1", "JMPC BOOL l", "NOT BOOL", "ST BOOL _ldc_x_1", "l:",
        "LD BOOL _ldc_x_1", "AND BOOL b", "ST BOOL c"]
    assert code("LD i\nl: ADD 1\nST i\nLD i\nJMP l")[:4] == [
        "LD INT i", "ST INT _ldc_x_1", "l:", "LD INT _ldc_x_1"]
    assert code("LD a\nl: LD b\nST c") == ["LD BOOL a", "l:", "LD BOOL b", "ST BOOL c"]


@pytest.mark.parametrize("call, expected", [
    ("CAL delay", ["CAL TON delay"]),
    ("CAL timers[1]", ["CAL TON timers[1]"]),
    ("CAL delay(a, T#1s, b)", ["LD BOOL a", "ST BOOL delay.IN", "LD TIME 1000000000", "ST TIME delay.PT",
                               "CAL TON delay", "LD BOOL delay.Q", "ST BOOL b"]),
    ("CAL delay(\n  IN := a, (* a comment, with a comma *)\n  ET => t\n)",
     ["LD BOOL a", "ST BOOL delay.IN", "CAL TON delay", "LD TIME delay.ET", "ST TIME t"]),
    ("CAL delay(NOT Q => b)", ["CAL TON delay", "LD BOOL delay.Q", "NOT BOOL", "ST BOOL b"]),
    ("CAL delay()", ["CAL TON delay"]),
    ("CAL count(PV := 5, CV => d)",
     ["LD INT 5", "ST INT count.PV", "CAL CTU count", "LD INT count.CV", "FN DINT INT_TO_DINT", "ST DINT d"]),
    ("LD a\nCALCN delay", ["LD BOOL a", "CALCN TON delay"]),
    ("LD a\nCALC count(CU := b)",
     ["LD BOOL a", "JMPCN BOOL _ldc_skip_1", "LD BOOL b", "ST BOOL count.CU", "CAL CTU count", "_ldc_skip_1:"]),
    ("LD a\nS1 latch", ["LD BOOL a", "ST BOOL latch.S1", "CAL SR latch"]),
    ("LD a\nR latch", ["LD BOOL a", "ST BOOL latch.R", "CAL SR latch"]),
    ("LD t\nPT timers[0]", ["LD TIME t", "ST TIME timers[0].PT", "CAL TON timers[0]"]),
])
def test_calls_of_function_blocks(call: str, expected: list[str]) -> None:
    assert code(call) == expected


FUNCTIONS = """FUNCTION scaled : REAL
VAR_INPUT raw : DINT; gain : REAL := 2.0; offset : REAL; END_VAR
VAR_OUTPUT over : BOOL; END_VAR
    LD raw
    DINT_TO_REAL
    MUL gain
    ADD offset
    ST scaled
    GT 100.0
    ST over
END_FUNCTION
FUNCTION seven : INT
    LD 7
    ST seven
END_FUNCTION
"""


@pytest.mark.parametrize("call, expected", [
    ("LD i\nLIMIT 0, 10\nST i", ["LD INT i", "FN INT LIMIT 0, 10", "ST INT i"]),
    ("LD d\nLIMIT 0, 100000", ["LD DINT d", "FN DINT LIMIT 0, 100000"]),
    ("LIMIT(MX := 10, IN := i, MN := 1)\nST j", ["LD INT 1", "FN INT LIMIT i, 10", "ST INT j"]),
    ("LD x\nSQRT\nST x", ["LD REAL x", "FN REAL SQRT", "ST REAL x"]),
    ("LD i\nINT_TO_REAL\nST x", ["LD INT i", "FN REAL INT_TO_REAL", "ST REAL x"]),
    ("LD a\nSEL i, j\nST i", ["LD BOOL a", "FN INT SEL i, j", "ST INT i"]),
    ("LD i\nMAX d\nST d", ["LD INT i", "FN DINT INT_TO_DINT", "FN DINT MAX d", "ST DINT d"]),
    ("LD t\nMUL 2\nST t", ["LD TIME t", "FN TIME MULTIME 2", "ST TIME t"]),
    ("LD clock\nADD t\nST clock",
     ["LD TIME_OF_DAY clock", "FN TIME_OF_DAY ADD_TOD_TIME t", "ST TIME_OF_DAY clock"]),
    ("LD d\nscaled 1.5, 2.0\nST x", ["LD DINT d", "FN REAL SCALED 1.5, 2.0", "ST REAL x"]),
    ("LD d\nscaled\nST x", ["LD DINT d", "FN REAL SCALED 2.0, 0.0", "ST REAL x"]),
    ("LD i\nscaled 1.5\nST x", ["LD INT i", "FN DINT INT_TO_DINT", "FN REAL SCALED 1.5, 0.0", "ST REAL x"]),
    ("scaled(raw := d,\n offset := 1.0,\n over => a)\nST x",
     ["LD DINT d", "FN REAL SCALED 2.0, 1.0 over=>a", "ST REAL x"]),
    ("seven\nST i", ["FN INT SEVEN", "ST INT i"]),
])
def test_functions(call: str, expected: list[str]) -> None:
    assert code(call, FUNCTIONS) == expected


def test_an_argument_that_widens_goes_through_a_temporary_and_the_accumulator_comes_back() -> None:
    assert code("LD d\nMAX i\nST d") == [
        "LD DINT d", "ST DINT _ldc_x_1", "LD INT i", "FN DINT INT_TO_DINT", "ST DINT _ldc_x_2",
        "LD DINT _ldc_x_1", "FN DINT MAX _ldc_x_2", "ST DINT d",
    ]


@pytest.mark.parametrize("body, expected", [
    ("LD i\nST d", ["LD INT i", "FN DINT INT_TO_DINT", "ST DINT d"]),
    ("LD i\nADD d\nST d", ["LD INT i", "FN DINT INT_TO_DINT", "ADD DINT d", "ST DINT d"]),
    ("LD d\nADD i\nST d", ["LD DINT d", "ADD( DINT i", "FN DINT INT_TO_DINT", ") DINT", "ST DINT d"]),
    ("LD u\nADD i\nST d", ["LD UINT u", "FN DINT UINT_TO_DINT", "ADD( DINT i", "FN DINT INT_TO_DINT", ") DINT",
                           "ST DINT d"]),
    ("LD i\nADD( d\nMUL 2\n)\nST d",
     ["LD INT i", "FN DINT INT_TO_DINT", "ADD( DINT d", "MUL DINT 2", ") DINT", "ST DINT d"]),
    ("LD i\nST d\nST j", ["LD INT i", "ST INT _ldc_x_1", "FN DINT INT_TO_DINT", "ST DINT d", "LD INT _ldc_x_1",
                          "ST INT j"]),
    ("LD x\nGT i\nST a", ["LD REAL x", "GT( REAL i", "FN REAL INT_TO_REAL", ") REAL", "ST BOOL a"]),
])
def test_values_widen_where_nothing_is_lost(body: str, expected: list[str]) -> None:
    assert code(body) == expected


@pytest.mark.parametrize("body, expected", [
    ("LD 0\nST u", ["LD UINT 0", "ST UINT u"]),
    ("LD 1\nST a", ["LD BOOL True", "ST BOOL a"]),
    ("LD 0\nST i\nST u\nST x", ["LD INT 0", "ST INT i", "LD UINT 0", "ST UINT u", "LD REAL 0.0", "ST REAL x"]),
    ("LD 5\nADD 3\nMUL d\nST d", ["LD DINT 5", "ADD DINT 3", "MUL DINT d", "ST DINT d"]),
    ("LD d\nADD( 5\nMUL 2\n)\nST d", ["LD DINT d", "ADD( DINT 5", "MUL DINT 2", ") DINT", "ST DINT d"]),
    ("LD 5\nADD( 2\nMUL 3\n)\nST u", ["LD UINT 5", "ADD( UINT 2", "MUL UINT 3", ") UINT", "ST UINT u"]),
    ("LD 5\nGT 3\nST a", ["LD INT 5", "GT INT 3", "ST BOOL a"]),
    ("LD 16#FF\nAND w\nST w", ["LD WORD 255", "AND WORD w", "ST WORD w"]),
    ("LD w\nAND 16#00FF\nEQ 0\nST a", ["LD WORD w", "AND WORD 255", "EQ WORD 0", "ST BOOL a"]),
    ("LD 100000\nADD 1\nST d", ["LD DINT 100000", "ADD DINT 1", "ST DINT d"]),
    ("LD most\nADD list[i]\nST list[2]", ["LD INT most", "ADD INT list[i]", "ST INT list[2]"]),
    ("LD w.3\nST w.4", ["LD BOOL w.3", "ST BOOL w.4"]),
    ("LD 'it$'s; (* no comment *)'\nST text", ["LD STRING[80] b\"it's; (* no comment *)\"", "ST STRING[20] text"]),
])
def test_literals_take_the_type_that_is_asked_for(body: str, expected: list[str]) -> None:
    assert code(body) == expected


def test_comments_of_the_printer_divide_the_code_into_rungs() -> None:
    unit, _ = read('(* rung "one": first of all *)\none:\nLD a\nST b\n(* rung "r00000000_1" *)\n\n'
                   '(* rung "two" *)\nLD b\nJMPC one')
    assert [(r.key, r.name, r.title, r.label, len(r.code)) for r in unit.rungs] == [
        ("one", "one", "first of all", "one", 2), ("r00000000_1", None, None, None, 0),
        ("two", "two", None, None, 2)]


def test_a_mark_does_not_part_what_belongs_together() -> None:
    carried, _ = read('LD a\n(* rung "x" *)\nST b')
    assert [(r.key, len(r.code)) for r in carried.rungs] == [("body", 2)]
    entered, _ = read('(* rung "x" *)\nLD a\nJMPC mid\n(* rung "y" *)\nLD b\nST c\nmid:\nLD a\nST b')
    assert [(r.key, len(r.code)) for r in entered.rungs] == [("body", 7)]


@pytest.mark.parametrize("body, code_, at", [
    ("LD a\nANDD b", "LD0701", "ANDD"),
    ("LD a\nTON", "LD0701", "TON"),
    ("LD a\n:= b", "LD0701", ":= b"),
    ("LD", "LD0702", "LD"),
    ("LD a\nJMPC", "LD0702", "JMPC"),
    ("LD a; AND b\nST b", "LD0101", ";"),
    ("LD i\nMAX ,3", "LD0702", ""),
    ("LD a\nNOT b", "LD0703", "b"),
    ("LD (a)", "LD0703", "LD (a)"),
    ("LD x\nSUB 1.0, 2.0", "LD0703", "2.0"),
    ("CAL delay(IN := a) b", "LD0703", "b"),
    ("LD a\nOR( b\nST c", "LD0704", "OR( b"),
    ("LD a\n)\nST b", "LD0704", ")"),
    ("CAL delay(IN := a\nLD a", "LD0704", "("),
    ("JMP nowhere", "LD0705", "nowhere"),
    ("x1:\nX1:\nLD a", "LD0706", "X1"),
    ("ST a", "LD0707", "ST a"),
    ("CAL delay\nST a", "LD0707", "ST a"),
    ("JMP over\nover: ANDN b\nST c", "LD0707", "ANDN b"),
    ("LD a\nCAL delay\nover: ANDN b\nST c", "LD0707", "ANDN b"),
    ("LD a\nJMPC l\nCAL delay\nl: ST b", "LD0707", "ST b"),
    ("LD i\nl: ADD 1\nST i\nCAL delay\nJMP l", "LD0707", "JMP l"),
    ("LD i\nJMP l\nLD x\nl: ST x", "LD0708", "l"),
    ("LD a\nAND(\n)\nST b", "LD0707", ")"),
    ("LD a\nADD i", "LD0708", "ADD i"),
    ("LD a\nADD b", "LD0708", "ADD b"),
    ("LD d\nST i", "LD0708", "ST i"),
    ("LD i\nJMPC l\nl:", "LD0708", "JMPC l"),
    ("LD i\nS a", "LD0708", "S a"),
    ("LD a\nS i", "LD0708", "S i"),
    ("LD x\nMOD x", "LD0708", "MOD x"),
    ("LD 5\nAND 3\nST i", "LD0708", "AND 3"),
    ("LD delay\nST a", "LD0708", "delay"),
    ("LD list\nST i", "LD0708", "ST i"),
    ("LD list\nEQ list", "LD0708", "list"),
    ("LD list\nEQ( list\n)", "LD0708", ")"),
    ("LD list\nEQ(\nLD list\n)", "LD0708", ")"),
    ("LD list\nNOT", "LD0708", "NOT"),
    ("LD list[i + 1]", "LD0709", "list[i + 1]"),
    ("LD i + 1", "LD0709", "i + 1"),
    ("CAL a", "LD0710", "a"),
    ("LD a\nAND( b\nJMP l\n)\nl:", "LD0711", "JMP l"),
    ("LD i\nST most", "LD0503", "most"),
    ("LD a\nST delay.Q", "LD0503", "delay.Q"),
    ("LD nope", "LD0404", "nope"),
    ("CAL delay(INN := a)", "LD0505", "INN"),
    ("CAL delay(IN := a, IN := b)", "LD0506", "IN"),
    ("CAL delay(IN => a)", "LD0508", "IN"),
    ("CAL delay(a, t, b, t, b)", "LD0509", "b"),
    ("LD x\nST u\nST i\nST a", "LD0708", "ST u"),
    ("LIMIT(MN := 0, IN := i)", "LD0507", "LIMIT(MN := 0, IN := i)"),
    ("LD i\nLIMIT 0", "LD0410", "LIMIT 0"),
])
def test_a_mistake_has_one_finding_where_it_was_made(body: str, code_: str, at: str) -> None:
    unit, diagnostics = read(body)
    errors = [d for d in diagnostics if d.severity == "error"]
    assert unit is None
    assert [d.code for d in errors] == [code_], [f"{d.code} {d.message}" for d in errors]
    assert errors[0].primary.span.text == at
    assert errors[0].help or code_[:4] != "LD07"


def test_parentheses_nest_a_hundred_levels_deep_and_no_deeper() -> None:
    assert len(code("LD a\n" + "OR( b\n" * 100 + ")\n" * 100 + "ST c")) == 202
    unit, diagnostics = read("LD a\n" + "OR( b\n" * 5000 + ")\n" * 5000 + "ST c")
    assert unit is None and [d.code for d in diagnostics] == ["LD0712"]


def test_the_word_that_was_meant_is_suggested() -> None:
    assert "`LIMIT`" in next(iter(read("LD i\nLIMITT 0, 1")[1])).help
    assert "`scaled`" in next(iter(read("LD d\nscaledd", FUNCTIONS)[1])).help


def test_a_function_block_with_in_out_pins() -> None:
    units, diagnostics = read_all("""
FUNCTION_BLOCK bump
VAR_IN_OUT total : INT; END_VAR
    LD total
    ADD 1
    ST total
END_FUNCTION_BLOCK
PROGRAM main
VAR one : bump; sum : INT; END_VAR
    CAL one(total := sum)
    LD sum
    ST one.total
END_PROGRAM
""")
    assert not list(diagnostics)
    (rung,) = units["MAIN"].rungs
    assert [(i.op, str(i.operand)) for i in rung.code] == [
        ("LD", "sum"), ("ST", "one.total"), ("CAL", "one"), ("LD", "one.total"), ("ST", "sum"),
        ("LD", "sum"), ("ST", "one.total")]


_PIECES = st.sampled_from(
    "LD ST ANDN AND( OR( ) JMPC JMP l l: CAL delay ( := => , a b i d 5 16#FF T#1s 'x' \" (* *) // \n \n \n & NOT LIMIT "
    "MAX RET delay. [1] list [ ] i+1 S R latch TRUE scaled %IX0.0 ; $ \x00 é".split(" ") + ["\n"])


@given(st.lists(_PIECES, max_size=40).map(" ".join))
def test_no_text_ends_in_an_exception_and_what_is_accepted_is_sound(body: str) -> None:
    unit, _ = read(body, FUNCTIONS)
    assert unit is None or check_unit(unit) == []
