"""Types of expressions, and contacts, coils and jumps."""

from __future__ import annotations

import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc import types
from ldc.diagnostics import Diagnostics
from ldc.expr import Apply
from ldc.model import Scope
from ldc.model.elements import Jump
from ldc.model.settings import Settings
from ldc.parser import ast
from tests.modelling import findings, first, modelled, program, shown, shown_element

BEFORE = """
TYPE
    Mode : (stopped, slow, fast);
    Other : (open, stopped);
    Percent : INT (0..100);
    Point : STRUCT x : REAL; y : INT; ok : BOOL; m : Mode; END_STRUCT;
END_TYPE
VAR_GLOBAL g : BOOL; END_VAR
FUNCTION scaled : REAL
VAR_INPUT value : REAL; factor : REAL := 2.0; END_VAR
RUNG <MUL(value, factor, OUT => scaled)>
END_FUNCTION
FUNCTION both : BOOL VAR_INPUT a : BOOL; END_VAR VAR_OUTPUT n : BOOL; END_VAR RUNG [a] (both) END_FUNCTION
"""
VARIABLES = """
    a, b, c : BOOL; si : SINT; i, j : INT; d : DINT; l : LINT; us : USINT; u : UINT; ud : UDINT; ul : ULINT;
    re : REAL; lr : LREAL;
    w : WORD; byt : BYTE; t : TIME; td : TOD; dat : DATE; dt1 : DT; txt : STRING[10]; ws : WSTRING;
    m : Mode; p : Percent;
    pt : Point; arr : ARRAY [1..3] OF INT; flags : ARRAY [0..1, 0..2] OF BOOL; pts : ARRAY [0..1] OF Point;
    warm : TON; timers : ARRAY [0..1] OF TON; inb AT %IX0.0 : BOOL; q AT %QX0.0 : BOOL;
END_VAR
VAR CONSTANT ten : INT := 10; nothing : INT := 0; yes : BOOL := TRUE;
"""


def typed(expression: str) -> str:
    element = first(VARIABLES, f"[{expression}] (c)", BEFORE)
    return shown(element.expr)


def wrong(rung: str) -> str:
    return findings(VARIABLES, rung, BEFORE)


@pytest.mark.parametrize(("text", "expected"), [
    ("i + 1 > d", "GT(INT_TO_DINT(ADD(i, 1:INT)), d)"),
    ("i + d * 2 > 0", "GT(ADD(INT_TO_DINT(i), MUL(d, 2:DINT)), 0:DINT)"),
    ("i + j + 1 + si > 0", "GT(ADD(i, j, 1:INT, SINT_TO_INT(si)), 0:INT)"),
    ("i > 100000", "GT(INT_TO_DINT(i), 100000:DINT)"),
    ("re > 1", "GT(re, 1.0:REAL)"),
    ("i > 1.5", "GT(INT_TO_REAL(i), 1.5:REAL)"),
    ("lr > 0.1", "GT(lr, 0.1:LREAL)"),
    ("re > 0.1", "GT(re, 0.10000000149011612:REAL)"),
    ("lr > re", "GT(lr, REAL_TO_LREAL(re))"),
    ("u > us", "GT(u, USINT_TO_UINT(us))"),
    ("i = us", "EQ(i, USINT_TO_INT(us))"),
    ("2 * 3 - 1 = i", "EQ(5:INT, i)"),
    ("i = 7 / 2", "EQ(i, 3:INT)"),
    ("i = -7 MOD 4", "EQ(i, -3:INT)"),
    ("re = 7.0 / 2", "EQ(re, 3.5:REAL)"),
    ("-i < -(3)", "LT(NEG(i), -3:INT)"),
    ("i = 16#7F", "EQ(i, 127:INT)"),
    ("w = 16#FFFF", "EQ(w, 65535:WORD)"),
    ("(w AND 16#F0) = 0", "EQ(AND(w, 240:WORD), 0:WORD)"),
    ("(byt OR w) <> 0", "NE(OR(BYTE_TO_WORD(byt), w), 0:WORD)"),
    ("a = 1", "EQ(a, True:BOOL)"),
    ("a AND b OR NOT c", "OR(AND(a, b), NOT(c))"),
    ("a AND b AND c AND g", "AND(a, b, c, g)"),
    ("a XOR b XOR 1", "XOR(a, b, True:BOOL)"),
    ("i - j - 1 > 0", "GT(SUB(SUB(i, j), 1:INT), 0:INT)"),
    ("re + re + re > 0.0", "GT(ADD(ADD(re, re), re), 0.0:REAL)"),
    ("t + T#1s > t * 2", "GT(ADD(t, 1000000000:TIME), MUL(t, 2:INT))"),
    ("t / i < T#1m", "LT(DIV(t, i), 60000000000:TIME)"),
    ("td - td > T#1s", "GT(SUB(td, td), 1000000000:TIME)"),
    ("dt1 - dt1 = t", "EQ(SUB(dt1, dt1), t)"),
    ("txt = 'abc'", "EQ(txt, b'abc':STRING[80])"),
    ("ws <> \"abc\"", "NE(ws, 'abc':WSTRING[80])"),
    ("LEN(txt) > 3", "GT(LEN(txt), 3:INT)"),
    ("m = fast", "EQ(m, 2:Mode)"),
    ("m = stopped", "EQ(m, 0:Mode)"),
    ("stopped = m", "EQ(0:Mode, m)"),
    ("m <> Mode#slow", "NE(m, 1:Mode)"),
    ("SEL(a, m, fast) = m", "EQ(SEL(a, m, 2:Mode), m)"),
    ("p + 1 > 50", "GT(ADD(p, 1:INT), 50:INT)"),
    ("MAX(i, 3, d) > 0", "GT(MAX(INT_TO_DINT(i), 3:DINT, d), 0:DINT)"),
    ("LIMIT(MX := 10, MN := 0, IN := i) = 3", "EQ(LIMIT(0:INT, i, 10:INT), 3:INT)"),
    ("INT_TO_REAL(i) > re", "GT(INT_TO_REAL(i), re)"),
    ("TO_REAL(i) > re", "GT(INT_TO_REAL(i), re)"),
    ("SHL(w, 3) = w", "EQ(SHL(w, 3:INT), w)"),
    ("scaled(i) > re", "GT(SCALED(INT_TO_REAL(i), 2.0:REAL), re)"),
    ("scaled(factor := 1, value := 2) > re", "GT(SCALED(2.0:REAL, 1.0:REAL), re)"),
    ("both(a)", "BOTH(a)"),
    ("pts[i].y > arr[2]", "GT(pts[i].y, arr[2])"),
    ("arr[i + 1] > 0", "GT(arr[...], 0:INT)"),
    ("warm.ET > T#1s", "GT(warm.ET, 1000000000:TIME)"),
    ("timers[1].ET > t", "GT(timers[1].ET, t)"),
    ("ten > i", "GT(ten, i)"),
    ("2 ** 3 > re", "GT(EXPT(2.0:REAL, 3:INT), re)"),
    ("INT#5 > d", "GT(5:DINT, d)"),
    ("%IW3 = w", "EQ(%IW3, w)"),
])
def test_types(text: str, expected: str) -> None:
    assert typed(text) == expected


@pytest.mark.parametrize(("rung", "expected"), [
    ("[a]", "open a"), ("[/A]", "closed a"), ("[P a]", "rising a"), ("[N a]", "falling a"),
    ("[1]", "open True:BOOL"), ("[/TRUE]", "closed True:BOOL"), ("[yes]", "open yes"),
    ("[%ix0.1]", "open %IX0.1"), ("[/%I0.1]", "closed %IX0.1"), ("[w.15]", "open w.15"),
    ("[P byt.0]", "rising byt.0"),
    ("[warm.q]", "open warm.Q"), ("[/timers[0].Q]", "closed timers[0].Q"), ("[g]", "open g"),
    ("[pt.ok]", "open pt.ok"), ("[flags[1, 2]]", "open flags[1, 2]"),
    ("[flags[i, 2]]", "expression flags[i, 2]"), ("[/flags[i, 2]]", "expression NOT(flags[i, 2])"),
    ("[P flags[i, 2]]", "rising flags[i, 2]"),
    ("[NOT a]", "expression NOT(a)"), ("[(a)]", "open a"),
    ("(a)", "normal a"), ("(/a)", "negated a"), ("(S a)", "set a"),
    ("(R a)", "reset a"), ("(P a)", "rising a"), ("(N a)", "falling a"), ("(%QX0.3)", "normal %QX0.3"),
    ("(S w.3)", "set w.3"), ("(warm.IN)", "normal warm.IN"),
    ("(flags[i, 0])", "normal flags[i, 0]"), ("(g)", "normal g"),
])
def test_contacts_and_coils(rung: str, expected: str) -> None:
    assert shown_element(first(VARIABLES, rung, BEFORE)) == expected


@pytest.mark.parametrize(("rung", "expected"), [
    ("[i] (a)", "LD0401 [i] a contact needs a BOOL | write `[i <> 0]`"),
    ("[t] (a)", "LD0401 [t] a contact needs a BOOL | write `[t <> T#0s]`"),
    ("[txt] (a)", "LD0401 [txt] a contact needs a BOOL | write `[txt <> '']`"),
    ("[warm] (a)", "LD0401 [warm] a contact needs a BOOL | name one of its outputs, as in `[warm.Q]`"),
    ("[5] (a)", "LD0401 [5] a contact needs a BOOL | write `[5 <> 0]`"),
    ("[a] (i)", "LD0401 [i] a coil needs a BOOL"),
    ("[/a AND b] (c)", "LD0413 [a AND b] a closed contact needs a variable | write `[NOT (a AND b)]`"),
    ("[P a OR b] (c)", "LD0413 [a OR b]"),
    ("[hello] (a)", "LD0404 [hello]"),
    ("[warn.Q] (a)", "did you mean `warm`"),
    ("[warm.X] (a)", "LD0406 [warm.X] an instance of TON has no member `X` | it has IN, PT, Q, ET"),
    ("[pt.okk] (a)", "did you mean `ok`?"),
    ("[a.x] (c)", "LD0405 [a]"),
    ("[w.16] (a)", "LD0409 [w.16] WORD has no bit 16"),
    ("[re.3] (a)", "LD0409 [re.3] REAL has no bits to name"), ("[i.16] (a)", "LD0409 [i.16] INT has no bit 16"),
    ("[arr[4] > 0] (a)", "LD0408 [4] index 4 is outside of the array"),
    ("[arr[ten] > 0] (a)", "LD0408 [ten] index 10 is outside of the array"),
    ("[arr[1 - 1] > 0] (a)", "LD0408 [1 - 1]"),
    ("[arr[re] > 0] (a)", "LD0407 [re] an index must be an integer"),
    ("[arr[t] > 0] (a)", "LD0407 [t] an index must be an integer"),
    ("[arr[1, 2] > 0] (a)", "LD0407 [arr[1, 2]] the array has 1 dimension"),
    ("[i[1] > 0] (a)", "LD0407 [i] an index is put on what is no array"),
    ("[%IX0.9] (a)", "LD0211 [%IX0.9]"),
    ("[%IB1024 = byt] (a)", "LD0211 [%IB1024]"),
    ("[i / 0 > 1] (a)", "LD0411 [0]"),
    ("[i MOD nothing > 1] (a)", "LD0411 [nothing]"),
    ("[DIV(i, 5 - 5) > 1] (a)", "LD0411 [5 - 5]"),
    ("[i > t] (a)", "LD0410 [i > t]"),
    ("[ul > i] (a)", "LD0410 [ul > i] GT: ULINT and INT have no common type; convert one of them | "
     "convert it by `INT_TO_ULINT(...)`"),
    ("[w AND w] (a)", "write `[(w AND w) <> 0]`"),
    ("[i AND b] (a)", "compare numbers first"),
    ("[warm = warm] (a)", "LD0410"),
    ("[m = txt] (a)", "LD0410"),
    ("<warm: TON(PT := 500)> (a)", "LD0403 [500] pin `PT` needs TIME, not INT | a time has a unit, for example `T#500ms`"),
    ("[m = open] (a)", "LD0410"),
    ("[m > t] (a)", "LD0410"),
    ("[stopped = 1] (a)", "LD0412 [stopped] `stopped` is a value of Mode and Other | write `Mode#stopped`"),
    ("[m = Mode#open] (a)",
     "LD0412 [Mode#open] Mode has no value `open` | its values are stopped, slow, fast"),
    ("[txt = ws] (a)", "LD0410"),
    ("[SINT#300 > 1] (a)", "[SINT#300]"),
    ("[scaled(txt) > re] (a)",
     "LD0403 [txt] pin `value` needs REAL, not STRING[10] | convert it by `STRING_TO_REAL(...)`"),
    ("[scaled() > re] (a)", "LD0507 [scaled()] `scaled` needs `value`"),
    ("[scaled(1, 2, 3) > re] (a)", "LD0509 [3]"),
    ("[scaled(1, value := 2) > re] (a)", "LD0512 [1]"),
    ("[scaled(valve := 2) > re] (a)", "did you mean `value`?"),
    ("[scaled(value := 2, value := 3) > re] (a)", "LD0506 [value := 3]"),
    ("[both(a, n => b)] (c)", "LD0514 [n => b]"),
    ("[main] (c)", "LD0405 [main] `main` is no variable | variables that several programs use"),
    ("[TON(a)] (c)", "LD0502"),
    ("[main(a)] (c)", "LD0502"),
    ("[scald(1) > re] (a)", "did you mean `scaled`?"),
    ("[MAXX(1, 2) > 1] (a)", "did you mean `MAX`?"),
    ("[LIMIT(1, 2) > 1] (a)", "LD0507 [LIMIT(1, 2)] `LIMIT` needs `MX`"),
    ("[ABS(i, j) > 1] (a)", "LD0509 [j]"),
    ("[ABS(X := i) > 1] (a)", "LD0505 [X := i] `ABS` has no pin `X`"),
    ("[a] (inb)", "LD0503 [inb] `inb` cannot be written | inputs are read only"),
    ("[a] (%IX0.3)", "LD0503 [%IX0.3]"),
    ("[a] (yes)", "LD0503 [yes]"),
    ("[a] (warm.Q)", "LD0503 [warm.Q] `warm.Q` cannot be written | only the block itself"),
    ("[a] (fast)", "LD0405 [fast] `fast` is no variable"),
    ("[a] (TON)", "LD0405 [TON]"),
    ("[a] >>nowhere", "LD0515 [>>nowhere]"),
])
def test_findings(rung: str, expected: str) -> None:
    text = wrong(rung)
    assert expected in text
    assert len(text.splitlines()) == 1, text


def test_both_sides_of_an_operator_are_reported() -> None:
    text = wrong("[hello + world > unknown] (a)")
    assert [line.split("]")[0] for line in text.splitlines()] == [
        "LD0404 [hello", "LD0404 [world", "LD0404 [unknown"]


def test_what_a_pou_may_not_write() -> None:
    found = modelled("VAR_GLOBAL g : BOOL; END_VAR FUNCTION f : BOOL VAR_INPUT i : BOOL; END_VAR "
                     "RUNG [g] (i) RUNG [i] (g) RUNG [i] (%QX0.0) RUNG [i] (f) END_FUNCTION "
                     "FUNCTION_BLOCK b VAR_INPUT i : BOOL; END_VAR VAR_IN_OUT io : BOOL; END_VAR "
                     "VAR_EXTERNAL g : BOOL; END_VAR "
                     "RUNG [g] (i) RUNG [i] (io) RUNG [i] (g) END_FUNCTION_BLOCK")
    assert sorted(found.codes) == ["LD0161"] * 2 + ["LD0503"] * 2, found.text


def test_a_function_has_no_edges() -> None:
    found = modelled("FUNCTION f : BOOL VAR_INPUT i : BOOL; END_VAR "
                     "RUNG [P i] [N i] (f) RUNG [i] (P f) END_FUNCTION")
    assert found.codes == ["LD0516"] * 3


def test_jumps_lead_to_rungs_of_any_spelling() -> None:
    found = modelled(program("a : BOOL;", "RUNG one [a] >>ONE\nRUNG [a] >>return"))
    jumps = [e for e in found.elements["MAIN"] if isinstance(e, Jump)]
    assert [j.label for j in jumps] == ["one", None]
    assert found.codes == []


@pytest.mark.parametrize("operator", ["AND", "+", "-", "/", "="])
def test_a_thousand_operators_need_no_deep_stack(operator: str) -> None:
    name, test = ("a", "") if operator in ("AND", "=") else ("re", " > 0.0")
    text = f" {operator} ".join([name] * 900) + test
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(700)
    try:
        element = first(VARIABLES, f"[{text}] (c)", BEFORE)
    finally:
        sys.setrecursionlimit(limit)
    assert isinstance(element.expr, Apply)
    if operator == "AND":
        assert len(element.expr.args) == 900


def test_ninety_brackets() -> None:
    assert typed("(" * 90 + "NOT a" + ")" * 90) == "NOT(a)"


def test_addresses_of_the_library_are_closed_to_programs() -> None:
    text = "FUNCTION_BLOCK f VAR t : TIME; END_VAR RUNG [t > T#1s] (%NOW) END_FUNCTION_BLOCK"
    assert all(code != "LD0503" for code in modelled(text).codes)
    library = modelled("FUNCTION_BLOCK TON VAR_OUTPUT Q : BOOL; END_VAR END_FUNCTION_BLOCK",
                       settings=Settings(library=True))
    assert library.codes == []
    scope, found = Scope(library.model, "TON"), Diagnostics()
    span = library.model.pous["TON"].span
    place = scope.place(ast.Direct("%now", span), found)
    assert (place.root, place.type, place.is_global) == ("%NOW", types.TIME, True)
    user = modelled("FUNCTION_BLOCK f END_FUNCTION_BLOCK")
    assert Scope(user.model, "f").place(ast.Direct("%now", span), found) is None
    assert len(found) == 1


def test_a_scope_without_a_pou_sees_globals_only() -> None:
    found = modelled(program("a : BOOL;", before="VAR_GLOBAL g : BOOL; END_VAR"))
    scope, diagnostics = Scope(found.model), Diagnostics()
    span = found.model.pous["MAIN"].span
    assert scope.place(ast.Name("G", span), diagnostics).root == "g"
    assert scope.place(ast.Name("a", span), diagnostics) is None


SAMPLE = program(VARIABLES, """
RUNG one "t" { [a] | [/b] } [i + 1 > d] <warm: TON(PT := T#1s, ET => t)> (S c)
RUNG [m = Mode#fast] <MOVE(IN := scaled(value := i, factor := 1.5), OUT => re)> (q)
RUNG { [a] @x [b] | [c] @y [w.3] } (flags[1, i]); @x [pts[0].ok] @y
RUNG [LIMIT(0, i, 10) = arr[2]] <ADD(i, 3, OUT => i) in=_> >>one
""", BEFORE)
TOKENS = [t for t in SAMPLE.replace("(", " ( ").replace(")", " ) ").replace(";", " ; ").split(" ") if t]


@given(st.lists(st.tuples(st.sampled_from(["drop", "swap", "double", "replace"]),
                          st.integers(0, len(TOKENS) - 1), st.integers(0, len(TOKENS) - 1)), max_size=6))
@settings(max_examples=150, deadline=None)
def test_broken_programs_never_raise(edits) -> None:
    tokens = list(TOKENS)
    for kind, at, other in edits:
        at, other = at % len(tokens), other % len(tokens)
        if kind == "drop":
            del tokens[at]
        elif kind == "swap":
            tokens[at], tokens[other] = tokens[other], tokens[at]
        elif kind == "double":
            tokens.insert(at, tokens[at])
        else:
            tokens[at] = tokens[other]
    found = modelled(" ".join(tokens))
    for pou, elements in found.elements.items():
        assert found.diagnostics.has_errors or None not in elements, pou


@given(st.sampled_from(["ADD", "MUL", "SUB", "MAX", "MIN"]),
       st.lists(st.sampled_from(["SINT", "INT", "DINT", "LINT", "REAL", "LREAL", "USINT", "UINT"]),
                min_size=2, max_size=2))
@settings(max_examples=80, deadline=None)
def test_arguments_have_one_type_that_holds_them_all(name: str, kinds: list[str]) -> None:
    found = modelled(program(f"x : {kinds[0]}; y : {kinds[1]}; c : BOOL;", f"RUNG [{name}(x, y) > 0] (c)"))
    contact = found.elements["MAIN"][0]
    if contact is None:
        assert set(found.codes) == {"LD0410"}
        return
    inner = contact.expr.args[0]
    assert inner.args[0].type == inner.args[1].type == inner.type
    sources = {(a.args[0] if isinstance(a, Apply) else a).type for a in inner.args}
    assert sources == {types.ELEMENTARY[k] for k in kinds}
