"""`ldc run --realtime`: slaves that are lost and started anew, what they retain, and a program that is changed
meanwhile."""

from __future__ import annotations

import csv
import os
import random
import signal
import time
from pathlib import Path

import native
import pytest
from online_runtime import private
from systems import MODULE, REAL_TIME, modules, mover
from test_realtime import ONE, WATCH, family, gone, ran, running, wait_until
from test_slave_retain import kept, project, time_of_save

from ldc.cli.main import main
from ldc.types import ELEMENTARY
from runtime.checksum import value_of
from runtime.processors.states import BEGUN_ANEW

pytestmark = REAL_TIME


def pulses(folder: Path, *scans: int) -> str:
    """Inputs that acknowledge at these scans; under load one may come too early."""
    rows = "".join(f"{scan},1\n{scan + 10},0\n" for scan in scans)
    (folder / "in.csv").write_text(f"scan,reset\n{rows}")
    return str(folder / "in.csv")


@native.needs_gcc
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=lambda n: n.name)
def test_a_lost_slave_is_started_anew_at_a_reset(tmp_path: Path, number: int) -> None:
    """One that is dead and one that hangs. The master scans on, the other slave does not notice."""
    folder, trace = modules(tmp_path, ONE), tmp_path / "trace.csv"
    inputs = pulses(folder, 160, 320, 480)
    with running(folder, "--for", "4s", "--watch", WATCH, "--trace", str(trace), "--inputs", inputs) as process:
        slave = wait_until(lambda: family(process.pid).get("ldc slave1"))
        other = wait_until(lambda: family(process.pid).get("ldc slave2"))
        time.sleep(0.2)
        os.kill(slave, number)
        fresh = wait_until(lambda: (now := family(process.pid).get("ldc slave1")) != slave and now)
        assert gone(slave)
        # The list of children may leave one out while another one ends.
        wait_until(lambda: family(process.pid).get("ldc slave2") == other)
        said = process.communicate(timeout=40)[1]
    rows = list(csv.DictReader(trace.read_text().splitlines()))
    assert "slave1 was started anew" in said and process.returncode == 1
    assert "LD0845" in said or "LD0861" in said
    assert [float(rows[-1][f"{name}.axis.position"]) for name in ("first", "second")] == [60.0, 10.0], said
    assert len(rows) > 400 and gone(fresh)


@native.needs_gcc
def test_a_slave_that_was_lost_stays_away_without_a_reset(tmp_path: Path) -> None:
    with running(modules(tmp_path, ONE), "--for", "1500ms") as process:
        slave = wait_until(lambda: family(process.pid).get("ldc slave1"))
        os.kill(slave, signal.SIGKILL)
        time.sleep(0.5)
        assert "ldc slave1" not in family(process.pid) or gone(slave)
        assert "started anew" not in process.communicate(timeout=30)[1]


@native.needs_gcc
def test_a_slave_whose_component_crashes_in_every_start(tmp_path: Path) -> None:
    """Started anew again and again, it ends nothing but its module."""
    folder = modules(tmp_path, ONE)
    body = folder / "mover1.c"
    text = body.read_text()
    body.write_text(text[: text.rindex("}")] + "    if (out->position > 5.0f) *(volatile int *)0 = 1;\n}\n")
    rows, said = ran(folder, "--for", "3s", "--watch", WATCH, "--inputs", pulses(folder, 120, 300), status=1)
    assert said.count("slave1 was ended by SIGSEGV") >= 2 and "slave1 was started anew" in said, said
    assert rows[-1]["%QX0.1"] == "0" and len(rows) > 200


@native.needs_gcc
def test_a_slave_that_paused_for_long_executes_nothing_until_a_reset(tmp_path: Path) -> None:
    """It was given up meanwhile; nobody watches what it would go on with."""
    folder, trace = modules(tmp_path, ONE.replace("60.0", "90.0")), tmp_path / "trace.csv"
    with running(folder, "--for", "2500ms", "--watch", WATCH, "--trace", str(trace)) as process:
        slave = wait_until(lambda: family(process.pid).get("ldc slave1"))
        time.sleep(0.2)
        os.kill(slave, signal.SIGSTOP)
        time.sleep(0.8)
        os.kill(slave, signal.SIGCONT)
        said = process.communicate(timeout=30)[1]
    rows = list(csv.DictReader(trace.read_text().splitlines()))
    assert "slave1 goes on" in said
    assert 0.0 < float(rows[-1]["first.axis.position"]) < 90.0 and rows[-1]["first.start"] == "0"


# ---- what is retained ------------------------------------------------------------------------------------


def hours(folder: Path) -> int:
    values = {entry.path: entry.data for entry in kept(folder).entries}
    count = value_of(values["MAIN.METER.HOURS"], 0, ELEMENTARY["DINT"])[0]
    assert int.from_bytes(values["MAIN.METER.ROWS"][6:8], "little") == -count & 0xFFFF, "torn"
    return count


@pytest.mark.parametrize("language", [pytest.param("c", marks=native.needs_gcc), "st"])
def test_slaves_in_processes_of_their_own_retain(tmp_path: Path, language: str) -> None:
    folder = project(tmp_path, language)
    retain = ("--retain", str(folder / "r.retain"), "--watch", "meter.total,meter.fresh")
    rows, _ = ran(folder, "--for", "400ms", *retain)
    first = hours(folder)
    assert first >= int(rows[-1]["meter.total"]) > 10, "the last save has what came after the last scan"
    rows, said = ran(folder, "--for", "400ms", *retain)
    assert int(rows[-1]["meter.total"]) - int(rows[-1]["meter.fresh"]) == first, said
    assert hours(folder) > first and said.count("retain: ") == 1


def test_a_slave_that_is_started_anew_has_what_it_retains(tmp_path: Path) -> None:
    folder = project(tmp_path, "st")
    with open(folder / "ldc.toml", "a") as file:
        file.write('[safety]\nreset = "reset"\n')
    (folder / "main.ld").write_text(
        "PROGRAM main\nVAR\n    meter : METER; reset AT %IX0.0 : BOOL;\nEND_VAR\n"
        "RUNG\n    [/reset] <meter: METER()>\nEND_PROGRAM\n")
    trace = tmp_path / "trace.csv"
    with running(folder, "--for", "6s", "--watch", "meter.total,meter.fresh,meter.error", "--trace", str(trace),
                 "--inputs", pulses(folder, *range(120, 520, 80)), "--retain", str(folder / "r.retain"),
                 "--retain-every", "100ms") as process:
        slave = wait_until(lambda: family(process.pid).get("ldc slave1"))
        wait_until(lambda: (folder / "r.retain.before").exists())
        before = hours(folder)
        os.kill(slave, signal.SIGKILL)
        said = process.communicate(timeout=40)[1]
    last = list(csv.DictReader(trace.read_text().splitlines()))[-1]
    total, since = int(last["meter.total"]), int(last["meter.fresh"])
    assert "started anew" in said and last["meter.error"] != str(BEGUN_ANEW)
    assert 0 < since < total and total - since >= before, said
    assert hours(folder) >= total


def test_power_cuts_in_real_time(tmp_path: Path) -> None:
    """kill -9 of the run: its slaves end with it, no value is torn, none goes back."""
    folder, dice, reached = project(tmp_path, "st"), random.Random(3), 0
    for _ in range(3):
        before = time_of_save(folder)
        with running(folder, "--for", "60s", "--retain", str(folder / "r.retain"),
                     "--retain-every", "30ms") as process:
            wait_until(lambda: time_of_save(folder) not in (0, before))
            time.sleep(dice.uniform(0.05, 0.2))
            below = family(process.pid)
            process.kill()
        for pid in below.values():
            wait_until(lambda: gone(pid))
        assert hours(folder) > reached
        reached = hours(folder)


# ---- online change ---------------------------------------------------------------------------------------


@native.needs_gcc
@pytest.mark.parametrize("engine", ["vm", "native"])
def test_a_program_is_changed_while_slaves_execute(tmp_path: Path, monkeypatch, capsys, engine: str) -> None:
    """The algorithm that moves goes on, by the same process; changes of algorithms are refused."""
    folder = modules(tmp_path, ONE.replace("60.0", "90.0"))
    monkeypatch.chdir(folder)
    with private(monkeypatch), running(folder, "--online", "--for", "60s", "--engine", engine) as process:
        slave = wait_until(lambda: family(process.pid).get("ldc slave1"))
        wait_until(lambda: Path(os.environ["LDC_SOCKET"]).exists())
        second = (folder / "second.ld").read_text()
        (folder / "second.ld").write_text(
            second.replace("    arrived : BOOL;", "    arrived : BOOL;\n    scans   : DINT;").replace(
                "RUNG move", "RUNG count\n    <ADD(IN1 := scans, IN2 := 1, OUT => scans)>\n\nRUNG move"))
        assert main(["online", "stage"]) == 0
        assert main(["online", "test"]) == 0
        assert main(["online", "commit"]) == 0
        capsys.readouterr()
        wait_until(lambda: value(capsys, "second.scans") > 5)
        assert value(capsys, "first.axis.position") > 0
        wait_until(lambda: value(capsys, "first.axis.position") == 90)
        wait_until(lambda: family(process.pid).get("ldc slave1") == slave)
        mover(folder, "MOVER9", 2, 2000)
        (folder / "third.ld").write_text(MODULE.format(name="third", mover="MOVER9", number=5))
        text = (folder / "ldc.toml").read_text()
        (folder / "ldc.toml").write_text(text.replace('"second"]\n[proc', '"second", "third"]\n[proc'))
        assert main(["online", "stage"]) == 1
        assert "LD0862" in (said := capsys.readouterr().err) and "third.axis" in said
        assert main(["online", "status"]) == 0
        assert "state    running" in capsys.readouterr().out
        process.send_signal(signal.SIGTERM)
        said = process.communicate(timeout=30)[1]
    assert process.returncode == 0 and "lateness in us" in said and "online change" in said, said


def value(capsys, path: str) -> float:
    assert main(["online", "get", path]) == 0
    return float(capsys.readouterr().out.split()[-1])


def test_a_fault_in_a_test_is_undone_in_real_time(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    text = ("PROGRAM main\nVAR n, m, zero : DINT; END_VAR\nRUNG count\n    <ADD(IN1 := n, IN2 := 1, OUT => n)>\n"
            "END_PROGRAM\n")
    (tmp_path / "main.ld").write_text(text)
    with private(monkeypatch), running(tmp_path / "main.ld", "--online", "--for", "60s") as process:
        wait_until(lambda: Path(os.environ["LDC_SOCKET"]).exists())
        (tmp_path / "main.ld").write_text(text.replace(
            "RUNG count", "RUNG bad\n    <MOVE(IN := 1 / zero, OUT => m)>\n\nRUNG count"))
        assert main(["online", "stage", "main.ld"]) == 0
        main(["online", "test", "main.ld"])
        wait_until(lambda: main(["online", "status", "main.ld"]) == 0 and "reverted" in capsys.readouterr().out)
        process.send_signal(signal.SIGINT)
        said = process.communicate(timeout=30)[1]
    assert "reverted: division by zero" in said and process.returncode == 0
