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


def declared(more: str, before: str = "") -> str:
    return program("RUNG [a] (q)", more, before)


def told(*arguments: str) -> tuple[int, str]:
    """Runs a command; its status and all that it said."""
    said = io.StringIO()
    start = time.process_time()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        status = main(arguments)
    assert time.process_time() - start < SECONDS, f"{arguments} took too long"
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


MANY = 500_000
LONG = {
    "a name": lambda: program(f"RUNG [{'a' * MANY}] (q)"),
    "a declared name": lambda: declared(f"{'a' * MANY} : BOOL;"),
    "an address": lambda: program(f"RUNG [%IX{'9' * MANY}.0] (q)"),
    "an address of many parts": lambda: program(f"RUNG [%IX0{'.0' * MANY}] (q)"),
    "a value of an enumeration": lambda: program(f"RUNG [{'a' * MANY}#b = 1] (q)"),
    "a number": lambda: program(f"RUNG [i > {'9' * MANY}] (q)"),
    "a real number": lambda: program(f"RUNG [x > {'9' * MANY}.0] (q)"),
    "an exponent": lambda: program(f"RUNG [x > 1.0e{'9' * MANY}] (q)"),
    "a duration": lambda: program(f"RUNG <t(PT := T#{'9' * MANY}s)> (q)"),
    "a string": lambda: declared(f"s1 : STRING := '{'a' * MANY}';"),
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
    rung = f"RUNG long {'[a] ' * 150_000} (* RUNG no *) // END_PROGRAM\n ['RUNG'] (q)"
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


def nested(opening: str, closing: str, inner: str, levels: int = 1_000) -> str:
    return opening * levels + inner + closing * levels


def chain(count: int, link: str, last: str) -> str:
    """``link`` for each of 0 to count - 1, with @ for its number and + for the next, then ``last``."""
    links = (link.replace("@", str(n)).replace("+", str(n + 1)) for n in range(count))
    return "".join(links) + last.replace("@", str(count))


def block(calls: str) -> str:
    return ("FUNCTION_BLOCK f@ VAR_INPUT i : BOOL; END_VAR VAR_OUTPUT o : BOOL; END_VAR\n"
            f"VAR x, y : f+; END_VAR RUNG [i] {calls} (o) END_FUNCTION_BLOCK\n")


LAST_BLOCK = ("FUNCTION_BLOCK f@ VAR_INPUT i : BOOL; END_VAR VAR_OUTPUT o : BOOL; END_VAR\n"
              "RUNG [i] (o) END_FUNCTION_BLOCK\n")
CONSTANTS = "VAR_GLOBAL CONSTANT\n{}END_VAR"
WRONG = {
    "empty": "",
    "only a comment": "(* nothing *)",
    "only NULs": "\0\0\0\0",
    "only a heading": "PROGRAM main",
    "open [": program("RUNG [a (q)"),
    "open (": program("RUNG [a] (q"),
    "open {": program("RUNG { [a] | [b] (q)"),
    "open <": program("RUNG [a] <t(PT := T#1s) (q)"),
    "open VAR": "PROGRAM main VAR a : BOOL; RUNG [a] (a) END_PROGRAM",
    "wrong brackets": program("RUNG [a) (q]"),
    "an unknown instance": program("RUNG [a] <u: TON(PT := T#1s)> (q)"),
    "an unknown block": program("RUNG [a] <t: TOM(PT := T#1s)> (q)"),
    "an unknown function": program("RUNG [a] <MOVEX(IN := 1, OUT => i)> (q)"),
    "an unknown pin": program("RUNG [a] <t: TON(PX := T#1s)> (q)"),
    "a wrong type": program("RUNG [i] (q)"),
    "a wrong type at a pin": program("RUNG [a] <t: TON(PT := 5)> (q)"),
    "a coil of an INT": program("RUNG [a] (i)"),
    "a coil of a number": program("RUNG [a] (5)"),
    "a short": program("RUNG [a] @n [b] @n (q)"),
    "a junction without source": program("RUNG [a] (q); @n [b] (c)"),
    "an empty branch": program("RUNG { [a] | } (q)"),
    "a loop of contacts": program("RUNG [a] @n [b] @m (q); @m [c] @n"),
    "a rung of nothing": program("RUNG"),
    "two rungs of one name": program("RUNG r [a] (q)\nRUNG r [b] (c)"),
    "two variables of one name": declared("a : INT;"),
    "two programs of one name": program("RUNG [a] (q)") + program("RUNG [a] (q)"),
    "a jump to nowhere": program("RUNG [a] >>away"),
    "a name of the compiler": declared("_ldc_x : BOOL;"),
    **{f"1,000 levels of {o}{c}": program(f"RUNG {nested(o, c, 'a')} (q)")
       for o, c in ("()", "[]", "{}", "<>")},
    "1,000 parentheses": program(f"RUNG [{nested('(', ')', 'a')}] (q)"),
    "1,000 indexes": program(f"RUNG [{nested('r[', ']', 'i')} > 0] (q)", "r : ARRAY [0..3] OF INT;"),
    "1,000 calls": program(f"RUNG [{nested('ABS(', ')', 'i')} > 0] (q)"),
    "1,000 NOT": program(f"RUNG [{nested('NOT ', '', 'a')}] (q)"),
    "1,000 signs": program(f"RUNG [{nested('-', '', 'i')} > 0] (q)"),
    "1,000 blocks at pins": program(f"RUNG {nested('<t(IN := {', '})>', '[a]')} (q)"),
    "1,000 comments that do not end": program(f"RUNG {nested('(*', '', 'a')} (q)"),
    "1,000 structures": f"TYPE s : {nested('STRUCT a : ', 'END_STRUCT; ', 'INT; ')} END_TYPE",
    "1,000 arrays of arrays": declared(f"z : {'ARRAY [0..0] OF ' * 1_000} INT;"),
    "1,000 brackets of values": declared(f"z : ARRAY [0..1] OF INT := {nested('[', ']', '1')};"),
    "1,000 dimensions": declared(f"z : ARRAY [{', '.join(['0..1'] * 1_000)}] OF INT;"),
    "5,000 operators": program(f"RUNG [{' + '.join(['i'] * 5_000)} > 0] (q)"),
    "5,000 members": program(f"RUNG [{'.'.join(['i'] * 5_000)} > 0] (q)"),
    "100,000 names": declared(", ".join(f"v{n}" for n in range(100_001)) + " : BOOL;"),
    "5,000 times one name": declared("v : BOOL; " * 5_000),
    "an array without end": declared("z : ARRAY [0..2000000000] OF INT;"),
    "an array of all numbers": program(
        "RUNG [a] (q)", "z : ARRAY [-9223372036854775808..9223372036854775807] OF TON;"),
    "values without end": declared("z : ARRAY [0..9] OF INT := [2000000000(1)];"),
    "arrays without end": declared("".join(f"z{n} : ARRAY [1..900000] OF INT;" for n in range(20))),
    "a long string": declared("z : STRING[2000000000];"),
    "a string without length": declared("z : STRING[0];"),
    "a far address": program("RUNG [%IX999999999.0] (q)"),
    "a farther address": declared(f"z AT %QD{'9' * 5_000} : DINT;"),
    "a far bit": program(f"RUNG [w.{'9' * 5_000}] (q)"),
    "a large number": program(f"RUNG [i > {'9' * 500}] (q)"),
    "a large power": declared("z : LINT := 9 ** 9 ** 9 ** 9;"),
    "a long formula of constants": program(f"RUNG [i = {' * '.join(['9'] * 999)}] (q)"),
    "a type of itself": declared("z : s;", "TYPE s : STRUCT s : s; END_STRUCT; END_TYPE"),
    "types of each other": declared("z : s;", "TYPE s : ARRAY [0..1] OF r; r : s; END_TYPE"),
    "a subrange of itself": declared("z : s;", "TYPE s : s (0..5); END_TYPE"),
    "a constant of itself": declared("", CONSTANTS.format("k : INT := k;")),
    "a block in itself": declared("z : f;", "FUNCTION_BLOCK f VAR f1 : f; END_VAR END_FUNCTION_BLOCK"),
    "a function that calls itself": program(
        "RUNG [f()] (q)", "", "FUNCTION f : BOOL RUNG [f()] (f) END_FUNCTION"),
    "a program in itself": "PROGRAM main VAR m : main; END_VAR END_PROGRAM",
    "2,000 types": declared("z : t0;", f"TYPE {chain(2_000, 't@ : t+; ', 't@ : INT; ')}END_TYPE"),
    "2,000 structures": declared("z : t0;", "TYPE " + chain(
        2_000, "t@ : STRUCT x : t+; END_STRUCT; ", "t@ : INT; ") + "END_TYPE"),
    "2,000 constants": declared("", CONSTANTS.format(chain(
        2_000, "k@ : LINT := k+ * k+;", "k@ : LINT := 9;"))),
    "200 functions": program("RUNG [f0()] (q)", "", chain(
        200, "FUNCTION f@ : BOOL RUNG [f+()] (f@) END_FUNCTION\n",
        "FUNCTION f@ : BOOL RUNG [TRUE] (f@) END_FUNCTION\n")),
    "150 blocks": program("RUNG [a] <z: f0()> (q)", "z : f0;", chain(150, block("<x: f+()>"), LAST_BLOCK)),
    "2 to the 30th blocks": program("RUNG [a] <z: f0()> (q)", "z : f0;", chain(
        30, block("<x: f+()> <y: f+()>"), LAST_BLOCK)),
    "2 to the 30th values": declared("z : t0;", "TYPE " + chain(
        30, "t@ : STRUCT x, y : t+; END_STRUCT; ", "t@ : INT; ") + "END_TYPE"),
}
"""Each of these is wrong; the name says how."""


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("what", ("empty", "open [", "a short", "a wrong type", "two programs of one name"))
def test_every_command_tells_it(what: str, command: str, folder: Path) -> None:
    (folder / "main.ld").write_text(WRONG[what])
    status, said = told(*COMMANDS[command], "main.ld")
    assert status in ((0, 1) if command in ("fmt", "draw") else (1,)), said
    assert "Traceback" not in said


@pytest.mark.parametrize("what", WRONG)
def test_wrong_input_is_told(what: str, folder: Path) -> None:
    (folder / "main.ld").write_text(WRONG[what], encoding="utf-8", newline="")
    check_told(WRONG[what], *told("check", "main.ld"))
    for command in ("fmt", "draw"):
        status, said = told(*COMMANDS[command], "main.ld")
        assert status in (0, 1), said[-2000:]
        assert "Traceback" not in said


def test_thousands_of_unknown_names_among_thousands(folder: Path) -> None:
    rungs = "".join(f"RUNG [v{n}x] (q)\n" for n in range(2_000))
    (folder / "main.ld").write_text(program(rungs, "".join(f"v{n} : BOOL;" for n in range(2_000))))
    status, said = told("check", "main.ld")
    assert status == 1
    assert "did you mean `v0`" in said


def series(count: int) -> str:
    """A rung that writes one variable very often, each time under another condition."""
    adds = " ".join(f"[x{n % 100}] <ADD(IN1 := i, IN2 := {n}, OUT => i)>" for n in range(count))
    return program(f"RUNG [a] {adds} (q)", "".join(f"x{n} : BOOL;" for n in range(100)))


LARGE = {
    "1,000 rungs": lambda: program(
        "".join(f"RUNG r{n} {{ [a] | [x{n}] }} [/b] (x{n})\n" for n in range(1_000)),
        "".join(f"x{n} : BOOL;" for n in range(1_000))),
    "10,000 contacts": lambda: program(f"RUNG {'[a] ' * 10_000} (q)"),
    "5,000 branches": lambda: program(f"RUNG {{ {'[a] | ' * 5_000} [b] }} (q)"),
    "2,000 coils": lambda: program(
        f"RUNG [a] {' '.join(f'(x{n})' for n in range(2_000))}",
        "".join(f"x{n} : BOOL;" for n in range(2_000))),
    "2,000 branches with coils": lambda: program(
        f"RUNG [a] {{ {' | '.join(f'[b] (x{n})' for n in range(2_000))} }}",
        "".join(f"x{n} : BOOL;" for n in range(2_000))),
    "1,000 timers": lambda: program(
        f"RUNG [a] {' '.join(f'<x{n}: TON(PT := T#1s)>' for n in range(1_000))} (q)",
        "".join(f"x{n} : TON;" for n in range(1_000))),
    "300 writes of one variable": lambda: series(300),
    "500 POUs": lambda: program(
        "".join(f"RUNG [a] <z{n}: f{n}()> (q)\n" for n in range(500)),
        "".join(f"z{n} : f{n};" for n in range(500)),
        "".join(LAST_BLOCK.replace("@", str(n)) for n in range(500))),
    "blocks 50 deep": lambda: program("RUNG [a] <z: f0()> (q)", "z : f0;", chain(
        50, block("<x: f+()>").replace("x, y", "x"), LAST_BLOCK)),
    "arrays of 10,000": lambda: program(
        "RUNG [z[i] > 2] <tt[3]: TON(PT := T#1s)> (q)",
        "z : ARRAY [0..9999] OF INT; tt : ARRAY [0..9999] OF TON;"),
}


@pytest.mark.parametrize("what", LARGE)
def test_large_programs_work_in_sane_time(what: str, folder: Path) -> None:
    (folder / "main.ld").write_text(LARGE[what]())
    status, said = told(*COMMANDS["run"], "main.ld")
    assert status == 0, said[-2000:]


MANIFESTS = {
    "a number of 5,000 digits": "[memory]\nimage_bytes = " + "9" * 5_000,
    "5,000 brackets": "[project]\nname = " + "[" * 5_000,
    "a safe value that no type holds": "[safe]\nq = 99999999999999999999",
    "a period without unit": "[run]\nperiod = 5",
    "a section twice": "[project]\n[project]",
    "globs of nothing": '[project]\nsources = ["nothing.ld"]',
    "a bad glob": '[project]\nsources = ["\\u0000"]',
    "two masters": '[processors]\na = "master"\nb = "master"',
}


@pytest.mark.parametrize("what", MANIFESTS)
def test_a_wrong_project_file_is_told(what: str, folder: Path) -> None:
    (folder / "main.ld").write_text(program("RUNG [a] (q)"))
    (folder / "ldc.toml").write_text(MANIFESTS[what])
    check_told(MANIFESTS[what], *told("run", "."))


@pytest.mark.parametrize("rows", (
    "", "a,scan\n1,0", "scan,a,a\n0,1,1", "scan,zz\n0,1", "scan,a\n0,1,2", "scan,a\n-1,1",
    "scan,a\n1,1\n0,1", "scan,a\n0,2", "scan,i\n0,99999", f"scan,i\n0,{'9' * 5_000}", f"scan,a\n{'9' * 5_000},1",
    'scan,a\n"0,1', "\0", "scan,t.PT\n0,T#99999999999999d",
    f"scan{',a' * 10_000}\n0",
))
def test_wrong_inputs_are_told(rows: str, folder: Path) -> None:
    (folder / "main.ld").write_text(program("RUNG [a] (q)"))
    (folder / "in.csv").write_text(rows)
    status, said = told("run", "main.ld", "--inputs", "in.csv")
    assert status == 1 and re.search(r"error\[LD06\d\d\]", said), said[:1000]


@pytest.mark.parametrize("path", (
    "nothing.ld", "nothing", ".", "a" * 5_000, "a" * 5_000 + ".ld", "a\0.ld", "", "folder.ld"))
def test_paths_that_are_no_source(path: str, folder: Path) -> None:
    (folder / "folder.ld").mkdir()
    for command in COMMANDS.values():
        status, said = told(*command, path)
        assert status == 1 and "error[LD06" in said, said[:1000]


def test_il_full_of_errors(folder: Path) -> None:
    (folder / "main.il").write_text("PROGRAM main\n" + "zz\n" * 50_000 + "END_PROGRAM")
    status, said = told("check", "main.il")
    assert status == 1 and "Traceback" not in said
