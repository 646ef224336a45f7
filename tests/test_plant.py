"""Plants: what they are wired to, when they step, what of a project is a system."""

from __future__ import annotations

from pathlib import Path

import pytest
from systems import REAL_TIME, Run, mover

from ldc.cli.main import main

TANK = """\
PROGRAM tank
VAR
    full  AT %IX0.0 : BOOL;
    level AT %IW2   : INT;
    valve AT %QX0.0 : BOOL;
    speed AT %QW2   : INT;
    lift  : LIFT;
    gate  : BOOL;
END_VAR

RUNG fill
    [/full] (valve)

RUNG rate
    [valve] <MOVE(IN := level + 1, OUT => speed)>

RUNG up
    [gate] <lift: LIFT(target := 5.0)>
END_PROGRAM
"""

PLANT = """\
from dataclasses import dataclass

@dataclass
class Tank:
    level: float = 0.0

class Plant:
    def __init__(self, field, parameters, seed):
        self.tank, self.most, self.seed = Tank(), parameters["most"], seed
        self.valve, self.speed = field.reader("%QX0.0"), field.reader("tank.speed")
        self.full, self.level = field.writer("tank.full"), field.writer("%IW2")

    def step(self, now_ns, dt_ns):
        if self.valve():
            self.tank.level += dt_ns / 1e6
        self.level(int(self.tank.level))
        self.full(self.tank.level >= self.most)
"""


def project(folder: Path, step: str = "1ms") -> Path:
    (folder / "tank.ld").write_text(TANK)
    (folder / "plant.py").write_text(PLANT)
    (folder / "plant.json").write_text('{"most": 25.0}')
    (folder / "ldc.toml").write_text(
        '[processors]\nmaster = "master"\nslave1 = "slave"\n'
        f'[plant]\nfile = "plant.py"\nparameters = "plant.json"\nstep = "{step}"\nseed = 7\n'
        '[run]\nwatch = ["valve", "level", "speed", "full"]\n')
    mover(folder, "LIFT", 1)
    return folder


@pytest.mark.parametrize("engine", ["vm", "native"])
def test_inputs_and_outputs_of_the_master_are_copied_between_scans(tmp_path: Path, engine: str) -> None:
    run = Run(project(tmp_path), engine, ("valve", "level", "speed", "full")).scans(6)
    # A scan sees what the plant wrote until that instant; the first one opens the valve.
    assert run.rows == [[True, 0, 1, False], [True, 10, 11, False], [True, 20, 21, False],
                        [False, 30, 21, True], [False, 30, 21, True], [False, 30, 21, True]]


def test_the_plant_has_a_step_of_its_own(tmp_path: Path) -> None:
    run = Run(project(tmp_path, "4ms"), watch=("level",)).scans(4)
    assert run.rows == [[0], [8], [20], [28]], "steps at 4, 8; 12, 16, 20; 24, 28 ms"


def test_ldc_run_steps_a_plant(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(project(tmp_path)), "--scans", "6", "--trace", "-"]) == 0
    rows = capfd.readouterr().out.splitlines()
    assert rows[0] == "scan,t_ms,valve,level,speed,full" and rows[-1].startswith("5,50,0,")


def test_what_units_do_is_written_as_csv(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "events.csv"
    (tmp_path / "in.csv").write_text("scan,gate\n1,1\n")
    arguments = ["run", str(project(tmp_path)), "--scans", "8", "--inputs", str(tmp_path / "in.csv"),
                 "--trace", "-", "--events", str(target)]
    assert main(arguments) == 0
    rows = target.read_text().splitlines()
    assert rows[:2] == ["t_ms,processor,unit,index,detail", "0,master,C.LOGIC,0,"]
    assert "10,master,C.SEND,1,START" in rows and "10,slave1,A.START,1," in rows
    assert "61,slave1,A.EXEC,1," in rows


def test_a_plant_that_exits_is_told_at_its_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    folder = project(tmp_path)
    (folder / "plant.py").write_text(PLANT.replace("self.full(self.tank.level >= self.most)", "raise SystemExit(3)"))
    assert main(["run", str(folder), "--scans", "6"]) == 1
    assert "LD0842" in (said := capfd.readouterr().err) and "plant.py:17" in said, said


@pytest.mark.parametrize(
    "options", [[], ["--engine", "native"], pytest.param(["--realtime"], marks=REAL_TIME)])
@pytest.mark.parametrize("point, value", [("%IW2", "40000"), ("%IW2", "-40000"), ("tank.few", "7")])
def test_what_the_declared_type_does_not_hold_is_told_at_the_line_of_the_plant(
        tmp_path: Path, capfd: pytest.CaptureFixture[str], options: list[str], point: str, value: str) -> None:
    folder = project(tmp_path)
    (folder / "tank.ld").write_text(TANK.replace("speed AT", "few AT %IW4 : INT(0..6);\n    speed AT"))
    text = PLANT.replace('"%IW2"', f'"{point}"').replace("int(self.tank.level)", value)
    (folder / "plant.py").write_text(text)
    assert main(["run", str(folder), "--scans", "30", *options]) == 1
    said = capfd.readouterr().err
    assert said.count("LD0842") == 1 and "plant.py:16" in said and f"not {value}" in said, said


@pytest.mark.parametrize("engine, options", [("vm", ["--for", "60s"]), ("native", ["--for", "60s"]),
                                             pytest.param("vm", ["--for", "3s", "--realtime"], marks=REAL_TIME)])
def test_a_step_that_does_not_end_is_told_at_its_line(
        tmp_path: Path, capfd: pytest.CaptureFixture[str], engine: str, options: list[str]) -> None:
    folder = project(tmp_path)
    endless = "while True: pass\n"
    (folder / "plant.py").write_text(PLANT.replace("self.full(self.tank.level >= self.most)", endless))
    assert main(["run", str(folder), "--engine", engine, *options]) == 1
    said = capfd.readouterr().err
    assert "error[LD0846]" in said and "plant.py:17" in said and "LD0805" not in said, said


def test_a_plant_that_leaves_the_process_is_not_taken_for_a_component(
        tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    folder = project(tmp_path)
    left = "__import__('os')._exit(5)"
    (folder / "plant.py").write_text(PLANT.replace("self.full(self.tank.level >= self.most)", left))
    assert main(["run", str(folder), "--scans", "20"]) == 1
    assert "a component or the plant left the process" in (said := capfd.readouterr().err), said


@pytest.mark.parametrize("language", ["c", "st"])
def test_local_pins_hold_what_their_type_holds(tmp_path: Path, language: str) -> None:
    folder = project(tmp_path)
    text = (folder / "lift.ldc.toml").read_text()
    pins = ('{ name = "teeth", type = "USINT", local = true, max = 20 }, '
            '{ name = "turn", type = "INT", local = true }')
    (folder / "lift.ldc.toml").write_text(text.replace("inputs = [{", f"inputs = [{pins}, {{").replace(
        'language = "c"', f'language = "{language}"').replace("lift.c", f"lift.{language}"))
    if language == "st":
        (folder / "lift.st").write_text("FUNCTION_BLOCK LIFT\nposition := target;\nEND_FUNCTION_BLOCK\n")
    field = Run(folder).system.slaves[0].field
    for pin, low, high in (("teeth", 0, 255), ("turn", -32768, 32767)):
        write, read = field.writer(f"tank.lift.{pin}"), field.reader(f"tank.lift.{pin}")
        for value in (low, high):  # the range of the component is for the component to tell
            write(value)
            assert read() == value
        for value in (low - 1, high + 1):
            with pytest.raises(ValueError, match=f"`tank.lift.{pin}` holds {low} to {high}, not {value}"):
                write(value)
