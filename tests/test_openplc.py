"""Files of OpenPLC Editor 4: what their drawings, declarations and projects become, and what they then do."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from openplc_json import (
    block,
    closing,
    coil,
    contact,
    diagram,
    entry,
    ladder,
    node,
    opening,
    pou,
    program,
    project,
    rung,
    task,
    variable,
)

from ldc.cli.main import main
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser.unparse import rung_text
from ldc.pipeline import Compiled, compile_paths, compile_project
from ldc.source import SourceFile
from runtime.vm.machine import Machine

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "corpus" / "openplc_v4"
BOOLS = "a, b, c, d, q, w : bool;"


def compiled(text: str, path: str = "main.ld", *more: SourceFile) -> Compiled:
    return compile_project(Sources((SourceFile(path, text), *more), Settings(), None))


def said(result: Compiled) -> list[str]:
    return [f"{d.code} {d.message}" for d in result.diagnostics]


def run(text: str, rows: list[dict], watch: str, path: str = "main.ld") -> list[str]:
    """The watched variables after each scan."""
    result = compiled(text, path)
    assert result.program is not None, said(result)
    machine, found = Machine(result.program), []
    for row in rows:
        for name, given_ in row.items():
            machine.set(name, given_)
        machine.scan()
        found.append(" ".join(str(int(machine.get(name))) for name in watch.split()))
    return found


def drawn(text: str, path: str = "main.ld") -> list[str]:
    result = compiled(text, path)
    assert not said(result)
    (body,) = [p.body for f in result.project.files for p in f.pous if p.name == "p"]
    return [" ".join(rung_text(r).split()) for r in body.rungs]


# ---- ladders

SEAL_IN = rung([contact("1", "a", "negated"), opening("2"), contact("3", "b", x=100),
                contact("4", "q", x=100, y=90), closing("5"), coil("6", "q")],
               ("left", "1"), ("1", "2"), ("2.output-right", "3"), ("3", "5"), ("2.output-down", "4"),
               ("4", "5.input-down"), ("5.output-right", "6"), ("6", "right.right-rail"), comment="Seal in")


def test_a_parallel_is_a_branch_and_the_comment_a_title() -> None:
    text = program(ladder(SEAL_IN), BOOLS)
    assert run(text, [{"b": 1}, {"b": 0}, {"a": 1}, {"a": 0}], "q") == ["1", "1", "0", "0"]
    (only,) = drawn(text)
    assert only.startswith('RUNG "Seal in"') and "[/a]" in only


def test_parallels_in_one_another() -> None:
    nodes = [contact("m", "d", "negated", 10), opening("o1"), contact("1", "a", x=60),
             opening("o2", y=50), contact("2", "b", x=60, y=50), contact("3", "c", x=60, y=90),
             closing("c2", y=50), closing("c1"), coil("q", "q")]
    text = program(ladder(rung(
        nodes, ("left", "m"), ("m", "o1"), ("o1.output-right", "1"), ("1", "c1"),
        ("o1.output-down", "o2.input-top"), ("o2.output-right", "2"), ("2", "c2"), ("o2.output-down", "3"),
        ("3", "c2.input-down"), ("c2.output-top", "c1.input-down"), ("c1.output-right", "q"))), BOOLS)
    rows = [{"a": i & 1, "b": i >> 1 & 1, "c": i >> 2 & 1, "d": i >> 3} for i in range(16)]
    want = [str(int(not r["d"] and bool(r["a"] or r["b"] or r["c"]))) for r in rows]
    assert run(text, rows, "q") == want


@pytest.mark.parametrize(("first", "last", "states"), [
    ("default", "default", "0 1 1 0"), ("negated", "default", "1 0 0 1"), ("default", "negated", "1 0 0 1"),
    ("risingEdge", "default", "0 1 0 0"), ("fallingEdge", "default", "0 0 0 1"),
    ("default", "set", "0 1 1 1"), ("default", "risingEdge", "0 1 0 0"),
    ("default", "fallingEdge", "0 0 0 1"),
])
def test_kinds_of_contacts_and_coils(first: str, last: str, states: str) -> None:
    text = program(ladder(rung([contact("1", "a", first), coil("2", "q", last)], ("left", "1"), ("1", "2"))),
                   BOOLS)
    assert run(text, [{"a": 0}, {"a": 1}, {"a": 1}, {"a": 0}], "q") == states.split()


def test_reset_and_order_of_rungs() -> None:
    first = rung([contact("1", "a"), coil("2", "q", "set")], ("left", "1"), ("1", "2"))
    then = rung([contact("1", "b"), coil("2", "q", "reset")], ("left", "1"), ("1", "2"))
    assert run(program(ladder(first, then), BOOLS), [{"a": 1}, {"b": 1}, {"b": 0}], "q") == ["1", "0", "1"]
    assert run(program(ladder(then, first), BOOLS), [{"a": 1}, {"b": 1}, {"b": 0}], "q") == ["1", "1", "1"]


def test_a_timer_with_a_value_at_its_pin() -> None:
    timer = block("t", "TON", "IN:bool PT:time", "Q:bool ET:time", "t0",
                  variables={"PT": "T#20ms", "ET": "e"})
    text = program(ladder(rung([contact("1", "a"), timer, coil("2", "q")], ("left", "1"), ("1", "t.IN"),
                               ("t.Q", "2"))), f"{BOOLS}\n t0 : TON;\n e : time;")
    assert run(text, [{"a": 1}, {}, {}, {"a": 0}], "q e") == ["0 0", "0 10000000", "1 20000000", "0 0"]


def test_variables_of_pins_as_nodes_win_and_empty_ones_are_none() -> None:
    counter = block("n", "CTU", "CU:bool R:bool PV:int", "Q:bool CV:int", "n0", variables={"PV": "9"})
    at = [node("variable", "v", variant="input", variable={"name": "2"}, block={"id": "n", "handleId": "PV"}),
          node("variable", "u", variant="input", variable={"name": ""}, block={"id": "n", "handleId": "R"}),
          node("variable", "o", variant="output", variable={"name": "i"},
               block={"id": "n", "handleId": "CV"})]
    text = program(ladder(rung([contact("1", "a"), counter, coil("2", "q"), *at],
                               ("left", "1"), ("1", "n.CU"), ("n.Q", "2"), ("v", "n.PV"), ("u", "n.R"),
                               ("n.CV", "o"))),
                   f"{BOOLS}\n n0 : CTU;\n i : int;")
    rows = [{"a": 1}, {"a": 0}, {"a": 1}]
    assert run(text, rows, "q i") == ["0 1", "0 1", "1 2"]


def test_further_power_pins_have_branches_of_their_own() -> None:
    counter = block("n", "CTUD", "CU:bool CD:bool R:bool LD:bool PV:int", "QU:bool QD:bool CV:int", "n0",
                    variables={"PV": "2", "CV": "i"})
    text = program(ladder(rung(
        [contact("1", "a"), contact("2", "b", y=90), counter, coil("3", "q"), coil("4", "w", y=90)],
        ("left", "1"), ("left.branch_n_CD", "2"), ("1", "n.CU"), ("2", "n.CD"), ("n.QU", "3"),
        ("n.QD", "4"))),
        f"{BOOLS}\n n0 : CTUD;\n i : int;")
    rows = [{"a": 1}, {"a": 0}, {"a": 1}, {"a": 0, "b": 1}]
    assert run(text, rows, "q w i") == ["0 0 1", "0 0 1", "1 0 2", "0 0 1"]


def test_a_function_under_en() -> None:
    add = block("f", "ADD", "EN:bool IN1:int IN2:int", "ENO:bool OUT:int", enable=True,
                variables={"IN1": "i", "IN2": "1", "OUT": "i"})
    text = program(ladder(rung([contact("1", "a"), add, coil("2", "q")], ("left", "1"), ("1", "f.EN"),
                               ("f.ENO", "2"))), f"{BOOLS}\n i : int;")
    assert run(text, [{"a": 1}, {}, {"a": 0}], "q i") == ["1 1", "1 2", "0 2"]


USER = """FUNCTION_BLOCK Twice
VAR_INPUT
IN : int;
END_VAR
VAR_OUTPUT
OUT : int;
END_VAR
OUT := IN * 2;
END_FUNCTION_BLOCK
"""


def test_a_function_block_of_another_file_under_en() -> None:
    """Its pins are known from the drawing."""
    twice = block("f", "Twice", "EN:bool IN:int", "ENO:bool OUT:int", "t", enable=True,
                  variables={"IN": "i", "OUT": "j"})
    text = program(ladder(rung([contact("1", "a"), twice, coil("2", "q")], ("left", "1"), ("1", "f.EN"),
                               ("f.ENO", "2"))), f"{BOOLS}\n t : Twice;\n i : int := 4;\n j : int;")
    result = compiled(text, "main.ld", SourceFile("Twice.st", USER))
    assert result.program is not None, said(result)
    machine, found = Machine(result.program), []
    for a, i in ((0, 4), (1, 5), (0, 6)):
        machine.set("a", a)
        machine.set("i", i)
        machine.scan()
        found.append((machine.get("j"), machine.get("q")))
    assert found == [(0, False), (10, True), (10, False)]


# ---- function block diagrams

def test_a_diagram_with_negation_connectors_and_execution_order() -> None:
    nodes = [variable("1", "input", "a", 0, 10), variable("2", "input", "b", 0, 50, negated=True),
             block("g", "AND", "IN1:bool IN2:bool", "OUT:bool", x=100, y=20),
             node("connector", "k", 200, 20, variable={"name": "link"}),
             node("continuation", "m", 0, 200, variable={"name": "link"}),
             variable("3", "output", "q", 300, 200), variable("4", "output", "w", 300, 240, negated=True),
             node("comment", "5", 0, 0, content="Both together")]
    text = program(diagram(nodes, ("1", "g.IN1"), ("2", "g.IN2"), ("g.OUT", "k"), ("m", "3"), ("m", "4")),
                   BOOLS)
    rows = [{"a": 0}, {"a": 1}, {"b": 1}]
    assert run(text, rows, "q w", "main.fbd") == ["0 1", "1 0", "0 1"]
    assert "Both together" in " ".join(drawn(text, "main.fbd"))


def test_numbers_order_the_blocks() -> None:
    def step(id_: str, x: int, order: int, name: str, source: str) -> list[dict]:
        made = block(id_, "ADD", "IN1:int IN2:int", "OUT:int", x=x)
        made["data"]["executionOrder"] = order
        return [made, variable(f"{id_}i", "input", source, x - 50),
                variable(f"{id_}k", "input", "1", x - 50, 30), variable(f"{id_}o", "output", name, x + 50)]

    def wires(id_: str) -> list[tuple[str, str]]:
        return [(f"{id_}i", f"{id_}.IN1"), (f"{id_}k", f"{id_}.IN2"), (f"{id_}.OUT", f"{id_}o")]

    def after_one_scan(first: int, second: int) -> str:
        nodes = [*step("f", 100, first, "i", "j"), *step("g", 400, second, "j", "i")]
        text = program(diagram(nodes, *wires("f"), *wires("g")), "i, j : int;")
        return run(text, [{}], "i j", "main.fbd")[0]

    assert after_one_scan(1, 2) == "1 2"
    assert after_one_scan(2, 1) == "2 1"


# ---- declarations

def test_addresses_behind_the_type_and_comments() -> None:
    text = ("(* Doubles\n   things *)\n\nPROGRAM p\nVAR\n  a : BOOL AT %IX0.3 := TRUE; (* the key *)\n"
            "  n AT %QW2 : INT := 5;\nEND_VAR\nVAR\n  l : ARRAY [0..3] OF INT AT %MW4;\nEND_VAR\n\n"
            "n := n + 1;\n\nEND_PROGRAM\n")
    result = compiled(text, "p.st")
    assert not said(result)
    (only,) = result.project.files[0].pous
    a, n, l = (v for section in only.var_blocks for v in section.variables)
    assert (a.location, a.note, n.location, l.location) == ("%IX0.3", "the key", "%QW2", "%MW4")
    assert only.title == "Doubles things"
    assert run(text, [{}, {}], "n", "p.st") == ["6", "7"]


def test_a_body_in_il() -> None:
    text = ("PROGRAM p\nVAR\n  a : BOOL AT %IX0.0;\n  q : BOOL AT %QX0.0;\nEND_VAR\n\nLDN a\nST q\n\n"
            "END_PROGRAM\n")
    assert run(text, [{"a": 0}, {"a": 1}], "q", "p.il") == ["1", "0"]


# ---- projects

TYPES = [
    {"name": "Mode", "derivation": "enumerated", "initialValue": "RUN",
     "values": [{"description": "IDLE"}, {"description": "RUN"}]},
    {"name": "Motor", "derivation": "structure", "variable": [
        {"name": "speed", "type": {"definition": "base-type", "value": "int"},
         "initialValue": {"simpleValue": {"value": "5"}}},
        {"name": "log", "type": {"definition": "array", "value": "", "data": {
            "baseType": {"definition": "base-type", "value": "int"},
            "dimensions": [{"dimension": "0..1"}, {"dimension": "2..3"}]}}}]},
    {"name": "Bank", "derivation": "array", "baseType": {"definition": "user-data-type", "value": "Motor"},
     "dimensions": [{"dimension": "1..2"}]},
]


def whole() -> str:
    """A project in one file, with everything that it may declare."""
    variables = [entry("total", "int", documentation='how "many"', location="%MW3", initialValue="7"),
                 entry("state", "Mode"), entry("motors", "Bank")]
    main = pou("program", "main", "ld", ladder(rung([contact("1", "a"), coil("2", "q")], ("left", "1"),
                                                    ("1", "2"))),
               [entry("a", "bool", location="%IX0.0"), entry("q", "bool", location="%QX0.0")])
    outside = {"class": "external"}
    sums = pou("program", "sums", "st",
               'total := Twice(total); // "all"\nmotors[2].speed := motors[1].speed + 1;',
               [entry("total", "int", **outside), entry("motors", "Bank", **outside)])
    twice = pou("function", "Twice", "il", "LD i\nMUL 2\nST Twice", [entry("i", "int", **{"class": "input"})],
                returnType="int")
    return project([main, sums, twice], TYPES, variables, [task("slow", "T#40ms"), task("fast", "T#20ms")],
                   [{"name": "one", "program": "main", "task": "fast"},
                    {"name": "two", "program": "sums", "task": "slow"}])


def test_a_project_in_one_file() -> None:
    rows = [{"one.a": 1}, {}, {}]
    assert run(whole(), rows, "one.q total motors[2].speed state", "project.json") == [
        "1 14 6 1", "1 14 6 1", "1 28 6 1"]
    file = compiled(whole(), "project.json").project.files[0]
    assert [v.note for section in file.globals for v in section.variables] == ['how "many"', None, None]


def test_a_project_in_a_folder(tmp_path: Path) -> None:
    (tmp_path / "pous/programs").mkdir(parents=True)
    (tmp_path / "pous/function-blocks").mkdir()
    (tmp_path / "project.json").write_text(project(
        variables=[entry("total", "int")], tasks=[task("t", "T#50ms")],
        instances=[{"name": "i", "program": "p", "task": "t"}]))
    (tmp_path / "pous/programs/p.ld").write_text(program(ladder(SEAL_IN), BOOLS))
    (tmp_path / "pous/function-blocks/Twice.st").write_text(USER)
    for argument in (tmp_path, tmp_path / "project.json"):
        result = compile_paths([str(argument)])
        assert result.program is not None, said(result)
        assert sorted(f.source.path.rsplit("/", 1)[1] for f in result.project.files) == [
            "Twice.st", "p.ld", "project.json"]
        assert Machine(result.program).period_ns == 50_000_000


def test_words_do_not_lie_on_bits(tmp_path: Path) -> None:
    """Bits and words are apart in that runtime, also when other files declare them."""
    shared = [entry("level", "INT", location="%QW0"), entry("far", "INT", location="%QW3")]
    (tmp_path / "pous" / "programs").mkdir(parents=True)
    (tmp_path / "project.json").write_text(project(variables=shared, tasks=[task("t")], instances=[
        {"name": "i", "task": "t", "program": "main"}]))
    text = """PROGRAM main
    VAR
      go : BOOL AT %IX0.0; lamp : BOOL AT %QX0.0; input : INT AT %IW0; direct : INT AT %IW7;
    END_VAR
    VAR_EXTERNAL level, far : INT; END_VAR
    lamp := go; level := input; go := FALSE; far := WORD_TO_INT(%IW7); END_PROGRAM"""
    (tmp_path / "pous" / "programs" / "main.st").write_text(text)
    result = compile_paths([str(tmp_path)])
    assert sorted(said(result)) == [
        "LD0149 `go` is the input %IX0.0, and the program writes it",
        "LD0155 `level` at %QW0 would lie on narrower variables here"]
    places = {v.name: v.location for file in result.project.files
              for block_ in (*file.globals, *(b for p in file.pous for b in p.var_blocks))
              for v in block_.variables if v.location}
    assert places == {"level": "%QW4", "far": "%QW3", "lamp": "%QX0.0", "input": "%IW0", "direct": "%IW7"}
    assert [(r.kind, r.what, r.into) for f in result.project.files for r in f.remarks] == [
        ("mapped", "level AT %QW0", "AT %QW4"), ("left out", "the address %IX0.0 of go", "the program writes it")]


def test_bodies_in_other_languages_are_named(tmp_path: Path) -> None:
    (tmp_path / "pous/programs").mkdir(parents=True)
    (tmp_path / "project.json").write_text(project([pou("program", "s", "sfc", "")]))
    head = "PROGRAM logger\nVAR\n  a : bool;\nEND_VAR\n"
    (tmp_path / "pous/programs/logger.py").write_text(f"{head}def block_loop():\n    pass\n")
    assert said(compile_paths([str(tmp_path)])) == [
        "LD0151 OpenPLC: the Python body of `logger` is not supported",
        "LD0151 OpenPLC: the body of `s` in `sfc` is not supported"]


# ---- broken files

@pytest.mark.parametrize(("text", "message"), [
    ("PROGRAM p\nVAR\nEND_VAR\n{\"name\": \"p\", \"rungs\": [", "LD0150 OpenPLC: the JSON ends too early"),
    ("PROGRAM p\nVAR\nEND_VAR\n{\"name\": \"p\", \"rungs\": }", "LD0150 OpenPLC: this is no JSON"),
    ("PROGRAM p\nVAR\nEND_VAR\n{\"name\": \"p\"}\nEND_PROGRAM", "LD0150 OpenPLC: the body of p has no rungs"),
    (program(ladder({"nodes": 1}), "a : bool;"), "LD0150 OpenPLC: p, rung 1 has no nodes and edges"),
    (program(ladder(rung([contact("1", "a", "odd")])), "a : bool;"),
     "LD0151 OpenPLC: p, rung 1: a contact `odd` is not supported"),
    (program(ladder(rung([node("lamp", "1")])), "a : bool;"),
     "LD0151 OpenPLC: p, rung 1: a node `lamp` is not supported"),
    (program(ladder(rung([coil("1", "a")], ("none", "1"))), "a : bool;"),
     "LD0146 p, rung 1: coil 2 `a` at (500, 0) is connected to the element none, which does not exist"),
    (program(ladder(rung([coil("1", "x")], ("left", "1"))), "a : bool;"),
     "LD0404 there is no variable `x` here"),
    ("{\"meta\": {}, \"data\": {\"pous\": [{\"type\": \"x\"}]}}", "LD0150 OpenPLC: `x` is no kind of POU"),
    (project(tasks=[task("t", triggering="Interrupt")]),
     "LD0151 OpenPLC: a task that waits for an interrupt is not supported"),
    ("{\"data\":" + "[" * 200, "LD0153 OpenPLC: more than 100 levels of JSON"),
])
def test_what_is_wrong_is_told(text: str, message: str) -> None:
    assert any(line.startswith(message) for line in said(compiled(text))), said(compiled(text))


def test_a_finding_shows_the_rung_and_where_the_element_is(tmp_path: Path, capsys) -> None:
    (tmp_path / "main.ld").write_text(program(ladder(SEAL_IN), "a, b : bool;"))
    assert main(["check", str(tmp_path / "main.ld")]) == 1
    shown = capsys.readouterr().err
    assert 'in PROGRAM p, rung 1 "Seal in", contact `q` at (100, 90)' in shown
    assert "└─┤ ├─┘" in shown


GOOD = (program(ladder(SEAL_IN), BOOLS), whole())


@pytest.mark.parametrize("text", GOOD)
def test_a_file_that_ends_anywhere_is_told(text: str) -> None:
    short = json.dumps(json.loads(text)) if text.startswith("{") else text
    for end in range(1, len(short) - 20, 23):
        result = compiled(short[:end], "project.json" if text.startswith("{") else "main.ld")
        assert result.program is None and said(result), end


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_no_change_of_a_file_raises(data: st.DataObject) -> None:
    text = data.draw(st.sampled_from(GOOD))
    at = data.draw(st.integers(0, len(text) - 1))
    to = at + data.draw(st.integers(0, 40))
    new = data.draw(st.sampled_from(
        ("", "{", "}", "[", "]", '"', ",", "null", "1e999", "\\ud800", "-", "END_VAR")))
    compiled(text[:at] + new + text[to:], "project.json" if text.startswith("{") else "main.ld")


def test_files_of_others() -> None:
    files = sorted(FOLDER.rglob("*.ld"))
    if not files:
        pytest.skip(f"no collection in {FOLDER.name}")
    for path in files:
        result = compile_paths([str(path)])
        assert result.program is not None, (path, said(result))
        Machine(result.program).scan()
