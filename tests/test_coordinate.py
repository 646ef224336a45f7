"""What a project says of its modules, resolved against its program: places, defaults, and nothing breaks
it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc import pipeline
from ldc.cli.coordinate import coordination
from ldc.diagnostics import Diagnostics, Invalid
from ldc.il.coordination import SYSTEM_MESSAGES, Coordination
from ldc.manifest import Manifest, load_manifest
from ldc.source import SourceFile

PROGRAM = """\
VAR_GLOBAL
    auto AT %IX0.0 : BOOL;
END_VAR

PROGRAM clamp
VAR_INPUT
    start  : BOOL;
    stroke : REAL;
    pause  : TIME;
    label  : STRING;
    count  : INT (0..10);
END_VAR
VAR_OUTPUT
    done     : BOOL;
    position : LREAL;
END_VAR
VAR
    timer : TON;
    curve : ARRAY [0..2] OF BOOL;
END_VAR
RUNG
    [start] <timer: TON(PT := pause)> (done)
END_PROGRAM

PROGRAM inject
VAR_INPUT
    start : BOOL;
    told  : BOOL;
    big   : LREAL;
END_VAR
VAR_OUTPUT
    done : BOOL;
END_VAR
RUNG
    [start] (done)
END_PROGRAM

PROGRAM lamps
VAR_INPUT
    told : BOOL;
    code : UDINT;
END_VAR
RUNG
    [told] [code > 0] (%QX0.0)
END_PROGRAM
"""
PROJECT = '[project]\nmodules = ["clamp", "inject", "lamps"]\n'


class Program:
    """The program above, compiled; that its print is short matters to Hypothesis."""

    def __init__(self, result: pipeline.Compiled) -> None:
        self.result, self.folder = result, result.sources.manifest.folder

    def of(self, manifest: Manifest) -> pipeline.Compiled:
        """It with another project file."""
        return replace(self.result, sources=replace(self.result.sources, manifest=manifest))


@pytest.fixture(scope="module")
def program(tmp_path_factory) -> Program:
    folder = tmp_path_factory.mktemp("project")
    (folder / "main.ld").write_text(PROGRAM, encoding="utf-8")
    (folder / "ldc.toml").write_text(PROJECT, encoding="utf-8")
    result = pipeline.compile_paths([str(folder)])
    assert result.program is not None
    return Program(result)


def loaded(toml: str, folder: Path, bag: Diagnostics) -> Manifest | None:
    return load_manifest(SourceFile("ldc.toml", PROJECT + toml), folder, bag)


def resolved(program: Program, toml: str) -> tuple[Coordination, list[str]]:
    bag = Diagnostics()
    manifest = loaded(toml, program.folder, bag)
    if manifest is None:
        return Coordination(), [d.code for d in bag]
    return coordination(program.of(manifest), bag), [d.code for d in bag]


def test_a_project_that_says_nothing(program) -> None:
    assert resolved(program, "") == (Coordination(), [])


def test_modules_and_their_parameters_have_places(program) -> None:
    found, codes = resolved(program, "[sequence]\n")
    assert codes == []
    clamp, inject, lamps = found.modules
    assert [(p.name, p.form, p.address) for p in clamp.parameters] == [
        ("stroke", "<f", 0x600), ("pause", "<q", 0x604), ("count", "<i", 0x60C)]  # a STRING is none
    assert [p.address for p in (*inject.parameters, *lamps.parameters)] == [0x610, 0x614, 0x61C, 0x620]
    assert (clamp.start, clamp.done) == ("clamp.start", "clamp.done") and lamps.start is None
    assert [step.name for step in found.sequence.steps] == ["clamp", "inject"]
    assert found.sequence.repeat and found.sequence.start is None


def test_steps_messages_and_safety(program) -> None:
    found, codes = resolved(program, """
[sequence]
start = "AUTO"
repeat = false
steps = [
    "inject",
    { module = "Clamp", parameters = { stroke = 350, pause = "T#1s500ms", COUNT = 3 }, when = "inject.done" },
    { module = "clamp", until = "clamp.timer.Q" },
]
[messages.clamped]
from = "clamp.curve[1]"
data = "clamp.stroke"
policy = "overwrite"
to = ["inject", { module = "inject", flag = "told", data = "big" }]
[messages.ALARM]
class = "system"
to = [{ module = "lamps", flag = "told", data = "code" }]
[safety]
estop = "%IX0.0"
""")
    assert codes == []
    first, second, third = found.sequence.steps
    assert (first.module, second.module, third.until) == (1, 0, "clamp.timer.Q")
    assert [(p.name, value) for p, value in second.parameters] == [
        ("stroke", 350.0), ("pause", 1_500_000_000), ("count", 3)]
    assert [m.name for m in found.messages] == [*SYSTEM_MESSAGES, "clamped"]
    clamped, alarm = found.message("clamped"), found.message("ALARM")
    assert (clamped.flag, clamped.depth, clamped.form, clamped.system) == (0x340, 1, "<f", False)
    assert [(s.module, s.flag, s.data) for s in clamped.subscribers] == [
        (1, None, None), (1, "inject.told", "inject.big")]
    assert (alarm.flag, alarm.subscribers[0].data) == (0x302, "lamps.code")
    assert found.estop == "%IX0.0"


def test_a_plant_is_found_beside_the_project(program) -> None:
    folder = program.folder
    (folder / "plant.py").write_text("class Plant: ...\n", encoding="utf-8")
    found, codes = resolved(program, '[plant]\nfile = "plant.py"\nstep = "500us"\nseed = 7\n')
    assert codes == []
    assert (found.plant.file, found.plant.step_ns, found.plant.seed, found.plant.parameters) == (
        str(folder / "plant.py"), 500_000, 7, None)


@pytest.mark.parametrize(("toml", "codes"), [
    ('[sequence]\nsteps = ["clamp"]\nstart = "clamp.curve"', ["LD0617"]),
    ('[sequence]\nsteps = [{ module = "clamp", parameters = { count = 11 } }]', ["LD0616"]),
    ('[sequence]\nsteps = [{ module = "clamp", parameters = { start = true } }]', ["LD0616"]),
    ('[sequence]\nsteps = [{ module = "clamp", parameters = { label = "x" } }]', ["LD0616"]),
    ('[sequence]\nsteps = [{ module = "clamp", parameters = { stroke = nan } }]', ["LD0616"]),
    ('[sequence]\nsteps = [{ module = "clamp", parameters = { stroke = 1e300 } }]', ["LD0616"]),
    ('[[sequence.steps]]\nmodule = "clamp"\n[[sequence.steps]]\nmodule = "press"', ["LD0614"]),
    ('[messages.a]\nfrom = "auto"\nto = ["lamps"]', ["LD0615"]),
    ('[messages.a]\nfrom = "auto"\nto = [{ module = "inject", data = "big" }]', ["LD0618"]),
    ('[messages.a]\nfrom = "auto"\ndata = "clamp.position"\n'
     'to = [{ module = "lamps", flag = "told", data = "code" }]', ["LD0618"]),
    ('[messages.a]\nfrom = "auto"\ndata = "clamp.label"\nto = ["inject"]', ["LD0618"]),
    ('[messages.a]\nfrom = "auto"\nto = [{ module = "inject", flag = "start" }]', ["LD0617"]),
    ('[messages.a]\nfrom = "auto"\nto = [{ module = "inject", flag = "told" }]\n'
     '[messages.b]\nfrom = "auto"\nto = [{ module = "inject", flag = "TOLD" }]', ["LD0619"]),
    ('[messages.Alarm]\nfrom = "auto"\nto = ["inject"]', ["LD0619"]),
    ('[messages.a]\nto = ["inject"]', ["LD0619"]),
    ('[messages.a]\nfrom = "auto"\ndepth = 5', ["LD0612"]),
    ('[messages.a]\nfrom = "auto"', ["LD0623"]),
    ('[plant]\nfile = "none.py"', ["LD0622"]),
    ('[safety]\nestop = "clamp"\nreset = "gone"', ["LD0617", "LD0617"]),
])
def test_what_does_not_fit_is_told(program, toml: str, codes: list[str]) -> None:
    assert resolved(program, toml)[1] == codes


@pytest.mark.parametrize(("toml", "said"), [
    ('[sequence]\nsteps = [5]', 'write "clamp" or { module = "clamp", until = "closed" }'),
    ('[messages.a]\nto = [5]', 'write "inject" or { module = "inject", flag = "on_clamped" }'),
    ('[messages.a]\nclass = "sys"', 'write "user" or "system"'),
    ('[messages.a]\npolicy = "wait"', 'write "queue" or "overwrite" or "reject"'),
])
def test_help_says_what_to_write(program, toml: str, said: str) -> None:
    bag = Diagnostics()
    loaded(toml, program.folder, bag)
    assert [(d.code, d.help) for d in bag] == [("LD0612", said)]


def test_a_parameter_is_shown_as_it_is_written(program) -> None:
    bag = Diagnostics()
    manifest = loaded('[sequence]\nsteps = [{ module = "clamp", parameters = { stroke = true } }]', program.folder, bag)
    coordination(program.of(manifest), bag)
    assert [d.message for d in bag] == ["`stroke` of module `clamp` cannot be `true`"]


def test_limits(program) -> None:
    def messages(count: int, more: str = "") -> str:
        return "".join(f'[messages.m{n}]\nfrom = "auto"\nto = ["inject"]\n{more}' for n in range(count))

    assert resolved(program, messages(192))[1] == []
    assert resolved(program, messages(193))[1] == ["LD0621"]
    assert resolved(program, messages(150, 'data = "clamp.position"\n'))[1] == ["LD0621"]


def test_without_a_bag_it_raises(program) -> None:
    manifest = loaded('[safety]\nestop = "gone"\n', Path("."), Diagnostics())
    with pytest.raises(Invalid):
        coordination(program.of(manifest))


names = st.sampled_from(["clamp", "inject", "lamps", "press", "auto", "clamp.done", "clamp.curve[1]",
                         "clamp.curve", "told", "code", "stroke", "count", "%IX0.0", "%IX", "", "a.b[",
                         "T#5ms", "label", "..", "[1]"])
values = st.one_of(
    names, st.integers(-5, 300), st.booleans(), st.floats(allow_nan=False, allow_infinity=False))
steps = st.one_of(names, values, st.dictionaries(
    st.sampled_from(["module", "parameters", "when", "until", "with"]),
    st.one_of(names, values, st.dictionaries(
        st.sampled_from(["stroke", "count", "start", "label"]), values))))
subscribers = st.one_of(names, st.dictionaries(st.sampled_from(["module", "flag", "data", "to"]), names))
tables = st.fixed_dictionaries({}, optional={
    "sequence": st.dictionaries(
        st.sampled_from(["steps", "start", "repeat"]), st.one_of(values, st.lists(steps))),
    "messages": st.dictionaries(st.sampled_from(["a", "b", "ALARM", "estop"]), st.dictionaries(
        st.sampled_from(["class", "from", "data", "to", "policy", "depth"]),
        st.one_of(values, st.lists(subscribers), st.sampled_from(["system", "user", "reject"])))),
    "safety": st.dictionaries(st.sampled_from(["estop", "reset"]), values),
    "plant": st.dictionaries(st.sampled_from(["file", "step", "parameters", "seed"]), values),
})


def written(value: object) -> str:
    """As an inline value of TOML."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {written(item)}" for key, item in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(written, value)) + "]"
    return repr(value) if isinstance(value, float) else json.dumps(value)


@settings(max_examples=300, deadline=None)
@given(tables)
def test_whatever_is_written_is_judged(program, project: dict) -> None:
    text = "".join(f"{name} = {written(table)}\n" for name, table in project.items())
    bag = Diagnostics()
    manifest = load_manifest(SourceFile("ldc.toml", text + PROJECT), program.folder, bag)
    if manifest is None:
        assert bag.has_errors
        return
    found = coordination(program.of(manifest), bag)
    assert bag.has_errors == (bool(manifest.coordination) and found == Coordination())
    for diagnostic in bag:
        assert diagnostic.primary is not None, diagnostic.message
