"""PLCopen XML as OpenPLC, Beremiz, CODESYS and TwinCAT write it: small drawings with their constructs."""

from __future__ import annotations

import pytest
from plcopen_xml import (
    NAMESPACE,
    block,
    coil,
    contact,
    fbd,
    ladder,
    pou,
    project,
    rail,
    result,
    value,
    variables,
    wires,
)
from test_plcopen import built, compiled, run, said

from ldc.cli.main import main
from ldc.diagnostics import Diagnostics
from ldc.parser.plcopen import read
from ldc.pipeline import compile_paths
from ldc.source import SourceFile

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
    xml = statements("IF a THEN q := b; END_IF FOR i := 1 TO 3 DO j := j + i; END_FOR\n"
                     "CASE i OF 4: k := 7; END_CASE")
    assert run(xml, [{"a": 1, "b": 1}], "q j k") == ["1 6 7"]


def test_pragmas_are_left_out_and_told_once() -> None:
    xml = statements("{warning disable C0371}\nq := a; {region 'it''s x'} w := b; {endregion}")
    assert findings(xml) == ["LD0152 PLCopen XML: the pragma `{warning disable C0371}` is left out"]
    assert run(xml, [{"a": 1, "b": 1}], "q w") == ["1 1"]


@pytest.mark.parametrize("pragma", ["{IF defined (x)}", "{{extern int i; i = 3;}}", "{__SET_VAR(d->,x,,1)}",
                                    "{"])
def test_pragmas_that_do_something_are_no_comments(pragma: str) -> None:
    told = findings(statements(f"q := a;\n{pragma}\nw := b;"))
    (found,) = [text for text in told if text.startswith("LD0151")]
    assert found.startswith("LD0151 PLCopen XML: the pragma `{")


def test_the_pragma_by_which_copied_timers_ask_for_the_time() -> None:
    asks = "{__SET_VAR(data__->,now,,__CURRENT_TIME)}"
    text = (f"(* the time *)\n{asks}\nIF a AND NOT b THEN since := now; END_IF;\n"
            "b := a; q := a AND now - since >= T#20ms;")
    declared = "a b q clock : BOOL; now since : TIME"
    rows = run(statements(text, declared), [{"a": a} for a in (0, 1, 1, 1, 1, 0, 1, 1, 1)], "q")
    assert rows == list("000110001")
    (found,) = findings(statements(f"IF a THEN {asks} END_IF;", declared))
    assert found.startswith("LD0151")


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
    record = ('<dataType name="Point"><baseType><struct><variable name="red"><type><INT/></type></variable>'
              "</struct></baseType></dataType>")
    xml = statements("Colour.red := 7; i := Colour.red;", "Colour : Point; i : INT", record + COLOUR)
    assert run(xml, [{}], "i") == ["7"]




# ---- drawings


def test_negated_coils_that_store() -> None:
    """They store when there is no power; power goes by them as it is."""
    xml = ladder(VALUES, rail(), contact(2, "a"), coil(3, "q", 2, negated="true", storage="set"),
                 coil(4, "w", 3))
    assert run(xml, [{"a": 1}, {"a": 0}, {"a": 1}], "q w") == ["0 1", "1 0", "1 1"]
    xml = ladder(f"{VALUES}; z : BOOL = TRUE", rail(), contact(2, "a"),
                 coil(3, "z", 2, negated="true", storage="reset"))
    assert run(xml, [{"a": 1}, {"a": 0}, {"a": 1}], "z") == ["1", "0", "0"]


def counted(first: int, *numbers: int) -> str:
    """`i := i * 2` and `i := i + 1` (with the order of execution), the second drawn above the first."""
    doubled, added = numbers
    return fbd("i : INT", value(1, "i"), value(2, "2"), value(3, "1"),
               block(4, "MUL", {"IN1": 1, "IN2": 2}, ("OUT",), at=(40, 90), executionOrderId=first + doubled),
               result(5, "i", "4.OUT", at=(80, 90), executionOrderId=first + doubled + 1),
               block(6, "ADD", {"IN1": 1, "IN2": 3}, ("OUT",), at=(40, 10), executionOrderId=first + added),
               result(7, "i", "6.OUT", at=(80, 10), executionOrderId=first + added + 1))


@pytest.mark.parametrize("first", [0, 1, 7])
def test_the_order_of_execution_may_count_from_0(first: int) -> None:
    assert run(counted(first, 0, 2), [{"i": 3}], "i") == ["7"]
    assert run(counted(first, 2, 0), [{"i": 3}], "i") == ["8"]


def test_0_is_no_order_of_execution_when_all_have_it() -> None:
    xml = counted(1, 0, 2)
    for number in range(1, 5):
        xml = xml.replace(f'executionOrderId="{number}"', 'executionOrderId="0"')
    assert run(xml, [{"i": 3}], "i") == ["8"]


# ---- inputs that the program writes


def located(body: str, *placed: tuple[str, str, str], sections: str = "") -> str:
    """A program whose variables are (name, address, type)."""
    lines = "".join(f'<variable name="{name}" address="{address}"><type><{type_}/></type></variable>'
                    for name, address, type_ in placed)
    return (f'<pou name="main" pouType="program"><interface>{sections}<localVars>{lines}</localVars>'
            f"</interface><body>{body}</body></pou>")


@pytest.mark.parametrize("body", [
    f"<LD>{rail()}{contact(2, 'a')}{coil(3, 'q', 2)}</LD>",
    f"<LD>{rail()}{block(4, 'MOVE', {'EN': 1, 'IN': 5}, ('ENO', 'OUT'))}{value(5, 'a')}"
    f"{result(3, 'q', '4.OUT')}</LD>", "<ST>IF a THEN q := TRUE; ELSE q := FALSE; END_IF;</ST>"])
def test_an_input_that_is_written_is_an_ordinary_variable(body: str) -> None:
    xml = project(located(body, ("a", "%IX0.0", "BOOL"), ("q", "%IX0.1", "BOOL")))
    assert findings(xml) == ["LD0149 `q` is the input %IX0.1, and the program writes it"]
    assert run(xml, [{"a": 1}, {"a": 0}], "q") == ["1", "0"]
    (variables,) = built(xml).project.files[0].pous[0].var_blocks
    assert [v.location for v in variables.variables] == ["%IX0.0", None]


def test_an_input_that_two_variables_share_keeps_its_address() -> None:
    body = f"<LD>{rail()}{contact(2, 'a')}{coil(3, 'q', 2)}</LD>"
    xml = project(located(body, ("a", "%IX0.1", "BOOL"), ("q", "%IX0.1", "BOOL")))
    assert [found[:6] for found in findings(xml)] == ["LD0503"]


def test_a_global_input_that_a_program_writes() -> None:
    external = '<externalVars><variable name="g"><type><BOOL/></type></variable></externalVars>'
    program = located(f"<LD>{rail()}{contact(2, 'a')}{coil(3, 'g', 2)}</LD>", ("a", "%IX0.0", "BOOL"),
                      sections=external)
    declared = ('<globalVars><variable name="g" address="%IX0.7"><type><BOOL/></type></variable>'
                '<variable name="h" address="%IX0.6"><type><BOOL/></type></variable></globalVars>')
    instances = (f'<configurations><configuration name="c"><resource name="r"><task name="t" '
                 f'interval="T#20ms" priority="0"><pouInstance name="p" typeName="main"/></task>{declared}</resource>'
                 "</configuration></configurations>")
    xml = project(program, instances=instances)
    assert findings(xml) == ["LD0149 `g` is the input %IX0.7, and the program writes it"]
    assert run(xml, [{"p.a": 1}], "g h") == ["1 0"]


# ---- declarations


TEXT = ("FUNCTION_BLOCK made {attribute 'x'}\nVAR_INPUT\n  a : BOOL; // a &lt; b\nEND_VAR\nVAR_OUTPUT "
        "q : BOOL; END_VAR\nVAR\n {attribute 'hide'} n : ARRAY [0..2] OF INT := [1, 2, 3];\nEND_VAR\n")
IN_TEXT = {
    "as CODESYS keeps it": '<data name="http://www.3s-software.com/plcopenxml/interfaceasplaintext">'
    f'<InterfaceAsPlainText><xhtml xmlns="http://www.w3.org/1999/xhtml">{TEXT}</xhtml></InterfaceAsPlainText>'
    "</data>",
    "as Bachmann keeps it": '<data name="www.bachmann.at/plc/plcopenxml"><textDeclaration><content>'
    f"{TEXT}</content></textDeclaration></data>"}


@pytest.mark.parametrize("data", IN_TEXT.values(), ids=IN_TEXT)
@pytest.mark.parametrize("inside", [True, False])
def test_declarations_that_are_text_only(data: str, inside: bool) -> None:
    data = f"<addData>{data}</addData>"
    interface = f"<interface><localVars/>{data}</interface>" if inside else "<interface/>"
    block_ = (f'<pou name="made" pouType="functionBlock">{interface}<body><ST>q := a AND n[2] = 3;</ST>'
              f"</body>{'' if inside else data}</pou>")
    xml = project(block_, pou("<ST>f(a := TRUE, q =&gt; q);</ST>", "f : made; q : BOOL"))
    assert run(xml, [{}], "q") == ["1"]


def test_a_type_that_is_written_out() -> None:
    names = ("STRING(3)", "STRING[4]", "ARRAY [0..2] OF INT")
    lines = "".join(f'<variable name="v{at}"><type><derived name="{name}"/></type></variable>'
                    for at, name in enumerate(names))
    lines += variables("i : INT")
    xml = project(f'<pou name="main" pouType="program"><interface><localVars>{lines}</localVars>'
                  "</interface><body><ST>v0 := CONCAT('ab', 'cde'); v1 := CONCAT('ab', 'cde'); "
                  "v2[2] := LEN(v0); i := LEN(v1) * v2[2];</ST></body></pou>")
    assert run(xml, [{}], "i") == ["12"]


# ---- blocks that Beremiz and OpenPLC bring along


def test_an_additional_block_comes_with_what_it_needs() -> None:
    xml = statements("f(AUTO := TRUE, PV := 3.0, SP := 1.0, KP := 2.0, TR := 1.0, TD := 0.0, "
                     "CYCLE := T#500ms); x := f.XOUT;", "f : PID; x : REAL")
    result_ = built(xml)
    assert not said(result_)
    assert [p.name for p in result_.project.files[0].pous] == ["main", "INTEGRAL", "DERIVATIVE", "PID"]
    assert run(xml, [{}, {}], "x") == ["6", "8"]  # 2 * (2 + the integral of 2 over 0.5 s each)


def test_a_block_of_the_file_goes_before_an_additional_one() -> None:
    own = pou("<ST>Q := NOT Q;</ST>", "", name="SEMA", kind="functionBlock",
              sections=f"<outputVars>{variables('Q : BOOL')}</outputVars>")
    xml = project(own, pou("<ST>s1(); q := s1.Q;</ST>", "s1 : SEMA; q : BOOL"))
    assert run(xml, [{}, {}], "q") == ["1", "0"]


def test_a_semaphore_a_ramp_and_a_hysteresis() -> None:
    xml = statements("s1(CLAIM := a, RELEASE := b, BUSY => q);", f"{VALUES}; s1 : SEMA")
    assert run(xml, [{"a": 1}, {}, {"a": 0}, {"b": 1}, {"b": 0}], "q") == ["0", "1", "1", "0", "0"]
    xml = statements("r1(RUN := a, X0 := 2.0, X1 := 6.0, TR := T#40ms, CYCLE := T#10ms, BUSY => q, "
                     "XOUT => x);",
                     f"{VALUES}; r1 : RAMP")
    assert run(xml, [{}, {"a": 1}, {}, {}, {}, {}], "q x") == ["0 2", "1 2", "1 3", "1 4", "1 5", "0 6"]
    xml = statements("h(XIN1 := x, XIN2 := 5.0, EPS := 1.0, Q => q);", f"{VALUES}; h : HYSTERESIS")
    assert run(xml, [{"x": 6.0}, {"x": 6.5}, {"x": 4.0}, {"x": 3.9}], "q") == ["0", "1", "1", "0"]


def codesys(xml: str) -> str:
    """A file that an editor of the CODESYS family wrote."""
    data = '<addData><data name="http://www.3s-software.com/plcopenxml/x"/></addData>'
    return xml.replace("<types>", f"{data}<types>")


def test_a_blinker_begins_with_its_pulse() -> None:
    xml = statements("b1(ENABLE := a, TIMELOW := T#20ms, TIMEHIGH := T#30ms, OUT => q);",
                     "a q : BOOL; b1 : Util.BLINK")
    rows = run(xml, [{"a": 0}, {"a": 1}, *[{}] * 8, {"a": 0}, {}, {"a": 1}], "q")
    assert "".join(rows) == "0111001110001"


def test_a_hysteresis_is_that_of_the_editor() -> None:
    xml = codesys(statements("h(IN := i, HIGH := 10, LOW := 5, OUT => q);",
                             "i : INT; q : BOOL; h : HYSTERESIS"))
    assert run(xml, [{"i": 7}, {"i": 4}, {"i": 10}, {"i": 11}, {"i": 5}], "q") == ["0", "1", "1", "0", "0"]


def test_functions_of_the_library_of_codesys() -> None:
    xml = codesys(statements(
        "s1(B := m); m := PACK(s1.B7, s1.B6, TRUE, a, FALSE, FALSE, FALSE, FALSE);"
        "n1(IN := i, HIGH := 8, LOW := 4); d := PUTBIT(d, 9, EXTRACT(d, 9) = FALSE);"
        "j := BCD_TO_INT(BYTE#16#42) * 100 + BYTE_TO_INT(INT_TO_BCD(37));",
        f"{VALUES}; m : BYTE; s1 : UNPACK; n1 : LIMITALARM").replace(
            "</localVars>", '<variable name="d"><type><DWORD/></type></variable></localVars>'))
    assert run(xml, [{"m": 0x80, "a": 1, "i": 9}, {"a": 0, "i": 3}, {"i": 4}],
               "m d j n1.O n1.U n1.IL") == ["13 512 4255 1 0 0", "4 0 4255 0 1 0", "4 512 4255 0 0 1"]
    drawn_ = codesys(fbd("i : INT; m : BYTE", value(1, "m"), block(
        2, "BCD_TO_INT", {"B": 1}, ("BCD_TO_INT",)), result(3, "i", "2.BCD_TO_INT")))
    assert run(drawn_, [{"m": 0x27}], "i") == ["27"]
    assert "LD0501" in {f[:6] for f in findings(statements("j := BCD_TO_INT(m);", "j : INT; m : BYTE"))}


def test_types_named_with_their_library() -> None:
    xml = statements("t(IN := a, PT := T#0s); q := t.Q;", "a q : BOOL; t : Standard.TON")
    assert run(xml, [{"a": 1}], "q") == ["1"]
    xml = fbd("a q : BOOL; t : Standard.TON", value(1, "a"), value(2, "T#0s"),
              block(3, "Standard.TON", {"IN": 1, "PT": 2}, ("Q", "ET"), "t"), result(4, "q", "3.Q"))
    assert run(xml, [{"a": 1}], "q") == ["1"]
    (found,) = findings(statements("a := TRUE;", "a : BOOL; x : SM3_Basic.AXIS_REF_SM3"))
    assert found.startswith("LD0205 there is no type or function block `AXIS_REF_SM3`")


@pytest.mark.parametrize("type_, value_, gives", [
    ('<array><dimension lower="0" upper="4"/><baseType><INT/></baseType></array>', "[3(5), 2(7)]",
     "v[2] * v[3]"),
    ('<derived name="Pair"/>', "(x := 5, y := 7)", "v.x * v.y"), ("<INT/>", "(5 * 7)", "v")])
def test_initial_values_that_are_written_out(type_: str, value_: str, gives: str) -> None:
    pair = f'<dataType name="Pair"><baseType><struct>{variables("x y : INT")}</struct></baseType></dataType>'
    declared = (f'<variable name="v"><type>{type_}</type><initialValue><simpleValue value="{value_}"/>'
                "</initialValue></variable></localVars>")
    xml = statements(f"i := {gives};", "i : INT", pair).replace("</localVars>", declared)
    assert run(xml, [{}], "i") == ["35"]


RESOURCES = {
    "an empty resource": ("<resource name='r'/>", "without a task"),
    "no resource": ("<globalVars><variable name='g'><type><BOOL/></type></variable></globalVars>",
                    "without a task"),
    "a task": ("<resource name='r'><task name='t' interval='T#10ms' priority='1'/></resource>",
               "in the task `t`")}


@pytest.mark.parametrize("inside, where", RESOURCES.values(), ids=RESOURCES)
def test_a_configuration_that_runs_nothing_runs_all(inside: str, where: str) -> None:
    configured = f"<configurations><configuration name='c'>{inside}</configuration></configurations>"
    xml = project(pou("<ST>q := TRUE;</ST>", "q : BOOL"), instances=configured)
    assert findings(xml) == [
        f"LD0157 no resource of this file runs a program: the program of it will run {where}"]
    assert run(xml, [{}], "q") == ["1"]


def test_the_derivative_of_a_ramp_is_its_slope() -> None:
    xml = statements("d1(RUN := a, XIN := x, CYCLE := T#100ms, XOUT => y);", f"{VALUES}; d1 : DERIVATIVE")
    rows = [{"a": 0, "x": 0.0}, *({"a": 1, "x": 2.0 * step} for step in range(1, 6))]
    assert run(xml, rows, "y")[-1] == "20"


def test_a_clock_is_set_by_an_edge() -> None:
    xml = statements("r1(IN := a, PDT := DT#2026-01-01-00:00:00, Q => q, CDT => when); "
                     "i := TIME_TO_INT((when - DT#2026-01-01-00:00:00) / 10);",
                     f"{VALUES}; r1 : RTC; when : DT")
    rows = run(xml, [{}, {"a": 1}, {}, {}], "q i")
    assert [row[0] for row in rows] == ["0", "1", "1", "1"]
    assert [row[2:] for row in rows[1:]] == ["0", "1", "2"]


def test_a_project_has_a_limit_of_statements() -> None:
    assert findings(statements(";" * 300_010)) == ["LD0142 the XML has more than 300,000 statements"]


def test_resources_have_names_of_their_own() -> None:
    def resource(name: str, type_: str) -> str:
        return (f"<resource name='{name}'><task name='t' interval='T#10ms' priority='1'><pouInstance "
                f"name='one' typeName='{type_}'/></task></resource>")

    xml = project(pou("<ST>i := i + 1;</ST>", "i : INT"), pou("<ST>i := i + 2;</ST>", "i : INT", name="other"),
                  instances=f"<configurations><configuration name='c'>{resource('a', 'main')}"
                            f"{resource('b', 'other')}</configuration></configurations>")
    configuration, = built(xml).project.files[0].configurations
    assert [p.name for r in configuration.resources for p in r.programs] == ["one", "b_one"]


@pytest.mark.parametrize("kind", ["program", "PROGRAM", "Program"])
def test_kinds_of_pous_in_any_case(kind: str) -> None:
    assert run(project(pou("<ST>q := TRUE;</ST>", "q : BOOL", kind=kind)), [{}], "q") == ["1"]


# ---- addresses

OF_BEREMIZ = f'<project xmlns:ns1="{NAMESPACE}" '
ANALOG = (("a", "%IX0.0", "BOOL"), ("level", "%IW0", "INT"), ("q", "%QX0.0", "BOOL"),
          ("speed", "%QW0", "INT"), ("far", "%QW3", "INT"), ("wide", "%MD0", "DINT"), ("narrow", "%MW1", "INT"),
          ("small", "%MB9", "BYTE"))


def places(xml: str) -> dict[str, str | None]:
    (main,) = compiled(xml).project.files[0].pous
    return {v.name: v.location for block in main.var_blocks for v in block.variables}


def test_bits_and_words_are_apart_in_openplc() -> None:
    body = "<ST>IF a THEN speed := level; q := TRUE; END_IF; wide := 70000; narrow := 5;</ST>"
    xml = project(located(body, *ANALOG)).replace("<project ", OF_BEREMIZ)
    assert places(xml) == {"a": "%IX0.0", "level": "%IW1", "q": "%QX0.0", "speed": "%QW4", "far": "%QW3",
                           "wide": "%MD3", "narrow": "%MW1", "small": "%MB9"}
    assert [found[:6] for found in findings(xml)] == ["LD0155"] * 3
    assert run(xml, [{"a": 1, "level": 256}, {"a": 0}], "a level speed q wide narrow") == [
        "1 256 256 1 70000 5", "0 256 256 1 70000 5"]


def test_an_address_that_the_program_names_stays() -> None:
    xml = project(located("<ST>%QW0 := 3; speed := speed + 1;</ST>", *ANALOG))
    xml = xml.replace("<project ", OF_BEREMIZ)
    assert places(xml)["speed"] == "%QW0"


def test_other_editors_mean_one_image() -> None:
    xml = project(located("<ST>q := a;</ST>", *ANALOG))
    assert places(xml) == {name: place for name, place, _ in ANALOG}


@pytest.mark.parametrize("place", ["%I*", "%QX*", "%MW*", "%IX0.1.2", "%QW1.2.3", "%MW2000", "%IX0.12", "%IW0.3",
                                   "%IX3", "IX0.1", "%"])
def test_an_address_that_is_no_place_here_is_left_out(place: str) -> None:
    xml = project(located("<ST>IF x > 2 THEN q := TRUE; END_IF;</ST>", ("x", place, "INT"),
                          ("q", "%QX0.0", "BOOL")))
    assert findings(xml) == [f"LD0152 PLCopen XML: the address {place} of `x` is left out"]
    assert run(xml, [{}, {"x": 3}], "q") == ["0", "1"]


@pytest.mark.parametrize("place, type_", [("%MD4", "TIME"), ("%IW2", "REAL"), ("%MB8", "BOOL"),
                                          ("%QX1.0", "INT")])
def test_an_address_of_another_size_is_left_out(place: str, type_: str) -> None:
    ours, other = ("v", place, type_), ("w", f"{place[:2]}B60", "BYTE")
    assert findings(project(located("<ST>;</ST>", ours, other))) == [
        f"LD0152 PLCopen XML: the address {place} of `v` is left out"]
    on = {"%MD4": "%MX16.0", "%IW2": "%IX7.0", "%MB8": "%MW4", "%QX1.0": "%QX2.7"}[place]
    both = located("<ST>;</ST>", ours, ("z", on, "INT" if "W" in on else "BOOL"))
    assert [found[:6] for found in findings(project(both))] == ["LD0212"]


@pytest.mark.parametrize("type_, value_, gives", [
    ("string", "abc", 3), ("string", "it's $5", 7), ("string", "'abc'", 3), ("wstring", "hello", 5),
    ("string", "&quot;a&quot;", 3)])
def test_strings_may_have_no_quotes(type_: str, value_: str, gives: int) -> None:
    declared = (f'<variable name="v"><type><{type_} length="20"/></type><initialValue>'
                f'<simpleValue value="{value_}"/></initialValue></variable></localVars>')
    assert run(statements("i := LEN(v);", "i : INT").replace("</localVars>", declared), [{}], "i") == [str(gives)]


@pytest.mark.parametrize("section, place", [("inputVars", "%IX0.3"), ("outputVars", "%QX0.3")])
def test_inputs_and_outputs_of_a_program_may_have_addresses(section: str, place: str) -> None:
    pins = f'<variable name="a" address="{place}"><type><BOOL/></type></variable>{variables("b : BOOL")}'
    xml = project(pou("<ST>q := a; b := b;</ST>" if section == "outputVars" else "<ST>q := a;</ST>", "q : BOOL",
                      sections=f"<{section}>{pins}</{section}>"))
    assert not findings(xml)
    (main_,) = built(xml).project.files[0].pous
    assert [(b.kind, [v.location for v in b.variables]) for b in main_.var_blocks][1] == ("VAR", [place])
    assert run(xml, [{"a": 1}], "q") == ["1"]


def test_an_external_variable_says_no_more_than_its_name() -> None:
    declared = ('<variable name="a" address="%IX0.3"><type><BOOL/></type><initialValue><simpleValue value="1"/>'
                "</initialValue></variable>")
    instances = (f"<configurations><configuration name='c'><globalVars>{declared}</globalVars>"
                 "<resource name='r'><task name='t' interval='T#10ms' priority='0'>"
                 "<pouInstance name='i' typeName='main'/></task></resource></configuration></configurations>")
    program = pou("<ST>q := a;</ST>", "q : BOOL", sections=f"<externalVars>{declared}</externalVars>")
    assert not findings(project(program, instances=instances))
    assert [f[:6] for f in findings(project(program))] == ["LD0217"]


def test_an_input_of_a_program_that_it_writes() -> None:
    sections = f"<inputVars>{variables('a b : BOOL')}</inputVars>"
    xml = project(pou(f"<LD>{rail()}{contact(2, 'a')}{coil(3, 'b', 2)}</LD>", "", sections=sections))
    assert not findings(xml)
    assert run(xml, [{"a": 1}], "b") == ["1"]


def test_a_pin_on_both_sides_of_a_block_is_in_out() -> None:
    inc = pou("<ST>v := v + 1;</ST>", "", name="inc", kind="functionBlock",
              sections=f"<inOutVars>{variables('v : INT')}</inOutVars>")
    drawn = f"<FBD>{value(2, 'i')}{block(3, 'inc', {'v': 2}, ('v',), 'f')}{result(4, 'j', '3.v')}</FBD>"
    xml = project(inc, pou(drawn, "i j : INT; f : inc"))
    assert run(xml, [{}, {}], "i j") == ["1 1", "2 2"]


# ---- numbers that other editors convert by themselves

MIXED = f"{VALUES}; v : WORD; m : BYTE; d : DINT; e : UINT"


def drawn(type_: str, **operands: str) -> str:
    """`k`, `q` and so on from a function block diagram with one operator."""
    target = operands.pop("to")
    pins = {f"IN{at}": at for at in range(1, len(operands) + 1)} if len(operands) > 1 else {"IN": 1}
    values = [value(at, text) for at, text in enumerate(operands.values(), 1)]
    return fbd(MIXED, *values, block(8, type_, pins, ("OUT",)), result(9, target, "8.OUT"))


WARNED = "LD0156 a value of type {} becomes {} without a conversion"


@pytest.mark.parametrize("type_, operands, sets, gives, told", [
    ("MOVE", {"a": "i", "to": "u"}, {"i": -1}, "65535", ["INT WORD"]),
    ("MOVE", {"a": "u", "to": "i"}, {"u": 65535}, "-1", ["WORD INT"]),
    ("MOVE", {"a": "m", "to": "i"}, {"m": 200}, "200", ["BYTE INT"]),
    ("ADD", {"a": "u", "b": "1", "to": "u"}, {"u": 65535}, "0", ["WORD UINT"]),
    ("ADD", {"a": "u", "b": "i", "to": "i"}, {"u": 65535, "i": 3}, "2", ["WORD DINT"]),
    ("GT", {"a": "u", "b": "i", "to": "q"}, {"u": 65535, "i": 3}, "1", ["WORD DINT"]),
    ("LT", {"a": "i", "b": "e", "to": "q"}, {"e": 65535, "i": -3}, "1", []),
    ("DIV", {"a": "u", "b": "2", "to": "u"}, {"u": 65535}, "32767", ["WORD UINT"])])
def test_an_operator_with_numbers_of_other_types(type_, operands, sets, gives, told) -> None:
    xml = drawn(type_, **operands)
    assert findings(xml) == [WARNED.format(*pair.split()) for pair in told]
    assert run(xml, [sets], operands["to"]) == [gives]


@pytest.mark.parametrize("text, sets, gives, told", [
    ("i := u;", {"u": 65535}, "i -1", ["WORD INT"]),
    ("u := i * 2 + u;", {"i": -1, "u": 5}, "u 3", ["WORD DINT"]),
    ("u := (u + 1) * u;", {"u": 3}, "u 12", ["WORD UINT", "WORD UINT"]),
    ("q := u >= 3 AND u = i;", {"u": 3, "i": 3}, "q 1", ["WORD DINT"]),
    ("d := u;", {"u": 65535}, "d 65535", ["WORD DINT"])])
def test_statements_with_numbers_of_other_types(text, sets, gives, told) -> None:
    xml = statements(text, MIXED)
    assert sorted(findings(xml)) == sorted(WARNED.format(*pair.split()) for pair in told)
    name, number = gives.split()
    assert run(xml, [sets], name) == [number]


@pytest.mark.parametrize("text", ["i := d;", "m := u;", "i := x;", "i := u + d;"])
def test_a_number_that_may_not_fit_is_an_error(text: str) -> None:
    assert "LD0403" in {found[:6] for found in findings(statements(text, MIXED))}


def test_pins_with_numbers_of_other_types() -> None:
    xml = ladder(MIXED, rail(), contact(2, "a"), value(3, "u"),
                 block(4, "CTU", {"CU": 2, "PV": 3}, ("Q", "CV"), "n"), coil(5, "q", "4.Q"),
                 result(6, "v", "4.CV"))
    assert [found for found in findings(xml) if found.startswith("LD01")] == [
        WARNED.format("WORD", "INT"), WARNED.format("INT", "WORD")]
    assert run(xml, [{"u": 2, "a": 1}, {"a": 0}, {"a": 1}], "q v") == ["0 1", "0 1", "1 2"]


PARTS = """<dataType name="Speed"><baseType><WORD/></baseType></dataType>
<dataType name="Axis"><baseType><struct>
<variable name="speed"><type><derived name="Speed"/></type></variable>
<variable name="steps"><type><array><dimension lower="1" upper="2"/><baseType><WORD/></baseType></array></type>
</variable>
<variable name="n"><type><INT/></type></variable>
</struct></baseType></dataType>"""


@pytest.mark.parametrize("text, gives, told", [
    ("o.speed := i; j := o.speed;", "j -2", ["INT WORD", "WORD INT"]),
    ("o.steps[k] := i; j := o.steps[k] + o.n;", "j -2", ["INT WORD", "WORD DINT"]),
    ("o.n := i; u := o.n;", "u 65534", ["INT WORD"]),
    ("p := i; j := p;", "j -2", ["INT WORD", "WORD INT"]),
    ("n(CU := a, PV := 1); u := n.CV;", "u 1", ["INT WORD"]),
    ("n.PV := u; j := n.PV;", "j 0", ["WORD INT"])])
def test_parts_of_variables_are_numbers_of_other_types(text, gives, told) -> None:
    xml = statements(text, f"{VALUES}; o : Axis; p : Speed", PARTS)
    assert sorted(findings(xml)) == sorted(WARNED.format(*pair.split()) for pair in told)
    name, number = gives.split()
    assert run(xml, [{"i": -2, "k": 1, "a": 1}], name) == [number]


def test_a_part_at_a_pin_is_converted() -> None:
    xml = project(pou("<FBD>" + "".join((
        value(1, "o.speed"), value(2, "o.n"), block(3, "ADD", {"IN1": 1, "IN2": 2}, ("OUT",)),
        result(4, "o.steps[2]", "3.OUT"))) + "</FBD>", f"{VALUES}; o : Axis"), types=PARTS)
    assert WARNED.format("WORD", "DINT") in findings(xml)
    assert run(xml, [{"o.speed": 65535, "o.n": 3}], "o.steps[2]") == ["2"]


def test_numbers_are_converted_on_wires_between_blocks() -> None:
    def made(name: str, text: str, inputs: str, outputs: str) -> str:
        return pou(f"<ST><p>{text}</p></ST>", "", name, "functionBlock", f"<inputVars>{variables(inputs)}"
                   f"</inputVars><outputVars>{variables(outputs)}</outputVars>")

    main = pou("<FBD>" + "".join((
        value(1, "u"), block(2, "give", {"a": 1}, ("b", "e"), "p"),
        block(3, "CTU", {"PV": "2.b"}, ("Q", "CV"), "n"),
        block(4, "own", {"x": "2.e", "d": "2.e", "r": "2.e"}, ("y", "z"), "o"), result(5, "v", "4.y"),
        block(6, "own", {"x": "2.b"}, ("y", "z"), "o2"), result(7, "d", "4.z"))) + "</FBD>",
        f"{MIXED}; p : give; o o2 : own")
    xml = project(main, made("give", "b := a; e := -3;", "a : WORD", "b : WORD; e : INT"),
                  made("own", "y := x; z := d + REAL_TO_DINT(r);", "x : WORD; d : DINT; r : REAL",
                       "y : WORD; z : DINT"))
    # A widening is made without a word.
    assert [f for f in findings(xml) if f[:6] == "LD0156"] == [
        WARNED.format("WORD", "INT"), WARNED.format("INT", "WORD")]
    assert run(xml, [{"u": 7}], "n.PV v d o2.x") == ["7 65533 -6 7"]


def test_a_number_that_may_not_fit_at_the_end_of_a_wire_is_an_error() -> None:
    maker = pou("<ST><p>w := 1;</p></ST>", "", "give", "functionBlock",
                f"<outputVars>{variables('w : DINT')}</outputVars>")
    main = pou("<FBD>" + block(1, "give", {}, ("w",), "p") + block(2, "CTU", {"PV": "1.w"}, ("Q",), "n")
               + "</FBD>", f"{MIXED}; p : give")
    assert "LD0313" in {found[:6] for found in findings(project(main, maker))}


def test_an_import_writes_the_conversions(tmp_path) -> None:
    (tmp_path / "plc.xml").write_text(statements("i := u; n(CU := a, RESET := b, PV := u);", MIXED))
    assert main(["import", str(tmp_path / "plc.xml"), "-o", str(tmp_path / "out")]) == 0
    text = (tmp_path / "out" / "src" / "main.st").read_text()
    assert "i := WORD_TO_INT(u);" in text
    assert "n(CU := a, R := b, PV := WORD_TO_INT(u));" in text


# ---- calls


def test_pins_of_standard_blocks_in_calls_have_their_long_names() -> None:
    xml = statements("n(CU := a, RESET := b, PV := 1); f(SET1 := n.Q, RESET := c); q := f.Q1;",
                     f"{VALUES}; f : SR")
    assert not said(built(xml))
    assert run(xml, [{"a": 1}, {"b": 1}, {"c": 1}], "q n.CV") == ["1 1", "1 0", "0 0"]


def test_outputs_follow_the_inputs_in_a_call_without_names() -> None:
    own = pou("<ST>s := p + 1;</ST>", "", name="plus", kind="functionBlock",
              sections=f"<inputVars>{variables('p : INT')}</inputVars>"
                       f"<outputVars>{variables('s : INT')}</outputVars>")
    xml = project(own, pou("<ST>t(a, T#0s, q); g(i, j);</ST>", f"{VALUES}; g : plus"))
    assert run(xml, [{"a": 1, "i": 4}], "q j") == ["1 5"]
    assert [found[:6] for found in findings(statements("t(a, T#1s, q, y, w);"))] == ["LD0509"] * 3


def test_an_address_in_a_comment_is_none_of_the_program() -> None:
    note = "<documentation><p>%QW0 is slow</p></documentation>"
    xml = project(located("<ST>(* %QW0 *) speed := 3;</ST>", *ANALOG)).replace("<project ", OF_BEREMIZ)
    assert places(xml.replace("</interface>", f"</interface>{note}"))["speed"] == "%QW4"


def test_a_body_in_another_language_is_told_once() -> None:
    text = "/* blink */\nint led = 13;\nvoid setup() {\n  pinMode(led, 1);\n}\nvoid loop() { led = 1; }\n"
    assert findings(statements(text)) == ["LD0151 PLCopen XML: a body in C or C++ is not supported"]


def test_conversions_between_bit_strings_and_real_numbers() -> None:
    xml = statements("x := WORD_TO_REAL(u) / 2.0; v := REAL_TO_WORD(x); m := real_to_byte(3.6);", MIXED)
    assert run(xml, [{"u": 40000}], "x v m") == ["20000 20000 4"]
    xml = ladder(MIXED, rail(), contact(2, "a"), value(3, "u"),
                 block(4, "WORD_TO_REAL", {"EN": 2, "IN": 3}, ("ENO", "OUT")), result(5, "x", "4.OUT"),
                 value(6, "x"), block(7, "REAL_TO_WORD", {"IN": 6}, ("OUT",), at=(40, 90)),
                 result(8, "v", "7.OUT", at=(80, 90)))
    assert run(xml, [{"u": 40000}, {"a": 1}], "x v") == ["0 0", "40000 40000"]


# ---- editors of the family of MULTIPROG


def test_lines_of_a_text_that_only_xhtml_breaks() -> None:
    """A comment ends where the line does, an instruction too."""
    text = ("<html><p>q := a; // one</p><p>IF b THEN // two<br/>q := FALSE; (* x<br/>y *) END_IF</p>"
            "<div>z := q;</div></html>")
    assert run(project(pou(f"<ST>{text}</ST>", "a b q z : BOOL")),
               [{"a": 1}, {"b": 1}, {"b": 0}], "z") == ["1", "0", "1"]
    listed = '<IL><p xml:space="preserve">LD a // first<br/>OR b<br/>ST q</p></IL>'
    xml = project(pou(listed, "a b q : BOOL"))
    assert run(xml, [{"a": 0}, {"b": 1}], "q") == ["0", "1"]


def test_a_body_in_il_with_broken_lines_is_imported(tmp_path) -> None:
    source = tmp_path / "plc.xml"
    source.write_text(project(pou("<IL><p>LD a // first<br/>ST q</p></IL>", "a q : BOOL")))
    assert main(["import", str(source), "-o", str(tmp_path / "made")]) == 0
    assert compile_paths([str(tmp_path / "made")]).image.digest == compile_paths([str(source)]).image.digest
    assert "LD a // first\n" in "".join(p.read_text() for p in (tmp_path / "made" / "src").iterdir())


def test_comments_of_variables_tasks_without_names_and_groups_of_globals() -> None:
    variable = '<variable name="shared" comment="seen by all"><type><BOOL/></type></variable>'
    body = (f"<interface><externalVars>{variable}</externalVars></interface>"
            "<body><ST>shared := TRUE;</ST></body>")
    instances = ('<configurations><configuration name="c"><resource name="r">'
                 '<task priority="0" interval="00:00:00.4"><programInstance name="one" type="main"/></task>'
                 '<task priority="1" interval="00:01:00"/>'
                 '<pouInstance name="two" taskName="slow" typeName="main"/>'
                 f'<task name="slow" interval="T#1s"/><globalVars name="Sys">{variable}</globalVars>'
                 "</resource></configuration></configurations>")
    xml = project(f'<pou name="main" pouType="program">{body}</pou>', instances=instances)
    found = compiled(xml)
    assert [d.code for d in found.diagnostics] == []
    file = read(SourceFile("plc.xml", xml), Diagnostics())
    assert [v.note for v in file.pous[0].var_blocks[0].variables] == ["seen by all"]
    tasks = {task.name: task.interval.value for task in file.configurations[0].resources[0].tasks}
    assert tasks == {"unnamed": 400_000_000, "unnamed_2": 60_000_000_000, "slow": 1_000_000_000}


def test_a_task_that_waits_for_an_event_of_the_system_is_told() -> None:
    instances = ('<configurations><configuration name="c"><resource name="r"><task name="start" '
                 'single="@warm"><pouInstance name="one" typeName="main"/></task></resource></configuration>'
                 "</configurations>")
    found = compiled(project(pou("<ST>a := TRUE;</ST>", "a : BOOL"), instances=instances)).diagnostics
    assert [d.message for d in found if d.code == "LD0145"] == [
        "the task `start` waits for an event of the system"]


def test_an_element_of_the_editors_own_with_wires_is_told_and_a_title_is_not() -> None:
    composed = ('<vendorElement localId="8"><position x="30" y="10"/>'
                "<alternativeText><p>Composer</p></alternativeText>"
                f"<inputVariables><variable formalParameter='In1'>{wires(2)}</variable></inputVariables>"
                "<outputVariables><variable formalParameter='Out1'><connectionPointOut/></variable>"
                "</outputVariables></vendorElement>")
    found = compiled(fbd("i j : INT", value(2, "i"), composed, result(3, "j", "8.Out1"))).diagnostics
    assert [(d.code, "`Composer`" in d.message) for d in found] == [("LD0145", True)]
    title = '<vendorElement localId="8"><alternativeText><p>Title</p></alternativeText></vendorElement>'
    assert not compiled(fbd("i j : INT", title, value(2, "i"), result(3, "j", 2))).diagnostics
