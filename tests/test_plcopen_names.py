"""Names in PLCopen files that are words of the language here: renamed wherever the file says them."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plcopen_xml import block, coil, contact, element, pou, project, rail, result, value, variables, wires

from ldc import pipeline
from ldc.cli.main import main
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser.foreign import RESERVED
from ldc.source import SourceFile

STATEMENTS = frozenset(
    "IF THEN ELSE ELSIF END_IF CASE OF END_CASE FOR TO BY DO END_FOR WHILE END_WHILE REPEAT UNTIL END_REPEAT "
    "EXIT RETURN AND OR XOR NOT MOD TRUE FALSE".split())
WORDS = sorted((RESERVED - STATEMENTS - {"_"}) | {"step", "on", "time", "dt", "From", "Rung", "String"})


def compiled(text: str) -> pipeline.Compiled:
    return pipeline.compile_project(Sources((SourceFile("plc.xml", text),), Settings(), None))


def structure(name: str, fields: str) -> str:
    return f'<dataType name="{name}"><baseType><struct>{variables(fields)}</struct></baseType></dataType>'


def digest(text: str) -> str:
    found = compiled(text)
    assert found.image is not None, [f"{d.code} {d.message}" for d in found.diagnostics]
    return found.image.digest


def imported(text: str, tmp_path) -> str:
    """The report of an import; what was imported compiles to the same image."""
    path = tmp_path / "plc.xml"
    path.write_text(text, encoding="utf-8")
    assert main(["import", str(path), "-o", str(tmp_path / "out")]) == 0
    assert pipeline.compile_paths([str(tmp_path / "out")]).image.digest == digest(text)
    return (tmp_path / "out" / "import-report.md").read_text(encoding="utf-8")


BODIES = {
    "ladder": lambda v: ld(contact(2, v, 1), contact(3, f"NOT {v} OR q", 2), coil(4, v, 3)),
    "FBD": lambda v: "<FBD>" + value(1, v) + block(2, "NOT", {"IN": 1}, ["OUT"]) + result(3, "q", "2.OUT")
    + "</FBD>",
    "ST": lambda v: f"<ST>(* {v} *) q := NOT {v} AND t = '{v}'; // {v}\nIF {v} THEN {v} := q; END_IF;</ST>",
    "IL": lambda v: f"<IL>LDN {v} (* {v} *)\nAND( {v}\nOR q\n)\nST {v}\n</IL>",
    "chart": lambda v: "<SFC>" + element("step", 1, wires(None), name="go", initialStep="true")
    + element("transition", 2, f'{wires(1)}<condition><inline name=""><ST>{v}</ST></inline></condition>')
    + element("jumpStep", 3, wires(2), targetName="go")
    + element("actionBlock", 4, wires(1) + f'<action qualifier="N"><reference name="{v}"/></action>')
    + "</SFC>",
}
TEXT = '<localVars><variable name="t"><type><string/></type></variable></localVars>'


def ld(*elements: str) -> str:
    return f"<LD>{rail(1)}{''.join(elements)}</LD>"


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("word", ["step", "on", "Time", "dt"])
def test_variables_in_bodies_of_all_kinds(body: str, word: str, tmp_path) -> None:
    def text(name: str) -> str:
        return project(pou(BODIES[body](name), f"{name} q : BOOL", sections=TEXT))

    assert digest(text(word)) == digest(text(f"{word}_").replace(f"'{word}_'", f"'{word}'"))
    report = imported(text(word), tmp_path)
    assert f"| `{word}` | `{word}_` |" in report and report.count(f"`{word}_`") == 1


@given(st.sampled_from(WORDS), st.sampled_from(sorted(BODIES)))
@settings(deadline=None, max_examples=40)
def test_every_word(word: str, body: str) -> None:
    found = compiled(project(pou(BODIES[body](word), f"{word} q : BOOL", sections=TEXT)))
    assert found.image is not None, [f"{d.code} {d.message}" for d in found.diagnostics]


def test_words_of_statements_as_operands_of_drawings_and_as_fields() -> None:
    typed = structure("Pair", "to by : BOOL")
    ladder = ld(contact(2, "to", 1), contact(3, "p.by", 2), coil(4, "q", 3))
    statements = "<ST>FOR n := 1 TO 3 BY 2 DO p.to := p.by; END_FOR;</ST>"
    digest(project(pou(ladder, "to q : BOOL; p : Pair"),
                   pou(statements, "n : INT; p : Pair", name="other"), types=typed))


def test_what_means_something_else_stays(tmp_path) -> None:
    """Literals, elementary types, strings, comments, the clock of other editors; other cases of the word."""
    text = project(pou("<ST>time := TIME#1s + T#2s; TIME := Time; (* time *) s := 'time'; "
                       "w := INT_TO_WORD(WORD_TO_INT(WORD#16#3));</ST>",
                       "time : TIME; w : WORD; word : WORD", sections=TEXT.replace('"t"', '"s"')))
    report = imported(text, tmp_path)
    assert "| `time` | `time_` |" in report and "| `word` | `word_` |" in report
    made = (tmp_path / "out" / "src" / "main.st").read_text(encoding="utf-8")
    assert "time_ := TIME#1s + T#2s;" in made and "s := 'time';" in made
    assert "w := INT_TO_WORD(WORD_TO_INT(WORD#16#3));" in made


def test_pins_fields_values_and_blocks(tmp_path) -> None:
    """A function block with such pins, its instance, an enumeration, a structure, another POU's name."""
    types = ('<dataType name="Mode"><baseType><enum><values><value name="off"/><value name="on"/></values>'
             '</enum></baseType><initialValue><simpleValue value="on"/></initialValue></dataType>'
             + structure("Task", "at : INT; with : BOOL"))
    pins = (f'<inputVars>{variables("on : BOOL; time : TIME")}</inputVars>'
            f'<outputVars>{variables("action : BOOL")}</outputVars>')
    timer = pou("<ST>action := on AND time &gt; T#1s;</ST>", "", "Step", "functionBlock", pins)
    drawn = ld(contact(2, "mode = on", 1), value(3, "most"), coil(5, "task.with", "4.action"),
               block(4, "Step", {"on": 2, "time": 3}, ["action"], "step"))
    called = ("<ST>i(on := TRUE, time := T#2s, action =&gt; q); mode := Mode#on; "
              "q := i.action AND task.at = 3;</ST>")
    declared = "q : BOOL; mode : Mode; task : Task; most : TIME = T#3s"
    text = project(timer, pou(drawn, f"{declared}; step : Step"),
                   pou(called, f"{declared}; i : Step", name="other"), types=types)
    report = imported(text, tmp_path)
    renamed = [line.split("`")[1::2] for line in report.split("## Renamed")[1].splitlines() if "`" in line]
    assert sorted(renamed) == [["Step", "Step_"], ["Task", "Task_"], ["action", "action_"], ["at", "at_"],
                               ["on", "on_"], ["time", "time_"], ["with", "with_"]]


@pytest.mark.parametrize("name", ["TON", "MAX", "LIMIT", "sr"])
def test_pous_with_the_name_of_a_standard_one_are_meant_where_they_are_used(name: str, tmp_path) -> None:
    pins = f'<inputVars>{variables("a : BOOL")}</inputVars><outputVars>{variables("z : BOOL")}</outputVars>'
    own = pou("<ST>z := NOT a;</ST>", "", name, "functionBlock", pins)
    drawn = ld(contact(2, "x", 1), block(3, name, {"a": 2}, ["z"], "i"), coil(4, "y", "3.z"))
    report = imported(project(own, pou(drawn, f"x y : BOOL; i : {name}")), tmp_path)
    assert f"| `{name}` | `{name}_` |" in report


def test_a_new_name_is_one_that_nothing_has(tmp_path) -> None:
    text = project(pou(BODIES["ladder"]("step"), "step q step_ : BOOL"))
    assert "| `step` | `step_2` |" in imported(text, tmp_path)


def test_labels_tasks_and_resources(tmp_path) -> None:
    drawn = ld(contact(2, "a", 1), element("jump", 3, wires(2), label="step"), rail(5),
               element("label", 4, label="step", at=(0, 100)), contact(6, "a", 5, (0, 150)),
               coil(7, "q", 6, (10, 150)))
    tasks = ('<configurations><configuration name="configuration"><resource name="Resource">'
             '<task name="Task" priority="1"><pouInstance name="program" typeName="main"/></task></resource></configuration>'
             "</configurations>")
    imported(project(pou(drawn, "a q : BOOL"), instances=tasks), tmp_path)


def test_places_are_those_of_the_line() -> None:
    """A finding behind a renamed word is in the right line and shows what is wrong there."""
    found = compiled(project(pou("<ST>q := step;\nq := step AND nothing;</ST>", "step q : BOOL"))).diagnostics
    told = [d for d in found if d.code == "LD0404"]
    assert [d.primary.span.text for d in told] == ["nothing"]


def test_files_without_such_names_are_not_touched() -> None:
    text = project(pou(BODIES["ST"]("steps"), "steps q : BOOL", sections=TEXT))
    file = compiled(text).project.files[0]
    assert file.remarks == () and file.pous[0].span.source.text == text
