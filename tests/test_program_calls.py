"""Programs that others call, connections of programs, tasks without a RESOURCE."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import PERIOD, checked, compiled, trace

from ldc import pipeline
from ldc.cli.main import main
from ldc.diagnostics import Diagnostics
from ldc.parser import parse_file
from ldc.parser.format import format_file
from ldc.pipeline.memory import Memory
from ldc.source import SourceFile
from runtime.vm.machine import Machine

COUNTING = """PROGRAM count
VAR_INPUT
    go  : BOOL;
END_VAR
VAR_OUTPUT
    n  : INT;
END_VAR
VAR
    k  AT %MW3 : INT;
    t  : TON;
    rounds  : INT;
END_VAR

    k := k + 1;
    rounds := rounds + 1;
    t(IN := go, PT := T#20ms);
    IF go THEN
        n := n + 1;
    END_IF;
END_PROGRAM

"""


def test_a_program_that_is_called_has_one_memory(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR
    q : BOOL := TRUE; m, o, r0 : INT; x : other;
END_VAR
    count();
    count(go := q, n => m);
    o := count.n; r0 := count.rounds;
    x();
    IF x.all > 2 THEN count.go := FALSE; END_IF;
END_PROGRAM
FUNCTION_BLOCK other
VAR_OUTPUT all : INT; END_VAR
    count(EN := all < 100, n => all);
END_FUNCTION_BLOCK
""" + COUNTING
    rows = trace(tmp_path, text, "main.st", [{}, {}, {"q": False}, {"q": True}], ("m", "o", "x.all", "r0"))
    assert rows == [(1, 1, 2, 2), (4, 4, 5, 5), (5, 5, 5, 8), (6, 6, 7, 11)]


def test_ladders_and_lists_call_too(tmp_path: Path) -> None:
    text = """PROGRAM main
VAR
    a, q  : BOOL;
    n     : INT;
END_VAR

RUNG
    [a] <counting(n => n)> (q)
END_PROGRAM

PROGRAM counting
VAR_INPUT
    go  : BOOL;
END_VAR
VAR_OUTPUT
    many  : BOOL;
    n     : INT;
END_VAR

RUNG
    [go] <ADD(IN1 := n, IN2 := 1, OUT => n)> [n > 1] (many)
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.ld", [{}, {"a": True}, {}], ("n", "q"))
    assert rows == [(0, False), (1, False), (2, True)]
    il = """PROGRAM main VAR n : INT; END_VAR
    CAL counting(go := TRUE)
    LD counting.n
    ST n
END_PROGRAM
PROGRAM counting
VAR_INPUT go : BOOL; END_VAR VAR_OUTPUT n : INT; END_VAR
    LD n
    ADD 1
    ST n
END_PROGRAM
"""
    machine = Machine(compiled(il, "main.il").program, period_ns=PERIOD)
    machine.scan()
    machine.scan()
    assert machine.get("main.n") == 2


CONNECTED = COUNTING + """CONFIGURATION plant
    VAR_GLOBAL
        enabled      : BOOL := TRUE;
        first, last  : INT;
        made         AT %QW7 : INT;
    END_VAR
    TASK fast (INTERVAL := T#10ms, PRIORITY := 1);
    TASK slow (INTERVAL := T#20ms, PRIORITY := 2);
    PROGRAM one WITH fast : count(go := enabled, n => first);
    PROGRAM two WITH slow : count(go := NOT enabled OR first > 2, n => made);
    PROGRAM three WITH fast : watching;
END_CONFIGURATION

PROGRAM watching

    last := one.n;
    enabled := first < 4;
END_PROGRAM
"""


def test_connections_of_programs_in_tasks_without_a_resource(tmp_path: Path) -> None:
    source = tmp_path / "plant.st"
    source.write_text(CONNECTED, encoding="utf-8")
    formatted = format_file(parse_file(SourceFile("plant.st", CONNECTED), Diagnostics()))
    assert format_file(parse_file(SourceFile("plant.st", formatted), Diagnostics())) == formatted
    assert "PROGRAM two WITH slow : count(go := NOT enabled OR first > 2, n => made);" in formatted
    assert main(["export", str(source), "--to", "plcopen", "-o", str(tmp_path / "plc.xml")]) == 0
    assert main(["import", str(tmp_path / "plc.xml"), "-o", str(tmp_path / "imported")]) == 0
    traces = []
    for path in (source, tmp_path / "plc.xml", tmp_path / "imported"):
        for engine in ("vm", "native"):
            out = tmp_path / "trace.csv"
            watched = "one.n,two.n,first,last,made,%MW3"
            assert main(["run", str(path), "--engine", engine, "--scans", "8", "--watch", watched,
                         "--trace", str(out)]) == 0
            traces.append(out.read_text())
    assert len(set(traces)) == 1
    rows = [line.split(",")[2:] for line in traces[0].splitlines()[1:]]
    assert rows[0] == ["1", "0", "1", "1", "0", "2"]
    assert rows[7] == ["4", "3", "4", "4", "3", "12"]
    images = [compiled(text, "plant.st").image.digest for text in (CONNECTED, formatted)]
    assert images[0] == images[1]


@pytest.mark.parametrize(("changed", "codes"), [
    ("count(go := nothing)", {"LD0404"}), ("count(stop := enabled)", {"LD0505"}), ("count(n := enabled)", None),
    ("count(go => first)", None), ("count(go := first)", {"LD0403"}), ("count(go := enabled, go := enabled)", None),
    ("count()", None),
    ("count(k => first)", None), ("nothing(go := enabled)", {"LD0220", "LD0404"}),
])
def test_connections_that_fit_nothing_are_told(changed: str, codes: set[str] | None) -> None:
    found = checked(CONNECTED.replace("count(go := enabled, n => first)", changed), "plant.st").diagnostics
    assert found.has_errors
    assert not [d for d in found if d.code == "LD0901"]
    assert codes is None or {d.code for d in found if d.severity == "error"} == codes


@pytest.mark.parametrize("text", [
    "PROGRAM a b(); END_PROGRAM PROGRAM b a(); END_PROGRAM",
    "PROGRAM a a(); END_PROGRAM",
    "FUNCTION f : INT count(); END_FUNCTION" + COUNTING,
    "PROGRAM main count(3); END_PROGRAM " + COUNTING,
    "PROGRAM main count.k := 3; count(); END_PROGRAM " + COUNTING,
    "PROGRAM main count.n := 3; count(); END_PROGRAM " + COUNTING,
    "PROGRAM main VAR x : INT; END_VAR x := count(); END_PROGRAM " + COUNTING,
])
def test_calls_that_cannot_be_are_told(text: str) -> None:
    found = checked(text, "main.st").diagnostics
    assert found.has_errors
    assert not [d for d in found if d.code == "LD0901"]


def test_a_ladder_that_calls_a_program_compiles_again(tmp_path: Path) -> None:
    """What is remembered of its rungs does not hide the call."""
    text = """PROGRAM pumps VAR_INPUT go : BOOL; END_VAR VAR_OUTPUT n : BOOL; END_VAR
RUNG only
    [go] (n)
END_PROGRAM
PROGRAM main VAR q, p : BOOL; END_VAR
RUNG only
    [q] <pumps()> (p)
END_PROGRAM
"""
    digests = {compiled(text, "main.ld", memory=Memory(tmp_path / "memory.rungs"), keep=False).image.digest
               for _ in range(2)}
    assert digests == {compiled(text, "main.ld").image.digest}


def test_a_task_of_the_project_that_names_a_called_program_is_told(tmp_path: Path) -> None:
    (tmp_path / "main.st").write_text(
        "PROGRAM pumps VAR n : INT; END_VAR n := n + 1; END_PROGRAM PROGRAM main pumps(); END_PROGRAM")
    (tmp_path / "ldc.toml").write_text(
        '[project]\nname = "p"\nsources = ["main.st"]\n[tasks.fast]\ninterval = "10ms"\nprograms = ["main", "pumps"]\n')
    found = [d for d in pipeline.compile_paths([str(tmp_path)]).diagnostics if d.severity == "error"]
    assert [d.code for d in found] == ["LD0221"] and "runs where it is called" in found[0].message
