"""Bad and huge input ends soon, with a finding that has a code and a place, and never with a traceback."""

from __future__ import annotations

import contextlib
import io
import re
import time
from pathlib import Path

import pytest

from ldc.cli.main import main

COMMANDS = {
    "check": ("check",), "compile": ("compile",), "run": ("run", "--scans", "3"),
    "fmt": ("fmt", "--check"), "draw": ("draw",),
}
SECONDS = 10
"""Far above what any of them takes, far below what a person waits for."""

DECLARED = "a, b, c, q : BOOL; i, j : INT; x, y : REAL; t : TON; w : WORD;"


def program(body: str, more: str = "", before: str = "") -> str:
    return f"{before}\nPROGRAM main\nVAR {DECLARED}\n{more}\nEND_VAR\n{body}\nEND_PROGRAM\n"


def told(*arguments: str) -> tuple[int, str]:
    """Runs a command; its status and all that it said."""
    said = io.StringIO()
    start = time.monotonic()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = main(arguments)
    assert time.monotonic() - start < SECONDS, f"{arguments} took too long"
    return status, said.getvalue()


def check_told(text: str, status: int, said: str) -> None:
    """Wrong input: status 1, a code, and the place in the source; and not more text than a person reads."""
    assert status == 1, said[-2000:]
    assert "Traceback" not in said
    assert re.search(r"^error\[LD0\d{3}\]: ", said, re.MULTILINE), said[:2000]
    assert re.search(r"^ *--> .*:\d+:\d+$", said, re.MULTILINE) or not text, said[:2000]
    assert len(said) < 100_000


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


MANY = 1_000_000
LONG = {
    "a name": lambda: program(f"RUNG [{'a' * MANY}] (q)"),
    "a declared name": lambda: program("RUNG [a] (q)", f"{'a' * MANY} : BOOL;"),
    "an address": lambda: program(f"RUNG [%IX{'9' * MANY}.0] (q)"),
    "an address of many parts": lambda: program(f"RUNG [%IX0{'.0' * MANY}] (q)"),
    "a value of an enumeration": lambda: program(f"RUNG [{'a' * MANY}#b = 1] (q)"),
    "a number": lambda: program(f"RUNG [i > {'9' * MANY}] (q)"),
    "a real number": lambda: program(f"RUNG [x > {'9' * MANY}.0] (q)"),
    "an exponent": lambda: program(f"RUNG [x > 1.0e{'9' * MANY}] (q)"),
    "a duration": lambda: program(f"RUNG <t(PT := T#{'9' * MANY}s)> (q)"),
    "a string": lambda: program("RUNG [a] (q)", f"s1 : STRING := '{'a' * MANY}';"),
    "an open string": lambda: program(f"RUNG ['{'a' * MANY}] (q)"),
    "an open comment": lambda: program(f"RUNG (* {'a' * MANY}] (q)"),
    "contacts": lambda: program(f"RUNG {'[a] ' * MANY} (q)"),
    "coils": lambda: program(f"RUNG [a] {'(q)' * MANY}"),
    "branches": lambda: program(f"RUNG {{ {'[a]|' * MANY} [a] }} (q)"),
    "paths": lambda: program(f"RUNG {'[a](q);' * MANY}"),
    "semicolons": lambda: program(";" * MANY),
    "empty rungs": lambda: program("RUNG\n" * (MANY // 10)),
    "words": lambda: program("word " * MANY),
    "open declarations": lambda: f"PROGRAM main {'VAR ' * (MANY // 10)}",
    "brackets (": lambda: program(f"RUNG {'(' * MANY}"),
    "brackets [": lambda: program(f"RUNG {'[' * MANY}"),
    "brackets {": lambda: program(f"RUNG {'{' * MANY}"),
    "brackets <": lambda: program(f"RUNG {'<' * MANY}"),
    "brackets }": lambda: program(f"RUNG {'}' * MANY}"),
    "NULs": lambda: "\0" * MANY,
    "line ends": lambda: "\r" * MANY,
    "emoji": lambda: "\U0001f600" * (MANY // 4),
}


@pytest.mark.parametrize("what", LONG)
def test_a_long_line_is_told_soon(what: str, folder: Path) -> None:
    text = LONG[what]()
    (folder / "main.ld").write_text(text, encoding="utf-8", newline="")
    check_told(text, *told("check", "main.ld"))


def test_a_rung_that_is_cut_hides_nothing_behind_it(folder: Path) -> None:
    rung = f"RUNG long {'[a] ' * 300_000} (* RUNG no *) // END_PROGRAM\n ['RUNG'] (q)"
    (folder / "main.ld").write_text(program(f"{rung}\nRUNG next [a] (nothing)"))
    status, said = told("check", "main.ld")
    assert status == 1
    assert [*re.findall(r"error\[(\w+)\]", said)] == ["LD0111", "LD0404"], said


def test_a_file_full_of_errors_is_not_read_to_the_end(folder: Path) -> None:
    (folder / "main.ld").write_text(program("RUNG [\n" * 3_000))
    status, said = told("check", "main.ld", "--format", "json")
    assert status == 1
    assert said.count('"LD0101"') + said.count('"LD0108"') < 1_010
    assert "the file has more than 1,000 errors" in said
