"""L5X files that are wrong: told at their place, never a traceback; and files of others."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from ldc.pipeline import compile_paths
from tests import l5x_xml as xml
from tests.foreign_files import compiled
from tests.test_l5x import GAIN

CORPUS = Path(__file__).resolve().parents[2] / "shared" / "corpus" / "l5x"
RICH = xml.one(
    ["SBR();", "XIC(a)[XIO(b.3),TON(t,5,0) ONS(b.1)]OTE(q);", "XIC(go)Gain(g[1],i,b,log)JSR(S,1,b,b);",
     "CPT(r,(i+1)*SIN(2.5)-b/3 AND 16#F)COP(log[0],log[1],2)FAL(c,3,0,ALL,log[c.POS],c.POS);", "LBL(x)MCR();",
     "LIM(1,i,5)MOV('a$'b',s)CONCAT(s,'x',s)JMP(x);"],
    "BOOL a q go; DINT b log[3]; INT i; REAL r; TIMER t; CONTROL c; Gain g[2]; STRING s",
    xml.rll("S", ["SBR(b);", "XIC(S:FS)OTE(Local:1:O.Data.2);", "RET(b);"])
    + xml.st("T", ["b := 1; IF a THEN b := 2; END_IF;"]), addons=GAIN,
    types='<DataType Name="U"><Members><Member Name="m" DataType="DINT" Dimension="2"/></Members></DataType>')


def read(text: str) -> list[str]:
    """The codes that a text gives."""
    return [d.code for d in compiled(text, "plant.L5X").diagnostics]


def test_the_whole_file_is_right() -> None:
    assert not [code for code in read(RICH) if code not in ("LD0204", "LD0152")]


def test_truncated_at_every_length() -> None:
    start = RICH.index("<RSLogix")
    for end in range(start + 40, len(RICH) - 25, 11):
        assert "LD0140" in read(RICH[:end])


def test_truncated_rungs() -> None:
    text = "XIC(a)[XIO(b.3),TON(t,5,0) ONS(b.1)]CPT(b,(b+1)*2)OTE(q);"
    for end in range(len(text)):
        read(xml.one([text[:end]], "BOOL a q; DINT b; TIMER t"))


@settings(max_examples=150, deadline=None)
@given(some.integers(0, 1 << 30), some.integers(1, 4))
def test_mutated(seed: int, count: int) -> None:
    chance, text = random.Random(seed), RICH
    for _ in range(count):
        at, size = chance.randrange(len(text)), chance.randrange(12)
        piece = chance.choice(["", "(", ")", "[", "]", ",", ";", "?", "9999999999", "-", ".", "'", "DINT",
                               "TIMER", "&amp;", "XIC", text[chance.randrange(len(text)) :][:size]])
        text = text[:at] + piece + text[at + size :]
    read(text)


@settings(max_examples=150, deadline=None)
@given(some.text(alphabet="ABabcit()[],;.?:'1230+-*/ \n$#&<>=", max_size=60))
def test_any_rung(text: str) -> None:
    if "]]>" not in text:
        read(xml.one([text], "BOOL a; DINT b c; TIMER t; INT i[3]"))


@settings(max_examples=100, deadline=None)
@given(some.lists(some.sampled_from(
    "IF THEN ELSE END_IF CASE OF END_CASE FOR TO BY DO END_FOR WHILE END_WHILE REPEAT UNTIL a b := ; ( ) 1 "
    ".. : + EXIT RETURN 2.5 [ ] . ABS".split()), max_size=25))
def test_any_statements(words: list[str]) -> None:
    read(xml.controller(xml.program("P", xml.rll("Main", ["JSR(S);"]) + xml.st("S", [" ".join(words)])),
                        xml.tags("BOOL a; DINT b")))


def test_a_bit_that_its_integer_does_not_have_is_told() -> None:
    types = ('<DataType Name="U"><Members><Member Name="w" DataType="SINT"/>'
             '<Member Name="b" DataType="BIT" Target="w" BitNumber="{}"/></Members></DataType>')
    assert read(xml.one(["XIC(u.b)OTE(q);"], "U u; BOOL q", types=types.format(7))) == []
    assert "LD0150" in read(xml.one(["XIC(u.b)OTE(q);"], "U u; BOOL q", types=types.format(8)))


WRONG = [
    ("XIC()OTE(a);", "LD0150"), ("XIC(a)OTE(a)", ""), ("FOO(a);", "LD0151"), ("MSG(t);", "LD0151"),
    ("GSV(a,b);", "LD0151"), ("XIC(nobody)OTE(a);", "LD0404"), ("TON(b,5,0);", "LD0150"),
    ("OTE(b.32);", "LD0150"), ("JMP(x);", "LD0150"), ("LBL(x)OTE(a);LBL(x)OTE(c);", "LD0150"),
    ("JSR(Nobody);", "LD0150"), ("ADD(b,1,2);", "LD0150"), ("XIC(a;", "LD0150"),
    ("XIC(a)]OTE(a);", "LD0150"), ("XIC(a)[OTE(a);", "LD0150"), ("MOV('abc,s);", "LD0150"),
    ("MOV(b+,b);", "LD0150"), ("MOV(?,b);", "LD0150"), ("OTE(arr[9]);", "LD0408"),
    ("XIC(u.none)OTE(a);", "LD0406"), ("XIC(b)OTE(a);", "LD0401"), ("TND()OTE(a);", "LD0151"),
    ("COP(b,u,1);", "LD0151"), ("RES(a);", "LD0150"), ("MOV(FOO(b),b);", "LD0151"),
    ("FAL(ctl,1,0,9z,b,1);", "LD0150"), ("NOP();", "LD0152"), ("XIC(a);", "LD0152"), (";", ""),
    ("OTE(S:V);", "LD0151"),
    ("[" * 120 + "OTE(a)" + "]" * 120 + ";", "LD0153"), (f"MOV({'(' * 120}b{')' * 120},b);", "LD0150"),
    (f"MOV({'-' * 120}b,b);", "LD0153"), ("MOV(16#,b);", "LD0150"), ("MOV(1e999,b);", "LD0150"),
]


@pytest.mark.parametrize(("rung", "code"), WRONG, ids=[w[0][:30] for w in WRONG])
def test_what_is_wrong_is_told(rung: str, code: str) -> None:
    declared = "BOOL a c; DINT b; TIMER t; CONTROL ctl; BOOL arr[3]; U u; STRING s"
    types = '<DataType Name="U"><Members><Member Name="m" DataType="INT"/></Members></DataType>'
    found = [c for c in read(xml.one([rung], declared, types=types)) if c not in ("LD0204", "LD0310")]
    assert (found[:1] or [""])[0] == code, found


def program(*rungs: str, own: str = "", **parts: str) -> str:
    return xml.controller(xml.program("P", xml.rll("Main", rungs), own), **parts)


def udt(name: str, **members: str) -> str:
    inside = "".join(f'<Member Name="{n}" DataType="{t}" Dimension="0"/>' for n, t in members.items())
    return f'<DataType Name="{name}"><Members>{inside}</Members></DataType>'


FILES = [
    ("<Controller/>", "LD0150"),
    (xml.controller('<Program Name="P" MainRoutineName="M"><Routines><Routine Name="M" Type="FBD"/>'
                    "</Routines></Program>"), "LD0151"),
    (program("OTE(x);", own=xml.tags("Nothing x")), "LD0150"),
    (program("OTE(y);", own=xml.tags("Nothing x; BOOL y")), "LD0152"),
    (program("OTE(y);", own=xml.tags("BOOL y; BOOL y")), "LD0201"),
    (program("OTE(y);", own=xml.tag("y", "BOOL", "9999999999")), "LD0150"),
    (xml.controller(xml.program("P", xml.rll("Main", ["OTE(y);"]))
                    + xml.program("Q", xml.rll("Main", ["OTE(y);"]), xml.tags("BOOL y"))), "LD0150"),
    (program("OTE(z);", own='<Tag Name="z" TagType="Alias" AliasFor="z"/>'), "LD0150"),
    (xml.one(["Gain(g,1);"], "Gain g", addons=GAIN), "LD0150"),
    (xml.one(["Gain(x,1,x,x);"], "DINT x", addons=GAIN), "LD0150"),
    (xml.one(["NOP();"], "", addons=xml.addon("TON", "", "")), "LD0150"),
    (xml.one(["OTE(a);"], "BOOL a").replace('Type="N"', 'Type="rR"'), "LD0151"),
    (xml.one(["OTE(a);"], "BOOL a", more='<Tasks><Task Name="T" Type="EVENT"/></Tasks>'), "LD0151"),
    (xml.one(["OTE(a);"], xml.tag("a", "BOOL", data=xml.value("BOOL", "x"))), "LD0152"),
    (program("OTE(u.q);", own=xml.tags("U u"), types=udt("U", q="BOOL", v="V") + udt("V", u="U")), "LD0150"),
    (program("OTE(u.q);", own=xml.tags("U0 u"), types="".join(
        udt(f"U{n}", q="BOOL", a=f"U{n + 1}", b=f"U{n + 1}") for n in range(300))), "LD0225"),
    (program("Own(o);", own=xml.tags("Own o"), addons=xml.addon(
        "Own", '<Parameter Name="P" TagType="Alias" Usage="Input" AliasFor="P"/>',
        xml.rll("Logic", ["XIC(P)OTE(P);"]))), "LD0150"),
]


@pytest.mark.parametrize(("text", "code"), FILES, ids=range(len(FILES)))
def test_files_that_are_wrong(text: str, code: str) -> None:
    text = text if "RSLogix" in text else xml.ROOT + "</RSLogix5000Content>"
    assert read(text)[:1] == [code]


def test_a_finding_stands_at_the_operand(tmp_path: Path) -> None:
    path = tmp_path / "plant.L5X"
    path.write_text(xml.one(["XIC(a)OTE(a);", "XIC(a)OTE(gone);"], "BOOL a"))
    (found,) = compile_paths([str(path)]).diagnostics
    assert found.primary.span.text == "gone" and found.primary.span.position[0] == 10


def test_long_files_cost_linear_time() -> None:
    """Reading only; every instruction of a rung with many is seen once."""
    read(xml.one([f"{'XIC(a)' * 5000}OTE(q);"], "BOOL a q"))
    assert read(xml.one(["XIC(gone)OTE(q);"] * 2000, "BOOL q")).count("LD0404") == 2000


def test_files_of_others() -> None:
    files = sorted(CORPUS.rglob("*.L5X"))
    if not files:
        pytest.skip("no collection of L5X files beside the repository")
    small = [path for path in files if "bench" not in path.name]
    good = {path.name for path in small if compile_paths([str(path)]).program is not None}
    assert len(good) >= 19 and {"DUTY_CYCLE.L5X", "ex1.L5X", "L5X_Printable.L5X", "rungs_math.L5X"} <= good
    assert not {name for name in good if name.startswith("EC0")} - {
        "EC012_array_init_count.L5X", "EC014_unresolved_constant.L5X", "EC015_invalid_data_type.L5X",
        "EC016_invalid_array_range.L5X"}
