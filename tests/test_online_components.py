"""Online change of programs with components in C: their code is exchanged, their state goes on
(docs/online.md)."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import pytest

import native
from ldc.cli.main import main
from online_runtime import running

pytestmark = native.needs_gcc

DESCRIPTOR = """[component]
name = "COUNTER"
id = "test.counter"
[requires]
inputs = [{ name = "width", type = "INT" }]
[provides]
power = "done"
outputs = [{ name = "done", type = "BOOL" }, { name = "count", type = "INT" }]
[properties]
state = [{ name = "total", type = "INT" }]
[function]
language = "c"
sources = ["counter.c"]
"""
BODY = """#include "counter.h"

void counter(const counter_in *in, counter_out *out, counter_state *state, uint32_t dt_us)
{
    (void)dt_us;
    if (in->enable) {
        state->total = (int16_t)((state->total + in->width) % 1000);
        PLC_D(seen) = state->total;
    }
    out->count = state->total;
    out->done = in->enable;
}
"""
PROGRAM = """VAR_GLOBAL
    seen : INT;
END_VAR
PROGRAM main
VAR
    k : COUNTER;
    lit : BOOL;
END_VAR
RUNG count
    <k: COUNTER(width := 1)> (lit)
END_PROGRAM
"""


def project(folder: Path, descriptor: str = DESCRIPTOR, body: str = BODY, program: str = PROGRAM) -> None:
    (folder / "ldc.toml").write_text('[project]\nname = "counting"\n')
    (folder / "counter.ldc.toml").write_text(descriptor)
    (folder / "counter.c").write_text(body)
    (folder / "main.ld").write_text(program)


@pytest.mark.parametrize("engine", ["vm", "native"])
def test_changed_code_goes_on_with_the_state_of_the_instance(tmp_path, monkeypatch, capsys, engine) -> None:
    project(tmp_path)
    monkeypatch.chdir(tmp_path)
    trace = tmp_path / "trace.csv"
    arguments = ["run", ".", "--online", "--engine", engine, "--trace", str(trace), "--watch", "k.count,seen"]
    with running(arguments, monkeypatch):
        project(tmp_path, body=BODY.replace("+ in->width)", "- in->width)"))
        assert main(["online", "stage"]) == 0
        assert main(["online", "test"]) == 0
        more = DESCRIPTOR.replace("state = [", 'state = [{ name = "calls", type = "INT" }, ')
        project(tmp_path, more,
                BODY.replace("out->done", "state->calls++;\n    out->done"))
        assert main(["online", "stage"]) == 1  # in a test
        assert main(["online", "commit"]) == 0
        assert main(["online", "stage"]) == 0
        assert "initialised main.k.calls" in capsys.readouterr().out
        assert main(["online", "test"]) == 0
        assert main(["online", "untest"]) == 0
        assert main(["online", "cancel"]) == 0
    with trace.open() as file:
        rows = [(int(row["k.count"]), int(row["seen"])) for row in csv.DictReader(file)]
    assert all(value == seen for value, seen in rows)
    steps = [after - before for (before, _), (after, _) in zip(rows, rows[1:])]
    first = steps.index(-1)
    second = steps.index(1, first)
    assert set(steps[:first]) == {1} and set(steps[first:second]) == {-1}, "the state goes on in every scan"
    assert set(steps[second:]) <= {1, -1} and list(map(bool, steps)) == [True] * len(steps)


def test_a_state_that_means_something_else_is_refused(tmp_path, monkeypatch, capsys) -> None:
    project(tmp_path)
    monkeypatch.chdir(tmp_path)
    with running(["run", ".", "--online", "--trace", str(tmp_path / "t.csv")], monkeypatch):
        project(tmp_path, DESCRIPTOR.replace('"total", type = "INT"', '"total", type = "DINT"'))
        assert main(["online", "stage"]) == 1
        error = capsys.readouterr().err
        assert "LD0820" in error and "counter.ldc.toml" in error
        project(tmp_path, body=BODY.replace("(void)dt_us;", "nothing;"))
        assert main(["online", "stage"]) == 1
        assert "counter.c" in capsys.readouterr().err
        project(tmp_path)
        assert main(["online", "stage"]) == 0
        assert "nothing to stage" in capsys.readouterr().err


def test_a_component_comes_while_the_program_runs(tmp_path, monkeypatch, capsys) -> None:
    plain = "PROGRAM main\nVAR lit : BOOL; END_VAR\nRUNG count\n[TRUE] (lit)\nEND_PROGRAM\n"
    project(tmp_path, program=plain)
    monkeypatch.chdir(tmp_path)
    trace = tmp_path / "t.csv"
    with running(["run", ".", "--online", "--watch", "lit", "--trace", str(trace)], monkeypatch) as process:
        project(tmp_path)
        assert main(["online", "stage"]) == 0
        assert main(["online", "test"]) == 0
        assert main(["online", "commit"]) == 0
        assert list(Path(tmp_path).glob("*.so")) == []
        assert main(["pull", "-o", "running"]) == 0
        assert (tmp_path / "running" / "counter.c").read_text() == BODY
        assert main(["check", "running"]) == 0
        (tmp_path / "counter.c").write_text(BODY.replace("% 1000", "% 999"))
        assert main(["pull", "--check"]) == 1
        assert "LD0830" in (said := capsys.readouterr().err) and "counter.c" in said
        assert process.poll() is None


@pytest.mark.parametrize("engine", ["vm", "native"])
def test_what_a_staged_component_breaks_is_told(tmp_path, monkeypatch, engine) -> None:
    """The runtime had no component when it was started."""
    project(tmp_path, program="PROGRAM main\nVAR lit : BOOL; END_VAR\nRUNG count\n[TRUE] (lit)\nEND_PROGRAM\n")
    monkeypatch.chdir(tmp_path)
    with running(["run", ".", "--online", "--engine", engine, "--watch", "lit"], monkeypatch) as process:
        project(tmp_path, body=BODY.replace("(void)dt_us;", "if (state->total > 5) *(volatile int *)0 = 1;"))
        assert main(["online", "stage"]) == 0
        main(["online", "test"])
        said = process.stderr.read()
        assert process.wait(timeout=20) == 1
        Path(os.environ["LDC_SOCKET"]).unlink()
    assert "error[LD0805]: a component reads or writes memory that is not there: the run was ended" in said


@pytest.mark.parametrize("engine", ["vm", "native"])
def test_code_of_a_slave_alone_is_exchanged(tmp_path, monkeypatch, engine) -> None:
    """The master's native code calls no component then, and has no place to bind one."""
    body = BODY.replace("        PLC_D(seen) = state->total;\n", "")
    paced = DESCRIPTOR + 'processor = "slave1"\nperiod_us = 1000\n'
    project(tmp_path, paced, body)
    with (tmp_path / "ldc.toml").open("a") as file:
        file.write('modules = ["main"]\n[processors]\nmaster = "master"\nslave1 = "slave"\n')
    monkeypatch.chdir(tmp_path)
    with running(["run", ".", "--online", "--engine", engine, "--watch", "lit"], monkeypatch):
        (tmp_path / "counter.c").write_text(body.replace("+ in->width)", "- in->width)"))
        for action in ("stage", "test", "commit"):
            assert main(["online", action]) == 0
