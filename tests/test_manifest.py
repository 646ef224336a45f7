"""Which sources the arguments mean, and what a project file may say."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ldc.diagnostics import Diagnostics
from ldc.durations import duration_text, parse_duration
from ldc.manifest import find_sources
from ldc.source import SourceFile
from ldc.toml_spans import toml_spans

RUNG = "PROGRAM main\nRUNG\n    [%IX0.0] (%QX0.0)\nEND_PROGRAM\n"
FULL = """\
[project]
name = "conveyor"
version = "1.2.0"
sources = ["src/*.ld", "blocks/*.st"]
modules = ["infeed", "press"]

[processors]
main = "master"
axis = "slave"

[tasks.fast]
interval = "1ms"
priority = 1
programs = ["control"]
processor = "axis"

[tasks."slow one"]
programs = ["lamps"]
processor = "main"

[memory]
image_bytes = 4096

[safe]
"%QX0.0" = true
"%QW1" = -5
speed = 0.5
delay = "T#20ms"

[run]
period = "500us"
watch = ["motor", "warm.ET"]
inputs = "inputs.csv"
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(folder: Path, **files: str) -> None:
    for name, text in files.items():
        path = folder / name.replace("__", "/").replace("_", ".")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def found(*arguments: str) -> tuple[list[str], list[str]]:
    """Paths of the files, and codes of the findings."""
    diagnostics = Diagnostics()
    sources = find_sources(arguments, diagnostics)
    return [file.path for file in sources.files], [d.code for d in diagnostics]


def test_every_key_is_read(folder: Path) -> None:
    write(folder, ldc_toml=FULL, src__b_ld=RUNG, src__a_ld=RUNG, blocks__x_st="", other_ld=RUNG)
    diagnostics = Diagnostics()
    sources = find_sources(["."], diagnostics)
    assert not list(diagnostics)
    assert [file.path for file in sources.files] == ["src/a.ld", "src/b.ld", "blocks/x.st"]
    manifest = sources.manifest
    assert (manifest.name, manifest.version, manifest.modules) == ("conveyor", "1.2.0", ("infeed", "press"))
    assert manifest.processors == {"main": "master", "axis": "slave"}
    assert (manifest.period, manifest.watch, manifest.inputs) == (500_000, ("motor", "warm.ET"), "inputs.csv")
    fast, slow = sources.settings.tasks
    assert (fast.name, fast.interval, fast.priority, fast.programs, fast.processor) == (
        "fast",
        1_000_000,
        1,
        ("control",),
        "axis",
    )
    assert (slow.name, slow.interval, slow.priority, slow.programs) == ("slow one", None, 0, ("lamps",))
    assert sources.settings.image_bytes == 4096
    assert sources.settings.safe == {"%QX0.0": True, "%QW1": -5, "speed": 0.5, "delay": "T#20ms"}
    assert manifest.value_span("run", "period").text == '"500us"'


def test_an_empty_manifest_means_everything_below_it(folder: Path) -> None:
    write(folder, ldc_toml="", main_ld=RUNG, deep__er__x_il="", README_md="", hidden_txt="")
    write(folder / ".venv", lib_ld=RUNG)
    assert found("ldc.toml") == (["deep/er/x.il", "main.ld"], [])
    assert find_sources(["."], Diagnostics()).manifest.name == folder.name


def test_a_file_alone_is_compiled_alone(folder: Path) -> None:
    write(folder, ldc_toml=FULL, main_ld=RUNG)
    sources = find_sources(["main.ld"], Diagnostics())
    assert sources.manifest is None and sources.settings.image_bytes == 1024


def test_files_keep_the_order_of_the_arguments_and_are_read_once(folder: Path) -> None:
    write(folder, b_ld=RUNG, a_ld=RUNG)
    assert found("b.ld", "./a.ld", "./b.ld", "a.ld", str(folder / "a.ld")) == (["b.ld", "./a.ld"], [])


@pytest.mark.parametrize("data", [b"\xef\xbb\xbfRUNG a\r\n", b"RUNG a\r", b"RUNG a\n"])
def test_byte_order_marks_and_line_ends_do_not_matter(folder: Path, data: bytes) -> None:
    (folder / "main.ld").write_bytes(data)
    assert find_sources(["main.ld"], Diagnostics()).files[0].text == "RUNG a\n"


def test_the_place_of_a_wrong_byte_is_told(folder: Path) -> None:
    (folder / "main.ld").write_bytes("(* ü *)\r\nRUNG F".encode() + b"\xf6rder")
    diagnostics = Diagnostics()
    assert find_sources(["main.ld"], diagnostics).files == ()
    (finding,) = diagnostics
    assert finding.code == "LD0603"
    assert finding.primary.span.position == (2, 7)
    assert finding.primary.text == "byte 0xF6 at offset 16"
    assert "`ö`" in finding.help


def test_arguments_that_are_no_source(folder: Path) -> None:
    write(folder, notes_md="", sub__x_ld=RUNG, axis_ldc_toml="")
    (folder / "noext").write_text("")
    assert found("notes.md", "noext", "gone.ld", "gone", "sub", "axis.ldc.toml", "gone/ldc.toml", "a\0b.ld")[
        1
    ] == ["LD0601", "LD0601", "LD0601", "LD0602", "LD0605", "LD0605", "LD0605", "LD0606"]


def test_one_project_at_a_time(folder: Path) -> None:
    for name in ("one", "two"):
        write(folder / name, ldc_toml="", main_ld=RUNG)
    assert found("one", "two")[1] == ["LD0608"]
    assert found("one", "one/ldc.toml", "two/main.ld") == (["one/main.ld", "two/main.ld"], [])


@pytest.mark.parametrize(
    ("text", "codes", "marked"),
    [
        ("[run]\nperiod = 10", ["LD0612"], ["10"]),
        ('[run]\nperiod = "0ms"', ["LD0612"], ['"0ms"']),
        ('[run]\nperiod = "10"', ["LD0612"], ['"10"']),
        ("run = 3", ["LD0612"], ["3"]),
        ('tasks = "x"', ["LD0612"], ['"x"']),
        ('[tasks]\nfast = "x"', ["LD0612"], ['"x"']),
        ('[tasks.a]\nprograms = ["x", 1]', ["LD0612"], ['["x", 1]']),
        ("[tasks.a]\npriority = 65536", ["LD0612"], ["65536"]),
        ('[processors]\na = "slave"', ["LD0612"], ["[processors]"]),
        ('[processors]\na = "boss"', ["LD0612"], ['"boss"']),
        ("[safe]\nx = [1]", ["LD0612"], ["[1]"]),
        ("[memory]\nimage_bytes = true", ["LD0612"], ["true"]),
        ("[memroy]\nimage_bytes = 1", ["LD0611"], ["[memroy]"]),
        ('project.nmae = "x"', ["LD0611"], ["project.nmae"]),
        ('[project]\n"a b" = 1', ["LD0611"], ['"a b"']),
        ('project = { nmae = "x" }', ["LD0611"], None),
        ("[project]\nsources = []", ["LD0612"], ["[]"]),
        ('[project]\nsources = ["*.txt", "", "/etc/*.ld", "../../../**/nothing.ld"]', ["LD0612"], None),
        ('[project]\nsources = ["*.txt", "no/*.ld"]', ["LD0613", "LD0613"], None),
        ("[project\n", ["LD0610"], None),
        ("x = " + "[" * 5000, ["LD0610"], None),
        ("a = 1\na = 2\n", ["LD0610"], None),
    ],
)
def test_what_does_not_fit_is_reported_where_it_stands(folder: Path, text, codes, marked) -> None:
    write(folder, ldc_toml=text, main_ld=RUNG)
    diagnostics = Diagnostics()
    find_sources(["."], diagnostics)
    assert [d.code for d in diagnostics] == codes
    if marked is not None:
        assert [d.primary.span.text for d in diagnostics] == marked


@pytest.mark.parametrize("pattern", ["/etc/*.ld", "", "**x", "a\x00b", ".."])
def test_no_pattern_breaks_the_search(folder: Path, pattern: str) -> None:
    text = pattern.replace("\0", "\\u0000")
    write(folder, ldc_toml=f'[project]\nsources = ["{text}"]', main_ld=RUNG)
    assert found(".")[1] in (["LD0612"], ["LD0613"])


KEYS = st.one_of(
    st.from_regex(r"[A-Za-z0-9_-]{1,6}", fullmatch=True),
    st.from_regex(r'"[a-z%. =#\[\]]{1,6}"', fullmatch=True),
)
VALUES = st.recursive(
    st.sampled_from(
        [
            '"a"',
            "'b # c'",
            '"""x\n"y"\n]"""',
            "'''\n= \"'''",
            "1",
            "-1.5e3",
            "true",
            "1979-05-27 07:32:00",
            '"\\"]"',
        ]
    ),
    lambda inner: st.lists(inner, max_size=3).map(lambda items: "[ " + ", # c ]\n".join([*items, ""]) + "]")
    | st.lists(inner.filter(lambda text: "\n" not in text), max_size=3).map(
        lambda items: "{ " + ", ".join(f"k{n} = {item}" for n, item in enumerate(items)) + " }"),
    max_leaves=6,
)


@given(
    st.lists(
        st.tuples(st.sampled_from(["", "[t]", "[ t . u ]", '["v.w"]', "[[z]]"]), KEYS, VALUES), max_size=6
    )
)
def test_every_value_of_a_toml_text_is_found_at_its_place(entries) -> None:
    text = "".join(f"{header}\n{key} = {value} # end\n" for header, key, value in entries)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return
    spans = toml_spans(SourceFile("x.toml", text))
    several = any(header.startswith("[[") for header, _, _ in entries)
    for path, entry in spans.items():
        if several and (path[0] == "z" and len(path) > 2 or any(isinstance(key, int) for key in path)):
            continue  # the tables of an array share one path: what is in a value may be of a later table
        value = data
        for key in path:
            if isinstance(value, dict) or isinstance(key, int):
                value = value[key]
            else:
                value = next(table[key] for table in value if key in table)
        if not entry.value.text.startswith("[") or isinstance(value, list):
            if isinstance(path[-1], int) or entry.value.text != entry.key.text:
                assert tomllib.loads(f"x = {entry.value.text}")["x"] == value


@pytest.mark.parametrize(
    ("text", "nanoseconds"),
    [
        ("10ms", 10_000_000),
        ("2s", 2_000_000_000),
        ("1.5 s", 1_500_000_000),
        ("T#1h30m", 5_400_000_000_000),
        ("time#1d_2h", 93_600_000_000_000),
        ("500us", 500_000),
        ("250µs", 250_000),
        ("7ns", 7),
        ("1s500ms", 1_500_000_000),
        ("", None),
        ("10", None),
        ("ms", None),
        ("-1s", None),
        ("0.5ns", None),
        ("1e3s", None),
        ("T#", None),
        ("10 apples", None),
        ("300000000000s", None),
    ],
)
def test_durations(text: str, nanoseconds: int | None) -> None:
    assert parse_duration(text) == nanoseconds


@given(st.integers(1, (1 << 63) - 1))
def test_a_printed_duration_reads_back(nanoseconds: int) -> None:
    assert parse_duration(duration_text(nanoseconds)) == nanoseconds


@pytest.mark.parametrize("toml, said", [
    ('[processors]\nmain = "master"\nslave9 = "slave"\n', "`slave9` is no number of a slave"),
    ('[processors]\nmain = "master"\nSLAVE0 = "slave"\n', "`SLAVE0` is no number of a slave"),
    ('[processors]\nmain = "master"\na = "slave"\nb = "slave"\nc = "slave"\nd = "slave"\nslave1 = "slave"\n',
     "`d` is one slave too many: a project has 4 at most"),
    ('[processors]\nmain = "master"\naxis = "slave"\n[watchdogs]\nSLAVE1 = "1ms"\naxis = "1ms"\n',
     "`axis` is no slave of this project"),
    ('[watchdogs]\nslave1 = "1ms"\n', "`slave1` is no slave of this project"),
    ('[processors]\nmain = "master"\nslave1 = "slave"\n[watchdogs]\nslave1 = "0s"\n',
     "`0s` is not a time greater than zero"),
    ('[plant]\nfile = "p.py"\nstep = "1ns"\n', "the plant would step every 1 ns"),
    ('[plant]\nfile = "p.py"\nstep = "999ns"\n', "the plant would step every 999 ns"),
])
def test_what_no_machine_has_is_refused(folder: Path, toml: str, said: str) -> None:
    (folder / "ldc.toml").write_text(toml)
    (folder / "main.ld").write_text(RUNG)
    diagnostics = Diagnostics()
    find_sources(["."], diagnostics)
    assert [(d.code, d.message) for d in diagnostics] == [("LD0612", said)]


@pytest.mark.parametrize("toml", [
    '[processors]\nmain = "master"\nslave4 = "slave"\nSlave1 = "slave"\nslaver = "slave"\n',
    '[processors]\nslave9 = "master"\n', '[plant]\nfile = "p.py"\nstep = "1us"\n'])
def test_the_least_that_a_machine_has(folder: Path, toml: str) -> None:
    (folder / "ldc.toml").write_text(toml)
    (folder / "main.ld").write_text(RUNG)
    diagnostics = Diagnostics()
    find_sources(["."], diagnostics)
    assert not list(diagnostics)
