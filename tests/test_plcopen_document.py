"""XML is XML: how tags are written changes nothing, and what is broken takes no longer to be told."""

from __future__ import annotations

import re

import growth
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plcopen_xml import block, coil, contact, ladder, rail, value
from test_plcopen import built

from ldc.diagnostics import Diagnostics
from ldc.parser.plcopen import interface
from ldc.parser.plcopen.document import MAX_DEPTH, Document
from ldc.source import SourceFile

DRAWN = ladder(
    "a b q : BOOL; t : TON; n : INT", rail(), contact(2, "n > 1"), contact(3, "b", 2, negated="true"),
    contact(4, "a"), value(5, "T#1s"), block(6, "TON", {"IN": (3, 4), "PT": 5}, ("Q", "ET"), instance="t"),
    coil(7, "q", "6.Q"))
TAGS = re.compile(r"<(/?)(?=[a-zA-Z])")
VALUES = re.compile(r'="([^"]*)"')


def bent(xml: str, inner: str) -> str:
    """With something in each wire."""
    return re.sub(r"<connection ([^>]*?)\s*/>", rf"<connection \1>{inner}</connection>", xml)


CHANGES = {
    "apostrophes": lambda xml: VALUES.sub(r"='\1'", xml),
    "blanks": lambda xml: VALUES.sub(r' =  "\1"', xml),
    "lines": lambda xml: xml.replace(' localId="', '\n\tlocalId="'),
    "greater": lambda xml: xml.replace(' localId="', ' note="a > b, a/>b" localId="'),
    "markup in values": lambda xml: xml.replace(' localId="', " note='&lt;!-- &gt; \">' localId=\""),
    "references": lambda xml: xml.replace('localId="4"', 'localId="&#52;"').replace(
        'refLocalId="4"', 'refLocalId="&#x34;"'),
    "prefix": lambda xml: TAGS.sub(r"<\1ppx:", xml).replace("xmlns=", "xmlns:ppx="),
    "comments": lambda xml: xml.replace("<connection ", "<!-- a wire > --><connection ").replace(
        "</LD>", "<?done?></LD>"),
    "bends": lambda xml: bent(xml, '<position x="1" y="2"/><position x="3" y="4"></position>'),
    "data in wires": lambda xml: bent(
        xml, '<addData><data name="x"><position x="1" y="2"/></data></addData>'),
    "places of pins": lambda xml: xml.replace(
        "<connectionPointIn>", '<connectionPointIn><relPosition x="0" y="8"/>'),
    "long places of pins": lambda xml: xml.replace(
        "<connectionPointIn>", '<connectionPointIn><relPosition x="0" y="8"></relPosition>'),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_the_same_in_other_words(change) -> None:
    other = change(DRAWN)
    assert other != DRAWN
    assert built(other).image.digest == built(DRAWN).image.digest


def test_spans_of_elements() -> None:
    text = ' <p>\n <a x="1" y = "&lt;"/>\n <n:b>c</n:b><b z=\'>\'> <d></d> </b></p>\n'
    found = Diagnostics()
    root = Document(SourceFile("x.xml", text), found).root
    assert not found
    first, second, third = root.children
    assert [node.tag for node in root.children] == ["a", "b", "b"]
    assert (first.whole.text, first.body.text) == ('<a x="1" y = "&lt;"/>', "")
    assert first.attributes == {"x": "1", "y": "<"}
    assert first.attribute("x").text == "1"
    assert (second.span.text, second.whole.text, second.content.text) == ("<n:b>", "<n:b>c</n:b>", "c")
    assert (third.whole.text, third.get("z")) == ("<b z='>'> <d></d> </b>", ">")
    assert [node.tag for node in third.children] == ["d"]


@pytest.mark.parametrize("part", [
    "<!--", "<![CDATA[", "<?", "<a ", '<a b="', "<a b='", '="', "= ", "<connection >", "<position />", "<a>b",
    "</a>", "<relPosition />", "<connection ><position />", "<connection ><position /></connection >", "<", ">",
    "\n", "<a/>"])
def test_broken_text_is_told_in_linear_time(part: str) -> None:
    times = []
    for count in (5_000, 50_000):
        for start in ("<p>", "<connection >", "<p "):
            found, text = Diagnostics(), start + part * count
            assert Document(SourceFile("x.xml", text), found).root is None and len(found) == 1
            times.append(growth.seconds(lambda: Document(SourceFile("x.xml", text), Diagnostics())))
    assert max(times[3:]) < 25 * max(*times[:3], 0.02), times


def test_as_many_levels_as_there_may_be() -> None:
    for depth, reads in ((MAX_DEPTH, True), (MAX_DEPTH + 1, False)):
        found = Diagnostics()
        text = "<a>" * depth + "</a>" * depth
        assert (Document(SourceFile("x.xml", text), found).root is not None) == reads
        if not reads:
            (problem,) = found
            assert (problem.code, problem.primary.span.start) == ("LD0142", 3 * MAX_DEPTH)


BLANKS = st.sampled_from(["", " ", "\n  "])
PLACES = st.sampled_from(['', '<position x="60" y="20"/>', '<position y="5" x="7" />',
                          '<position x="1.5" y="-3"/>'])
WIRE = st.sampled_from(['<connection refLocalId="3"/>', '<connection refLocalId="5" formalParameter="Q"/>',
                        '<connection formalParameter="Q" refLocalId="5"></connection>',
                        '<connection refLocalId="7">\n<position x="1" y="2"/><position x="3" y="2"/>'
                        "</connection>"])
POINT = st.builds(lambda place, wires: f"<connectionPointIn>{place}{''.join(wires)}</connectionPointIn>",
                  st.sampled_from(["", '<relPosition x="0" y="8"/>']), st.lists(WIRE, max_size=3))
WORDS = st.sampled_from(["", "<variable>a</variable>", "<variable> a.b[2] </variable>", "<variable></variable>",
                         "<variable>a &amp; b</variable>", "<variable><!-- no -->c</variable>"])


@given(st.sampled_from(["contact", "coil"]), PLACES,
       st.one_of(st.just(""), POINT, st.just("<connectionPointIn/>")),
       st.sampled_from(["", "<connectionPointOut/>", '<connectionPointOut>\n<relPosition x="2" y="8"/>'
                        "</connectionPointOut>"]), WORDS, st.sampled_from(["", "<documentation/>"]), BLANKS)
def test_what_is_written_as_usual_says_what_its_tree_says(
        tag: str, place: str, point: str, out: str, words: str, more: str, blank: str) -> None:
    inside = blank.join(["", place, point, out, words, more, ""])
    text = f'<LD><{tag} localId="4" negated="true">{inside}</{tag}></LD>'
    node = Document(SourceFile("x.xml", text), Diagnostics()).root.children[0]
    tree = node.like(tag, node.children)
    assert tree.usual is None
    if place:
        assert (node.usual is None) == ("&" in words or "<!--" in words or bool(more))
    assert node.position == tree.position
    assert node.wires() == tree.wires()
    assert [wire.whole for wire in node.connections()] == [wire.whole for wire in tree.connections()]
    assert len(node.wires()) == len(list(node.connections()))
    assert node.words("variable") == tree.words("variable")
    assert (node.end, node.whole, node.flag("negated")) == (len(text) - len("</LD>"), tree.whole, True)


TYPES = st.sampled_from(["<BOOL/>", "<INT />", "<bool/>", "<POINTER/>", '<derived name="TON"/>', "<string/>",
                         '<derived name="STRING(20)"/>', '<derived name="a b"/>', "<derived name='T'/>",
                         '<derived name="Stra&#223;e"/>', '<derived name="x" y="z"/>', "", "<BOOL></BOOL>"])


@given(TYPES, st.sampled_from(["", '<initialValue><simpleValue value="1"/></initialValue>',
                               "<documentation>why</documentation>", "<!-- no -->", "<edge/>"]), BLANKS)
def test_a_declared_variable_is_what_its_tree_says(type_: str, more: str, blank: str) -> None:
    inside = blank.join(["", f"<type>{blank}{type_}{blank}</type>", more, ""])
    text = f'<localVars><variable name="v" address="%ix0.0">{inside}</variable></localVars>'
    node = Document(SourceFile("x.xml", text), Diagnostics()).root.children[0]
    if type_ in ("<BOOL/>", '<derived name="TON"/>'):
        assert (node.usual is None) == bool(more)
    tree = node.like("variable", node.children)
    told, expected = Diagnostics(), Diagnostics()
    assert interface.variable(node, told) == interface.variable(tree, expected)
    assert list(told) == list(expected)
    assert node.position == tree.position and list(node.wires()) == [] and node.words("variable") is None
