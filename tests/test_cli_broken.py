"""No input, however broken, ends in a traceback: sources with pieces taken out, doubled and exchanged."""

from __future__ import annotations

import contextlib
import io
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ldc.cli.main import main

ROOT = Path(__file__).resolve().parent.parent
SOURCES = {path.name: path.read_text(encoding="utf-8") for path in sorted((ROOT / "samples").glob("*/*.ld"))}
PROJECT = (ROOT / "ldc" / "cli" / "project" / "ldc.toml").read_text(encoding="utf-8")
INPUTS = (ROOT / "ldc" / "cli" / "project" / "inputs.csv").read_text(encoding="utf-8")
PIECES = [
    "",
    "{",
    "}",
    "[",
    "]",
    "(",
    ")",
    "<",
    ">",
    ";",
    "|",
    ":=",
    "=>",
    "@x",
    "@",
    ">>",
    "RUNG ",
    "END_VAR",
    "VAR ",
    '"',
    "'",
    "(*",
    "*)",
    "//",
    "TON",
    "BOOL",
    "INT#",
    "16#",
    "T#",
    "%IX0.0",
    "%",
    "1.5",
    "99999999999999999999",
    ".",
    "..",
    "/",
    "P ",
    "S ",
    "NOT ",
    "RETURN",
    "in=_",
    "out=Q",
    "ARRAY [0..9] OF ",
    "STRUCT",
    "FUNCTION ",
    "END_PROGRAM",
    "\0",
    "\t",
    "é",
    "\U0001f600",
    "#",
    "$",
    "[TRUE]",
    "(motor)",
    "<MOVE()>",
    "{ [a] | [b] }",
    "_ldc_x",
    "-",
    "**",
]

EDITS = st.lists(
    st.tuples(st.integers(0, 10**6), st.integers(0, 30), st.sampled_from(PIECES)), min_size=1, max_size=4
)


def broken(text: str, edits: list[tuple[int, int, str]]) -> str:
    for at, length, piece in edits:
        at %= len(text) + 1
        text = text[:at] + piece + text[at + length :]
    return text


def quietly(*arguments: str) -> tuple[int, str]:
    """Runs a command; its status and what it said."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = main(arguments)
    return status, said.getvalue()


@pytest.fixture(scope="module", autouse=True)
def folder(tmp_path_factory):
    with contextlib.chdir(tmp_path_factory.mktemp("broken")) as _:
        yield


LIMITS = settings(deadline=None, max_examples=60, suppress_health_check=[HealthCheck.too_slow])


@LIMITS
@given(
    st.sampled_from(sorted(SOURCES)),
    EDITS,
    st.sampled_from(
        [
            ["check"],
            ["compile"],
            ["compile", "--emit", "graph"],
            ["compile", "--max-paren-depth", "1"],
            ["draw"],
            ["fmt", "--check"],
            ["run", "--scans", "5"],
        ]
    ),
)
def test_broken_ladder(name: str, edits, command: list[str]) -> None:
    Path("main.ld").write_text(broken(SOURCES[name], edits), encoding="utf-8")
    status, said = quietly(*command, "main.ld")
    assert status in (0, 1), said


@LIMITS
@given(st.sampled_from(sorted(SOURCES)), EDITS)
def test_broken_il(name: str, edits) -> None:
    Path("good.ld").write_text(SOURCES[name], encoding="utf-8")
    if quietly("compile", "good.ld", "-o", "good.il")[0] == 0:
        Path("bad.il").write_text(
            broken(Path("good.il").read_text(encoding="utf-8"), edits), encoding="utf-8"
        )
        for command in ("check", "run"):
            status, said = quietly(command, "bad.il")
            assert status in (0, 1), said


@LIMITS
@given(EDITS, EDITS)
def test_broken_project_and_inputs(project_edits, input_edits) -> None:
    main_text = (ROOT / "ldc" / "cli" / "project" / "main.ld").read_text(encoding="utf-8")
    Path("plant").mkdir(exist_ok=True)
    Path("plant/main.ld").write_text(main_text, encoding="utf-8")
    Path("plant/ldc.toml").write_text(broken(PROJECT, project_edits), encoding="utf-8")
    Path("plant/inputs.csv").write_text(broken(INPUTS, input_edits), encoding="utf-8")
    status, said = quietly("run", "plant", "--scans", "3")
    assert status in (0, 1), said
