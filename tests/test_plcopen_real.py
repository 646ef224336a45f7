"""PLCopen XML as OpenPLC, Beremiz, CODESYS and TwinCAT really write it: small drawings with their constructs."""

from __future__ import annotations

import pytest
from plcopen_xml import pou, project
from test_plcopen import built, compiled, run, said

VALUES = "a b c q w : BOOL; i j k : INT; x y : REAL; t : TON; n : CTU; u : WORD"


def statements(text: str, declared: str = VALUES, types: str = "") -> str:
    """A project with one program in Structured Text, as editors wrap it."""
    wrapped = f'<ST><xhtml xmlns="http://www.w3.org/1999/xhtml"><![CDATA[{text}]]></xhtml></ST>'
    return project(pou(wrapped, declared), types=types)


def findings(xml: str) -> list[str]:
    return [f"{d.code} {d.message}" for d in compiled(xml).diagnostics]


# ---- Structured Text


def test_operators_called_as_functions() -> None:
    xml = statements("i := MOD(j, 3); q := AND(a, b, NOT(c)); w := OR(a, XOR(b, c)) AND (a);", VALUES)
    assert run(xml, [{"j": 8, "a": 1, "b": 1, "c": 0}, {"c": 1, "a": 0}], "i q w") == ["2 1 1", "2 0 0"]


def test_arguments_without_a_value_are_none() -> None:
    xml = statements("t(IN := a, PT := T#0s, Q => , ET => ); n(CU := t.Q, R := , PV := 1, Q => q);")
    assert not said(built(xml))
    assert run(xml, [{"a": 1}], "t.Q q") == ["1 1"]
    xml = statements("t(IN := ); t(IN := , PT := T#0s); t(Q => , IN := a); q := t.Q;")
    assert run(xml, [{"a": 1}], "q") == ["1"]


def test_a_block_may_end_without_a_semicolon() -> None:
    xml = statements("IF a THEN q := b; END_IF FOR i := 1 TO 3 DO j := j + i; END_FOR\nCASE i OF 4: k := 7; END_CASE")
    assert run(xml, [{"a": 1, "b": 1}], "q j k") == ["1 6 7"]


def test_pragmas_are_left_out_and_told_once() -> None:
    xml = statements("{warning disable C0371}\nq := a; {region 'it''s x'} w := b; {endregion}")
    assert findings(xml) == ["LD0152 PLCopen XML: the pragma `{warning disable C0371}` is left out"]
    assert run(xml, [{"a": 1, "b": 1}], "q w") == ["1 1"]


@pytest.mark.parametrize("pragma", ["{IF defined (x)}", "{{extern int i; i = 3;}}", "{__SET_VAR(d->,x,,1)}", "{"])
def test_pragmas_that_do_something_are_no_comments(pragma: str) -> None:
    (found,) = [text for text in findings(statements(f"q := a;\n{pragma}\nw := b;")) if text.startswith("LD0151")]
    assert found.startswith("LD0151 PLCopen XML: the pragma `{")


@pytest.mark.parametrize("text, gives", [
    ("q := TRUE; (* x (* y *) w := TRUE; *)", "1 0"), ("(***)q := TRUE; (* (* (* *) *) *) w := TRUE;", "1 1"),
    ("(* 'it (* is' *) q := TRUE; // (* no\nw := TRUE;", "1 1"),
    ("(* a *) q := TRUE; (* b (* c *) *)", "1 0"), ("(* don't (* x *) *) s := 'a'; q := TRUE;", "1 0")])
def test_comments_nest(text: str, gives: str) -> None:
    assert run(statements(text, "q w : BOOL; s : STRING"), [{}], "q w") == [gives]


COLOUR = ('<dataType name="Colour"><baseType><enum><values><value name="red" value="1"/><value name="green" '
          'value="16#2"/></values><baseType><INT/></baseType></enum></baseType></dataType>')


def test_values_of_enumerations_with_the_name_of_their_type() -> None:
    text = ("IF e = Colour.green THEN i := 1; END_IF; e := colour.RED; "
            "CASE e OF Colour.red: j := 2; Colour.green: j := 3; END_CASE;")
    xml = statements(text, "e : Colour = Colour.green; i j : INT", COLOUR)
    assert run(xml, [{}], "i j") == ["1 2"]
    (found,) = findings(statements("e := Colour.blue;", "e : Colour", COLOUR))
    assert "Colour has no value `blue`" in found


def test_a_variable_hides_a_type_of_its_name() -> None:
    record = ('<dataType name="Point"><baseType><struct><variable name="red"><type><INT/></type></variable></struct>'
              "</baseType></dataType>")
    xml = statements("Colour.red := 7; i := Colour.red;", "Colour : Point; i : INT", record + COLOUR)
    assert run(xml, [{}], "i") == ["7"]


