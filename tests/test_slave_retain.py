"""What algorithms on slaves retain: state that the descriptor or the instance says, through saves, power cuts
and faults."""

from __future__ import annotations

import csv
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import native
import pytest

from ldc import pipeline
from ldc.diagnostics import Diagnostics
from runtime.checksum import value_of
from runtime.retain_file import Kept, Store
from ldc.types import ELEMENTARY

PROJECT = '[project]\nname = "meters"\n[processors]\nmaster = "master"\nslave1 = "slave"\n[run]\nperiod = "10ms"\n'
METER = """\
[component]
name = "METER"
id = "test.meter"
[provides]
outputs = [{{ name = "total", type = "DINT" }}, {{ name = "fresh", type = "DINT" }},
           {{ name = "drive", type = "DINT", local = true }}]
[properties]
state = [{{ name = "since", type = "DINT" }}, {{ name = "hours", type = "DINT", {retain} }},
         {{ name = "rows", type = "ARRAY [0..1, 1..2] OF INT", {retain} }}, {{ name = "last", type = "DINT" }}]
[function]
language = "{language}"
sources = ["meter.{suffix}"]
processor = "slave1"
period_us = 1000
"""
BODIES = {
    "c": '#include "meter.h"\nvoid meter(const meter_in *in, meter_out *out, meter_state *state, uint32_t dt)\n'
         "{\n    (void)dt;\n    if (in->enable) {\n        state->hours++;\n        state->since++;\n"
         "        state->rows[1][1] = (int16_t)-state->hours;\n    }\n"
         "    out->total = state->rows[1][1] == -state->hours ? state->hours : -1;\n"
         "    out->fresh = state->since;\n    out->drive = state->since;\n}\n",
    "st": "FUNCTION_BLOCK METER\nIF enable THEN\n    hours := hours + 1; since := since + 1;\n"
          "    rows[1, 2] := DINT_TO_INT(-hours);\nEND_IF;\n"
          "IF rows[1, 2] = DINT_TO_INT(-hours) THEN total := hours; ELSE total := -1; END_IF;\n"
          "fresh := since; drive := since;\nEND_FUNCTION_BLOCK\n",
}
MAIN = """\
PROGRAM main
VAR{qualifier}
    meter : METER;
END_VAR
RUNG
    <meter: METER()>
END_PROGRAM
"""
WATCH = "meter.total,meter.fresh"


def project(folder: Path, language: str, retain: str = "retain = true", qualifier: str = "") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "ldc.toml").write_text(PROJECT)
    (folder / "meter.ldc.toml").write_text(METER.format(retain=retain, language=language, suffix=language))
    (folder / f"meter.{language}").write_text(BODIES[language])
    (folder / "main.ld").write_text(MAIN.format(qualifier=qualifier))
    return folder


def command(folder: Path, *options: str) -> list[str]:
    return [sys.executable, "-m", "ldc.cli", "run", str(folder), "--watch", WATCH, "--trace", "-",
            "--retain", str(folder / "r.retain"), *options]


def ran(folder: Path, *options: str) -> tuple[tuple[int, int], str]:
    """Total and fresh of the last scan, and what was said."""
    done = subprocess.run(command(folder, *options), capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    row = list(csv.DictReader(done.stdout.splitlines()))[-1]
    return (int(row["meter.total"]), int(row["meter.fresh"])), done.stderr


LANGUAGES = pytest.mark.parametrize("language", [pytest.param("c", marks=native.needs_gcc), "st"])


@LANGUAGES
@pytest.mark.parametrize("engine", ["vm", pytest.param("native", marks=native.needs_gcc)])
def test_state_that_the_descriptor_retains_goes_on(tmp_path: Path, language: str, engine: str) -> None:
    folder = project(tmp_path, language)
    (total, fresh), _ = ran(folder, "--scans", "10", "--engine", engine)
    assert total == fresh > 50
    (again, since), said = ran(folder, "--scans", "10", "--engine", engine)
    assert since == fresh and again == 2 * total + (again - since - total)
    assert total < again - since <= total + 10, "what was executed after the last scan was saved too"
    assert "values of scan 10" in said and "dropped" not in said
    assert ran(folder, "--scans", "10", "--start", "cold", "--engine", engine)[0] == (total, fresh)


@LANGUAGES
def test_a_retained_instance_keeps_all_of_its_state(tmp_path: Path, language: str) -> None:
    folder = project(tmp_path, language, "retain = false", " RETAIN")
    (total, _), _ = ran(folder, "--scans", "10")
    (again, since), _ = ran(folder, "--scans", "10")
    assert again == since >= 2 * total
    plain = project(tmp_path / "plain", language, "retain = false")
    assert ran(plain, "--scans", "10")[0] == ran(plain, "--scans", "10")[0] == (total, total)


def test_state_stays_when_its_component_moves_to_the_master(tmp_path: Path) -> None:
    """Values are known by path and type, wherever they are executed."""
    folder = project(tmp_path, "st")
    (total, _), _ = ran(folder, "--scans", "10")
    descriptor = folder / "meter.ldc.toml"
    descriptor.write_text(descriptor.read_text().replace('"slave1"', '"master"').replace(", local = true", ""))
    (again, since), said = ran(folder, "--scans", "10")
    assert since == 10 and total < again - since <= total + 10, said


def test_timers_of_an_algorithm_keep_what_has_elapsed(tmp_path: Path) -> None:
    folder = project(tmp_path, "st")
    (folder / "meter.st").write_text(
        "FUNCTION_BLOCK METER\nVAR RETAIN wait : TON; END_VAR\nwait(IN := enable, PT := T#150ms);\n"
        "IF wait.Q THEN hours := 1; END_IF;\ntotal := hours; fresh := DINT#7;\nEND_FUNCTION_BLOCK\n")
    assert ran(folder, "--scans", "10")[0][0] == 0
    assert ran(folder, "--scans", "10")[0][0] == 1, "100 ms and 100 ms"


def test_a_fault_is_a_warm_restart_of_its_algorithm(tmp_path: Path) -> None:
    folder = project(tmp_path, "st")
    (folder / "meter.st").write_text(
        "FUNCTION_BLOCK METER\nVAR share : DINT := 5; END_VAR\nIF enable THEN hours := hours + 1; "
        "share := share - 1; fresh := 100 / share; END_IF;\ntotal := hours;\nEND_FUNCTION_BLOCK\n")
    with open(folder / "ldc.toml", "a") as file:
        file.write('[safety]\nreset = "reset"\n')
    (folder / "main.ld").write_text(MAIN.format(qualifier="\n    go AT %IX0.1 : BOOL; reset AT %IX0.0 : BOOL;")
                                    .replace("<meter", "[go] <meter"))
    (folder / "in.csv").write_text("scan,go,reset\n0,1,0\n5,0,0\n6,0,1\n8,1,0\n")
    done = subprocess.run(command(folder, "--scans", "12", "--inputs", str(folder / "in.csv")),
                          capture_output=True, text=True, timeout=60)
    totals = [int(row["meter.total"]) for row in csv.DictReader(done.stdout.splitlines())]
    assert "LD0801" in done.stderr and totals[4] <= 5 < totals[-1] <= 10, done.stdout + done.stderr


@LANGUAGES
def test_the_layout_of_the_file_covers_what_slaves_retain(tmp_path: Path, language: str) -> None:
    def layout(folder: Path) -> str:
        ran(folder, "--scans", "2")
        return kept(folder).layout

    one, two = project(tmp_path / "1", language), project(tmp_path / "2", language)
    text = (two / "meter.ldc.toml").read_text()
    (two / "meter.ldc.toml").write_text(text.replace('name = "hours", type = "DINT"',
                                                     'name = "hours", type = "UDINT"'))
    (two / f"meter.{language}").write_text(
        BODIES[language].replace("-hours", "-1").replace(":= hours;", ":= 1;"))
    digests = {pipeline.compile_paths([str(folder)]).image.layout.digest for folder in (one, two)}
    assert len(digests) == 1, "the master's own is the same"
    assert layout(one) != layout(two)
    (two / "r.retain").write_bytes((one / "r.retain").read_bytes())
    (two / "r.retain.before").unlink(missing_ok=True)
    _, said = ran(two, "--scans", "2")
    assert "LD0853" in said and "MAIN.METER.HOURS" in said


def kept(folder: Path) -> Kept:
    found = Diagnostics()
    saved = Store(folder / "r.retain").load(found)
    assert not len(found), "a torn file"
    return saved


def time_of_save(folder: Path) -> int:
    """0 while one file takes the name of the other."""
    try:
        return (folder / "r.retain").stat().st_mtime_ns
    except FileNotFoundError:
        return 0


def test_power_cuts_at_any_moment(tmp_path: Path) -> None:
    """kill -9 of a run again and again: no value is torn, none goes back, and runs go on from them."""
    folder, dice, reached = project(tmp_path, "st"), random.Random(7), 0
    ran(folder, "--scans", "2")
    for _ in range(6):
        before = time_of_save(folder)
        process = subprocess.Popen(command(folder, "--scans", "1000000", "--retain-every", "20ms"),
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        end = time.monotonic() + 20
        while time_of_save(folder) in (0, before) and time.monotonic() < end:
            time.sleep(0.005)
        time.sleep(dice.uniform(0, 0.05))
        os.kill(process.pid, signal.SIGKILL)
        process.wait()
        values = {entry.path: entry.data for entry in kept(folder).entries}
        hours = value_of(values["MAIN.METER.HOURS"], 0, ELEMENTARY["DINT"])[0]
        rows = values["MAIN.METER.ROWS"]
        assert hours > reached and int.from_bytes(rows[6:8], "little") == -hours & 0xFFFF
        reached = hours
