"""IL as it is printed: for other compilers to read, and the same again when it was read back."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.il_text import VARIABLES, library, read, read_all

from ldc.expr import Const, FieldStep, IndexStep, Load, Place
from ldc.il.literals import initial_text, literal, real_text, time_text
from ldc.il.program import Instr, Program, Resource, Run, RungCode, Task, Unit
from ldc.il.text import print_program, print_unit
from ldc.il.typecheck import check_unit
from ldc.symbols import Location, Variable
from ldc.types import (
    BOOL, BYTE, DATE, DINT, DT, DWORD, INT, LREAL, REAL, SINT, STRING, TIME, TOD, UINT, WORD, WSTRING, Array, Enum,
    Field, Instance, String, Struct, Subrange,
)

COLOUR = Enum("Colour", (("red", 0), ("amber", 5), ("green", 6)), 5)
RECIPE = Struct("Recipe", (Field("fill", TIME, 300_000_000), Field("level", Array(((0, 2),), REAL))))


@pytest.mark.parametrize("value, type_, bare, typed", [
    (True, BOOL, "TRUE", "TRUE"),
    (-5, INT, "-5", "-5"),
    (5, DINT, "5", "DINT#5"),
    (-7, SINT, "-7", "SINT#-7"),
    (9, BYTE, "9", "BYTE#9"),
    (255, WORD, "16#FF", "WORD#16#FF"),
    (1.5, REAL, "1.5", "1.5"),
    (100.0, REAL, "100.0", "100.0"),
    (2.0**100, REAL, "1.2676506E30", "1.2676506E30"),
    (0.1, LREAL, "0.1", "LREAL#0.1"),
    (1_500_000_000, TIME, "T#1500ms", "T#1500ms"),
    (-1_000, TIME, "T#-0.001ms", "T#-0.001ms"),
    (365, DATE, "D#1971-01-01", "D#1971-01-01"),
    (3_661_500_000_000, TOD, "TOD#01:01:01.5", "TOD#01:01:01.5"),
    (86_400_000_000_000, DT, "DT#1970-01-02-00:00:00", "DT#1970-01-02-00:00:00"),
    (b"it's $5\n\xe9", STRING, "'it$'s $$5$L$E9'", "'it$'s $$5$L$E9'"),
    ('"é', WSTRING, '"$"$00E9"', '"$"$00E9"'),
    (5, COLOUR, "Colour#amber", "Colour#amber"),
    (5, Subrange("", INT, 0, 9), "5", "5"),
])
def test_constants(value, type_, bare: str, typed: str) -> None:
    assert literal(value, type_) == bare
    assert literal(value, type_, typed=True) == typed


def test_initial_values_of_compound_types() -> None:
    assert initial_text((0, 0, 0, 7, 7), Array(((1, 5),), INT), dict) == "[3(0), 7, 7]"
    value = (("fill", 1_000_000), ("level", (1.0, 2.0, 3.0)))
    assert initial_text(value, RECIPE, dict) == "(fill := T#1ms, level := [1.0, 2.0, 3.0])"
    assert initial_text((("PT", 2_000_000),), Instance("TON"), lambda _: {"PT": TIME}) == "(PT := T#2ms)"


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_a_real_reads_back_exactly(value: float) -> None:
    unit, _ = read(f"LD {real_text(value, True)}\nST x")
    (load, _) = unit.rungs[0].code
    assert load.operand == Const(value, REAL)


@given(st.integers(-(1 << 63), (1 << 63) - 1))
def test_a_time_reads_back_exactly(value: int) -> None:
    unit, diagnostics = read(f"LD {time_text(value)}\nST t")
    assert unit is not None, [d.message for d in diagnostics]
    assert unit.rungs[0].code[0].operand == Const(value, TIME)


# ---- whole programs ---------------------------------------------------------------------------


def _place(root: str, type_, *steps, is_global: bool = False) -> Place:
    return Place(root, type_, steps, is_global)


def _project() -> Program:
    start, motor, run = _place("start", BOOL), _place("motor", BOOL), _place("run", BOOL)
    delay, level = _place("delay", Instance("TON")), _place("level", REAL, is_global=True)
    raw, scaled, share = _place("raw", INT), _place("scale", REAL), _place("share", REAL)
    scale = Unit("FUNCTION", "scale", (
        Variable("raw", INT, "input"), Variable("share", REAL, "input", 2.0), Variable("over", BOOL, "output"),
        Variable("scale", REAL),
    ), (RungCode("body", (
        Instr("LD", raw, INT), Instr("FN", None, REAL, "INT_TO_REAL"), Instr("MUL", share, REAL),
        Instr("ST", scaled, REAL), Instr("GT", Const(100.0, REAL), REAL), Instr("ST", _place("over", BOOL), BOOL),
    )),), REAL)
    main = Unit("PROGRAM", "conveyor", (
        Variable("start", BOOL, location=Location.parse("%IX0.0")),
        Variable("motor", BOOL, location=Location.parse("%QX0.0")),
        Variable("run", BOOL),
        Variable("delay", Instance("TON"), initial=(("PT", 2_000_000_000),)),
        Variable("recipe", RECIPE, retain=True),
        Variable("colour", COLOUR, initial=6),
        Variable("most", INT, constant=True, initial=12),
        Variable("list", Array(((1, 4),), INT), initial=(1, 1, 1, 9)),
        Variable("i", INT),
        Variable("_ldc_seal_in_P_start_1", BOOL, "hidden", False),
        Variable("_ldc_t1", BOOL, "temp"),
    ), (
        RungCode("seal_in", (
            Instr("LD", start), Instr("OR(", motor), Instr("AND", run), Instr(")"), Instr("ST", motor),
        ), "seal_in", "Start/stop (* with *) seal-in", "seal_in"),
        RungCode("r0123abcd_1", (
            Instr("LD", _place("delay", BOOL, FieldStep("Q"))), Instr("JMPC", name="seal_in"),
            Instr("LD", motor), Instr("ST", _place("delay", BOOL, FieldStep("IN"))), Instr("CAL", delay, delay.type),
            Instr("LD", _place("list", INT, IndexStep((Load(_place("i", INT)),), ((1, 4),))), INT),
            Instr("FN", None, REAL, "SCALE", (Const(1.5, REAL),), (("over", run),)),
            Instr("ST", level, REAL),
            Instr("LD", _place("%IW2", WORD, is_global=True), WORD),
            Instr("AND", Const(255, WORD), WORD), Instr("EQ", Const(10, WORD), WORD),
            Instr("ST", _place("_ldc_t1", BOOL)),
            Instr("LD", _place("colour", COLOUR), COLOUR), Instr("EQ", Const(6, COLOUR), COLOUR),
            Instr("JMPCN", name="_ldc_r0123abcd_1_1"),
            Instr("LD", Const(100_000, DINT), DINT), Instr("FN", None, REAL, "DINT_TO_REAL"),
            Instr("ST", level, REAL),
            Instr("LABEL", name="_ldc_r0123abcd_1_1"), Instr("RET"),
        )),
    ), title="Infeed conveyor")
    return Program(
        (*library("TON"), scale, main), (COLOUR, RECIPE),
        (Variable("level", REAL, "global", 1.5, retain=True), Variable("lamp", BOOL, "global",
                                                                      location=Location.parse("%QX1.0"))),
        (Resource("line", "master", (Task("fast", 10_000_000, 1), Task("edge", None, 2, _place(
            "lamp", BOOL, is_global=True))), (Run("conveyor", "CONVEYOR", "fast"),)),), (), "plant 1")


def test_a_whole_program_is_printed_for_other_compilers(golden) -> None:
    program = _project()
    for unit in program.units:
        assert check_unit(unit, program.units) == []
    golden("il_text_program.il", print_program(program))


def test_a_printed_program_reads_back_to_the_same_code() -> None:
    program = _project()
    text = print_program(program)
    units, diagnostics = read_all(text)
    assert not [d for d in diagnostics if d.severity == "error"]
    for unit in program.units[1:]:
        found = units[unit.name.upper()]
        assert found.title == unit.title
        assert [(r.key, r.label, r.name, r.code) for r in found.rungs] == [
            (r.key, r.label, r.name, r.code) for r in unit.rungs]
        kinds = {v.name: v.kind for v in unit.variables}
        assert {v.name: v.kind for v in found.variables if v.kind != "external"} == kinds
    again = Program(tuple(units.values()), program.types, program.globals, program.resources, (), program.name)
    assert print_program(again) == text


def test_names_that_are_words_of_il_are_renamed_everywhere() -> None:
    block = Unit("FUNCTION_BLOCK", "keeper", (Variable("S", BOOL, "input"), Variable("_S", BOOL, "output")), (
        RungCode("body", (Instr("LD", _place("S", BOOL)), Instr("ST", _place("_S", BOOL)))),))
    keeper = _place("k", Instance("KEEPER"))
    main = Unit("PROGRAM", "main", (
        Variable("LD", BOOL), Variable("ready", BOOL), Variable("k", keeper.type), Variable("up", Instance("CTD"))), (
        RungCode("ready", (
            Instr("LD", _place("LD", BOOL)), Instr("ST", _place("k", BOOL, FieldStep("S"))),
            Instr("CAL", keeper, keeper.type), Instr("LD", _place("ready", BOOL)),
            Instr("ST", _place("up", BOOL, FieldStep("LD"))), Instr("LD", _place("Add", INT, is_global=True), INT),
            Instr("EQ", Const(0, INT), INT), Instr("JMPC", name="ready")), "ready", None, "ready"),))
    text = print_program(Program((*library("CTD"), block, main), (), (Variable("Add", INT, "global"),), ()))
    assert "    _S2 : BOOL;" in text and "LD      _S2" in text
    assert "    _LD " in text and "LD      _LD\n    ST      k._S2" in text
    assert "ST      up.LD" in text, "the pins of standard blocks keep their names"
    assert "VAR_EXTERNAL\n    _Add : INT;" in text and "LD      _Add" in text
    assert "_ready:\n" in text and "JMPC    _ready" in text, "a label is no variable"
    units, diagnostics = read_all(text.replace("CONFIGURATION config\n", "").replace("END_CONFIGURATION\n", ""))
    assert not [d.message for d in diagnostics if d.severity == "error"]
    assert print_unit(units["KEEPER"]) in text


def test_the_first_argument_of_a_call_with_outputs_may_be_a_computed_value() -> None:
    scale = Unit("FUNCTION", "scale", (Variable("raw", REAL, "input"), Variable("over", BOOL, "output"),
                                       Variable("scale", REAL)), (), REAL)
    x, over = _place("x", REAL), _place("a", BOOL)
    main = Unit("PROGRAM", "main", (Variable("x", REAL), Variable("a", BOOL)), (RungCode("body", (
        Instr("LD", x, REAL), Instr("MUL", x, REAL), Instr("FN", None, REAL, "SCALE", (), (("over", over),)),
        Instr("ST", x, REAL))),))
    text = print_unit(main, (scale,))
    assert "    MUL     x\n    ST      _ldc_first_1\n    scale(\n        raw := _ldc_first_1,\n" in text
    units, _ = read_all(print_unit(scale) + text)
    assert print_unit(units["MAIN"], (scale,)) == text


def test_an_empty_program_prints_nothing() -> None:
    assert print_program(Program((), (), (), ())) == ""


# ---- random code ------------------------------------------------------------------------------

_NAMES = {
    BOOL: ("a", "b", "c", "delay.Q", "timers[1].Q", "w.3"), INT: ("i", "j", "list[2]", "list[i]"), DINT: ("d",),
    UINT: ("u",), REAL: ("x",), LREAL: ("y",), BYTE: ("n",), WORD: ("w",), TIME: ("t", "delay.ET"), DATE: ("day",),
    TOD: ("clock",), String("STRING", 20): ("text",),
}
_NUMBERS = (INT, DINT, UINT, REAL, LREAL)
_FUNCTIONS = {
    BOOL: (("INT_TO_BOOL", INT, ()),), INT: (("LIMIT", INT, (INT, INT)), ("SEL", BOOL, (INT, INT)), ("ABS", INT, ())),
    DINT: (("INT_TO_DINT", INT, ()), ("REAL_TO_DINT", REAL, ())), UINT: (("MAX", UINT, (UINT,)),),
    REAL: (("SQRT", REAL, ()), ("EXPT", REAL, (INT,)), ("MIN", REAL, (REAL,))), LREAL: (("REAL_TO_LREAL", REAL, ()),),
    BYTE: (("ROL", BYTE, (INT,)),), WORD: (("SHL", WORD, (INT,)), ("BYTE_TO_WORD", BYTE, ())),
    TIME: (("MULTIME", TIME, (INT,)), ("SEL", BOOL, (TIME, TIME)), ("SUB_TOD_TOD", TOD, (TOD,))),
    TOD: (("ADD_TOD_TIME", TOD, (TIME,)),),
}


def _operand_of(type_) -> st.SearchStrategy:
    def parsed(name: str) -> Place:
        unit, diagnostics = read(f"LD {name}")
        assert unit is not None, [d.message for d in diagnostics]
        return unit.rungs[0].code[0].operand

    places = [parsed(name) for name in _NAMES[type_]]
    if isinstance(type_, String):
        constants = st.binary(max_size=20).map(lambda v: Const(v, STRING))
    elif type_.kind == "real":
        width = type_.bits
        constants = st.floats(width=width, allow_nan=False, allow_infinity=False).map(lambda v: Const(v, type_))
    elif type_.kind == "bool":
        constants = st.booleans().map(lambda v: Const(v, BOOL))
    else:
        low, high = (0, 10_000) if type_.kind in ("date", "tod") else type_.range
        constants = st.integers(low, high).map(lambda v: Const(v, type_))
    return st.sampled_from(places) | constants


_OPERANDS = {type_: _operand_of(type_) for type_ in _NAMES}


@st.composite
def expressions(draw, type_, depth: int = 3) -> list[Instr]:
    """Code that leaves a value of the type in the accumulator."""
    operand = draw(_OPERANDS[type_])
    functions = _FUNCTIONS.get(type_, ())
    if depth and functions and draw(st.integers(0, 3)) == 0:
        name, first, others = draw(st.sampled_from(functions))
        args = tuple(draw(_OPERANDS[t]) for t in others)
        return [*draw(expressions(first, depth - 1)), Instr("FN", None, type_, name, args)]
    if depth and type_ == BOOL and draw(st.integers(0, 3)) == 0:
        other = draw(st.sampled_from([t for t in _NAMES if t != BOOL]))
        return draw(joined(draw(expressions(other, depth - 1)), ("GT", "EQ", "LE"), other, depth))
    code = [Instr(draw(st.sampled_from(("LD", "LDN"))) if type_ == BOOL else "LD", operand, operand.type)]
    if type_ in (BOOL, BYTE, WORD):
        operators = ("AND", "OR", "XOR", "ANDN", "ORN", "XORN")
    elif type_ in _NUMBERS:
        operators = ("ADD", "SUB", "MUL", "DIV") + (("MOD",) if type_.kind != "real" else ())
    else:
        operators = ("ADD", "SUB") if type_ == TIME else ()
    for _ in range(draw(st.integers(0, 3)) if operators else 0):
        code = draw(joined(code, operators, type_, depth))
    if type_ in (BOOL, WORD) and draw(st.booleans()):
        code.append(Instr("NOT", None, type_))
    return code


@st.composite
def joined(draw, code: list[Instr], operators, type_, depth: int) -> list[Instr]:
    op = draw(st.sampled_from(operators))
    if not depth or draw(st.booleans()):
        return [*code, Instr(op, draw(_OPERANDS[type_]), type_)]
    inner = draw(expressions(type_, depth - 1))
    if inner[0].op == "LD" and draw(st.booleans()):
        return [*code, Instr(op + "(", inner[0].operand, type_), *inner[1:], Instr(")", None, type_)]
    return [*code, Instr(op + "(", None, type_), *inner, Instr(")", None, type_)]


_TARGETS = {type_: Place(names[0], type_) for type_, names in _NAMES.items()}


@st.composite
def statements(draw, labels: tuple[str, ...]) -> list[Instr]:
    type_ = draw(st.sampled_from(list(_NAMES)))
    target = _TARGETS[type_]
    choice = draw(st.integers(0, 5))
    if choice == 0:
        op = draw(st.sampled_from(("JMPC", "JMPCN")))
        return [*draw(expressions(BOOL)), Instr(op, name=draw(st.sampled_from(labels)))]
    if choice == 1:
        op = draw(st.sampled_from(("S", "R", "STN")))
        return [*draw(expressions(BOOL)), Instr(op, Place("a", BOOL))]
    if choice == 2:
        delay = Place("delay", Instance("TON"))
        conditional = draw(st.sampled_from(("CALC", "CALCN")))
        return draw(st.sampled_from(([Instr("CAL", delay, delay.type)], [
            *draw(expressions(BOOL)), Instr(conditional, delay, delay.type), Instr("RETC")])))
    return [*draw(expressions(type_)), Instr("ST", target, type_)]


class Made(tuple):
    """Rungs that show as text when a test fails."""

    def __repr__(self) -> str:
        return print_unit(Unit("PROGRAM", "main", (), tuple(self)))


@st.composite
def rungs(draw) -> Made:
    count = draw(st.integers(1, 3))
    labels = tuple(f"rung_{n}" for n in range(count))
    result = []
    for n in range(count):
        inner = f"_ldc_rung_{n}_1"
        code = [i for s in draw(st.lists(statements((*labels, inner)), min_size=1, max_size=4)) for i in s]
        if draw(st.booleans()):
            code += [Instr("LABEL", name=inner), *draw(statements((*labels, inner)))]
        code = [i for i in code if i.name != inner or any(j.op == "LABEL" for j in code)]
        title = draw(st.none() | st.text("ab *()\"'$é;:", min_size=1, max_size=8).map(str.strip))
        result.append(RungCode(labels[n], tuple(code), labels[n], title or None, labels[n]))
    return Made(result)


@settings(max_examples=60, deadline=None)
@given(rungs())
def test_random_code_is_sound_and_reads_back_equal(made: Made) -> None:
    frame, _ = read("LD a")
    unit = Unit("PROGRAM", "main", frame.variables, tuple(made))
    assert check_unit(unit) == []
    text = print_unit(unit)
    units, diagnostics = read_all(text)
    assert "MAIN" in units, [f"{d.code} {d.message} {d.primary.span}" for d in diagnostics]
    assert [(r.key, r.label, r.name, _plain(r.code)) for r in units["MAIN"].rungs] == [
        (r.key, r.label, r.name, _plain(r.code)) for r in made]
    assert print_unit(units["MAIN"]) == text


def _plain(code: tuple[Instr, ...]) -> list[Instr]:
    """Which of two lengths of strings an operator is said to work in means nothing."""
    return [replace(i, type=STRING) if isinstance(i.type, String) else i for i in code]


def test_every_variable_block_is_printed_as_it_was_declared() -> None:
    unit, _ = read("LD a")
    text = print_unit(unit)
    declared = [line.strip() for line in VARIABLES.splitlines() if line.startswith("    ")]
    names = [n.strip() for line in declared for n in line.split(":")[0].split(",")]
    assert [line.split()[0] for line in text.splitlines() if line.startswith("    ") and ":" in line] == names
    assert "VAR CONSTANT\n    most : INT := 7;\nEND_VAR" in text
    assert f"text   : {String('STRING', 20)};" in text
    assert DWORD.name not in text
