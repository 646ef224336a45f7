"""The components that come with ldc, each against something that knows better: ruckig for the axis, formulas
for filters, properties for the controller."""

from __future__ import annotations

import math
from functools import cache

import pytest
import ruckig
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc import pipeline
from ldc.components import host
from ldc.diagnostics import Diagnostics
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile
from runtime.vm.machine import Machine


@cache
def compiled(type_: str, pins: str, globals_: str = ""):
    """A program with one instance ``c`` of a component; its pins are wired to variables of their names."""
    names = [name.strip().split(":") for name in pins.split(",") if name.strip()]
    declared = "\n".join(f"{name.strip()} : {kind.strip()};" for name, kind in names)
    wired = ", ".join(f"{name.strip()} := {name.strip()}" for name, _ in names)
    text = (f"{globals_}PROGRAM main\nVAR\ngo : BOOL;\nc : {type_};\n{declared}\nEND_VAR\n"
            f"RUNG [go] <c: {type_}({wired})>\nEND_PROGRAM\n")
    result = pipeline.compile_project(Sources((SourceFile("main.ld", text),), Settings(), None))
    assert not result.diagnostics.has_errors, [f"{d.code} {d.message}" for d in result.diagnostics]
    found = Diagnostics()
    bindings = tuple(host.build(n, tuple(result.model.globals.values()), found) for n in result.natives)
    assert not found.has_errors, [d.message for d in found]
    return result.program, bindings


def machine(type_: str, pins: str = "", period_ns: int = 1_000_000, globals_: str = "", **values) -> Machine:
    program, bindings = compiled(type_, pins, globals_)
    made = Machine(program, period_ns=period_ns, bindings=bindings)
    for name, value in values.items():
        made.set(name, value)
    return made


AXIS = "target : LREAL, max_velocity : LREAL, max_acceleration : LREAL, max_jerk : LREAL"
limits = st.tuples(st.floats(5, 500), st.floats(50, 5000), st.floats(500, 100_000))


@settings(max_examples=20, deadline=None)
@given(st.floats(-400, 400).filter(lambda d: abs(d) > 1e-3), limits)
def test_the_axis_takes_the_time_and_the_way_that_ruckig_finds(distance: float, limit: tuple) -> None:
    velocity, acceleration, jerk = limit
    given_ = ruckig.InputParameter(1)
    given_.target_position = [distance]
    given_.max_velocity, given_.max_acceleration, given_.max_jerk = [velocity], [acceleration], [jerk]
    best = ruckig.Trajectory(1)
    assert ruckig.Ruckig(1).calculate(given_, best) == ruckig.Result.Working
    period = 1e-3
    m = machine("AXIS_SCURVE", AXIS, target=distance, max_velocity=velocity, max_acceleration=acceleration,
                max_jerk=jerk, go=True)
    scans = min(int(best.duration / period) + 3, 800)
    m.scan()
    for number in range(1, scans):
        m.scan()
        position, speed, acc = (value[0] for value in best.at_time(min(number * period, best.duration)))
        assert m.get("c.position") == pytest.approx(position, rel=1e-6, abs=1e-6 * velocity)
        assert m.get("c.velocity") == pytest.approx(speed, rel=1e-6, abs=1e-5 * velocity)
        assert m.get("c.acceleration") == pytest.approx(acc, rel=1e-6, abs=1e-5 * acceleration + jerk * 1e-8)
        if number * period < best.duration - period:
            assert m.get("c.moving") and not m.get("c.done")
    if scans < 800:
        assert m.get("c.done") and m.get("c.position") == distance and not m.faults


@settings(max_examples=15, deadline=None)
@given(st.lists(st.tuples(st.integers(1, 60), st.floats(-50, 50), st.booleans()), min_size=1, max_size=6), limits)
def test_limits_hold_whatever_the_target_does(commands: list, limit: tuple) -> None:
    velocity, acceleration, jerk = limit
    m = machine("AXIS_SCURVE", AXIS, max_velocity=velocity, max_acceleration=acceleration, max_jerk=jerk)
    period, before = 1e-3, (0.0, 0.0, 0.0)
    for scans, target, enabled in commands:
        m.set("target", target)
        m.set("go", enabled)
        for _ in range(scans):
            m.scan()
            x, v, a = (m.get(f"c.{name}") for name in ("position", "velocity", "acceleration"))
            assert abs(v) <= velocity * (1 + 1e-9) and abs(a) <= acceleration * (1 + 1e-9)
            assert abs(a - before[2]) <= jerk * period * (1 + 1e-6) + 1e-9 * acceleration
            assert abs(v - before[1]) <= acceleration * period * (1 + 1e-6) + 1e-9
            assert abs(x - before[0]) <= velocity * period * (1 + 1e-6) + 1e-9
            before = x, v, a
    m.set("go", False)
    for _ in range(20_000):
        m.scan()
        if not m.get("c.moving"):
            break
    assert (m.get("c.moving"), m.get("c.velocity"), m.get("c.acceleration")) == (False, 0.0, 0.0)


PID = ("setpoint : REAL, actual : REAL, manual : BOOL, manual_value : REAL, kp : REAL, ti : REAL, td : REAL, "
       "tf : REAL, low : REAL, high : REAL")


def pid(**values) -> Machine:
    usual = {"kp": 2.0, "ti": 0.0, "td": 0.0, "tf": 0.0, "low": -100.0, "high": 100.0, "go": True}
    return machine("PID", PID, 10_000_000, **{**usual, **values})


def test_the_parts_of_the_controller_are_those_of_the_formula() -> None:
    m = pid(setpoint=3.0, actual=1.0)
    m.scan()
    assert m.get("c.output") == 4.0
    m = pid(setpoint=3.0, actual=1.0, ti=0.5)
    for _ in range(51):
        m.scan()
    assert m.get("c.output") == pytest.approx(4.0 + 4.0 * 0.5 / 0.5, rel=1e-5)
    m = pid(td=0.1)
    for number in range(5):  # actual rises by 1 a second
        m.set("actual", number * 0.01)
        m.scan()
    assert m.get("c.output") == pytest.approx(2.0 * -0.04 - 2.0 * 0.1, rel=1e-4)


def test_a_process_is_brought_to_the_setpoint_without_windup() -> None:
    m = pid(setpoint=50.0, kp=4.0, ti=1.5, low=0.0)
    actual, peak = 0.0, 0.0
    for number in range(3000):
        m.set("actual", actual)
        m.scan()
        actual += (m.get("c.output") * 0.8 - actual) * 0.01 / 2.0
        peak = max(peak, actual)
    assert actual == pytest.approx(50.0, abs=0.05)
    assert peak < 55.0, "an integral part that had run on at the limit would overshoot"


def test_at_the_limit_the_integral_part_stands_still() -> None:
    m = pid(setpoint=1000.0, ti=0.1)
    for _ in range(500):
        m.scan()
    assert (m.get("c.output"), m.get("c.limited")) == (100.0, True)
    m.set("setpoint", -1.0)
    m.scan()
    assert m.get("c.output") < 100.0, "it leaves the limit at once"


def test_from_manual_to_automatic_there_is_no_bump() -> None:
    m = pid(setpoint=10.0, actual=8.0, ti=2.0, manual=True, manual_value=42.0)
    for _ in range(20):
        m.scan()
    assert m.get("c.output") == 42.0
    m.set("manual", False)
    m.scan()
    assert m.get("c.output") == pytest.approx(42.0, abs=0.1)
    m.set("go", False)
    m.scan()
    assert (m.get("c.output"), m.get("c.ENO")) == (0.0, False)


def test_a_sensor_that_is_no_number_is_told_and_the_output_stays() -> None:
    m = pid(setpoint=10.0, actual=8.0)
    m.scan()
    m.set("actual", math.nan)
    m.scan()
    assert (m.get("c.output"), m.get("c.error"), m.get("c.ENO")) == (4.0, 6, False)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.floats(-1000, 1000, width=32), min_size=1, max_size=40), st.integers(1, 12))
def test_the_moving_average_is_the_mean_of_the_last_values(values: list[float], window: int) -> None:
    m = machine("MOVING_AVERAGE", "input : REAL, window : UINT", window=window, go=True)
    for number, value in enumerate(values):
        m.set("input", value)
        m.scan()
        last = values[max(0, number + 1 - window): number + 1]
        assert m.get("c.output") == pytest.approx(sum(last) / len(last), rel=1e-5, abs=1e-3)
    m.set("go", False)
    m.scan()
    assert m.get("c.output") == values[-1]


@pytest.mark.parametrize("period", (1_000_000, 10_000_000, 50_000_000))
def test_the_low_pass_reaches_63_percent_after_its_time_constant_at_any_scan_time(period: int) -> None:
    m = machine("LOW_PASS", "input : REAL, time_constant : REAL", period, time_constant=0.5, go=True)
    m.scan()
    m.set("input", 1.0)
    for _ in range(500_000_000 // period):
        m.scan()
    assert m.get("c.output") == pytest.approx(1 - math.exp(-1), abs=1e-5)


def test_debouncing_takes_what_is_steady() -> None:
    m = machine("DEBOUNCE", "delay : TIME", 10_000_000, delay="T#30ms")
    seen = []
    for on in (1, 0, 1, 1, 1, 1, 1, 0, 1, 0, 0, 0, 0, 0):
        m.set("go", bool(on))
        m.scan()
        seen.append(int(m.get("c.output")))
    assert seen == [0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0]


def test_the_ramp_has_two_slopes() -> None:
    m = machine("RAMP", "target : REAL, rise : REAL, fall : REAL", 10_000_000, target=3.0, rise=100.0,
                fall=200.0, go=True)
    seen = []
    for number in range(8):
        m.set("go", number < 5)
        m.scan()
        seen.append((m.get("c.value"), m.get("c.reached")))
    assert [v for v, _ in seen] == pytest.approx([0, 1, 2, 3, 3, 1, 0, 0], abs=1e-5)
    assert [r for _, r in seen] == [False, False, False, True, True, False, False, False]


def test_jog_has_no_pins_and_writes_the_memory_that_it_names() -> None:
    globals_ = "VAR_GLOBAL\njog_speed, jog_pressure : REAL;\nEND_VAR\n"
    m = machine("JOG", globals_=globals_, go=True)
    m.scan()
    assert (m.get("jog_speed"), m.get("jog_pressure")) == (20.0, 40.0)
    m.set("go", False)
    m.scan()
    assert (m.get("jog_speed"), m.get("jog_pressure")) == (0.0, 0.0)
    m.set("jog_speed", 5.0)
    m.scan()
    assert m.get("jog_speed") == 5.0, "another one may drive the axis now"
