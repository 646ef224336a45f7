"""Drawings as people see them: goldens, and what must hold for every rung."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest
from drawings import RUNGS, meant, read_back, rung, rung_texts
from hypothesis import example, given, settings
from hypothesis import strategies as st

from ldc.cli.main import main
from ldc.diagnostics import Diagnostics
from ldc.draw import BlockPins, notes_of, pins_from, pou_svg, pou_text, project_svg, rung_svg, rung_text
from ldc.draw.arrange import arrange
from ldc.draw.labels import Options, text_width
from ldc.draw.layout import place
from ldc.draw.shapes import Box, Label, Rail, Symbol, Wire
from ldc.parser import ast, parse_file
from ldc.source import SourceFile

SVG = "{http://www.w3.org/2000/svg}"
ROOT = Path(__file__).resolve().parent.parent
CONVEYOR = '''PROGRAM conveyor "Infeed conveyor"
VAR
    start AT %IX0.0 : BOOL;  (* green button *)
    stop  AT %IX0.1 : BOOL;  // red button
    motor AT %QX0.0 : BOOL;
    ready : BOOL;
    warm  : TON;
END_VAR

(* The motor holds itself
   until somebody presses stop. *)
RUNG seal_in "Start/stop with seal-in"
    { [start] | [motor] } [/stop] (motor)

RUNG
    [motor] <warm: TON(PT := T#2s)> (ready)  // ready after two seconds

RUNG last
    [ready] >>RETURN
END_PROGRAM
'''


def conveyor() -> ast.File:
    found = Diagnostics()
    file = parse_file(SourceFile("conveyor.ld", CONVEYOR), found)
    assert not len(found)
    return file


# ---- goldens ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", RUNGS)
def test_text_golden(name: str, golden: Callable[[str, str], None]) -> None:
    golden(f"draw/{name}.txt", rung_text(rung(RUNGS[name], name, "a title"), number=1) + "\n")


@pytest.mark.parametrize(
    "name", ["seal_in", "timer_and_counter", "bridge", "wraps", "not_planar", "long_expression"]
)
def test_svg_golden(name: str, golden: Callable[[str, str], None]) -> None:
    golden(f"draw/{name}.svg", rung_svg(rung(RUNGS[name], name, "a title"), number=1))


def test_pou_goldens(golden: Callable[[str, str], None]) -> None:
    file = conveyor()
    golden("draw/pou.txt", pou_text(file.pous[0], comments=file.comments, width=80) + "\n")
    golden("draw/pou.svg", pou_svg(file.pous[0], comments=file.comments, width=80))


# ---- what must hold for every rung ------------------------------------------------------------


@settings(max_examples=120, deadline=None)
@given(rung_texts(), st.sampled_from([60, 79, 100, 132]))
def test_every_rung_has_a_text_drawing_that_fits_and_names_all_operands(text: str, width: int) -> None:
    drawn = rung(text)
    lines = rung_text(drawn, width=width, number=1).split("\n")
    assert max(map(text_width, lines)) <= width
    shown = "\n".join(lines)
    for name in operands(drawn):
        assert name in shown


@settings(max_examples=60, deadline=None)
@given(rung_texts())
def test_every_rung_has_an_svg_that_is_xml_and_names_all_operands(text: str) -> None:
    drawn = rung(text)
    root = ElementTree.fromstring(rung_svg(drawn))
    shown = {element.text for element in root.iter(SVG + "text")}
    assert operands(drawn) <= shown


@settings(max_examples=250, deadline=None)
@given(rung_texts(blocks=False), st.sampled_from([60, 100, 400]))
@example("{ [n1] @x [n2] | [n3] @y [n4] } (n5); @x [n6] @y", 100)
@example("{ [n1] @x [n2] | [n3] @y [n4] | [n5] @z [n6] } (q); @x [n7] @z; @z [n8] @y; @x [n9] @y", 100)
def test_the_lines_of_a_drawing_connect_what_the_text_connects(text: str, width: int) -> None:
    """Whoever follows the lines, tags and arrows with a finger finds the nets of the rung."""
    drawn = rung(text)
    assert read_back(rung_text(drawn, width=width)) == meant(drawn)


@settings(max_examples=120, deadline=None)
@given(rung_texts())
def test_nothing_is_drawn_over_a_text(text: str) -> None:
    taken: dict[tuple[int, int], str] = {}
    drawing = place(arrange(rung(text), Options()), Options())
    for shape in drawing.shapes:
        match shape:
            case Label(words, _, y):
                begin = shape.begin(text_width(words))
                for column in range(begin, begin + text_width(words)):
                    assert taken.setdefault((column, y), words) == words
                    assert 0 < column < drawing.width - 1
    for shape in drawing.shapes:
        assert not taken.keys() & cells(shape), shape


def cells(shape: object) -> set[tuple[int, int]]:
    match shape:
        case Wire(x1, y1, x2, y2):
            return {(x, y) for x in range(x1, x2 + 1) for y in range(y1, y2 + 1)}
        case Rail(x, y1, y2):
            return {(x, y) for y in range(y1, y2 + 1)}
        case Symbol(_, _, x, y):
            return {(x - 1, y), (x, y), (x + 1, y)}
        case Box(_, x, y, width, height):
            frame = {(x + i, line) for i in range(width) for line in (y, y + height - 1)}
            return frame | {(column, y + i) for i in range(height) for column in (x, x + width - 1)}
    return set()


def operands(drawn: ast.Rung) -> set[str]:
    """The names that the random rungs use are all plain identifiers ``n<number>x…``."""
    return set(re.findall(r"\bn\d+x*\b", drawn.span.text))


# ---- what a drawing may be told ---------------------------------------------------------------


def test_a_bridge_is_drawn_with_wires_and_without_tags() -> None:
    assert "@" not in rung_text(rung(RUNGS["bridge"]))


def test_what_cannot_be_drawn_without_a_crossing_gets_name_tags() -> None:
    assert "@z" in rung_text(rung(RUNGS["not_planar"]))


def test_a_mark_is_carets_in_plain_text_and_colour_on_a_terminal() -> None:
    drawn = rung("{ [start] | [motor] } [/stop] (motor)")
    stop = drawn.paths[0].items[1]
    plain = rung_text(drawn, mark={stop.expr.span: "error"}).split("\n")
    at = plain[1].index("┤/├")
    assert plain[2][at : at + 3] == "^^^"
    coloured = rung_text(drawn, mark={stop.expr.span: "error"}, colour=True)
    assert "\x1b[1;31m┤/├\x1b[0m" in coloured and "^" not in coloured


def test_a_mark_in_a_pin_network_marks_the_contact_and_not_its_block() -> None:
    drawn = rung(RUNGS["timer_and_counter"])
    at = drawn.span.source.text.index("[reset]")
    reset = type(drawn.span)(drawn.span.source, at, at + 7)
    root = ElementTree.fromstring(rung_svg(drawn, mark={reset: "warning"}))
    marked = [e for e in root.iter() if "ldc-mark-warning" in e.get("class", "").split()]
    assert [e.text for e in marked if e.tag == SVG + "text"] == ["reset"]


def test_power_colours_what_it_flows_through() -> None:
    drawn = rung("{ [start] | [motor] } [/stop] (motor)")
    closed = {"[motor]"}
    root = ElementTree.fromstring(rung_svg(drawn, power=lambda item, pin: item.span.text in closed))
    on = [e.text for e in root.iter(SVG + "text") if "ldc-on" in e.get("class", "").split()]
    assert on == ["motor"]
    wires = [e.get("class") for e in root.iter(SVG + "path") if e.get("class", "").startswith("ldc-wire")]
    assert {"ldc-wire ldc-on", "ldc-wire ldc-off"} == set(wires)


def test_addresses_and_comments_stand_under_the_operands() -> None:
    file = conveyor()
    assert notes_of(file.pous[0], file.comments) == {
        "START": ("%IX0.0", "green button"), "STOP": ("%IX0.1", "red button"), "MOTOR": ("%QX0.0",),
    }
    assert "%IX0.0" not in pou_text(file.pous[0], addresses=False)


def test_pins_of_blocks_of_the_project_may_be_told() -> None:
    pins = BlockPins(("run", "speed"), ("busy", "done"), "run", "busy")
    text = rung_text(rung(RUNGS["unknown_block"]), pins_of=lambda block: pins)
    assert re.search("┤run +busy├", text) and re.search("┤speed +done├", text)


def test_pins_of_a_models_signatures_and_of_the_library() -> None:
    block = rung("<t: tof(PT := T#1s)>").paths[0].items[0]
    assert pins_from({})(block) == BlockPins(("IN", "PT"), ("Q", "ET"), "IN", "Q")


def test_positional_arguments_of_a_standard_function_get_their_pins() -> None:
    text = rung_text(rung("[a] <LIMIT(0, speed, 100, OUT => limited)> (q)"))
    assert re.search("0 ──┤MN +OUT├── limited", text)
    assert "speed ──┤IN" in text and "100 ──┤MX" in text
    wrong = rung_text(rung("[a] <LIMIT(1, 2, 3, 4)> <LIMIT()> <ADD()> <t: LIMIT(1)> <TO_INT(x, y)> (q)"))
    assert wrong.count("┤EN") == 4 and "4 ──┤ " in wrong


def test_coils_of_all_rungs_of_a_pou_stand_under_each_other() -> None:
    found = Diagnostics()
    text = "PROGRAM p\nRUNG [a] (q)\nRUNG [a] [b] [c] [d] (r)\nRUNG [ready] (S s)\nEND_PROGRAM\n"
    pou = parse_file(SourceFile("p.ld", text), found).pous[0]
    lines = pou_text(pou).split("\n")
    assert len({line.index(")") for line in lines if ")" in line}) == 1
    assert len({len(line) for line in lines if line.startswith("├")}) == 1


def test_a_long_name_is_shortened_and_whole_in_the_title() -> None:
    name = "a_name_that_somebody_thought_would_be_clearer_when_it_is_long"
    drawn = rung(f"[{name}] (q)")
    root = ElementTree.fromstring(rung_svg(drawn))
    texts = {e.text or "".join(e.itertext()) for e in root.iter(SVG + "text")}
    assert name in [e.text for e in root.iter(SVG + "title")]
    assert name not in texts
    assert "…" in rung_text(drawn)


def test_an_svg_has_a_title_and_the_rung_as_its_description() -> None:
    root = ElementTree.fromstring(rung_svg(rung("[a]   (q)", "one", "first <&> last"), number=4))
    assert root.find(SVG + "title").text == "4  one  first <&> last"
    assert root.find(SVG + "desc").text == "[a] (q)"
    assert root.get("role") == "img"


def test_a_project_is_one_picture_and_text_bodies_are_left_out() -> None:
    found = Diagnostics()
    pou = conveyor().pous[0]
    source = SourceFile("s.st", "PROGRAM other\nVAR a : BOOL; END_VAR\na := TRUE;\nEND_PROGRAM\n")
    other = parse_file(source, found).pous[0]
    root = ElementTree.fromstring(project_svg([pou, other, pou]))
    names = [e.text for e in root.iter(SVG + "text") if e.get("class") == "ldc-pou"]
    assert names == ["conveyor", "conveyor"]


def test_a_rung_of_ten_thousand_contacts_is_drawn() -> None:
    text = rung_text(rung(" ".join(f"[a{i}]" for i in range(10_000)) + " (q)"), width=120)
    assert "a9999" in text and max(map(len, text.split("\n"))) <= 120


def test_brackets_as_deep_as_allowed_in_each_other_are_drawn() -> None:
    text = rung_text(rung("{ [a] | " * 99 + "[b]" + " }" * 99 + " (q)"))
    assert text.count("┤ ├") == 100


def test_many_junctions_that_cannot_all_be_wires_end_in_tags_soon() -> None:
    paths = [f"[a{i}] @j{i} [b{i}] (q{i})" for i in range(60)]
    paths += [f"@j{i} [c{i}] @j{59 - i}" for i in range(30)]
    assert "@j0" in rung_text(rung("; ".join(paths)))


def test_a_program_of_texts_draws_nothing_and_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    source = tmp_path / "main.st"
    source.write_text("PROGRAM main\nVAR n : INT; END_VAR\n    n := n + 1;\nEND_PROGRAM\n")
    assert main(["draw", str(source)]) == 0
    shown = capsys.readouterr()
    assert (shown.out, shown.err) == ("", "there is no rung to draw: all bodies are texts\n")
    assert main(["draw", str(source), "--svg", str(tmp_path / "main.svg")]) == 1
    assert not (tmp_path / "main.svg").exists()
