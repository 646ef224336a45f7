"""The injection machine whole: its trace on each engine, the paper's programs 1 and 2, what it does when
something is wrong, and the figures of its report over a few cycles (SPEC 11.3, 12.1).
"""

from __future__ import annotations

import csv
import io
import re
import shutil
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest
from systems import Run

from ldc import pipeline
from ldc.cli.main import main

SAMPLE = Path(__file__).resolve().parents[1] / "samples" / "injection_machine"
sys.path.insert(0, str(SAMPLE))
import report  # noqa: E402
import runs  # noqa: E402

ENGINES = pytest.mark.parametrize("engine", ["vm", "native"])


@dataclass(frozen=True)
class Seen:
    """A run: rows of its trace and of its events."""

    trace: list[dict[str, str]]
    events: list[dict[str, str]]

    def times(self, name: str, value: str = "1") -> list[float]:
        """When a variable became that (ms)."""
        was, found = None, []
        for row in self.trace:
            if row[name] == value != was:
                found.append(float(row["t_ms"]))
            was = row[name]
        return found

    def starts(self, module: int) -> list[float]:
        return [float(e["t_ms"]) for e in self.events if (e["unit"], e["index"]) == ("C.START", str(module))]


@pytest.fixture
def run(tmp_path: Path) -> Callable[..., Seen]:
    """``run(scans, watch, engine, inputs, edit)``: a copy of the sample, with files changed by ``edit``."""

    def go(scans: int, watch: str, engine: str = "vm", inputs: str | None = None,
           edit: dict[str, list[tuple[str, str]]] | None = None) -> Seen:
        folder = tmp_path / "machine"
        if not folder.exists():
            shutil.copytree(SAMPLE, folder, ignore=shutil.ignore_patterns("__pycache__"))
        for name, changes in (edit or {}).items():
            text = (folder / name).read_text()
            for old, new in changes:
                assert old in text, old
                text = text.replace(old, new)
            (folder / name).write_text(text)
        if inputs is not None:
            (folder / "inputs.csv").write_text(inputs)
        trace, events = tmp_path / "trace.csv", tmp_path / "events.csv"
        assert main(["run", str(folder), "--engine", engine, "--scans", str(scans), "--watch", watch,
                     "--trace", str(trace), "--events", str(events)]) == 0
        return Seen(*(list(csv.DictReader(io.StringIO(path.read_text()))) for path in (trace, events)))

    return go


def test_every_rung_is_proved() -> None:
    result = pipeline.compile_paths([str(SAMPLE)])
    assert not [d.message for d in result.diagnostics]
    assert {r.verdict.kind for rungs in result.units.values() for r in rungs} == {"proof"}


@ENGINES
def test_trace(engine: str, tmp_path: Path, golden_at) -> None:
    trace = tmp_path / "trace.csv"
    assert main(["run", str(SAMPLE), "--engine", engine, "--trace", str(trace)]) == 0
    golden_at(SAMPLE / "expected.csv", trace.read_text())


# ---- program 1: logic and motion in one design ---------------------------------------------------


def test_the_ejector_keeps_its_limits_and_its_position_and_nothing_else_changes(tmp_path: Path) -> None:
    made = runs.machine("slave")
    whole, plant, watched = runs.system(made, "machine", 1)
    for _ in range(1000):
        whole.scan()
    strokes = [at for _, axis, _, at in plant.journal if axis == "ejector"]
    assert strokes and all(abs(at) <= 0.1 for at in strokes)
    assert 0 < watched.most["velocity"] <= runs.LIMITS["velocity"]
    for name, limit in runs.LIMITS.items():
        assert watched.most[name] <= limit * report.ROUNDING
    folder = tmp_path / "without"
    shutil.copytree(SAMPLE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "ejector.ld").unlink()
    project = (folder / "ldc.toml").read_text()
    project = project.replace('"ejector", ', "").replace('    { module = "ejector" },\n', "")
    project = re.sub(r"\[messages\.part\].*?\n\n", "", project, flags=re.S)
    (folder / "ldc.toml").write_text(project)
    before = pipeline.compile_paths([str(folder)])
    assert not before.diagnostics.has_errors, [d.message for d in before.diagnostics]
    units = {u.name: u for u in made.result.program.units}
    others = [u for u in before.program.units if u.kind == "PROGRAM"]
    assert len(others) == 6
    for unit in others:
        assert [r.code for r in unit.rungs] == [r.code for r in units[unit.name].rungs]


def test_the_ejector_reaches_its_stroke(run) -> None:
    seen = run(850, "ejector.axis.position,ejector.was_out")
    at = next(float(row["ejector.axis.position"]) for row in seen.trace if row["ejector.was_out"] == "1")
    assert abs(at - 60.0) < 1.0
    furthest = max(float(row["ejector.axis.position"]) for row in seen.trace)
    assert abs(furthest - 60.0) <= 0.1


# ---- program 2: a message from clamp to injection ------------------------------------------------

BY_MESSAGE = ('    { module = "inject" },\n    { module = "charge" },\n',
              '    { module = "charge", when = "inject.done" },\n')


def message(source: str) -> tuple[str, str]:
    return "[messages.part]", f'[messages.closed]\nfrom = "{source}"\nto = ["inject"]\n\n[messages.part]'


@ENGINES
def test_injection_starts_by_message_when_the_clamp_has_locked(run, engine: str) -> None:
    seen = run(850, "mould_locked,inject.start,charge.start,cooling.start", engine,
               edit={"ldc.toml": [BY_MESSAGE, message("mould_locked")]})
    locked, = seen.times("mould_locked")
    injected, = seen.starts(1)
    assert 0 < injected - locked <= 10
    assert [e["unit"] for e in seen.events if e["t_ms"] == seen.trace[int(locked / 10)]["t_ms"]
            and e["unit"] in ("C.BCAST", "C.MSG")] == ["C.BCAST", "C.MSG"]
    # Those who did not subscribe take no notice, and the cycle goes on after injection.
    assert not any(row["cooling.start"] == "1" for row in seen.trace if float(row["t_ms"]) < injected + 1000)
    assert seen.starts(2)[0] > injected + 900


@ENGINES
def test_injection_can_overlap_with_high_pressure_behind_the_interlock(run, engine: str) -> None:
    """Variant (a): the flag at the end of mould protection. Injection may begin when the mould is touched."""
    seen = run(400, "mould_touched,mould_locked,inject.axis.enable,high_pressure", engine,
               edit={"ldc.toml": [BY_MESSAGE, message("mould_touched")],
                     "inject.ld": [("[start] [mould_locked] [/full]", "[start] [mould_touched] [/full]")]})
    touched, = seen.times("mould_touched")
    assert 0 < seen.starts(1)[0] - touched <= 10
    both = [row for row in seen.trace if row["high_pressure"] == row["inject.axis.enable"] == "1"
            and row["mould_locked"] == "0"]
    assert 150 <= 10 * len(both) <= 300


def test_injection_waits_for_the_interlock(run) -> None:
    seen = run(400, "mould_locked,inject.start,inject.axis.enable",
               edit={"ldc.toml": [BY_MESSAGE, message("mould_touched")]})
    locked = seen.times("mould_locked")[0]
    assert seen.times("inject.start")[0] < locked <= seen.times("inject.axis.enable")[0]


def test_a_module_that_is_started_again_at_once_sees_that_it_had_ended(run) -> None:
    """Without the ejector, closing follows opening: both are steps of one module."""
    seen = run(1000, "clamp.start,clamp.arrived,mould_locked,clamp.axis.position",
               edit={"ldc.toml": [('    { module = "ejector" },\n', "")]})
    assert len(seen.starts(0)) == len(seen.times("clamp.start")) == 3
    assert all(float(row["clamp.axis.position"]) < 2 for row in seen.trace if row["mould_locked"] == "1")
    assert seen.times("mould_locked")[1] - seen.starts(0)[2] > 1500


# ---- when something is wrong ---------------------------------------------------------------------


@ENGINES
def test_an_emergency_stop_ends_every_axis_within_a_scan_and_is_acknowledged(run, engine: str) -> None:
    inputs = ("scan,auto_switch,guard,motor_ok,estop,reset\n0,0,1,1,0,0\n2,1,,,,\n100,,,,1,\n160,,,,0,\n"
              "170,,,,,1\n171,,,,,0\n")
    seen = run(460, "red,clamp.axis.position,control.alarm,mould_locked,pump", engine, inputs)
    position = [float(row["clamp.axis.position"]) for row in seen.trace]
    assert position[98] - position[99] > 1
    assert max(position[102:160]) - min(position[102:160]) < 0.3
    assert {row["pump"] for row in seen.trace[101:170]} == {"0"}
    assert "1" in {row["red"] for row in seen.trace[102:170]}
    assert seen.trace[175]["control.alarm"] == "0"
    assert seen.times("mould_locked")[0] > 2000


def test_an_obstacle_in_the_mould_is_told_by_mould_protection(run) -> None:
    block = ("        for go_on in self.doing:\n", "        if self.axes[0].position < 10.0:\n"
             "            self.axes[0].position = 10.0\n        for go_on in self.doing:\n")
    seen = run(400, "low_pressure,clamp.blocked,red,control.automatic,high_pressure",
               edit={"plant.py": [block]})
    began, told = seen.times("low_pressure")[-1], seen.times("clamp.blocked")[0]
    assert told - began == pytest.approx(1500, abs=20)
    assert not seen.times("high_pressure")
    assert seen.times("control.automatic", "0")[-1] - told <= 20
    assert seen.times("red")


def test_buttons_move_the_clamp_in_manual_mode(run) -> None:
    inputs = ("scan,auto_switch,guard,motor_ok,close_button,open_button\n0,0,1,1,0,0\n5,,,,1,\n10,,,,0,\n"
              "250,,,,,1\n255,,,,,0\n")
    seen = run(480, "clamp.start,mould_locked,mould_open,inject.start,yellow", inputs=inputs)
    assert len(seen.times("clamp.start")) == 2
    assert 1800 < seen.times("mould_locked")[0] < 2400
    assert seen.times("mould_open")[0] > 4000
    assert not seen.times("inject.start")


def test_without_a_guard_nothing_closes(run) -> None:
    seen = run(100, "clamp.axis.position,control.automatic,clamp.axis.enable",
               inputs="scan,auto_switch,guard,motor_ok\n0,1,0,1\n")
    assert not seen.times("control.automatic") and not seen.times("clamp.axis.enable")


# ---- the figures of the report -------------------------------------------------------------------


def test_a_slave_at_1_ms_and_the_master_alone_run_the_same_cycle() -> None:
    found = {}
    for arrangement in runs.ARRANGEMENTS:
        result = runs.cycles(runs.machine(arrangement), "controller-limited", 3, 4)
        for phase, lengths in result.phases.items():
            assert lengths == pytest.approx([runs.PHASES[phase]] * 4, rel=0.12)
        assert all(len(errors) >= 4 and max(map(abs, errors)) < 1.0 for errors in result.errors.values())
        found[arrangement] = result
    assert found["slave"].most and not found["scan"].most
    errors = {a: sum(abs(e) for m in ("V/P switch-over", "mould open") for e in r.errors[m])
              for a, r in found.items()}
    assert errors["slave"] < errors["scan"]


def test_a_seed_gives_one_run_bit_for_bit_on_every_engine() -> None:
    made = runs.machine("slave")
    first = runs.cycles(made, "machine", 5, 1)
    assert first == runs.cycles(made, "machine", 5, 1) == runs.cycles(made, "machine", 5, 1, engine="native")
    assert first != runs.cycles(made, "machine", 6, 1)


def test_instants_of_plant_and_slave_alone_are_as_those_that_somebody_looks_at() -> None:
    """Who asks for what is there after every instant makes each of them one by itself."""
    found = []
    for seen in (True, False):
        run = Run(SAMPLE, watch=("clamp.axis.position", "clamp.done", "inject.start"), seen=seen)
        run.scans(150, guard=True, motor_ok=True, auto_switch=True)
        found.append((run.rows, run.events, run.system.rows(), bytes(run.system.shared)))
        assert bool(run.trace) is seen and len({row[0] for row in run.rows}) > 60
    assert found[0] == found[1]


def test_a_report_goes_on_where_it_was_interrupted(tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.setattr(runs, "cycles", lambda made, regime, seed, count, tell=None, engine="vm": runs.Result(
        {m: [0.1 * seed, -0.1] for m in runs.TARGETS}, {p: [s, s] for p, s in runs.PHASES.items()},
        dict(runs.LIMITS) if made == "slave" else {}))
    monkeypatch.setattr(runs, "machine", lambda arrangement: arrangement)
    monkeypatch.setattr(report, "start_up", lambda: [0.4, 0.5])
    kept, drawn = tmp_path / "runs.jsonl", tmp_path / "errors.svg"
    monkeypatch.setattr(sys, "argv", ["report.py", "--cycles", "2", "--keep", str(kept), "--at-most", "5"])
    assert report.main() == 0 and len(kept.read_text().splitlines()) == 5
    monkeypatch.setattr(sys, "argv", ["report.py", "--cycles", "2", "--keep", str(kept), "--svg", str(drawn)])
    assert report.main() == 0 and len(kept.read_text().splitlines()) == 32
    shown = capsys.readouterr().out
    assert "| machine | slave, 1 ms | 0.275 ±" in shown
    assert "NOT REACHED: (ii)" in shown and "- reached: (iii) cycle 8.000 s" in shown
    assert drawn.read_text().count("<circle") == 8
