"""PLCopen XML: what every construct of a drawing becomes, and what it then does."""

from __future__ import annotations

import pytest
from plcopen_xml import (
    block,
    coil,
    contact,
    element,
    fbd,
    ladder,
    pou,
    project,
    rail,
    result,
    right,
    value,
    wires,
)

from ldc.il import text as il_text
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser.unparse import rung_text
from ldc.pipeline import Compiled, compile_project
from ldc.source import SourceFile
from runtime.vm.machine import Machine

BOOLS = "a b c d q w z : BOOL"
VALUES = f"{BOOLS}; i j k : INT; x y : REAL; t : TON; n : CTU; f : SR"


def compiled(xml: str) -> Compiled:
    return compile_project(Sources((SourceFile("plc.xml", xml),), Settings(), None))


def said(result: Compiled) -> str:
    return "\n".join(f"{d.severity.value} {d.code} {d.message}" for d in result.diagnostics)


def built(xml: str) -> Compiled:
    result = compiled(xml)
    assert result.program is not None, said(result)
    return result


def run(xml: str, inputs: list[dict], watch: str) -> list[str]:
    """The watched variables after each scan, as `101`."""
    machine = Machine(built(xml).program)
    rows = []
    for row in inputs:
        for name, given in row.items():
            machine.set(name, given)
        machine.scan()
        rows.append(" ".join(str(int(machine.get(name))) for name in watch.split()))
    return rows


CASES = {
    "series and parallel": ladder(
        BOOLS, rail(), contact(2, "a"), contact(3, "b", at=(30, 30)), contact(4, "c", (2, 3), negated="true"),
        coil(5, "q", 4), right(6, 5)),
    "two coils share a set of sources": ladder(
        BOOLS, rail(), contact(2, "a"), contact(3, "b"), coil(4, "q", (2, 3)), coil(5, "w", (2, 3))),
    "an output in two sets goes into the wider one": ladder(
        BOOLS, rail(), contact(2, "a"), contact(3, "b"), coil(4, "q", 2), coil(5, "w", (2, 3))),
    "three sets that overlap": ladder(
        BOOLS, rail(), contact(2, "a"), contact(3, "b"), contact(4, "c"), coil(5, "q", (2, 3)),
        coil(6, "w", (3, 4)), coil(7, "z", (2, 4))),
    "coils in a row pass power": ladder(BOOLS, rail(), contact(2, "a"), coil(3, "q", 2), coil(4, "w", 3)),
    "all coils": ladder(
        BOOLS, rail(), contact(2, "a"), coil(3, "q", 2, negated="true"), coil(4, "w", 2, storage="set"),
        coil(5, "w", 2, storage="reset"), coil(6, "z", 2, edge="rising"), coil(7, "d", 2, edge="falling")),
    "edges": ladder(
        BOOLS, rail(), contact(2, "a", edge="rising"), contact(3, "b", 2, edge="falling"),
        coil(4, "q", 3)),
    "one edge contact feeds two coils": ladder(
        BOOLS, rail(), contact(2, "a", edge="rising"), coil(3, "q", 2), coil(4, "w", 2)),
    "a timer": ladder(
        VALUES, rail(), contact(2, "a"), value(3, "T#1s"),
        block(4, "TON", {"IN": 2, "PT": 3}, ("Q", "ET"), "t"), coil(5, "q", "4.Q")),
    "a counter with two power pins and a value": ladder(
        VALUES, rail(), contact(2, "a"), contact(3, "b"), value(4, "5"),
        block(5, "CTU", {"CU": 2, "R": 3, "PV": 4}, ("Q", "CV"), "n"), coil(6, "q", "5.Q"),
        result(7, "i", "5.CV")),
    "EN and ENO": ladder(
        VALUES, rail(), contact(2, "a"), value(3, "i"),
        block(4, "MOVE", {"EN": 2, "IN": 3}, ("ENO", "OUT"), at=(40, 0)), result(5, "j", "4.OUT"),
        coil(6, "q", "4.ENO")),
    "EN at the rail": ladder(
        VALUES, rail(), value(3, "i"), block(4, "MOVE", {"EN": 1, "IN": 3}, ("ENO", "OUT")),
        result(5, "j", "4.OUT")),
    "a chain of values": fbd(
        VALUES, value(1, "i"), value(2, "2"), block(3, "ADD", {"IN1": 1, "IN2": 2}, ("OUT",)),
        block(4, "MUL", {"IN1": "3.OUT", "IN2": 2}, ("OUT",)), result(5, "j", "4.OUT")),
    "one value, two variables": fbd(
        VALUES, value(1, "i"), value(2, "2"), block(3, "ADD", {"IN1": 1, "IN2": 2}, ("OUT",)),
        result(4, "j", "3.OUT"), result(5, "k", "3.OUT")),
    "a condition in FBD": fbd(
        VALUES, value(1, "i"), value(2, "7"), block(3, "GT", {"IN1": 1, "IN2": 2}, ("OUT",)),
        value(4, "a"), block(5, "AND", {"IN1": "3.OUT", "IN2": 4}, ("OUT",)), result(6, "q", "5.OUT")),
    "a variable to a variable": fbd(VALUES, value(1, "i + 1"), result(2, "j", 1)),
    "negated and edge pins": ladder(
        VALUES, rail(), contact(2, "a"), contact(3, "b"),
        block(4, "CTU", {"CU": 2, "R": 3, "PV": 5}, ("Q", "CV"), "n",
              modified={"CU": 'edge="rising"', "R": 'negated="true"', "Q": 'negated="true"'}),
        value(5, "3"), coil(6, "q", "4.Q")),
    "a negated value and an edge of a variable": fbd(
        VALUES, value(1, "a", negated="true"), value(2, "b"),
        block(3, "SR", {"S1": 1, "R": 2}, ("Q1",), "f", modified={"R": 'edge="rising"'}),
        result(4, "q", "3.Q1", negated="true")),
    "feedback": fbd(
        VALUES, block(1, "AND", {"IN1": 2, "IN2": "3.OUT"}, ("OUT",), at=(10, 10)), value(2, "a"),
        block(3, "OR", {"IN1": "1.OUT", "IN2": 4}, ("OUT",), at=(50, 10)), value(4, "b"), result(5, "q", "3.OUT")),
    "jump, label, return": ladder(
        BOOLS, rail(), contact(2, "a", at=(20, 10)),
        element("jump", 3, wires(2), (60, 10), label="behind"),
        contact(4, "b", at=(20, 50)), coil(5, "q", 4, at=(60, 50)),
        element("label", 6, "", (10, 90), label="behind"),
        contact(7, "c", at=(20, 100)), element("return", 8, wires(7), (60, 100)),
        contact(9, "d", at=(20, 150)), coil(10, "w", 9, at=(60, 150))),
    "connector and continuation": ladder(
        BOOLS, rail(), contact(2, "a"), element("connector", 3, wires(2), name="on"),
        element("continuation", 4, "<connectionPointOut/>", name="on"), contact(5, "b", 4), coil(6, "q", 5)),
    "execution order comes before position": fbd(
        VALUES, value(1, "i"), value(2, "1"),
        block(3, "ADD", {"IN1": 1, "IN2": 2}, ("OUT",), at=(10, 50), executionOrderId=1),
        result(4, "i", "3.OUT", executionOrderId=2),
        block(5, "MUL", {"IN1": 1, "IN2": 2}, ("OUT",), at=(10, 10), executionOrderId=3),
        result(6, "j", "5.OUT", executionOrderId=4)),
    "no rail": ladder(BOOLS, contact(2, "a", None), coil(3, "q", 2)),
    "two rails": ladder(
        BOOLS, rail(), contact(2, "a"), coil(3, "q", 2), rail(4), contact(5, "b", (1, 4)), coil(6, "w", 5)),
    "a bridge": ladder(
        BOOLS, rail(), contact(2, "a"), contact(3, "b"), contact(4, "c", 2), contact(5, "d", (3, 4)),
        contact(6, "z", 2), coil(7, "q", (5, 6))),
    "a comment is the title": ladder(
        BOOLS, element("comment", 9, "<content><p>  first\n rung </p></content>", (5, 0)), rail(),
        contact(2, "a", at=(20, 10)), coil(3, "q", 2, at=(50, 10)),
        contact(4, "b", at=(20, 50)), coil(5, "w", 4, at=(50, 50))),
    "an expression in a contact": ladder(
        VALUES, rail(), contact(2, "i > 3 & b"), contact(3, "i < j", 2, negated="true"), coil(4, "q", 3)),
    "an expression at a pin": ladder(
        VALUES, rail(), contact(2, "a"),
        element("block", 3, '<inputVariables><variable formalParameter="EN">' + wires(2) + "</variable>"
                '<variable formalParameter="IN"><connectionPointIn><expression>i</expression>'
                "</connectionPointIn></variable></inputVariables><inOutVariables/><outputVariables>"
                '<variable formalParameter="OUT"><connectionPointOut><expression>j</expression>'
                "</connectionPointOut></variable></outputVariables>", typeName="MOVE")),
}


def test_listings(golden) -> None:
    parts = []
    for title, xml in CASES.items():
        result = built(xml)
        listing = il_text.print_unit(result.program.unit("main"), result.program.units)
        body = listing[listing.index("(* rung"):].replace("END_PROGRAM", "").strip()
        rungs = "\n".join(rung_text(build.rung) for build in result.units["main"])
        notes = "".join(f"(* {line} *)\n" for line in said(result).splitlines())
        parts.append(f"(* ==== {title} ==== *)\n{rungs}\n\n{body}\n{notes}")
    golden("plcopen/listings.txt", "\n".join(parts))


@pytest.mark.parametrize("title", CASES)
def test_every_rung_is_the_same_as_its_drawing(title: str) -> None:
    for build in built(CASES[title]).units["main"]:
        assert build.verdict.kind in ("proof", "check")


def test_a_contact_is_not_read_again_for_a_second_coil() -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a", negated="true"), coil(3, "a", 2), coil(4, "q", 2))
    assert run(xml, [{}, {}], "a q") == ["1 1", "0 0"]


def test_eno_is_written_before_what_follows_reads_it() -> None:
    xml = ladder(
        VALUES, rail(), contact(2, "a"), value(3, "10"), value(4, "i"),
        block(5, "DIV", {"EN": 2, "IN1": 3, "IN2": 4}, ("ENO", "OUT")), result(6, "j", "5.OUT"),
        coil(7, "q", "5.ENO"), contact(8, "q", "5.ENO"), coil(9, "w", 8))
    assert run(xml, [{"a": 1, "i": 0}, {"i": 5}, {"a": 0, "i": 1}], "q w j") == ["0 0 0", "1 1 2", "0 0 2"]


def test_one_edge_contact_feeding_two_coils_is_one_memory() -> None:
    xml = CASES["one edge contact feeds two coils"]
    assert len([v for v in built(xml).program.unit("main").variables if v.name.startswith("_ldc_r")]) == 1
    assert run(xml, [{}, {"a": 1}, {}, {"a": 0}, {"a": 1}], "q w") == ["0 0", "1 1", "0 0", "0 0", "1 1"]


def test_sources_of_one_input_are_ored_and_do_not_flow_back() -> None:
    xml = CASES["an output in two sets goes into the wider one"]
    assert run(xml, [{}, {"a": 1}, {"a": 0, "b": 1}], "q w") == ["0 0", "1 1", "0 1"]


def test_chained_coils_pass_power() -> None:
    assert run(CASES["coils in a row pass power"], [{"a": 1}, {"a": 0}], "q w") == ["1 1", "0 0"]


def test_feedback_counts_as_it_was_in_the_previous_scan() -> None:
    rows = run(CASES["feedback"], [{"a": 1}, {"b": 1}, {"b": 0}, {}, {"a": 0}, {}], "q")
    assert rows == ["0", "1", "1", "1", "0", "0"]


def test_execution_numbers_decide_what_is_read_first() -> None:
    assert run(CASES["execution order comes before position"], [{"i": 5}], "i j") == ["6 6"]


def test_a_jump_skips_the_rungs_before_its_label() -> None:
    rows = run(CASES["jump, label, return"], [{"b": 1, "d": 1}, {"a": 1, "b": 0, "c": 1, "d": 0}], "q w")
    assert rows == ["1 1", "1 1"]


TYPES = """
<dataType name="Colour"><baseType><enum><values><value name="red"/><value name="green" value="5"/></values></enum>
</baseType></dataType>
<dataType name="Level"><baseType><subrangeSigned><range lower="0" upper="9"/><baseType><INT/></baseType>
</subrangeSigned></baseType><initialValue><simpleValue value="3"/></initialValue></dataType>
<dataType name="Point"><baseType><struct><variable name="x"><type><INT/></type></variable>
<variable name="tags"><type><array><dimension lower="1" upper="4"/><baseType><INT/></baseType></array></type>
</variable></struct></baseType></dataType>
"""
SECTIONS = """
<globalVars/>
<localVars retain="true"><variable name="kept" address="%QW2"><type><INT/></type>
<initialValue><simpleValue value="16#10"/></initialValue></variable></localVars>
<localVars constant="true"><variable name="most"><type><INT/></type>
<initialValue><simpleValue value="7"/></initialValue></variable></localVars>
<tempVars><variable name="list"><type><array><dimension lower="0" upper="2"/><baseType><INT/></baseType></array>
</type><initialValue><arrayValue><value repetitionValue="2"><simpleValue value="4"/></value>
<value><simpleValue value="6"/></value></arrayValue></initialValue></variable></tempVars>
<localVars><variable name="shade"><type><derived name="Colour"/></type>
<initialValue><simpleValue value="green"/></initialValue></variable>
<variable name="text"><type><string length="12"/></type>
<initialValue><simpleValue value="'a &lt; b'"/></initialValue></variable>
<variable name="level"><type><derived name="Level"/></type></variable>
<variable name="at"><type><derived name="Point"/></type><initialValue><structValue>
<value member="x"><simpleValue value="8"/></value></structValue></initialValue></variable></localVars>
"""
INSTANCES = """
<configurations><configuration name="Config 0"><resource name="Res0">
<task name="fast" interval="PT0.005S" priority="1"><pouInstance name="one" typeName="main"/></task>
<task name="slow" interval="20ms" priority="2"/>
<globalVars><variable name="shared"><type><INT/></type></variable></globalVars>
</resource></configuration></configurations>
"""


def test_types_variables_initial_values_and_tasks() -> None:
    body = f"<LD>{rail()}{contact(2, 'level = 3')}{coil(3, 'q', 2)}</LD>"
    found = built(project(pou(body, "q : BOOL", sections=SECTIONS), types=TYPES, instances=INSTANCES))
    machine = Machine(found.program)
    machine.scan()
    shown = {name: machine.get(name) for name in ("q", "kept", "most", "shade", "text", "at_.x", "level")}
    assert shown == {"q": True, "kept": 16, "most": 7, "shade": 5, "text": "a < b", "at_.x": 8, "level": 3}
    resource, = found.program.resources
    assert [(t.name, t.interval, t.priority) for t in resource.tasks] == [
        ("fast", 5_000_000, 1), ("slow", 20_000_000, 2)]
    assert {v.name: v.retain for v in found.program.unit("main").variables}["kept"]


@pytest.mark.parametrize("namespace", ["http://www.plcopen.org/xml/tc6.xsd",
                                       "http://www.plcopen.org/xml/tc6_0200", ""])
def test_any_namespace(namespace: str) -> None:
    body = f"<LD>{rail()}{contact(2, 'a')}{coil(3, 'q', 2)}</LD>"
    assert run(project(pou(body, "a q : BOOL"), namespace=namespace), [{"a": 1}], "q") == ["1"]


def test_prefixed_names_and_text_before_the_declaration() -> None:
    xml = CASES["coils in a row pass power"].replace("<", "<p:").replace("<p:/", "</p:").replace("<p:?", "<?")
    assert run(" \n" + xml.replace("xmlns=", "xmlns:p="), [{"a": 1}], "q") == ["1"]


def test_a_body_in_instruction_list() -> None:
    il = "<IL><xhtml xmlns='http://www.w3.org/1999/xhtml'><![CDATA[\nLD a\nAND(b\nOR c\n)\nST q\n]]></xhtml></IL>"
    assert run(project(pou(il, "a b c q : BOOL")), [{"a": 1, "c": 1}], "q") == ["1"]


def test_a_body_in_structured_text() -> None:
    st = ("<ST><xhtml xmlns='http://www.w3.org/1999/xhtml'>\nIF a &amp; i &lt;= 3 THEN\n  q := i &lt;&gt; 2;\n"
          "END_IF;\n</xhtml></ST>")
    assert run(project(pou(st, "a q : BOOL; i : INT")), [{"a": 1}, {"i": 2}, {"i": 4}], "q") == ["1", "0", "0"]
    xml = project(pou(st.replace("q :=", "p :="), "a q : BOOL; i : INT"))
    wrong = compiled(xml)
    finding, = wrong.diagnostics
    assert (finding.code, finding.primary.span.text) == ("LD0404", "p")
    assert finding.primary.span.position[0] == xml[: xml.index("p :=")].count("\n") + 1


STATEMENTS = ('<block localId="3" typeName="EXECUTE"><inputVariables><variable formalParameter="EN">' + wires(2)
              + '</variable></inputVariables><outputVariables><variable formalParameter="Out1"/></outputVariables>'
              '<addData><data name="x/stcode"><STCode>i := i + 1; IF i &gt; 2 THEN w := b; END_IF;</STCode></data>'
              "</addData></block>")


def test_statements_in_a_block_run_under_power() -> None:
    xml = ladder(VALUES, rail(), contact(2, "a"), STATEMENTS, coil(4, "q", "3.Out1"))
    rows = run(xml, [{"b": 1}, {"a": 1}, {}, {}, {"a": 0, "b": 0}], "i w q")
    assert rows == ["0 0 0", "1 0 1", "2 0 1", "3 1 1", "3 1 0"]


def test_a_function_block_with_en_is_called_under_power_only() -> None:
    counter = block(3, "CTU", {"EN": 2, "CU": 4, "PV": 5}, ("ENO", "Q", "CV"), "n")
    xml = ladder(VALUES, rail(), contact(2, "a"), counter, contact(4, "b"), value(5, "3"), result(6, "i", "3.CV"),
                 coil(7, "q", "3.ENO"))
    rows = run(xml, [{"b": 1}, {"b": 0, "a": 1}, {"b": 1}, {"a": 0, "b": 0}, {"b": 1}], "i n.CV q")
    assert rows == ["0 0 0", "0 0 1", "1 1 1", "1 1 0", "1 1 0"]


def test_en_at_the_rail_and_eno_without_en_are_always_on() -> None:
    counter = block(3, "CTU", {"EN": 1, "CU": 4, "PV": 5}, ("ENO", "Q", "CV"), "n")
    xml = ladder(VALUES, rail(), counter, contact(4, "b"), value(5, "3"), coil(7, "q", "3.ENO"))
    assert run(xml, [{}, {"b": 1}], "n.CV q") == ["0 1", "1 1"]


def test_a_function_block_of_the_project_keeps_its_own_en() -> None:
    inside = ladder("", rail(), contact(2, "EN"), coil(3, "done", 2)).partition("<body>")[2].partition("</body>")[0]
    pins = ('<inputVars><variable name="EN"><type><BOOL/></type></variable></inputVars>'
            '<outputVars><variable name="done"><type><BOOL/></type></variable></outputVars>')
    own = pou(inside, "", name="own", kind="functionBlock", sections=pins)
    body = f"<LD>{rail()}{contact(2, 'a')}{block(3, 'own', {'EN': 2}, ('done',), 'o')}{coil(4, 'q', '3.done')}</LD>"
    assert run(project(own, pou(body, "a q : BOOL; o : own")), [{"a": 1}, {"a": 0}], "q") == ["1", "0"]


def test_findings_point_into_the_xml() -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a"), contact(3, "i > 5"), coil(4, "mortor", (2, 3)))
    found = compiled(xml)
    marked = {(d.code, d.primary.span.text, d.primary.span.position[0]) for d in found.diagnostics
              if d.severity.value == "error"}
    line = xml[: xml.index(">mortor<")].count("\n") + 1
    assert ("LD0404", "mortor", line) in marked
    assert any(d.primary.span.source.line(line_of_i).strip().endswith("<variable>i > 5   </variable></contact>")
               for d in found.diagnostics for line_of_i in [xml[: xml.index("i &gt; 5")].count("\n") + 1]
               if d.primary and d.primary.span.text == "i")


def test_loose_parts_are_told_and_left_out() -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a"), coil(3, "q", 2), contact(4, "b"), contact(5, "c", None),
                 coil(6, "w", 5), coil(7, "z", None), right(8, 4))
    found = built(xml)
    assert [rung_text(b.rung) for b in found.units["main"]] == ["RUNG\n    [a] (q)"]
    assert [d.code for d in found.diagnostics] == ["LD0147"] * 4


@pytest.mark.parametrize("at", range(0, 100, 3))
def test_a_truncated_file_is_told(at: int) -> None:
    xml = CASES["negated and edge pins"]
    found = compiled(xml[: len(xml) * at // 100])
    assert found.program is None and found.diagnostics.has_errors


@pytest.mark.parametrize("xml", [
    "<", "<project", "<project/>", "<project></project", "<project><types/></project>", "\ufeff<project/>",
    "<project>\x00</project>", "<project>" + "<a>" * 100_000, "<a b='" + "&#65;" * 1000 + "'/>",
    '<!DOCTYPE p [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><project>&b;</project>',
    '<!DOCTYPE p SYSTEM "file:///etc/passwd"><project/>',
    project(pou("<LD><contact/></LD>", "")), project(pou("<FBD><block localId='1'/></FBD>", "")),
    project(pou("", "a : nothing"), instances="<configurations><configuration><resource><task><pouInstance/>"
            "</task></resource></configuration></configurations>"), project(pou("", "a : nothing")), project("<pou/>"), project("<pou name='1' pouType='x'/>"),
    ladder("a : BOOL", rail(), contact(2, "")), ladder("a : BOOL", rail(), contact(2, "a b"), coil(3, "a", 2)),
    ladder("a : BOOL", contact(2, "a", 3), contact(3, "a", 2), coil(4, "a", 3)),
    ladder("a : BOOL", rail(), element("continuation", 2, name="x"), coil(3, "a", 2)),
    ladder("a : BOOL", element("connector", 2, wires(3), name="x"),
           element("continuation", 3, name="x"), coil(4, "a", 3)),
])
def test_broken_files_are_told_and_never_raise(xml: str) -> None:
    found = compiled(xml)
    assert found.program is None or not found.program.unit("main").rungs
    assert len(found.diagnostics) > 0
