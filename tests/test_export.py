"""`ldc export --to plcopen`: a valid file, drawn without overlaps, that is read back as the same program."""

from __future__ import annotations

import random
import re
from pathlib import Path
from xml.etree.ElementTree import Element

import growth
import pytest
from charts import COILS, COUNTS, INPUTS, LAMPS, Chart, Scan, charts, scans
from charts import text as chart_text
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from strategies import junction_rungs, program_text, sp_rungs
from tc6 import broken_rules

from ldc.cli.main import main
from ldc.diagnostics import Diagnostics
from ldc.export.plcopen.chart import draw
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser import ast, parse_file
from ldc.parser.unparse import expr_text, paths_text
from ldc.pipeline import Compiled, compile_paths, compile_project
from ldc.source import SourceFile
from runtime.vm.machine import Machine

ROOT = Path(__file__).resolve().parents[1]
CORPUS = ROOT.parent / "shared" / "corpus" / "plcopen"


SAMPLES = sorted(path.parent for path in (ROOT / "samples").glob("*/ldc.toml")
                 if not list(path.parent.glob("*.ldc.toml")))
"""Components are not exported."""


def exported(tmp_path: Path, *sources: Path | str) -> str:
    target = tmp_path / "plc.xml"
    assert main(["export", *map(str, sources), "--to", "plcopen", "-o", str(target)]) == 0
    return target.read_text(encoding="utf-8")


def read(xml: str) -> Compiled:
    result = compile_project(Sources((SourceFile("plc.xml", xml),), Settings(), None))
    assert result.image is not None, [f"{d.code} {d.message}" for d in result.diagnostics]
    return result


def without_text(xml: str) -> str:
    """The drawing alone."""
    return re.sub(r'<data name="urn:ldc:plcopen/rungs".*?</data>', "", xml, flags=re.DOTALL)


def written(tmp_path: Path, text: str, name: str = "main.ld") -> Path:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    return path


def round_trip(tmp_path: Path, text: str, name: str = "main.ld") -> tuple[Compiled, str]:
    """What a source compiles to, and the XML, which compiles to the same image."""
    path = written(tmp_path, text, name)
    xml = exported(tmp_path, path)
    result = compile_paths([str(path)])
    assert broken_rules(xml) == []
    assert read(xml).image.digest == result.image.digest
    return result, xml


# ---- whole projects


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda path: path.name)
def test_every_sample_comes_back_as_the_same_program(sample: Path, tmp_path: Path) -> None:
    result = compile_paths([str(sample)])
    xml = exported(tmp_path, sample)
    assert broken_rules(xml) == []
    assert read(xml).image.digest == result.image.digest
    assert exported(tmp_path, sample) == xml
    assert main(["import", str(tmp_path / "plc.xml"), "-o", str(tmp_path / "back")]) == 0
    assert compile_paths([str(tmp_path / "back")]).image.digest == result.image.digest


def test_the_drawing_alone_is_the_same_program(tmp_path: Path) -> None:
    """Named rungs of one piece need nothing that is kept beside the drawing."""
    for sample in ("start_stop", "lift", "traffic_light", "bottle_filler", "bridge"):
        xml = without_text(exported(tmp_path, ROOT / "samples" / sample))
        assert read(xml).image.digest == compile_paths([str(ROOT / "samples" / sample)]).image.digest


def test_files_of_others_are_drawn_anew(tmp_path: Path) -> None:
    done = 0
    for path in sorted(CORPUS.rglob("*.xml")):
        result = compile_paths([str(path)])
        if result.image is None:
            continue
        xml = exported(tmp_path, path)
        assert broken_rules(xml) == []
        assert read(xml).image.digest == result.image.digest, path
        done += 1
    if not done:
        pytest.skip("no collection of PLCopen files")


# ---- drawings


BLOCKS = """
    bits : WORD; level, total : INT; t1, t2 : TON; c : CTUD; c2 : CTU;
    text : STRING[20]; field : ARRAY [1..3] OF INT;
    a, b, d, e, f, g, q, k, u, v : BOOL;
"""
CASES = {
    "pins": "[a] <c2: CTU(R := { [b] | [/d] [e] }, PV := 5, CV => level)> (q)",
    "all pins of two rails": "<c: CTUD(CU := a, CD := { [b] }, R := d, "
                             "LD := FALSE, PV := 3, QD => e, CV => total) in=_ out=_>",
    "chosen pins": "[a] <c: CTUD(CU := b, PV := 3) in=CD out=QD> (q)",
    "junctions at pins": "[a] @x [b] (q); [d] @y <c2: CTU(R := @x, PV := 3, CV => @v)> (k); "
                         "<MOVE(IN := @v, OUT => level) in=_ out=_>",
    "functions": "[a] <ADD(IN1 := level, IN2 := 7, OUT => total)> <GT(total, 10, OUT => @big)> (q); @big (k)",
    "without power": "<MUL(IN1 := level, IN2 := level, OUT => total) in=_ out=_>",
    "a function without EN feeds a coil": "<GE(IN1 := level, IN2 := 3, OUT => @x) in=_ out=_>; @x [a] (q)",
    "blocks in a row": "[a] <t1: TON(PT := T#1s)> <t2: TON(PT := T#2s)> { (q) | [b] (S k) }",
    "expressions": "[level + 1 > total AND NOT a] [bits.3] [/bits.4] [field[2] > 5] (q)",
    "edges": "[P a] [N b] (P q); [d] { (N k) | (R u) | (/v) }",
    "a bridge": "{ [a] @x [b] | [d] @y [e] } (q); @x [f] @y",
    "not planar": "{ [a] @x [b] | [d] @y [e] | [f] @z [g] } (q); @x [k] @z; @z [u] @y; @x [v] @y",
    "a loop": "[a] @in <t1: TON(PT := T#1s)> @out (q); @out [/b] @in",
    "a loop of functions": "@y [b] @z; <OR(IN1 := a, IN2 := @z, OUT => @x) in=_ out=_>; "
                           "<AND(IN1 := @x, IN2 := d, OUT => @y) in=_ out=_>; @y (q)",
    "several paths": "[a] (q); [b] [d] (k); [e] >>RETURN",
    "strings": "<CONCAT(IN1 := 'a$01<&>$'', IN2 := text, OUT => text)>",
    "coils in a row": "[a] (q) [b] (k)",
    "long names": f"[{'x' * 50}] <{'y' * 60}: TON(PT := T#1s)> ({'z' * 55})",
}


@pytest.mark.parametrize("case", CASES)
def test_every_kind_of_drawing(case: str, tmp_path: Path) -> None:
    more = f"{'x' * 50}, {'z' * 55} : BOOL; {'y' * 60} : TON;"
    text = (f"PROGRAM main VAR {BLOCKS} {more} END_VAR RUNG {CASES[case]} "
            'RUNG named "A title; <&> \x01" [a] (v) END_PROGRAM')
    result, xml = round_trip(tmp_path, text)
    drawn = read(without_text(xml))
    assert rungs(drawn)[-1][:2] == ("named", "A title; <&> \ufffd" if "\x01" in xml else rungs(drawn)[-1][1])
    same_behaviour(result, drawn, [v for v in "a b d e f g k u v q level total".split()])


def rungs(result: Compiled) -> list[tuple[str | None, str | None, str]]:
    return [(r.name, r.title, paths_text(r)) for r in result.project.files[0].pous[0].body.rungs]


def same_behaviour(one: Compiled, other: Compiled, names: list[str], seed: int = 0) -> None:
    machines, chosen = (Machine(one.program), Machine(other.program)), random.Random(seed)
    for _ in range(20):
        for name in names:
            if chosen.random() < 0.4:
                value = chosen.random() < 0.5
                for machine in machines:
                    machine.set(name, chosen_value(machine, name, value))
        for machine in machines:
            machine.scan()
        left, right = ([machine.get(name) for name in names] for machine in machines)
        assert left == right


def chosen_value(machine: Machine, name: str, value: bool) -> object:
    return value if isinstance(machine.get(name), bool) else 7 * value


@given(st.lists(sp_rungs(max_leaves=16) | junction_rungs(), min_size=1, max_size=3), st.integers(0, 9))
@settings(deadline=None, max_examples=40)
def test_random_drawings(tmp_path_factory, drawn: list[ast.Rung], seed: int) -> None:
    tmp_path = tmp_path_factory.mktemp("drawn")
    text = program_text(drawn)
    assume(compile_project(Sources((SourceFile("main.ld", text),), Settings(), None)).image is not None)
    result, xml = round_trip(tmp_path, text)
    names = [*(f"a{i}" for i in range(6)), *(f"q{i}" for i in range(3))]
    same_behaviour(result, read(without_text(xml)), names, seed)


# ---- a drawing that was changed in another tool


LABEL = '<label localId="901" label="mine"><position x="0" y="0"/></label>'
TWO = """PROGRAM main VAR a, b, d, q, w, v : BOOL; END_VAR
RUNG first "One" [a] (q); [P b] (w)
RUNG [P a] @net [b] (v); @net [d] (w)
END_PROGRAM"""


def test_what_was_not_touched_keeps_its_text(tmp_path: Path) -> None:
    xml = round_trip(tmp_path, TWO)[1]
    moved = xml.replace('y="40"', 'y="41"').replace('negated="false" ', "").replace("\n  ", "\n")
    assert rungs(read(moved)) == rungs(read(xml)) == [
        ("first", "One", "[a] (q); [P b] (w)"), (None, None, "[P a] @net [b] (v); @net [d] (w)")]


@pytest.mark.parametrize("change", [
    lambda xml: xml.replace("<variable>b</variable>", "<variable>d</variable>", 1),
    lambda xml: xml.replace('edge="rising"', 'edge="falling"', 1),
    lambda xml: xml.replace("<label ", f"{LABEL}<label ", 1),
    lambda xml: xml.replace("</LD>", f"{COIL}</LD>", 1),
])
def test_what_was_drawn_anew_is_read_from_the_drawing(change, tmp_path: Path) -> None:
    """An operand, an edge, a further label, a coil that hangs on a contact of a rung."""
    xml = round_trip(tmp_path, TWO)[1]
    found = rungs(read(change(xml)))
    assert found != rungs(read(xml))
    assert found == rungs(read(change(without_text(xml)))) or found[-1] == rungs(read(xml))[-1]


COIL = ('<coil localId="900" executionOrderId="90"><position x="300" y="80"/><connectionPointIn>'
        '<connection refLocalId="4"/></connectionPointIn><connectionPointOut/><variable>v</variable></coil>')


# ---- charts


@given(charts(), scans)
@settings(deadline=None, max_examples=40, suppress_health_check=list(HealthCheck))
def test_random_charts(tmp_path_factory, chart: Chart, run: list[Scan]) -> None:
    """The same image; the drawing alone does the same, in whichever order transitions are drawn."""
    result, xml = round_trip(tmp_path_factory.mktemp("chart"), chart_text(chart))
    alone = read(re.sub(r'<data name="urn:ldc:plcopen/.*?</data>', "", xml, flags=re.DOTALL))
    machines = Machine(result.program), Machine(alone.program)
    steps = [f"chart.s{n}.{field}" for n in range(chart.steps) for field in "XT"]
    for scan in run:
        for machine in machines:
            for name, value in zip(("run", *INPUTS), (scan.run, *scan.inputs), strict=True):
                machine.set(name, value)
            machine.scan()
        names = [*steps, *(f"chart.{name}" for name in (*COILS, *LAMPS, *COUNTS))]
        assert [machines[0].get(name) for name in names] == [machines[1].get(name) for name in names]


def sequence(steps: str, *ways: str) -> str:
    """A program with a chart: its steps (the first is the initial one) and lines ``a b > c : condition``."""
    first, *others = steps.split()
    parts = [f"INITIAL_STEP {first}: END_STEP", *(f"STEP {name}: END_STEP" for name in others)]
    for way in ways:
        ends, _, condition = way.partition(" : ")
        sides = [side.split() for side in ends.split(">")]
        ends = " TO ".join(side[0] if len(side) == 1 else f"({', '.join(side)})" for side in sides)
        parts.append(f"TRANSITION FROM {ends} := {condition}; END_TRANSITION")
    body = "\n".join(parts)
    return f"PROGRAM main VAR go, x, y, q : BOOL; END_VAR\n{body}\nEND_PROGRAM\n"


def drawn(xml: str) -> list[str]:
    return re.findall(r"<(step|transition|jumpStep|actionBlock|s\w+vergence) localId", xml)


@pytest.mark.parametrize(("chart", "bars"), [
    (sequence("a b c d", "a > b : x", "a > c : y", "b > d : go", "c > d : go", "d > a : x"),
     ["selectionDivergence", "selectionConvergence", "jumpStep"]),
    (sequence("a b c d", "a > b c : x", "b c > d : go", "d > a : x"),
     ["simultaneousDivergence", "simultaneousConvergence", "jumpStep"]),
    (sequence("a b c", "a > b : x", "b > c : y", "b > a : go", "c > b : x"),
     ["selectionDivergence", "jumpStep", "jumpStep"]),
    (sequence("a b", "a > b : x", "a > b : go AND y", "b > a : x"),
     ["selectionDivergence", "selectionConvergence", "jumpStep"]),
    (sequence("a b c", "a > b : x", "b > c : x", "a > c : go", "c > a : y"),
     ["selectionDivergence", "selectionConvergence", "jumpStep"]),
])
def test_a_chart_is_drawn_downwards(chart: str, bars: list[str], tmp_path: Path) -> None:
    """What leads down is joined by a convergence, what leads back jumps."""
    xml = round_trip(tmp_path, chart)[1]
    assert sorted(t for t in drawn(xml) if t not in ("step", "transition")) == sorted(bars)


PLAIN = "PROGRAM main\nVAR a, b, q, w : BOOL; END_VAR\n"


def test_turns_are_numbered_only_where_places_do_not_show_them(tmp_path: Path) -> None:
    """Other editors evaluate blocks with a number before all coils."""
    for sample in SAMPLES:
        assert "executionOrderId" not in exported(tmp_path, sample)
    _, xml = round_trip(tmp_path, PLAIN + "RUNG [a] @n; (w); @n [b] (q)\nEND_PROGRAM")
    assert xml.count("executionOrderId") == 4


def test_a_coil_that_was_moved_below_another_is_evaluated_behind_it(tmp_path: Path) -> None:
    _, xml = round_trip(tmp_path, PLAIN + "RUNG [a] { (S q) | [b] (R q) }\nEND_PROGRAM")
    coil = re.search(r'<coil [^>]*storage="set".*?y="(\d+)"', xml, re.DOTALL)
    moved = f"{xml[:coil.start(1)]}900{xml[coil.end(1):]}"
    for drawn, expected in ((xml, False), (moved, True)):
        machine = Machine(read(drawn).program)
        for name in ("a", "b"):
            machine.set(name, True)
        machine.scan()
        assert machine.get("q") is expected

CHART = """TYPE Lamp : STRUCT lit : BOOL; END_STRUCT; END_TYPE
PROGRAM main
VAR go, x, y, z, q : BOOL; n : INT; pause : TIME; warm : TON; lamps : ARRAY [1..3] OF Lamp; END_VAR
INITIAL_STEP a: END_STEP
STEP b: act(SD, pause); q(L, T#1s, n, go); lamps[2].lit(N); END_STEP
STEP c: idle(); END_STEP
TRANSITION last FROM c TO a := NOT x; END_TRANSITION
TRANSITION second FROM a TO (c, b) := GE(IN1 := n, IN2 := 3) OR x; END_TRANSITION
TRANSITION (PRIORITY := 4) FROM a TO b := go; END_TRANSITION
TRANSITION warmed FROM (c, b) TO a: warm(IN := x, PT := T#1s); warmed := warm.Q; END_TRANSITION
TRANSITION never FROM b TO c: warm(IN := x); END_TRANSITION
TRANSITION leaves FROM b TO c: RETURN; END_TRANSITION
TRANSITION drawn FROM b TO a: RUNG [P x] (drawn); [y] @m [z] (S q); @m [x] (z) END_TRANSITION
ACTION act: n := n + 1; // <&>
END_ACTION
ACTION idle: RUNG [P x] (y); [y] @m (S z); @m [go] (R q) RUNG over "Title" [idle.Q] >>RETURN END_ACTION
ACTION nothing: END_ACTION
END_PROGRAM"""


def test_all_parts_of_a_chart(tmp_path: Path) -> None:
    result, _ = round_trip(tmp_path, CHART)
    assert main(["import", str(tmp_path / "plc.xml"), "-o", str(tmp_path / "back")]) == 0
    back = compile_paths([str(tmp_path / "back")])
    assert back.image.digest == result.image.digest
    names = [way.name for way in back.model.pous["MAIN"].body.transitions]
    assert names == ["last", "second", None, "warmed", "never", "leaves", "drawn"]


def test_a_chart_that_was_changed_is_read_from_the_drawing(tmp_path: Path) -> None:
    """A transition that was moved to the left goes first; one that leads elsewhere is followed."""
    two = sequence("a b c", "a > b : x", "a > c : go", "b > a : y", "c > a : y")
    xml = round_trip(tmp_path, two)[1]
    ways = re.findall(r'<transition localId="(\d+)"[^>]*>\s*<position x="(\d+)"', xml)
    moved = xml.replace(f'<position x="{ways[1][1]}"', '<position x="1"', 1)
    for text, conditions in ((xml, ["x", "go"]), (moved, ["go", "x"])):
        body = read(text).model.pous["MAIN"].body
        assert [expr_text(w.condition) for w in body.transitions if w.sources[0].name == "a"] == conditions
    turned = xml.replace('targetName="a"', 'targetName="b"', 1)
    assert [w.targets[0].name for w in read(turned).model.pous["MAIN"].body.transitions].count("b") == 2


def test_large_charts_are_drawn_in_linear_time(tmp_path: Path) -> None:
    def seconds(count: int) -> float:
        names = [f"s{n}" for n in range(count)]
        ways = [f"{a} > {b} : x" for a, b in zip(names, [*names[1:], "s0"], strict=True)]
        ways += [f"{a} > s0 : y" for a in names[1:]] + [f"s0 > {a} : y" for a in names[2:]]
        text = sequence(" ".join(names), *ways)
        chart = parse_file(SourceFile("main.ld", text), Diagnostics()).pous[0].body
        return growth.seconds(lambda: draw(Element("pou"), chart))

    assert seconds(2_000) < 20 * seconds(200) + 0.5


# ---- text, declarations, configurations


STATEMENTS = """FUNCTION_BLOCK counter
VAR_INPUT
    up : BOOL;
END_VAR
VAR_OUTPUT
    n : INT;  // parts & <more>
END_VAR
    (* count ]]> *)
    IF up AND n < 5 THEN
        n := n + 1;  // up
    END_IF;
END_FUNCTION_BLOCK
"""
LISTED = """FUNCTION twice : INT
VAR_INPUT
    v : INT;
END_VAR
    LD v  (* <&> *)
    ADD v
    ST twice
END_FUNCTION
"""
CALLER = """PROGRAM main VAR c : counter; n : INT; a : BOOL; END_VAR
RUNG [a] <c: counter(n => n) out=_> RUNG <twice(v := n, OUT => n)> END_PROGRAM"""


def test_statements_and_lists_keep_their_text_and_comments(tmp_path: Path) -> None:
    texts = {"c.st": STATEMENTS, "t.il": LISTED, "main.ld": CALLER}
    paths = [written(tmp_path, text, name) for name, text in texts.items()]
    xml = exported(tmp_path, *paths)
    assert broken_rules(xml) == []
    assert read(xml).image.digest == compile_paths(list(map(str, paths))).image.digest
    for text in ("(* count ]]&gt; *)", "// up", "IF up AND n &lt; 5 THEN", "LD v  (* &lt;&amp;&gt; *)",
                 "parts &amp; &lt;more&gt;"):
        assert text in xml


DECLARATIONS = """
TYPE
    Mode : (idle, busy := 5) := busy;
    Percent : INT (0..100);
    Small : USINT (1..10) := 3;
    Point : STRUCT x, y : REAL := 1.0; END_STRUCT;
    Grid : ARRAY [0..1, 1..3] OF Point;
    Label : STRING[20] := 'a<b';
END_TYPE
VAR_GLOBAL CONSTANT size : INT := 3; END_VAR
VAR_GLOBAL RETAIN total AT %MW4 : INT; END_VAR
FUNCTION_BLOCK fb VAR_INPUT a : BOOL; END_VAR VAR_IN_OUT n : INT; END_VAR VAR_OUTPUT q : BOOL := TRUE; END_VAR
RUNG [a] (q) RUNG <ADD(n, 1, OUT => n)> END_FUNCTION_BLOCK
PROGRAM main
VAR mode : Mode; p : Percent; grid : Grid; field : ARRAY [1..size] OF INT := [2(7), 1];
    one : Point := (x := 2.0, y := 3.0);
    when : TOD := TOD#12:00:00; day : DT; t : TON := (PT := T#3s); i : fb; q AT %QX0.0 : BOOL;
    wide : WSTRING[5] := "x"; END_VAR
VAR RETAIN kept : INT; END_VAR
VAR_EXTERNAL total : INT; END_VAR
VAR_TEMP quick : INT; END_VAR
RUNG [mode = idle] <i: fb(n := total)> (q)
END_PROGRAM
"""


def test_every_kind_of_declaration(tmp_path: Path) -> None:
    round_trip(tmp_path, DECLARATIONS)


PLANT = """
CONFIGURATION plant
    VAR_GLOBAL go : BOOL; END_VAR
    RESOURCE cell ON slave1
        VAR_GLOBAL ready : BOOL; END_VAR
        TASK fast (INTERVAL := T#1500us, PRIORITY := 1);
        TASK event (SINGLE := go, PRIORITY := 2);
        TASK idle (PRIORITY := 9);
        PROGRAM main WITH idle : main;
        PROGRAM other WITH fast : main;
        PROGRAM third WITH event : main;
        PROGRAM free : main;
    END_RESOURCE
END_CONFIGURATION
PROGRAM main VAR q : BOOL; END_VAR VAR_EXTERNAL go : BOOL; END_VAR RUNG [go] (q) END_PROGRAM
"""


def test_configurations_keep_processors_order_and_names(tmp_path: Path) -> None:
    result, xml = round_trip(tmp_path, PLANT)
    assert 'name="main_1" typeName="main"' in xml and 'interval="T#10ms"' in xml
    assert read(xml).model.resources[0].processor == "slave1"
    slower = read(xml.replace('interval="T#10ms"', 'interval="T#70ms"')).model.resources[0]
    assert {t.name: t.interval for t in slower.tasks}["idle"] == 70_000_000  # changed in another tool
    assert {t.name: t.interval for t in result.model.resources[0].tasks}["idle"] is None


def test_tasks_and_safe_values_of_the_project_file(tmp_path: Path) -> None:
    (tmp_path / "ldc.toml").write_text(
        '[project]\nname = "p"\n[tasks.quick]\ninterval = "2ms"\npriority = 3\n'
        '[safe]\n"%QX0.0" = true\n"%QW2" = 7\n'
        'level = 1.5\nname = "\'ab\'"\n', encoding="utf-8")
    written(tmp_path, "VAR_GLOBAL level : REAL; name : STRING; END_VAR "
                      "PROGRAM main VAR a : BOOL; q AT %QX0.0 : BOOL; END_VAR RUNG [a] (q) END_PROGRAM")
    result = compile_paths([str(tmp_path)])
    xml = exported(tmp_path, tmp_path)
    again = read(xml)
    assert again.image.digest == result.image.digest
    assert again.model.safe == {"%QX0.0": True, "%QW2": 7, "level": 1.5, "name": "'ab'"}


def test_what_is_wrong_is_not_exported(tmp_path: Path, capsys) -> None:
    path = written(tmp_path, "PROGRAM main VAR a : BOOL; END_VAR RUNG [a] (b) END_PROGRAM")
    assert main(["export", str(path), "--to", "plcopen", "-o", str(tmp_path / "plc.xml")]) == 1
    assert "LD0404" in capsys.readouterr().err and not (tmp_path / "plc.xml").exists()


def test_damaged_data_of_ours_is_not_looked_at(tmp_path: Path) -> None:
    """Whatever stands in it, the drawing is read."""
    xml = round_trip(tmp_path, TWO)[1]
    for old, new in [('digest="', 'digest="0'), ("RUNG first", "RUNG ]["), ('elements="', 'elements="999 '),
                     ('processor="', 'processor="1 2'), ("<rungs", "<other"),
                     ('elements="', 'elements="" x="')]:
        damaged = xml.replace(old, new).replace("</rungs", "</other" if new == "<other" else "</rungs")
        assert [text for _, _, text in rungs(read(damaged))][0].startswith("[a] (q)")


def test_components_have_no_place_in_the_format(tmp_path: Path, capsys) -> None:
    assert main(["export", str(ROOT / "samples" / "press"), "--to", "plcopen", "-o", str(tmp_path / "x.xml")]) == 1
    told = capsys.readouterr().err
    assert "`PRESS_FORCE`" in told and told.count("LD0660") == 3
    assert not (tmp_path / "x.xml").exists()


def test_what_is_said_about_types_and_members_goes_and_comes_back(tmp_path: Path) -> None:
    text = """TYPE
    Mode : (a, b);  // how it runs
    Axis : STRUCT  // one axis
        position  : REAL;                                 // in mm
        limits    : ARRAY [0..1] OF REAL := [0.0, 400.0]; (* both ends *)
    END_STRUCT;
END_TYPE

PROGRAM main
VAR
    x : Axis; m : Mode; q : BOOL;
END_VAR

RUNG
    [m = a] (q)
END_PROGRAM
"""
    result, xml = round_trip(tmp_path, text)
    assert main(["import", str(tmp_path / "plc.xml"), "-o", str(tmp_path / "back")]) == 0
    written_back = "".join(path.read_text() for path in (tmp_path / "back" / "src").iterdir())
    for line in (r"Mode : \(a, b\);", "Axis : STRUCT", "position +: REAL;"):
        assert re.search(f"{line} +// ", written_back), line
    assert all(written_back.count(f"// {said}") == 1 for said in ("how it runs", "one axis", "in mm", "both ends"))
    assert compile_paths([str(tmp_path / "back")]).image.digest == result.image.digest
