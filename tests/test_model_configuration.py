"""Resources, tasks and program instances; what ldc.toml says instead."""

from __future__ import annotations

import pytest

from ldc.diagnostics import Diagnostics
from ldc.model import Scope
from ldc.model.settings import Settings, TaskSetting
from tests.modelling import modelled

PROGRAMS = """
VAR_GLOBAL go : BOOL; count : INT; END_VAR
PROGRAM Infeed VAR a AT %QX0.0 : BOOL; END_VAR END_PROGRAM
PROGRAM outfeed VAR note : STRING; END_VAR END_PROGRAM
FUNCTION_BLOCK helper END_FUNCTION_BLOCK
"""


def configured(inside: str):
    return modelled(PROGRAMS, "CONFIGURATION plant RESOURCE cpu ON master\n"
                              f"{inside} END_RESOURCE END_CONFIGURATION")


def runs(found) -> list[tuple[str, str, str, str]]:
    return [(r.name, run.name, run.pou, run.task) for r in found.model.resources for run in r.runs]


def test_without_a_configuration_every_program_runs() -> None:
    found = modelled(PROGRAMS)
    assert runs(found) == [("main", "Infeed", "INFEED", "main"), ("main", "outfeed", "OUTFEED", "main")]
    task, = found.model.resources[0].tasks
    assert (task.name, task.interval, task.priority) == ("main", None, 0)
    assert found.codes == []


def test_a_configuration() -> None:
    found = modelled(PROGRAMS, """
        CONFIGURATION plant
            VAR_GLOBAL top : INT := 3; END_VAR
            RESOURCE cpu ON master
                VAR_GLOBAL own : BOOL; END_VAR
                TASK fast (INTERVAL := T#5ms + T#5ms, PRIORITY := 1);
                TASK edge (SINGLE := go, PRIORITY := 2);
                PROGRAM one WITH FAST : infeed;
                PROGRAM two WITH edge : INFEED;
                PROGRAM rest : outfeed;
            END_RESOURCE
            RESOURCE io ON slave1
                TASK t (INTERVAL := T#1s);
                PROGRAM three WITH t : Infeed;
            END_RESOURCE
        END_CONFIGURATION""")
    assert found.codes == [], found.text
    cpu, io = found.model.resources
    assert [(t.name, t.interval, t.priority) for t in cpu.tasks] == [
        ("fast", 10_000_000, 1), ("edge", None, 2), ("main", None, 65_535)]
    assert runs(found) == [("cpu", "one", "INFEED", "fast"), ("cpu", "two", "INFEED", "edge"),
                           ("cpu", "rest", "OUTFEED", "main"), ("io", "three", "INFEED", "t")]
    assert (io.name, io.processor) == ("io", "slave1")
    assert set(found.model.globals) == {"GO", "COUNT", "TOP", "OWN"}
    place = Scope(found.model).place(cpu.tasks[1].single, Diagnostics())
    assert (place.root, place.is_global) == ("go", True)


@pytest.mark.parametrize(("inside", "codes"), [
    ("TASK t (INTERVAL := T#0s); PROGRAM a WITH t : Infeed; PROGRAM b WITH t : outfeed;", ["LD0221"]),
    ("TASK t (INTERVAL := 5); PROGRAM a WITH t : Infeed;", ["LD0403"]),
    ("TASK t (INTERVAL := T#1s * count); PROGRAM a WITH t : Infeed;", ["LD0207"]),
    ("TASK t (PRIORITY := 65536); PROGRAM a WITH t : Infeed;", ["LD0221"]),
    ("TASK t (PRIORITY := -1); PROGRAM a WITH t : Infeed;", ["LD0221"]),
    ("TASK t (SINGLE := count); PROGRAM a WITH t : Infeed;", ["LD0221"]),
    ("TASK t (SINGLE := gone); PROGRAM a WITH t : Infeed;", ["LD0404"]),
    ("TASK t (SINGLE := go, INTERVAL := T#1s); PROGRAM a WITH t : Infeed;", ["LD0221"]),
    ("TASK t (PRIORITY := 1); TASK T (PRIORITY := 2); PROGRAM a WITH t : Infeed;", ["LD0201"]),
    ("TASK t (PRIORITY := 1); PROGRAM a WITH s : Infeed;", ["LD0220"]),
    ("TASK t (PRIORITY := 1); PROGRAM a WITH t : infed;", ["LD0220"]),
    ("TASK t (PRIORITY := 1); PROGRAM a WITH t : helper;", ["LD0220"]),
    ("TASK t (PRIORITY := 1); PROGRAM a WITH t : Infeed; PROGRAM A WITH t : outfeed;", ["LD0201"]),
    ("TASK t (PRIORITY := 1); PROGRAM go WITH t : Infeed;", ["LD0201"]),
    ("TASK t (PRIORITY := 1); PROGRAM a WITH t : Infeed;", ["LD0223"]),
    ("PROGRAM a : Infeed; PROGRAM b : outfeed;", []),
])
def test_findings(inside: str, codes: list[str]) -> None:
    found = configured(inside)
    assert found.codes == codes, found.text


def test_tasks_of_the_manifest() -> None:
    settings = Settings(tasks=(TaskSetting("fast", 10_000_000, 0, ("infeed",)),
                               TaskSetting("slow", None, 3, ("OUTFEED",), "slave1")))
    found = modelled(PROGRAMS, settings=settings)
    assert runs(found) == [("master", "Infeed", "INFEED", "fast"), ("slave1", "outfeed", "OUTFEED", "slow")]
    assert [t.interval for r in found.model.resources for t in r.tasks] == [10_000_000, None]
    assert found.codes == []


def test_one_task_of_the_manifest_without_programs_runs_all() -> None:
    found = modelled(PROGRAMS, settings=Settings(tasks=(TaskSetting("main", 10_000_000),)))
    assert [run[2] for run in runs(found)] == ["INFEED", "OUTFEED"]


def test_a_configuration_in_the_text_wins() -> None:
    text = ("CONFIGURATION c RESOURCE r ON master PROGRAM p : Infeed; PROGRAM q : outfeed; "
            "END_RESOURCE END_CONFIGURATION")
    found = modelled(PROGRAMS, text, settings=Settings(tasks=(TaskSetting("x", 1),)))
    assert [run[1] for run in runs(found)] == ["p", "q"]


@pytest.mark.parametrize(("task", "code"), [
    (TaskSetting("t", None, 0, ("nothing",)), "LD0220"),
    (TaskSetting("t", None, 0, ("helper",)), "LD0220"),
    (TaskSetting("t", None, 0, ("Infeed", "infeed")), "LD0201"),
    (TaskSetting("t", 0, 0, ("Infeed",)), "LD0221"),
    (TaskSetting("t", None, -1, ("Infeed",)), "LD0221"),
])
def test_findings_about_the_manifest(task: TaskSetting, code: str) -> None:
    assert modelled(PROGRAMS, settings=Settings(tasks=(task,))).codes == [code]


@pytest.mark.parametrize(("path", "known"), [
    ("%QX0.0", True), ("%IX0.0", False), ("%Q", False), ("go", True), ("Infeed.a", True), ("infeed.A", True),
    ("a", False), ("infeed.b", False), ("infeed", False),
])
def test_safe_values_name_what_exists(path: str, known: bool) -> None:
    found = modelled(PROGRAMS, settings=Settings(safe={path: True}))
    assert found.codes == ([] if known else ["LD0224"])
    assert found.model.safe == {path: True}


def test_with_one_program_its_name_may_be_left_out_of_a_safe_value() -> None:
    text = "PROGRAM p VAR a : BOOL; END_VAR END_PROGRAM"
    assert modelled(text, settings=Settings(safe={"a": True})).codes == []


def test_settings_may_be_any_object() -> None:
    class Own:
        image_bytes = 8

    text = "PROGRAM p VAR a AT %QB8 : BYTE; END_VAR END_PROGRAM"
    assert modelled(text, settings=Own()).codes == ["LD0211"]
