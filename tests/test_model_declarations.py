"""Declarations: types, constants, initial values, addresses, names, who calls whom."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc import types
from ldc.library import blocks
from ldc.model.settings import Settings
from tests.modelling import modelled, program


def variable(declaration: str, before: str = ""):
    found = modelled(program(declaration, before=before))
    assert not found.diagnostics.has_errors, found.text
    return found.model.pous["MAIN"].variables[declaration.split()[0].upper()]


# ---- types and initial values -----------------------------------------------------------------------


@pytest.mark.parametrize(("declaration", "type_", "initial"), [
    ("x : BOOL;", "BOOL", None),
    ("x : BOOL := TRUE;", "BOOL", True),
    ("x : BOOL := 1;", "BOOL", True),
    ("x : INT := -5;", "INT", -5),
    ("x : INT := 2 * (3 + 4);", "INT", 14),
    ("x : REAL := 5;", "REAL", 5.0),
    ("x : REAL := 1.0 / 3.0;", "REAL", 0.3333333432674408),
    ("x : LREAL := 1.0 / 3.0;", "LREAL", 1 / 3),
    ("x : WORD := 16#FFFF;", "WORD", 65535),
    ("x : DINT := INT#7;", "DINT", 7),
    ("x : TIME := T#1s500ms;", "TIME", 1_500_000_000),
    ("x : TIME := T#1s + T#20ms;", "TIME", 1_020_000_000),
    ("x : STRING := 'abc';", "STRING[80]", b"abc"),
    ("x : STRING[5] := CONCAT('ab', 'cd');", "STRING[5]", b"abcd"),
    ("x : WSTRING[4] := \"ab\";", "WSTRING[4]", "ab"),
    ("x : ARRAY [1..3] OF INT := [1, 2(7)];", "ARRAY [1..3] OF INT", (1, 7, 7)),
    ("x : ARRAY [1..2, 0..1] OF INT := [5];", "ARRAY [1..2, 0..1] OF INT", (5, 0, 0, 0)),
    ("x : TON := (PT := T#5s);", "TON", (("PT", 5_000_000_000),)),
    ("x : INT (0..10) := 10;", "INT(0..10)", 10),
])
def test_types_and_initial_values(declaration: str, type_: str, initial) -> None:
    found = variable(declaration)
    assert (str(found.type), found.initial) == (type_, initial)


TYPES = """
TYPE
    Line : ARRAY [1..LENGTH] OF Point;
    Point : STRUCT x : REAL := 1.5; y : Percent; m : Mode; END_STRUCT;
    Percent : INT (0..100) := 10;
    Mode : (stopped, slow := 5, fast) := slow;
    Speed : Percent;
    Start : Point := (x := 3.0);
END_TYPE
VAR_GLOBAL CONSTANT LENGTH : INT := HALF * 2; HALF : INT := 1; END_VAR
"""


def test_declared_types_may_stand_in_any_order() -> None:
    line = variable("l : Line;", TYPES)
    assert line.type.bounds == ((1, 2),)
    one = (("x", 1.5), ("y", 10), ("m", 5))
    assert types.default(line.type) == (one, one)


def test_the_initial_value_of_a_type_is_that_of_its_variables() -> None:
    assert variable("s : Speed;", TYPES).initial == 10
    assert variable("p : Start;", TYPES).initial == (("x", 3.0), ("y", 10), ("m", 5))
    assert variable("p : Point := (y := 4);", TYPES).initial == (("x", 1.5), ("y", 4), ("m", 5))
    assert variable("a : ARRAY [0..1] OF Percent;", TYPES).initial == (10, 10)
    assert variable("m : Mode := fast;", TYPES).initial == 6
    assert types.default(variable("m : Mode;", TYPES).type) == 5


def test_enumerations_without_a_name_print_as_they_are_declared() -> None:
    found = variable("m : (open, shut := 7) := shut;")
    assert str(found.type) == "(open := 0, shut := 7)"
    assert found.initial == 7


def test_constants_of_the_pou_are_known_in_its_bounds() -> None:
    found = modelled("PROGRAM p VAR a : ARRAY [1..n] OF BOOL; END_VAR "
                     "VAR CONSTANT n : INT := 3; END_VAR END_PROGRAM")
    assert found.model.pous["P"].variables["A"].type.bounds == ((1, 3),)
    assert found.codes == []


@pytest.mark.parametrize(("declaration", "code", "marked"), [
    ("x : SINT := 200;", "LD0402", "200"),
    ("x : INT := 1.5;", "LD0403", "1.5"),
    ("x : INT := 'a';", "LD0403", "'a'"),
    ("x : INT (0..10) := 11;", "LD0402", "11"),
    ("x : STRING[2] := 'abc';", "LD0402", "'abc'"),
    ("x : STRING[2] := CONCAT('ab', 'c');", "LD0402", "CONCAT('ab', 'c')"),
    ("x : STRING[0];", "LD0208", "0"),
    ("x : INT (10..0);", "LD0208", "10..0"),
    ("x : ARRAY [1.5..2] OF INT;", "LD0208", "1.5"),
    ("x : INT := 1 / 0;", "LD0411", "0"),
    ("x : ARRAY [1..2] OF INT := 5;", "LD0210", "5"),
    ("x : ARRAY [1..2] OF INT := [3(1)];", "LD0210", "[3(1)]"),
    ("x : TON := (PR := T#1s);", "LD0210", "T#1s"),
    ("x : (red, green) := blue;", "LD0404", "blue"),
    ("x : INT := y; y : INT := 3;", "LD0207", "y"),
    ("x : ARRAY [1..2000] OF ARRAY [1..1000] OF INT;", "LD0209", "ARRAY [1..2000] OF ARRAY [1..1000] OF INT"),
])
def test_wrong_declarations(declaration: str, code: str, marked: str) -> None:
    found = modelled(program(declaration))
    assert found.codes == [code], found.text
    assert next(iter(found.diagnostics)).primary.span.text == marked


@given(st.integers(-10**6, 10**6), st.integers(-10**6, 10**6), st.sampled_from("+-*/"))
@settings(max_examples=60, deadline=None)
def test_arithmetic_on_literals_is_exact(a: int, b: int, op: str) -> None:
    found = modelled(program(f"x : LINT := ({a}) {op} ({b});"))
    if op == "/" and b == 0:
        assert found.codes == ["LD0411"]
        return
    expected = {"+": a + b, "-": a - b, "*": a * b}.get(op)
    if expected is None:
        expected = abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)
    assert found.model.pous["MAIN"].variables["X"].initial == expected


# ---- no cascades, no depth ----------------------------------------------------------------------------


def test_one_wrong_declaration_is_one_finding() -> None:
    text = program("a : REEL; t : TON;", "RUNG [a > 5.0] <t: TON(PT := T#1s)> (b.c)",
                   "VAR_GLOBAL b : Nothing; END_VAR")
    assert modelled(text).codes == ["LD0205", "LD0205"]


def test_a_declaration_that_did_not_parse_silences_unknown_names() -> None:
    found = modelled(program("a : := BOOL;", "RUNG [a] (a)"))
    assert found.codes and all(code.startswith("LD01") for code in found.codes), found.text


def test_a_declaration_that_did_not_parse_silences_its_own_pou_only() -> None:
    fb = "FUNCTION_BLOCK fb VAR_INPUT go : BOOL; x : := INT; END_VAR RUNG [x] (y) END_FUNCTION_BLOCK"
    found = modelled(program("f : fb; a : BOOL;", "RUNG [b] <f: fb(x := 1) out=_>", fb))
    assert [code for code in found.codes if not code.startswith("LD01")] == ["LD0404"], found.text


def test_a_rung_that_did_not_parse_silences_labels_but_not_names() -> None:
    found = modelled(program("a : BOOL;", "RUNG one [a (a)\nRUNG [a] >>one\nRUNG [b] (a)"))
    assert [code for code in found.codes if not code.startswith("LD01")] == ["LD0404"]


def test_types_in_a_circle_are_one_finding() -> None:
    types_ = "TYPE A : ARRAY [0..1] OF B; B : STRUCT a : C; END_STRUCT; C : A; END_TYPE"
    found = modelled(program("x : A; y : B;", before=types_))
    assert found.codes == ["LD0206"]
    assert "A -> B -> C -> A" in found.text


@pytest.mark.parametrize("count", [10, 3000])
def test_long_chains_of_types_and_constants(count: int) -> None:
    constants = "".join(f"c{n} : DINT := c{n - 1} + 1; " for n in range(1, count))
    aliases = "".join(f"T{n} : T{n - 1}; " for n in range(1, count))
    before = (f"TYPE T0 : DINT; {aliases} END_TYPE "
              f"VAR_GLOBAL CONSTANT c0 : DINT := 0; {constants} END_VAR")
    found = modelled(program(f"x : T{count - 1} := c{count - 1};", before=before))
    assert found.codes == []
    assert found.model.pous["MAIN"].variables["X"].initial == count - 1


def test_chains_against_the_order_of_the_text_are_cut() -> None:
    constants = "".join(f"c{n} : DINT := c{n + 1}; " for n in range(3000))
    before = f"VAR_GLOBAL CONSTANT {constants} c3000 : DINT := 1; END_VAR"
    found = modelled(program("x : BOOL;", before=before))
    assert set(found.codes) == {"LD0225"}


# ---- names ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("text", "codes"), [
    ("PROGRAM p VAR a : BOOL; A : INT; END_VAR END_PROGRAM", ["LD0201"]),
    ("PROGRAM p VAR p : BOOL; END_VAR END_PROGRAM", ["LD0203"]),
    ("PROGRAM p VAR_INPUT a : BOOL; END_VAR VAR a : BOOL; END_VAR END_PROGRAM", ["LD0201"]),
    ("PROGRAM p END_PROGRAM FUNCTION_BLOCK P END_FUNCTION_BLOCK", ["LD0201"]),
    ("TYPE p : INT; END_TYPE PROGRAM p END_PROGRAM", ["LD0201"]),
    ("TYPE s : STRUCT a : INT; A : INT; END_STRUCT; END_TYPE", ["LD0201"]),
    ("TYPE e : (a, b, A); END_TYPE", ["LD0201"]),
    ("VAR_GLOBAL p : INT; END_VAR PROGRAM p END_PROGRAM", ["LD0201"]),
    ("PROGRAM p VAR _LDC_x : INT; END_VAR END_PROGRAM", ["LD0202"]),
    ("FUNCTION_BLOCK CTU END_FUNCTION_BLOCK", ["LD0180"]),
    ("FUNCTION limit : INT END_FUNCTION", ["LD0180"]),
    ("FUNCTION limit : INT VAR limit : INT; END_VAR END_FUNCTION", ["LD0180", "LD0203"]),
    ("FUNCTION MUL : INT END_FUNCTION", ["LD0203"]),
    ("PROGRAM CTU END_PROGRAM", ["LD0203"]),
    ("TYPE limit : INT; END_TYPE", ["LD0203"]),
    ("FUNCTION limit : INT END_FUNCTION FUNCTION LIMIT_2 : INT END_FUNCTION", ["LD0180"]),
    ("FUNCTION limit : INT END_FUNCTION FUNCTION LIMIT : INT END_FUNCTION", ["LD0180", "LD0201"]),
    ("FUNCTION f : INT VAR_INPUT EN : BOOL; END_VAR END_FUNCTION", ["LD0203"]),
    ("FUNCTION f : INT VAR f : INT; END_VAR END_FUNCTION", ["LD0203"]),
    ("PROGRAM p VAR limit : INT; LD : INT; END_VAR END_PROGRAM", ["LD0204", "LD0204"]),
    ("FUNCTION_BLOCK f VAR_INPUT S : BOOL; R : BOOL; END_VAR END_FUNCTION_BLOCK", []),
])
def test_names(text: str, codes: list[str]) -> None:
    found = modelled(text)
    assert found.codes == codes, found.text


def test_the_second_declaration_shows_the_first_across_files() -> None:
    found = modelled("VAR_GLOBAL a : INT; END_VAR", "VAR_GLOBAL a : BOOL; END_VAR")
    finding = next(iter(found.diagnostics))
    assert finding.primary.span.source.path == "1x.ld"
    assert finding.secondary[0].span.source.path == "x.ld"


# ---- where variables may be -----------------------------------------------------------------------------


@pytest.mark.parametrize(("text", "codes"), [
    ("PROGRAM p VAR x AT %IX0.8 : BOOL; END_VAR END_PROGRAM", ["LD0211"]),
    ("PROGRAM p VAR x AT %QW512 : INT; END_VAR END_PROGRAM", ["LD0211"]),
    ("PROGRAM p VAR x AT %QW511 : INT; END_VAR END_PROGRAM", []),
    ("PROGRAM p VAR x AT %QW0 : BOOL; END_VAR END_PROGRAM", ["LD0212"]),
    ("PROGRAM p VAR x AT %QD0 : REAL; END_VAR END_PROGRAM", []),
    ("PROGRAM p VAR x AT %QD0 : (a, b); END_VAR END_PROGRAM", []),
    ("PROGRAM p VAR x AT %QW0 : ARRAY [0..1] OF DINT; END_VAR END_PROGRAM", ["LD0212"]),
    ("PROGRAM p VAR_INPUT x AT %IX0.0 : BOOL; END_VAR END_PROGRAM", []),
    ("PROGRAM p VAR_IN_OUT x AT %IX0.0 : BOOL; END_VAR END_PROGRAM", ["LD0213"]),
    ("FUNCTION_BLOCK p VAR_INPUT x AT %IX0.0 : BOOL; END_VAR END_FUNCTION_BLOCK", ["LD0213"]),
    ("FUNCTION_BLOCK p VAR x AT %IX0.0 : BOOL; END_VAR END_FUNCTION_BLOCK", ["LD0213"]),
    ("PROGRAM p VAR x AT %QX0.1 : BOOL; y AT %QB0 : BYTE; END_VAR END_PROGRAM", ["LD0214"]),
    ("PROGRAM p VAR x AT %IX0.1 : BOOL; y AT %IB0 : BYTE; END_VAR END_PROGRAM", []),
    ("PROGRAM p VAR x AT %QX0.1 : BOOL; y AT %QX0.2 : BOOL; z AT %QW1 : INT; END_VAR END_PROGRAM", []),
    ("PROGRAM p VAR_EXTERNAL x : BOOL; END_VAR END_PROGRAM", ["LD0215"]),
    ("VAR_GLOBAL x : INT; END_VAR PROGRAM p VAR_EXTERNAL x : BOOL; END_VAR END_PROGRAM", ["LD0215"]),
    ("VAR_GLOBAL x : INT; END_VAR PROGRAM p VAR_EXTERNAL x : INT := 5; END_VAR END_PROGRAM", ["LD0217"]),
    ("PROGRAM p VAR_GLOBAL x : INT; END_VAR END_PROGRAM", ["LD0217"]),
    ("PROGRAM p VAR_TEMP t : TON; END_VAR END_PROGRAM", ["LD0217"]),
    ("FUNCTION f : INT VAR t : ARRAY [0..1] OF TON; END_VAR END_FUNCTION", ["LD0217"]),
    ("FUNCTION f : TON END_FUNCTION", ["LD0217"]),
    ("PROGRAM q END_PROGRAM PROGRAM p VAR x : q; END_VAR END_PROGRAM", ["LD0218"]),
])
def test_places(text: str, codes: list[str]) -> None:
    found = modelled(text)
    assert found.codes == codes, found.text


def test_the_size_of_the_image_is_a_setting() -> None:
    text = "PROGRAM p VAR x AT %QB100 : BYTE; END_VAR END_PROGRAM"
    assert modelled(text, settings=Settings(image_bytes=100)).codes == ["LD0211"]
    assert modelled(text, settings=Settings(image_bytes=101)).codes == []


def test_external_variables_are_the_globals() -> None:
    found = modelled("VAR_GLOBAL CONSTANT Top : INT := 9; END_VAR "
                     "PROGRAM p VAR_EXTERNAL TOP : INT; END_VAR "
                     "VAR a : ARRAY [0..top] OF BOOL; END_VAR END_PROGRAM")
    variable = found.model.pous["P"].variables["TOP"]
    assert (variable.name, variable.kind, variable.constant) == ("Top", "external", True)
    assert found.model.pous["P"].variables["A"].type.bounds == ((0, 9),)


def test_pins_come_first_in_declared_order() -> None:
    found = modelled("FUNCTION_BLOCK f VAR a : INT; END_VAR VAR_OUTPUT q : INT; END_VAR "
                     "VAR_IN_OUT io : INT; END_VAR VAR_INPUT i, j : INT := 3; END_VAR END_FUNCTION_BLOCK")
    assert list(found.model.pous["F"].variables) == ["I", "J", "Q", "IO", "A"]
    signature = found.model.signatures["F"]
    assert [p.name for p in signature.inputs] == ["i", "j"]
    assert [p.initial for p in signature.inputs] == [3, 3]
    assert [p.name for p in signature.in_outs] == ["io"]


def test_the_result_of_a_function_is_a_local_variable() -> None:
    found = modelled("FUNCTION half : REAL VAR_INPUT x : REAL; END_VAR END_FUNCTION")
    assert found.model.pous["HALF"].variables["HALF"].kind == "local"
    assert found.model.signatures["HALF"].result is types.REAL


def test_signatures_of_used_standard_blocks_are_in_the_model() -> None:
    found = modelled(program("t : ARRAY [0..3] OF TON; c : CTU_DINT;"))
    assert found.model.signatures["TON"] is blocks.signature("TON")
    assert "CTU_DINT" in found.model.signatures


# ---- who calls whom ---------------------------------------------------------------------------------


FUNCTION = "FUNCTION {0} : BOOL VAR_INPUT x : BOOL; END_VAR RUNG [{1}] ({0}) END_FUNCTION\n"


def test_callees_come_first() -> None:
    text = program("b : outer;", "RUNG [f(TRUE)] (b.q)") + (
        "FUNCTION_BLOCK outer VAR_OUTPUT q : BOOL; END_VAR "
        "VAR i : ARRAY [0..1] OF inner; END_VAR END_FUNCTION_BLOCK "
        "FUNCTION_BLOCK inner VAR_OUTPUT q : BOOL; END_VAR RUNG <g(TRUE, OUT => q)> END_FUNCTION_BLOCK "
    ) + FUNCTION.format("f", "NOT (x AND g(x))") + FUNCTION.format("g", "x")
    order = modelled(text).model.order
    assert sorted(order) == ["F", "G", "INNER", "MAIN", "OUTER"]
    for caller, callee in (("F", "G"), ("INNER", "G"), ("OUTER", "INNER"), ("MAIN", "OUTER"), ("MAIN", "F")):
        assert order.index(callee) < order.index(caller)


@pytest.mark.parametrize(("text", "cycle"), [
    (FUNCTION.format("f", "f(x)"), "f -> f"),
    (FUNCTION.format("f", "g(x)") + FUNCTION.format("g", "f(x)"), "f -> g -> f"),
    ("FUNCTION_BLOCK a VAR x : a; END_VAR END_FUNCTION_BLOCK", "a -> a"),
    ("FUNCTION_BLOCK a VAR x : ARRAY [0..1] OF b; END_VAR END_FUNCTION_BLOCK "
     "FUNCTION_BLOCK b VAR x : a; END_VAR END_FUNCTION_BLOCK", "a -> b -> a"),
])
def test_recursion_is_named(text: str, cycle: str) -> None:
    found = modelled(text)
    assert found.codes == ["LD0216"], found.text
    assert f"circle: {cycle} |" in found.text


def test_calls_in_text_bodies_count() -> None:
    il = ("FUNCTION f : INT VAR_INPUT a : INT; END_VAR\n LD a\n g\n ST f\nEND_FUNCTION\n"
          "FUNCTION g : INT VAR_INPUT a : INT; END_VAR\n LD a (* f *)\n ST g\nEND_FUNCTION\n")
    found = modelled(il, name="x.il")
    assert found.codes == [] and found.model.order == ("G", "F")


def test_a_chain_of_two_thousand_blocks_is_refused_and_not_a_crash() -> None:
    chain = "".join(f"FUNCTION_BLOCK b{n} VAR x : b{n + 1}; END_VAR END_FUNCTION_BLOCK\n"
                    for n in range(2000))
    found = modelled(chain + "FUNCTION_BLOCK b2000 END_FUNCTION_BLOCK")
    assert found.codes == ["LD0225"]
    assert found.model.order[0] == "B2000"
