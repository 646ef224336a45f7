"""Where findings are in drawings: POU, rung, element, position, and the rung with the element marked."""

from __future__ import annotations

import json

import pytest
from plcopen_xml import block, coil, contact, element, ladder, pou, project, rail, value

from ldc.cli.main import main
from ldc.diagnostics import Diagnostics, Place
from ldc.draw import Locator
from ldc.parser import parse_file
from ldc.pipeline import compile_paths
from ldc.source import SourceFile

BOOLS = "a b c d q w : BOOL; t : TON"


@pytest.fixture
def check(tmp_path, monkeypatch, capsys):
    """What `ldc check` says about a text (or bytes) in `plc.xml`, or about one in another file."""
    def run(text: str, *arguments: str, name: str = "plc.xml") -> str:
        monkeypatch.chdir(tmp_path)
        (tmp_path / name).write_text(text, encoding="utf-8")
        main(["check", *arguments, name])
        out, err = capsys.readouterr()
        return out or err

    return run


def places(text: str) -> list[Place]:
    """The places of all findings in a file."""
    diagnostics = Diagnostics()
    source = SourceFile("plc.xml", text)
    locate = Locator([parse_file(source, diagnostics)])
    found = [locate(d.primary.span, "error") for d in diagnostics]
    return [place for place in found if place]


def test_a_wrong_name_is_shown_in_its_rung(check) -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a"), coil(3, "q", 2), contact(4, "b"),
                 contact(5, "mtor", 4, negated="true"), coil(6, "w", 5))
    assert """\
   = in PROGRAM main, rung 2, closed contact `mtor` at (50, 10)
   |
   | │  b    mtor    w  │
   | ├─┤ ├───┤/├────( )─┤
   | │       ^^^        │
""" in check(xml)


def test_a_pin_is_named_with_its_block(check) -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a"), value(3, "5"),
                 block(4, "TON", {"IN": 2, "PT": 3}, ("Q",), "t", at=(70, 20)), coil(5, "q", "4.Q"))
    shown = check(xml)
    assert "in PROGRAM main, rung 1, pin `PT` of block `t: TON` at (70, 20)\n" in shown
    assert "│ TON  │" in shown and "^^^^^^^^" in shown


def test_what_the_reader_cannot_read_is_drawn_too(check) -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a"), coil(3, "q", 2), contact(4, "b b"), coil(5, "w", 4),
                 contact(6, "c"), coil(7, "", 6), contact(8, "d"), coil(9, "nowhere", 8))
    shown = check(xml)
    assert "rung 2, contact `b b` at (40, 10)" in shown and "│ b b    w  │" in shown
    assert "rung 3, coil `?` at (70, 10)" in shown
    assert "rung 4, coil `nowhere` at (90, 10)" in shown


def test_names_and_titles_of_rungs_are_told(check) -> None:
    xml = ladder(BOOLS, element("comment", 9, "<content>Start the pump</content>", (0, 5)),
                 element("label", 8, "", (0, 6), label="pump"), rail(), contact(2, "x", at=(20, 10)),
                 coil(3, "q", 2, at=(50, 10)))
    assert 'in PROGRAM main, rung 1 `pump` "Start the pump", contact `x` at (20, 10)' in check(xml)


def test_other_bodies_and_declarations_name_the_pou(check) -> None:
    body = f"<LD>{rail()}{contact(2, 'a')}{coil(3, 'a', 2)}</LD>"
    xml = project(pou("<ST>q := x;</ST>", "q : BOOL", name="first"),
                  pou(body, "a : BOOL; b : NOTHING", name="second"))
    shown = check(xml)
    assert "= in PROGRAM first\n" in shown and "= in PROGRAM second\n" in shown


def test_an_element_that_was_left_out_has_a_position() -> None:
    xml = ladder(BOOLS, rail(), contact(2, "a"), coil(3, "q", 2), contact(4, "b", at=(7, 70)))
    (found,) = places(xml)
    assert (found.pou, found.rung, found.position) == ("PROGRAM main", "", "at (7, 70)")


def test_text_shows_itself(check) -> None:
    assert " = in " not in check("PROGRAM p\nVAR q : BOOL; END_VAR\nRUNG [x] (q)\nEND_PROGRAM\n", name="p.ld")


def test_machines_get_the_place_in_words(check) -> None:
    xml = ladder(BOOLS, rail(), contact(2, "x"), coil(3, "q", 2))
    (found,) = json.loads(check(xml, "--format", "json"))
    words = {"pou": "PROGRAM main", "rung": "rung 1", "element": "contact `x`", "position": "at (20, 10)"}
    assert found["primary"]["drawn"] == words
    location = json.loads(check(xml, "--format", "sarif"))["runs"][0]["results"][0]["locations"][0]
    assert location["logicalLocations"] == [
        {"fullyQualifiedName": "main/rung 1/contact `x`", "kind": "element", "properties": words}]


def test_of_a_long_rung_the_elements_around_are_drawn(check) -> None:
    names = " ".join(f"v{n}" for n in range(400))
    row = [contact(n + 2, "wrong" if n == 200 else f"v{n}", n + 1) for n in range(400)]
    shown = check(ladder(f"{names} q : BOOL", rail(), *row, coil(999, "q", 401)))
    assert "v196" in shown and "v202" in shown and "v195" not in shown and "v203" not in shown


def test_of_a_high_rung_the_lines_around_are_drawn(check) -> None:
    names = " ".join(f"v{n}" for n in range(50))
    row = [contact(n + 2, "wrong" if n == 25 else f"v{n}", at=(10, 20 * n)) for n in range(50)]
    shown = check(ladder(f"{names} q : BOOL", rail(), *row, coil(999, "q", tuple(range(2, 52)), at=(90, 0))))
    assert "rung 1, contact `wrong`" in shown and "v24" in shown
    assert "v10 " not in shown and "v40" not in shown


def test_a_fault_of_the_running_program_is_shown_in_the_rung(tmp_path, monkeypatch, capsys) -> None:
    xml = ladder("a q : BOOL; i : INT", rail(), contact(2, "10 / i > 2"), coil(3, "q", 2))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plc.xml").write_text(xml, encoding="utf-8")
    assert main(["run", "plc.xml", "--scans", "2"]) == 1
    assert "in PROGRAM main, rung 1, contact `10 / i > 2` at (20, 10)" in capsys.readouterr().err


def test_every_finding_of_a_drawing_has_a_place(tmp_path) -> None:
    """Also when the position is written in other ways, or not at all."""
    xml = ladder(BOOLS, rail(), contact(2, "x"), coil(3, "q", 2)).replace('<position x="20" y="10"/>', "")
    path = tmp_path / "plc.xml"
    path.write_text(xml, encoding="utf-8")
    result = compile_paths([str(path)])
    locate = Locator(result.project.files)
    (found,) = [locate(d.primary.span, "error") for d in result.diagnostics]
    assert (found.element, found.position) == ("contact `x`", "")


@pytest.mark.parametrize(
    "before", ["", "<p>", "<!-- sum -->", "<![CDATA[", "<p>\n  <![CDATA[", "<![CDATA[a := b;\n ", "a:=b; <!--\n-->  "])
def test_columns_of_texts_are_those_of_the_file(check, before: str) -> None:
    after = ("]]>" if "CDATA" in before else "") + ("</p>" if "<p>" in before else "")
    xml = project(pou(f"<ST>{before}nowhere := a;{after}</ST>", "a b : BOOL"))
    (found,) = json.loads(check(xml, "--format", "json"))
    lines = xml[: xml.index("nowhere")].split("\n")
    assert (found["primary"]["line"], found["primary"]["column"]) == (len(lines), len(lines[-1]) + 1)
