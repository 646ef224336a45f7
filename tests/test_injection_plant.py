"""The plant of the injection machine alone: its axes against the solution of their equation, its spread, its
seed.
"""

from __future__ import annotations

import importlib.util
import json
import math
import sys
from pathlib import Path
from random import Random
from statistics import fmean, stdev

import pytest

SAMPLE = Path(__file__).resolve().parents[1] / "samples" / "injection_machine"
MS = 1_000_000


def module(name: str):
    """A file of the sample as a module."""
    spec = importlib.util.spec_from_file_location(f"injection_{name}", SAMPLE / f"{name}.py")
    made = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = made
    spec.loader.exec_module(made)
    return made


class Points(dict):
    """A field of plain values."""

    def reader(self, path: str):
        self.setdefault(path, 0.0)
        return lambda: self[path]

    def readers(self, paths: list[str]):
        each = [self.reader(path) for path in paths]
        return lambda: tuple(read() for read in each)

    def writer(self, path: str):
        self[path] = 0.0
        return lambda value: self.__setitem__(path, value)


class Rig:
    """A plant and its clock. ``exact``: without noise and spread."""

    def __init__(self, seed: int = 1, exact: bool = False) -> None:
        parameters = json.loads((SAMPLE / "plant.json").read_text())
        regime = parameters["regimes"]["machine"]
        if exact:
            regime["gain_sd"] = 0.0
            regime["sensor"]["noise_mm"] = 0.0
            for drive in ("clamp", "inject", "charge"):
                regime[drive]["delay_sd_s"] = 0.0
        self.regime, self.points, self.now = regime, Points(), 0
        self.plant = module("plant").Plant(self.points, parameters, seed)

    def run(self, ms: int, **references: float) -> None:
        for drive, value in references.items():
            self.points[f"{drive}.axis.reference"] = value
        for _ in range(ms):
            self.now += MS
            self.plant.step(self.now, MS)

    def shows(self, drive: str) -> float:
        return self.points[f"{drive}.axis.measured"]


def test_its_random_numbers_are_those_of_the_standard_library() -> None:
    ours, theirs = module("plant").Noise(5), Random(5)
    assert [ours.gauss(1.5, 0.25) for _ in range(1001)] == [theirs.gauss(1.5, 0.25) for _ in range(1001)]


def test_an_axis_follows_the_solution_of_its_equation() -> None:
    rig = Rig(exact=True)
    clamp, lag, delay = rig.plant.axes[0], rig.regime["clamp"]["lag_s"], rig.regime["clamp"]["delay_s"]
    rig.run(100, clamp=-200.0)
    t = 0.1 - delay
    assert clamp.velocity == pytest.approx(-200 * (1 - math.exp(-t / lag)), rel=1e-9)
    assert clamp.position == pytest.approx(350 - 200 * (t - lag * (1 - math.exp(-t / lag))), abs=1e-9)


def test_what_a_stop_costs_is_velocity_times_delay_and_lag() -> None:
    rig = Rig(exact=True)
    rig.run(200, inject=-40.0)
    at, late = rig.plant.axes[1].position, 0.012 + 0.004
    rig.run(300, inject=0.0)
    when, axis, drive, rest = rig.plant.journal[-1]
    assert (axis, drive) == ("screw", "inject")
    assert rest - at == pytest.approx(-40.0 * late, abs=5e-4)
    assert rig.shows("inject") == pytest.approx(rest, abs=0.006)
    assert 200 * MS < when < 400 * MS


def test_the_same_screw_is_shown_to_all_its_drives() -> None:
    rig = Rig()
    rig.run(500, charge=20.0)
    assert rig.shows("charge") == rig.shows("inject") == rig.shows("suck_back") > 80


def test_valves_and_oil_spread_as_the_parameters_say() -> None:
    rig, ends = Rig(), []
    for _ in range(200):
        before = rig.plant.axes[0].position
        rig.run(100, clamp=-100.0)
        rig.run(150, clamp=0.0)
        ends.append(before - rig.plant.axes[0].position)
        rig.run(100, clamp=100.0)
        rig.run(150, clamp=0.0)
    # Start and stop are both delayed by 6 ms each, and the gain has 6 %.
    expected = math.hypot(100 * 0.006 * math.sqrt(2), 10 * 0.06)
    assert fmean(ends) == pytest.approx(10.0, abs=0.3)
    assert stdev(ends) == pytest.approx(expected, rel=0.2)


def test_melt_is_packed_while_there_is_pressure() -> None:
    rig, ends = Rig(), []
    for _ in range(60):
        rig.plant.axes[1].position = 14.0
        rig.points["%QD4"] = 50.0
        rig.run(400)
        rig.points["%QD4"] = 0.0
        rig.run(1)
        assert rig.plant.journal[-1][2] == "hold"
        ends.append(rig.plant.journal[-1][3] - 5.0)
    assert 0.08 < fmean(map(abs, ends)) < 0.15


def test_force_and_eye() -> None:
    rig = Rig()
    rig.points["%QX0.1"] = True
    rig.run(400)
    assert rig.points["%ID4"] > 1990
    rig.points["%QX0.1"] = False
    rig.run(1000)
    assert rig.points["%ID4"] == 0
    rig.run(300, ejector=200.0)
    assert rig.points["%IX1.0"] is True


def test_a_seed_gives_one_plant() -> None:
    def shown(seed: int) -> list[float]:
        rig, out = Rig(seed), []
        for _ in range(50):
            rig.run(4, inject=-50.0)
            out.append(rig.shows("inject"))
        return out

    assert shown(1) == shown(1) != shown(2)


def test_intervals_of_the_report() -> None:
    figures = module("figures")
    for freedom, quantile in ((7, 2.3646), (9, 2.2622), (15, 2.1314), (30, 2.0423)):
        assert figures.t_quantile(freedom) == pytest.approx(quantile, abs=0.001)
    found = figures.spread([0.19, 0.21, 0.20, 0.22, 0.18, 0.20, 0.21, 0.19])
    assert found.mean == pytest.approx(0.2) and found.half == pytest.approx(0.0109, abs=5e-4)
