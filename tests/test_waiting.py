"""Steps of the sequence that wait for long are told when the run ends: each that did, once (LD0848)."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from ldc.cli.main import main

SAMPLE = Path(__file__).resolve().parents[1] / "samples" / "injection_machine"

TOML = ('[project]\nmodules = ["clamp", "stamp"]\n[sequence]\nsteps = [{ module = "clamp", until = "shut" }, '
        '{ module = "stamp", when = "hot" }]\n[run]\nperiod = "100ms"\n')
GLOBALS = "VAR_GLOBAL\n    shut AT %IX0.0 : BOOL;\n    hot AT %IX0.1 : BOOL;\nEND_VAR\n"
MODULE = ("PROGRAM {0}\nVAR_INPUT start : BOOL; END_VAR\nVAR_OUTPUT done : BOOL; END_VAR\n"
          "RUNG\n    [start] (done)\nEND_PROGRAM\n")


def run(folder: Path, capsys: pytest.CaptureFixture, inputs: str, scans: int) -> list[str]:
    (folder / "ldc.toml").write_text(TOML)
    (folder / "main.ld").write_text(GLOBALS + MODULE.format("clamp") + MODULE.format("stamp"))
    (folder / "in.csv").write_text(f"scan,shut,hot\n{inputs}")
    assert main(["run", str(folder), "--scans", str(scans), "--inputs", str(folder / "in.csv")]) == 0
    return [line.split("sequence: ")[1] for line in capsys.readouterr().err.splitlines() if "LD0848" in line]


def test_each_step_that_waited_for_long_is_told_once(tmp_path: Path, capsys) -> None:
    """Twice for `shut`, once for `hot`; what ended in time, or waits for less, is not."""
    told = run(tmp_path, capsys, "0,0,0\n150,1,0\n290,1,1\n300,0,0\n450,1,1\n470,0,0\n", 500)
    assert len(told) == 2 and told[0].startswith("step 1 of 2 (`clamp`) waited 1"), told
    assert told[1].startswith("step 2 of 2 (`stamp`) waited 1") and told[1].endswith("for `hot`")


def test_a_step_that_waits_still_is_told_in_its_place(tmp_path: Path, capsys) -> None:
    told = run(tmp_path, capsys, "0,0,0\n150,1,0\n160,0,0\n", 400)
    assert len(told) == 2 and "waited" in told[0]
    assert told[1].startswith("step 2 of 2 (`stamp`) waits for `hot`")


def test_nobody_waits_for_long(tmp_path: Path, capsys) -> None:
    assert run(tmp_path, capsys, "0,1,1\n", 400) == []


def test_the_error_of_an_algorithm_is_told_with_what_waits_for_it(tmp_path: Path, capfd) -> None:
    """A parameter out of range: the module never ends."""
    folder = tmp_path / "machine"
    shutil.copytree(SAMPLE, folder)
    project = folder / "ldc.toml"
    step = '{ module = "inject"'
    assert step in project.read_text()
    project.write_text(project.read_text().replace(step, step + ", parameters = { lead = 9.0 }", 1))
    assert main(["run", str(folder), "--for", "14s"]) == 0
    told = [line for line in capfd.readouterr().err.splitlines() if "LD0848" in line]
    assert len(told) == 1 and "module `inject` to end" in told[0]
    assert told[0].endswith("`inject.axis.error` is 7")
