"""PLCopen XML as editors write it: pin names, placeholders, open inputs, lists of globals, other parts."""

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
from test_plcopen import built, compiled, run, said

from ldc.diagnostics import Diagnostics
from ldc.parser.plcopen import attributes, read
from ldc.parser.unparse import rung_text
from ldc.pipeline import compile_paths
from ldc.source import SourceFile

BOOLS = "a b c d q w z : BOOL"
VALUES = f"{BOOLS}; i j k : INT; x y : REAL; t : TON; n : CTU; m : CTD; f : SR; g : RS; u : WORD"
START = f"<LD>{rail()}{contact(2, 'a')}{coil(3, 'q', 2)}</LD>"


def codes(xml: str) -> list[str]:
    return [d.code for d in compiled(xml).diagnostics]


# ---- names of pins


@pytest.mark.parametrize("outputs", [("Out1",), ("ENO", "Out1")])
def test_an_editor_that_counts_the_inputs_of_a_comparison_from_en(outputs) -> None:
    xml = ladder(VALUES, rail(), contact(2, "a"), value(4, "i"), value(5, "3"),
                 block(3, "GT", {"EN": 2, "In2": 4, "In3": 5}, outputs), coil(6, "q", "3.Out1"))
    assert run(xml, [{"i": 5}, {"a": 1}, {"i": 3}], "q") == ["0", "1", "0"]


def test_a_wire_may_name_the_output_otherwise_than_the_block() -> None:
    xml = ladder(VALUES, rail(), contact(2, "a"), value(4, "i"), value(5, "3"),
                 block(3, "EQ", {"EN": 2, "In2": 4, "In3": 5}, ("Out1",)), coil(6, "q", "3.q"))
    assert run(xml, [{"a": 1}, {"i": 3}], "q") == ["0", "1"]


def test_results_of_functions_have_many_names() -> None:
    inner = ('<inputVariables><variable formalParameter="EN">' + wires(2) + "</variable>"
             '<variable formalParameter="In2">' + wires(4) + "</variable></inputVariables><inOutVariables/>"
             '<outputVariables><variable formalParameter="ENO"><connectionPointOut/></variable>'
             '<variable formalParameter="Out2"><connectionPointOut><expression>j</expression>'
             "</connectionPointOut></variable></outputVariables>")
    xml = ladder(VALUES, rail(), contact(2, "a"), value(4, "i"), element("block", 3, inner, typeName="MOVE"),
                 right(9, "3.ENO"))
    assert run(xml, [{"i": 5}, {"a": 1}], "j") == ["0", "5"]


def test_long_names_of_the_inputs_of_standard_blocks() -> None:
    counters = ladder(
        VALUES, rail(), contact(2, "a"), contact(3, "b"), value(4, "2"),
        block(5, "CTU", {"CU": 2, "RESET": 3, "PV": 4}, ("Q", "CV"), "n"), coil(6, "q", "5.Q"),
        block(7, "CTD", {"CD": 2, "LOAD": 3, "PV": 4}, ("Q", "CV"), "m", at=(70, 60)), coil(8, "w", "7.Q"))
    rows = run(counters, [{"b": 1}, {"b": 0}, {"a": 1}, {"a": 0}, {"a": 1}, {"b": 1}], "n.CV m.CV q w")
    assert rows == ["0 2 0 0", "0 2 0 0", "1 1 0 0", "1 1 0 0", "2 0 1 1", "0 2 0 0"]
    latches = ladder(
        VALUES, rail(), contact(2, "a"), contact(3, "b"),
        block(5, "SR", {"SET1": 2, "RESET": 3}, ("Q1",), "f"),
        coil(6, "q", "5.Q1"), block(7, "RS", {"SET": 2, "RESET1": 3}, ("Q1",), "g"), coil(8, "w", "7.Q1"))
    rows = run(latches, [{"a": 1, "b": 1}, {"b": 0}, {"a": 0}, {"b": 1}], "q w")
    assert rows == ["1 0", "1 1", "1 1", "0 0"]


# ---- open pins


def test_boxes_without_a_name_stand_at_open_pins() -> None:
    xml = ladder(
        VALUES, rail(), contact(2, "a"), element("inVariable", 5, "<connectionPointOut/><expression/>"),
        block(3, "CTU", {"CU": 2, "R": 5, "PV": 6}, ("Q", "CV"), "n"), value(6, "1"), coil(4, "q", "3.Q"),
        element("outVariable", 7, wires("3.CV") + "<expression/>"))
    assert not said(built(xml))
    assert run(xml, [{"a": 1}], "q n.CV") == ["1 1"]


def test_open_inputs_of_function_blocks_keep_what_they_had() -> None:
    timer = block(3, "TON", {"IN": 2, "PT": None}, ("Q",), "t")
    xml = ladder(VALUES, rail(), contact(2, "a"), timer, coil(4, "q", "3.Q"))
    assert not said(built(xml))
    assert run(xml, [{"a": 1}, {}], "q") == ["1", "1"]


@pytest.mark.parametrize("name, sources, gives", [
    ("AND", (1, 2, None), "1"), ("OR", (None, 3, 1), "1"), ("XOR", (1, None, 2), "0"),
    ("AND", (1, None), "0"), ("OR", (None, 1), "1"), ("EQ", (3, None), "1")])
def test_open_inputs_of_standard_functions_are_told(name: str, sources: tuple, gives: str) -> None:
    pins = {f"IN{n}": source for n, source in enumerate(sources, 1)}
    drawn = block(4, name, pins, ("OUT",))
    xml = fbd(BOOLS, value(1, "a"), value(2, "b"), value(3, "c"), drawn, result(5, "q", "4.OUT"))
    assert codes(xml).count("LD0148") == 1
    assert run(xml, [{"a": 1, "b": 1}], "q") == [gives]


FUNCTION = pou(
    "<ST><p>scaled := p + more; </p></ST>", "", name="scaled", kind="function",
    sections='<returnType><INT/></returnType><inputVars><variable name="p"><type><INT/></type></variable>'
             '<variable name="more"><type><INT/></type><initialValue><simpleValue value="7"/></initialValue>'
             "</variable>"
             '<variable name="far"><type><BOOL/></type></variable></inputVars>')


@pytest.mark.parametrize("out", ["scaled", "OUT"])
def test_open_inputs_of_own_functions_have_their_declared_values(out: str) -> None:
    drawn = block(4, "scaled", {"EN": 2, "p": 3, "more": None}, ("ENO", out))
    parts = rail(), contact(2, "a"), value(3, "i"), drawn, result(5, "j", f"4.{out}"), coil(6, "q", "4.ENO")
    xml = project(FUNCTION, pou(f"<LD>{''.join(parts)}</LD>", "a q : BOOL; i j : INT"))
    assert codes(xml) == ["LD0148", "LD0148"]
    assert run(xml, [{"i": 1}, {"a": 1}], "j q") == ["0 0", "8 1"]


# ---- lists of global variables

BUTTON = "<variable name='start'><type><BOOL/></type></variable>"
LISTS = (f"<addData><data name='.../globalvars'><globalVars name='GVL'>{BUTTON}<variable name='Level'><type>"
         f"<INT/></type></variable></globalVars><globalVars name='HMI'>{BUTTON}</globalVars></data></addData>"
         "</project>")


def test_variables_of_lists_are_found_by_their_qualified_names() -> None:
    xml = ladder("q : BOOL", rail(), contact(2, "GVL.start"), contact(4, "HMI.start", 2),
                 contact(5, "gvl.level = 3", 4), coil(3, "q", 5)).replace("</project>", LISTS)
    found = built(xml)
    (rung,) = found.units["main"]
    assert rung_text(rung.rung) == "RUNG\n    [GVL_start] [HMI_start] [level = 3] (q)"
    remarks = [(r.kind, r.what, r.into) for r in found.project.files[0].remarks]
    assert remarks == [("mapped", "GVL.name", "the name alone"),
                       ("renamed", "GVL.start", "GVL_start"), ("renamed", "HMI.start", "HMI_start")]


def test_a_local_variable_does_not_hide_a_qualified_one() -> None:
    statements = "<ST><p>start := TRUE; q := HMI.start;</p></ST>"
    xml = project(pou(statements, "start q : BOOL")).replace("</project>", LISTS)
    assert run(xml, [{}], "start q") == ["1 0"]


def test_an_unknown_variable_of_a_list_is_told_where_it_is() -> None:
    xml = project(pou(START.replace(">a<", ">GVL.stop<"), "q : BOOL")).replace("</project>", LISTS)
    (found,) = [d for d in compiled(xml).diagnostics if d.severity.value == "error"]
    line = xml[: xml.index("GVL.stop")].count("\n") + 1
    assert (found.code, found.primary.span.position[0]) == ("LD0404", line)


# ---- other parts of a file


def test_interfaces_of_blocks_of_the_editor_are_not_ours() -> None:
    known = ("<addData><data name='openplc.org/library-blocks'><libraryBlocks><pou name='CTU' "
             "pouType='functionBlock'><interface><outputVars><variable name='Q'><type><BOOL/></type>"
             "</variable></outputVars></interface></pou></libraryBlocks></data></addData></project>")
    assert run(project(pou(START, "a q : BOOL")).replace("</project>", known), [{"a": 1}], "q") == ["1"]


def test_a_single_pou_is_a_project() -> None:
    assert run(pou(START, "a q : BOOL").replace("<pou ", '<pou xmlns="http://www.plcopen.org/xml/tc6_0201" '),
               [{"a": 1}], "q") == ["1"]


@pytest.mark.parametrize("part", [
    "<addData><data name='x'><Method name='m'><body><ST><p>;</p></ST></body></Method></data></addData>",
])
def test_methods_are_told(part: str) -> None:
    assert "LD0151" in codes(project(pou(START, "a q : BOOL")).replace("<body>", f"{part}<body>"))


def test_access_paths_are_left_out() -> None:
    access = ("<accessVars><accessVariable alias='x' instancePathAndName='r.a' direction='readOnly'><type>"
              "<BOOL/></type></accessVariable></accessVars>")
    xml = project(pou(START, "a q : BOOL", sections=access))
    assert codes(xml) == ["LD0152"] and built(xml)


def test_pointers_are_told_with_their_variable() -> None:
    pointer = "<variable name='p'><type><pointer><baseType><INT/></baseType></pointer></type></variable>"
    xml = project(pou(START, "a q : BOOL", sections=f"<localVars>{pointer}</localVars>"))
    assert "`p` has the type <pointer>" in said(compiled(xml))


def test_an_input_variable_that_nothing_reads_is_told() -> None:
    xml = fbd(VALUES, value(1, "i"), value(2, "j"), result(3, "k", 1))
    assert codes(xml) == ["LD0147"] and built(xml)


def test_documentation_is_kept() -> None:
    xml = project(pou(START, "a q : BOOL")).replace(
        '<variable name="a"><type><BOOL/></type>',
        '<variable name="a"><type><BOOL/></type><documentation><p>Start\n button</p></documentation>'
    ).replace(
        "</body></pou>", "</body><documentation><p>Starts the pump</p></documentation></pou>")
    (found,) = built(xml).project.files[0].pous
    assert found.title == "Starts the pump"
    assert [v.note for b in found.var_blocks for v in b.variables] == ["Start button", None]


# ---- encodings


@pytest.mark.parametrize("encoding", [
    "utf-8", "UTF-8-SIG", "iso-8859-1", "ISO-8859-15", "windows-1252", "UTF-16", "utf-16-le", "utf-16-be", "cp1250",
    "gbk"])
def test_xml_in_the_encoding_that_it_declares(encoding: str, tmp_path) -> None:
    word = "Kühlung" if encoding != "gbk" else "冷却"
    xml = project(pou(START.replace(">a<", f">x<!--{word}--><"), "x q : BOOL")).replace(
        'encoding="utf-8"', f'encoding="{encoding.removesuffix("-SIG")}"').replace(
        "</body>", f"</body><documentation><p>{word}</p></documentation>").replace("\n", "\r\n")
    path = tmp_path / "plc.xml"
    path.write_bytes(xml.encode(encoding))
    result = compile_paths([str(path)])
    assert result.program is not None, said(result)
    assert result.project.files[0].pous[0].title == word


@pytest.mark.parametrize("data", [
    b'<?xml version="1.0" encoding="utf-8"?><project a="\xe4"/>', b'<?xml version="1.0"?><project a="\xe4"/>',
    b'<?xml version="1.0" encoding="gbk"?><project a="\x80\xff"/>', b"\xff\xfe<", b"<\0", b"\xff\xfeP\0R\0",
    b'<?xml version="1.0" encoding="rot13"?><project/>', b'<?xml version="1.0" encoding="unicode_escape"?>\\x\xe4',
    b'<?xml version="1.0" encoding="cp1"?><project/>'])
def test_text_that_is_not_in_its_encoding_is_told(data: bytes, tmp_path) -> None:
    path = tmp_path / "plc.xml"
    path.write_bytes(data)
    result = compile_paths([str(path)])
    assert result.program is None and result.diagnostics.has_errors


# ---- contacts that compare, a list of projects


def comparing(id_: int, function: str, left: str, other: str, sources=1, **attributes) -> str:
    inner = (f"{wires(sources)}<connectionPointOut/><variable>{left}</variable>"
             f"<variable1>{other}</variable1>")
    return element("contact", id_, inner, typeName=function, **attributes)


def test_contacts_that_compare_two_values() -> None:
    xml = ladder(VALUES, rail(), comparing(2, "EQ_INT", "i", "3"), comparing(3, "LT_INT", "j", "i", 2),
                 comparing(4, "none", "a", "", 3), coil(5, "q", 4),
                 comparing(6, "GE_INT", "k", "5", negated="true"), coil(7, "w", 6))
    given = [{"i": 3, "a": 1}, {"j": 3}, {"j": 2, "a": 0}, {"a": 1, "k": 5}, {"i": 4}]
    assert run(xml, given, "q w") == ["1 1", "0 1", "0 1", "1 0", "0 0"]
    wrong = ladder(VALUES, rail(), comparing(2, "BIT_INT", "i", "3"), coil(3, "q", 2))
    assert codes(wrong) == ["LD0145"]
    assert codes(ladder(VALUES, rail(), comparing(2, "EQ_INT", "i", ""), coil(3, "q", 2))) == ["LD0144"]


def test_typed_functions_are_drawn_as_the_others() -> None:
    xml = ladder(VALUES, rail(), contact(2, "a"), value(4, "i"), value(5, "7"),
                 block(6, "MIN_INT", {"EN": 2, "IN1": 4, "IN2": 5}, ("ENO", "OUT")), result(7, "j", "6.OUT"))
    assert run(xml, [{"a": 1, "i": 9}, {"i": 3}, {"a": 0, "i": 2}], "j") == ["7", "3", "3"]
    assert codes(xml) == []


def test_a_project_in_a_list_of_projects() -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a"), coil(3, "q", 2))
    head, _, rest = xml.partition("<project")
    listed = f'{head}<projects version="2.0"><fileHeader/><project{rest}</projects>'
    assert run(listed, [{"a": 1}, {"a": 0}], "q") == ["1", "0"]
    assert codes('<projects version="2.0"><fileHeader/></projects>') == ["LD0143"]


# ---- attributes of an editor's own


def test_an_unknown_attribute_is_told_once_for_a_kind_of_element_and_listed_by_import() -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a", colour="red"), contact(3, "b", 2, colour="blue"),
                 coil(4, "q", 3, colour="", delay="T#1s"))
    found = [d for d in compiled(xml).diagnostics if d.code == "LD0172"]
    assert [d.message.partition(" is ")[0] for d in found] == [
        "the attribute `colour` of <contact>", "the attribute `delay` of <coil>"]
    assert "and in 1 more" in found[0].primary.text
    assert all(d.primary.span.text in ("colour", "delay") for d in found)
    remarks = read(SourceFile("plc.xml", xml), Diagnostics()).remarks
    assert [remark.what for remark in remarks] == ["attribute colour of <contact>", "attribute delay of <coil>"]


def test_the_encoding_of_a_file_is_no_attribute_to_look_for(monkeypatch) -> None:
    """Nearly all files say it: to look at each of their tags takes longer than all the rest of reading."""
    monkeypatch.setattr(attributes, "_TAG", None)
    xml = ladder(BOOLS, rail(), contact(2, "a"), coil(3, "q", 2))
    _, declared, rest = xml.rpartition("?>")
    assert "LD0172" not in codes(f'<?xml version="1.0" encoding="utf-8" standalone="yes"?>{rest if declared else xml}')


def test_attributes_in_additional_data_in_texts_and_of_namespaces_are_not_told() -> None:
    more = ('<addData><data name="own"><thing kind="x"><addData odd="1"/></thing></data></addData>'
            '<documentation><p class="wide">a = "b"</p></documentation>')
    xml = project(pou(f"<ST><p style='x'>q := a; (* mode=\"x\" *)</p></ST>{more}", BOOLS))
    xml = xml.replace("<project ", '<project xmlns:s="http://s" s:schemaLocation="" ', 1)
    assert "LD0172" not in codes(xml)
