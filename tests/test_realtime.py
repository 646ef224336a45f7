"""`ldc run --realtime`: processes, what they note of their time, and what becomes of the rest when one is
lost.

Nothing here asks for a time to be kept, for the machine may be busy: that scans went on, were counted, and
what they did.
"""

from __future__ import annotations

import csv
import math
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree

import native
import pytest
from hypothesis import given
from hypothesis import strategies as st
from systems import DIVIDER, REAL_TIME, modules

from ldc.cli.main import main
from runtime.protocol.check import Code
from runtime.realtime import processes
from runtime.realtime.lateness import WORDS, Lateness
from runtime.realtime.pace import Pace

pytestmark = REAL_TIME
ENGINES = pytest.mark.parametrize("engine", ["vm", pytest.param("native", marks=native.needs_gcc)])
BLINK = ("PROGRAM main\nVAR\n    lamp AT %QX0.0 : BOOL;\n    wait : TON;\n    stop AT %IX0.0 : BOOL;\n"
         "END_VAR\n"
         "RUNG\n    [/lamp] [/stop] <wait: TON(PT := T#20ms)> (lamp)\nEND_PROGRAM\n")
ONE = ('[sequence]\nrepeat = false\n'
       'steps = [{ module = "first", parameters = { target = 60.0 } }, "second"]\n'
       '[safety]\nestop = "estop"\nreset = "reset"\n[run]\nperiod = "5ms"\n')
WATCH = "first.start,first.axis.position,first.axis.error,second.axis.position,%QX0.1"


def command(source: Path, *options: str) -> list[str]:
    return [sys.executable, "-m", "ldc.cli", "run", str(source), "--realtime", *options]


def ran(source: Path, *options: str, status: int = 0) -> tuple[list[dict[str, str]], str]:
    """The rows of the trace, and what was said."""
    done = subprocess.run(command(source, "--trace", "-", *options), capture_output=True, text=True,
                          timeout=60)
    assert done.returncode == status, done.stderr
    return list(csv.DictReader(done.stdout.splitlines())), done.stderr


@contextmanager
def running(source: Path, *options: str) -> Iterator[subprocess.Popen]:
    process = subprocess.Popen(command(source, *options), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True, start_new_session=True)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def family(pid: int) -> dict[str, int]:
    """The processes below one, by the names that `ps` shows."""
    found = {}
    for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
        try:
            found[Path(f"/proc/{child}/comm").read_text().strip()] = int(child)
            found |= family(int(child))
        except (FileNotFoundError, ProcessLookupError):
            continue
    return found


def wait_until(condition, seconds: float = 20.0):
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.01)
    return found


def gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
    except FileNotFoundError:
        return True


@given(st.lists(st.integers(0, 2**34 - 1), min_size=1, max_size=200), st.floats(0.01, 1.0))
def test_figures_are_those_of_the_values(values: list[int], share: float) -> None:
    """At most a quarter too high; nothing below 1 us is told apart."""
    lateness = Lateness(memoryview(bytearray(8 * WORDS)).cast("Q"))
    for n, value in enumerate(values):
        lateness.add(value, n % 3)
    figures = lateness.figures()
    exact = sorted(values)[math.ceil(share * len(values)) - 1]
    assert (figures.count, figures.most_ns) == (len(values), max(values))
    assert figures.missed == sum(n % 3 for n in range(len(values)))
    assert exact <= figures.quantile(share) <= max(1.25 * exact, 1280)
    rows = figures.rows()
    assert sum(count for _, _, count in rows) == len(values) and rows[0][2] and rows[-1][2]
    assert all(any(low <= value < high for low, high, _ in rows) for value in values)


def test_missed_periods_are_left_out_and_counted() -> None:
    lateness = Lateness(memoryview(bytearray(8 * WORDS)).cast("Q"))
    pace = Pace(2_000_000, lateness)
    pace.begin(time.monotonic_ns())
    pace.wait()
    first = pace.now_ns
    time.sleep(0.011)
    missed = pace.wait()
    assert first % 2_000_000 == pace.now_ns % 2_000_000 == 0
    assert missed >= 4 and pace.now_ns == first + (missed + 1) * 2_000_000
    assert lateness.figures().missed >= missed and lateness.figures().most_ns >= 2_000_000 * missed


@ENGINES
def test_a_program_alone_does_what_it_does_in_virtual_time(tmp_path: Path, engine: str) -> None:
    """A scan that was missed is missing in the time of the trace too: timers measure the real one."""
    source = tmp_path / "blink.ld"
    source.write_text(BLINK)
    inputs = tmp_path / "inputs.csv"
    inputs.write_text("scan,stop\n30,1\n")
    rows, said = ran(source, "--scans", "40", "--period", "5ms", "--engine", engine, "--inputs", str(inputs))
    assert [int(row["scan"]) for row in rows] == list(range(40))
    times = [float(row["t_ms"]) for row in rows]
    assert all(b - a >= 5 and (b - a) % 5 == 0 for a, b in zip(times, times[1:]))
    missed = int(re.search(r"^master +5 +40 +(\d+)", said, re.M)[1])
    assert (times[-1] - times[0]) / 5 - 39 <= missed
    assert [row["stop"] for row in rows] == ["0"] * 30 + ["1"] * 10
    assert {row["lamp"] for row in rows[:30]} == {"0", "1"} and {row["lamp"] for row in rows[30:]} == {"0"}
    assert "lateness in us" in said


@native.needs_gcc
@ENGINES
def test_modules_with_algorithms_on_two_slaves(tmp_path: Path, engine: str) -> None:
    rows, said = ran(modules(tmp_path, ONE), "--for", "1500ms", "--watch", WATCH, "--engine", engine)
    assert [float(rows[-1][f"{name}.axis.position"]) for name in ("first", "second")] == [60.0, 10.0]
    moved = [row for row in rows if 0.0 < float(row["first.axis.position"]) < 60.0]
    assert len(moved) > 5 and all(row["second.axis.position"] == "0.0" for row in moved)
    for name, period in (("master", 5), ("slave1", 1), ("slave2", 1)):
        assert int(re.search(rf"^{name} +{period} +(\d+) ", said, re.M)[1]) > 20


@native.needs_gcc
def test_the_first_scan_waits_until_all_processes_are_there(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """A busy computer lets a new process wait; a slave that is missing at the start would be given up."""
    claim, trace = processes.claim, tmp_path / "trace.csv"

    def late(cpu: int | None) -> list[str]:
        if Path("/proc/self/comm").read_text().startswith("ldc slave"):
            time.sleep(0.7)
        return claim(cpu)

    monkeypatch.setattr(processes, "claim", late)
    assert main(["run", str(modules(tmp_path, ONE)), "--realtime", "--scans", "300", "--watch", WATCH,
                 "--trace", str(trace)]) == 0, capsys.readouterr().err
    rows = list(csv.DictReader(trace.read_text().splitlines()))
    assert float(rows[-1]["first.axis.position"]) == 60.0


@native.needs_gcc
def test_an_emergency_reaches_slaves_without_a_transfer(tmp_path: Path) -> None:
    folder = modules(tmp_path, ONE)
    (folder / "inputs.csv").write_text("scan,estop\n60,1\n")
    rows, _ = ran(folder, "--scans", "120", "--watch", WATCH, "--inputs", str(folder / "inputs.csv"))
    assert 0.0 < float(rows[80]["first.axis.position"]) == float(rows[-1]["first.axis.position"]) < 60.0
    assert rows[55]["%QX0.1"] == "1" and rows[-1]["%QX0.1"] == rows[-1]["first.start"] == "0"


@native.needs_gcc
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=lambda n: n.name)
def test_a_slave_that_is_lost_ends_its_module_and_nothing_else(tmp_path: Path, number: int) -> None:
    """P finds it, by T_ack; the outputs of its module are safe, the master scans on."""
    folder, trace = modules(tmp_path, ONE), tmp_path / "trace.csv"
    with running(folder, "--for", "1500ms", "--watch", WATCH, "--trace", str(trace)) as process:
        slave = wait_until(lambda: family(process.pid).get("ldc slave1"))
        time.sleep(0.3)
        os.kill(slave, number)
        said = process.communicate(timeout=30)[1]
    assert trace.exists(), said
    rows = list(csv.DictReader(trace.read_text().splitlines()))
    assert ("slave1 was ended by SIGKILL" if number == signal.SIGKILL else "slave1 does not go on") in said
    assert process.returncode == 1
    last = rows[-1]
    assert int(last["first.axis.error"]) == Code.SILENT and last["first.start"] == last["%QX0.1"] == "0"
    assert 0.0 < float(last["first.axis.position"]) < 60.0 and len(rows) > 100
    assert gone(slave)


@native.needs_gcc
@pytest.mark.parametrize(("line", "end"), [
    ("*(volatile int *)0 = 1;", "slave1 was ended by SIGSEGV"), ("for (;;) { }", "slave1 does not go on")])
def test_what_a_component_breaks_is_broken_on_its_slave_alone(tmp_path: Path, line: str, end: str) -> None:
    folder = modules(tmp_path, ONE)
    body = folder / "mover1.c"
    text = body.read_text()
    body.write_text(text[: text.rindex("}")] + f"    if (out->position > 20.0f) {line}\n}}\n")
    rows, said = ran(folder, "--for", "1s", "--watch", WATCH, status=1)
    assert end in said and "LD0805" not in said
    assert int(rows[-1]["first.axis.error"]) == Code.SILENT and rows[-1]["%QX0.1"] == "0"
    assert 0.0 < float(rows[-1]["first.axis.position"]) <= 20.5


@native.needs_gcc
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL, signal.SIGTERM], ids=lambda n: n.name)
def test_the_end_of_the_run_is_that_of_all_its_processes(tmp_path: Path, number: int) -> None:
    """Ctrl-C reaches the whole group, SIGTERM and SIGKILL the one process that they are sent to; but for the
    last, the run ends in good order."""
    with running(modules(tmp_path, ONE), "--for", "60s") as process:
        wait_until(lambda: "ldc slave2" in family(process.pid))
        below = family(process.pid)
        (os.killpg if number == signal.SIGINT else os.kill)(process.pid, number)
        said = process.communicate(timeout=30)[1]
        for pid in below.values():
            wait_until(lambda: gone(pid))
    assert ("lateness in us" in said) == (number != signal.SIGKILL)
    assert process.returncode == (-number if number == signal.SIGKILL else 0), said


def test_a_plant_has_a_process_of_its_own_and_its_fault_ends_the_run(tmp_path: Path) -> None:
    (tmp_path / "ldc.toml").write_text(
        '[project]\nmodules = ["main"]\n[plant]\nfile = "plant.py"\n[run]\nperiod = "5ms"\n')
    (tmp_path / "main.ld").write_text(
        "PROGRAM main\nVAR\n    near AT %IX0.0 : BOOL;\n    drive AT %QX0.0 : BOOL;\nEND_VAR\n"
        "RUNG\n    [/near] (drive)\nEND_PROGRAM\n")
    plant = ("class Plant:\n    def __init__(self, field, parameters, seed):\n"
             "        self.drive, self.near, self.way = field.reader('%QX0.0'), field.writer('%IX0.0'), 0\n"
             "    def step(self, now_ns, dt_ns):\n        self.way += dt_ns if self.drive() else 0\n"
             "        self.near(self.way >= 50_000_000)\n")
    (tmp_path / "plant.py").write_text(plant)
    rows, said = ran(tmp_path, "--scans", "60", "--watch", "near,drive")
    assert (rows[2]["drive"], rows[-1]["drive"], rows[-1]["near"]) == ("1", "0", "1")
    assert re.search(r"^plant +1 +\d+", said, re.M)
    (tmp_path / "plant.py").write_text(
        plant + "        if self.way > 20_000_000: raise ValueError('jammed')\n")
    rows, said = ran(tmp_path, "--scans", "4000", "--watch", "near,drive", status=1)
    assert len(rows) < 2000 and "LD0842" in said and "jammed" in said and "Traceback" not in said


def test_retain_forces_and_ring_are_attached_once(tmp_path: Path) -> None:
    source, kept, ring = tmp_path / "blink.ld", tmp_path / "blink.retain", tmp_path / "ring.csv"
    source.write_text(BLINK.replace("main\nVAR", "main\nVAR RETAIN"))
    options = ("--period", "5ms", "--retain", str(kept), "--force", "stop=1",
               "--ring", str(ring), "--trigger", "stop = 1", "--before", "1", "--after", "1")
    ran(source, "--scans", "4", *options)
    rows, said = ran(source, "--scans", "4", *options)
    assert said.count("retain: ") == said.count("still forced: ") == said.count("ring: ") == 1
    assert "ring: triggered in scan 0, 2 rows" in said and len(rows) == 4
    assert len(list(csv.DictReader(ring.read_text().splitlines()))) == 2


def test_a_picture_of_the_lateness(tmp_path: Path) -> None:
    source, picture = tmp_path / "blink.ld", tmp_path / "late.svg"
    source.write_text(BLINK)
    ran(source, "--scans", "20", "--period", "1ms", "--plot", str(picture))
    root = ElementTree.fromstring(picture.read_bytes())
    texts = " ".join(root.itertext())
    assert root.tag.endswith("svg") and "master, 1 ms: 20 periods" in texts and " us: " in texts


@pytest.mark.parametrize(("options", "status", "said"), [
    (("--plot", "late.pdf"), 2, ".svg or .png"), (("--online", "--no-wait"), 2, "--no-wait"),
    (("--target", "cortex-m3"), 2, "this computer"),
])
def test_options_that_mean_nothing_together(tmp_path: Path, options, status, said) -> None:
    source = tmp_path / "blink.ld"
    source.write_text(BLINK)
    assert said in ran(source, "--scans", "2", *options, status=status)[1]


def test_png_needs_matplotlib_or_says_so(tmp_path: Path) -> None:
    source, picture = tmp_path / "blink.ld", tmp_path / "late.png"
    source.write_text(BLINK)
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        assert "ldc[plot]" in ran(source, "--scans", "2", "--plot", str(picture), status=1)[1]
        assert not picture.exists()
        return
    ran(source, "--scans", "2", "--period", "1ms", "--plot", str(picture))
    assert picture.read_bytes().startswith(b"\x89PNG")


@native.needs_gcc
def test_sigterm_to_all_processes_ends_a_run_in_order(tmp_path: Path) -> None:
    """As a service manager sends it: no slave is lost by it."""
    with running(modules(tmp_path, ONE), "--for", "60s") as process:
        wait_until(lambda: "ldc slave2" in family(process.pid))
        time.sleep(0.5)
        os.killpg(process.pid, signal.SIGTERM)
        _, err = process.communicate(timeout=30)
    assert process.returncode == 0 and "was ended by" not in err and re.search("^slave2 ", err, re.M), err


@native.needs_gcc
def test_the_watchdog_of_a_slave_measures_real_time(tmp_path: Path) -> None:
    """One that allows nothing; the other slave, which has none, goes on."""
    folder = modules(tmp_path, ONE + '[watchdogs]\nslave1 = "1ns"\n')
    rows, err = ran(folder, "--for", "1s", "--watch", WATCH, status=1)
    assert rows[-1]["first.axis.error"] == "831" and rows[-1]["second.axis.position"] != "0"
    assert "error[LD0831]: task first.axis on slave1" in err and "0.000001 ms are allowed" in err


def test_a_fault_of_an_algorithm_is_told_as_in_virtual_time(tmp_path: Path) -> None:
    (tmp_path / "ldc.toml").write_text('[processors]\nmaster = "master"\nslave1 = "slave"\n')
    (tmp_path / "divider.ldc.toml").write_text(DIVIDER)
    (tmp_path / "divider.st").write_text(
        "FUNCTION_BLOCK DIVIDER\npart := 100 / share; count := count + 1;\nEND_FUNCTION_BLOCK\n")
    (tmp_path / "parts.ld").write_text(
        "PROGRAM parts\nVAR\n    one : DIVIDER;\n    lamp AT %QX1.0 : BOOL;\nEND_VAR\n"
        "RUNG\n    <one: DIVIDER(share := 0)> (lamp)\nEND_PROGRAM\n")
    rows, said = ran(tmp_path, "--scans", "40", "--watch", "one.error", status=1)
    assert rows[-1]["one.error"] == "801" and said.count("error[LD0801]") == 1, said
    assert "task parts.one on slave1 stopped: division by zero" in said and "divider.st:2:" in said, said


@pytest.mark.parametrize("how, told", [("sys.exit(3)", "LD0842"), ("raise KeyboardInterrupt", "SIGINT")])
def test_a_plant_that_ends_by_itself_shows_nothing_of_python(tmp_path: Path, how: str, told: str) -> None:
    (tmp_path / "ldc.toml").write_text('[plant]\nfile = "plant.py"\n')
    (tmp_path / "main.ld").write_text(BLINK)
    (tmp_path / "plant.py").write_text(
        "import sys\n\nclass Plant:\n    def __init__(self, field, parameters, seed):\n        self.n = 0\n"
        f"    def step(self, now_ns, dt_ns):\n        self.n += 1\n        if self.n > 50: {how}\n")
    rows, said = ran(tmp_path, "--scans", "4000", status=1)
    assert len(rows) < 2000 and told in said and "Traceback" not in said, said
