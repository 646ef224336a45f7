"""The axes of the injection machine alone, called every millisecond: limits of the S-curve, switch-over in
time.
"""

from __future__ import annotations

import shutil
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc import pipeline
from ldc.components import host
from ldc.diagnostics import Diagnostics
from runtime.vm.machine import Machine

SAMPLE = Path(__file__).resolve().parents[1] / "samples" / "injection_machine"
MAIN = """PROGRAM main
VAR
    go : BOOL;
    target, measured : REAL;
    servo : SERVO_AXIS;
    valve : HYDRAULIC_AXIS;
END_VAR
RUNG [go] <servo: SERVO_AXIS(target := target, measured := measured)>
RUNG [go] <valve: HYDRAULIC_AXIS(target := target, measured := measured, velocity := 320.0, creep := 25.0,
    creep_distance := 15.0, lead := 0.022)>
END_PROGRAM
"""
VELOCITY, ACCELERATION, JERK = 250.0, 2500.0, 60000.0
DT = 0.001


@cache
def compiled(folder: Path):
    for name in ("servo_axis", "hydraulic_axis"):
        for suffix in ("ldc.toml", "c"):
            shutil.copy(SAMPLE / f"{name}.{suffix}", folder)
    (folder / "main.ld").write_text(MAIN)
    (folder / "ldc.toml").write_text("")
    result, found = pipeline.compile_paths([str(folder)]), Diagnostics()
    assert not result.diagnostics.has_errors, [f"{d.code} {d.message}" for d in result.diagnostics]
    bindings = tuple(host.build(n, tuple(result.model.globals.values()), found) for n in result.natives)
    assert not found.has_errors, [d.message for d in found]
    return result.program, bindings


@pytest.fixture(scope="module")
def machine(tmp_path_factory):
    """``machine()``: a new one, both axes at 0 mm."""
    folder = tmp_path_factory.mktemp("axes")

    def make() -> Machine:
        program, bindings = compiled(folder)
        return Machine(program, period_ns=1_000_000, bindings=bindings)

    return make


class Drive:
    """A drive that follows its reference with a lag of 2 ms."""

    def __init__(self, machine: Machine, pin: str) -> None:
        self.machine, self.pin, self.position, self.velocity = machine, pin, 0.0, 0.0

    def scan(self) -> None:
        self.velocity += (self.machine.get(self.pin) - self.velocity) * 0.39
        self.position += self.velocity * DT
        self.machine.set("measured", self.position)
        self.machine.scan()


def within_limits(speeds: list[float]) -> None:
    """Differences of a sampled velocity never exceed the limits, up to the rounding of REAL."""
    accelerations = [(b - a) / DT for a, b in zip(speeds, speeds[1:])]
    jerks = [(b - a) / DT for a, b in zip(accelerations, accelerations[1:])]
    assert max(map(abs, speeds)) <= VELOCITY * 1.000001
    assert max(map(abs, accelerations)) <= ACCELERATION + 0.1
    assert max(map(abs, jerks)) <= JERK + 100


@settings(max_examples=12, deadline=None)
@given(st.lists(st.tuples(st.integers(1, 200), st.floats(0, 120), st.booleans()), min_size=1, max_size=5))
def test_the_servo_keeps_its_limits_whatever_the_ladder_asks(machine, commands: list) -> None:
    m = machine()
    drive, speeds = Drive(m, "servo.reference"), [0.0, 0.0]
    for scans, target, go in commands:
        m.set("go", go)
        m.set("target", target)
        for _ in range(scans):
            drive.scan()
            speeds.append(m.get("servo.speed"))
    within_limits(speeds)


@pytest.mark.parametrize("target", [0.04, 0.5, 8.0, 60.0, 400.0])
def test_the_servo_arrives_and_stays(machine, target: float) -> None:
    m = machine()
    drive = Drive(m, "servo.reference")
    m.set("go", True)
    m.set("target", target)
    scans = 0
    while not m.get("servo.done") or scans < 20:
        drive.scan()
        scans += 1
        assert scans < 3000
    for _ in range(200):
        drive.scan()
    assert abs(drive.position - target) < 0.01


def test_the_servo_brakes_without_power_and_goes_on_from_there(machine) -> None:
    m = machine()
    drive = Drive(m, "servo.reference")
    m.set("go", True)
    m.set("target", 100.0)
    for _ in range(150):
        drive.scan()
    moving = drive.position
    m.set("go", False)
    for _ in range(400):
        drive.scan()
    assert moving < drive.position < 60 and m.get("servo.reference") == 0 and not m.get("servo.done")
    m.set("go", True)
    for _ in range(800):
        drive.scan()
    assert m.get("servo.done") and abs(drive.position - 100) < 0.05


@pytest.mark.parametrize("start, target", [(0.0, 350.0), (350.0, 0.0), (0.0, 10.0)])
def test_the_valve_closes_by_its_lead_before_the_target(machine, start: float, target: float) -> None:
    m, position, way = machine(), start, 1 if target > start else -1
    m.set("go", True)
    m.set("target", target)
    creeps, fastest, scans = 0, 0.0, 0
    while not m.get("valve.done"):
        position += m.get("valve.reference") * DT
        m.set("measured", position)
        m.scan()
        speed = way * m.get("valve.reference")
        assert speed >= 0
        creeps += speed == 25.0
        fastest, scans = max(fastest, speed), scans + 1
        assert scans < 4000
    assert m.get("valve.reference") == 0
    assert way * (target - position) == pytest.approx(25.0 * (0.022 + DT / 2), abs=25.0 * DT)
    if abs(target - start) > 100:
        assert fastest == 320.0 and creeps >= 500
