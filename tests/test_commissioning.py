"""Values of a running program over its socket and by the commands: read, set, forced, traced, retained."""

from __future__ import annotations

import json
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import native
from ldc.cli.main import main
from ldc.diagnostics import Diagnostics, Invalid
from online_programs import loaded
from online_runtime import running, wait_until
from runtime.online import wire
from runtime.online.audit import Audit
from runtime.online.checks import Limits
from runtime.online.controller import Controller, prepare
from runtime.online.server import Server
from runtime.online.wire import Answer, Arm, Collect, Force, Forced, Get, Set, Unforce
from runtime.retain_file import Store

TEXT = """PROGRAM main
VAR RETAIN n : DINT; END_VAR
VAR a AT %IX0.0 : BOOL; q AT %QX0.0 : BOOL; x : REAL; row : ARRAY [1..3] OF INT; rest : TIME := T#1s; END_VAR
RUNG counts
<ADD(IN1 := n, IN2 := 1, OUT => n)>
RUNG shows
[a] (q)
END_PROGRAM
"""
ENGINES = ("vm", pytest.param("native", marks=native.needs_gcc))


class Runtime:
    """A program that runs in this process with its socket, one scan a millisecond."""

    def __init__(self, folder: Path, engine: str) -> None:
        self.first = loaded(TEXT, engine)
        self.controller = Controller(self.first)
        self.log = folder / "audit.jsonl"
        self.server = Server(self.controller, folder / "s", "main", Audit(self.log, pytest.fail))
        self._end, self.failed = threading.Event(), []
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        try:
            while not self._end.wait(0.001):
                if self.server.serve():
                    self.server.values.follow(self.controller.machine)
                self.controller.scan()
                self.server.values.scanned()
        except Exception as error:  # shown by the test, which would wait for ever otherwise
            self.failed.append(error)
            raise

    def close(self) -> None:
        self._end.set()
        self._thread.join()
        self.server.close()
        assert not self.failed

    def raw(self, body: bytes) -> Answer:
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(str(self.server.path))
            connection.sendall(struct.pack(">I", len(body)) + body)
            return wire.receive(connection, Answer)

    def ask(self, request) -> Answer:
        return self.raw(msgspec.msgpack.encode(request))

    def codes(self, request) -> list[str]:
        return [f.code for f in self.ask(request).findings]

    def lines(self) -> list[dict]:
        return [json.loads(line) for line in self.log.read_text(encoding="utf-8").splitlines()]


@contextmanager
def runtime_at(folder: Path, engine: str = "vm") -> Iterator[Runtime]:
    runtime = Runtime(folder, engine)
    try:
        yield runtime
    finally:
        runtime.close()


@pytest.fixture(params=ENGINES)
def runtime(request, tmp_path: Path) -> Iterator[Runtime]:
    with runtime_at(tmp_path, request.param) as made:
        yield made


def values(runtime: Runtime, *paths: str) -> list[str]:
    return [value.value for value in runtime.ask(Get(paths=list(paths))).values]


def test_what_is_set_is_there_once_and_what_is_forced_stays(runtime: Runtime) -> None:
    assert not runtime.codes(Set(path="n", value="1000000", owner="me"))
    assert 1_000_000 <= int(values(runtime, "main.n")[0]) < 2_000_000
    assert not runtime.codes(Force(path="%IX0.0", value="TRUE", owner="me"))
    assert not runtime.codes(Force(path="row[2]", value="-5", owner="me"))
    assert not runtime.codes(Set(path="a", value="0", owner="me"))
    wait_until(lambda: values(runtime, "a", "q", "row[2]") == ["1", "1", "-5"])
    assert [(v.path, v.type, v.value) for v in runtime.ask(Forced()).values] == [
        ("%IX0.0", "BOOL", "1"), ("main.row[2]", "INT", "-5")]
    assert not runtime.codes(Unforce(owner="me", path="a"))
    wait_until(lambda: values(runtime, "a", "q") == ["0", "0"])
    assert not runtime.codes(Unforce(owner="me")) and runtime.ask(Forced()).values == []
    told = [(line["action"], line.get("path"), line.get("value")) for line in runtime.lines()]
    assert told == [("started", None, None), ("set", "main.n", "1000000"), ("forced", "%IX0.0", "1"),
                    ("forced", "main.row[2]", "-5"), ("set", "main.a", "0"), ("unforced", "%IX0.0", "1"),
                    ("unforced", "main.row[2]", "-5")]
    assert len({line["client"] for line in runtime.lines()[1:]}) == 1


@pytest.mark.parametrize(("request_", "code"), [
    (Get(paths=["n", "m"]), "LD0855"), (Get(paths=["row"]), "LD0855"), (Get(paths=["a"] * 1001), "LD0859"),
    (Set(path="n", value="many", owner=""), "LD0855"), (Set(path="", value="1", owner=""), "LD0855"),
    (Force(path="x", value="", owner=""), "LD0855"), (Force(path="row[4]", value="1", owner=""), "LD0855"),
    (Unforce(owner="", path="n"), "LD0858"), (Unforce(owner="", path="m"), "LD0855"),
    (Arm(paths=["n"], trigger="n", before=1, after=1, owner=""), "LD0857"),
    (Arm(paths=["m"], trigger="n > 1", before=1, after=1, owner=""), "LD0855"),
    (Arm(paths=["n"], trigger="n > 1", before=-1, after=1, owner=""), "LD0859"),
    (Arm(paths=["n"], trigger="n > 1", before=1 << 62, after=1, owner=""), "LD0859"),
    (Arm(paths=["n"] * 1001, trigger="n > 1", before=1, after=1, owner=""), "LD0859"),
    (Collect(owner="nobody"), "LD0859")])
def test_what_cannot_be_is_refused_and_logged(tmp_path: Path, request_, code: str) -> None:
    with runtime_at(tmp_path) as runtime:
        assert runtime.codes(request_) == [code]
        assert runtime.lines()[-1]["action"] == "refused" and runtime.lines()[-1]["codes"] == [code]


def test_a_thousand_forces_are_the_most(tmp_path: Path) -> None:
    with runtime_at(tmp_path) as runtime:
        runtime.controller.machine.forces.rows.extend(  # sent one by one it would take seconds
            [runtime.controller.machine.forces.add("x", "1")] * 999)
        assert runtime.codes(Force(path="n", value="1", owner="me")) == ["LD0859"]


SCALARS = st.one_of(st.none(), st.booleans(), st.integers(-(1 << 63), (1 << 63) - 1), st.text(max_size=6),
                    st.binary(max_size=6), st.lists(st.text(max_size=4), max_size=3))


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_messages_of_any_shape_leave_the_program_running(shared: Runtime, data) -> None:
    kind = data.draw(st.sampled_from((Get, Set, Force, Unforce, Forced, Arm, Collect)))
    names = [f.name for f in msgspec.structs.fields(kind) if f.name != "version"]
    likely = {"path": st.sampled_from(("n", "a", "row[1]", "zz", "a[", "%IX0.0", "main.x")),
              "value": st.sampled_from(("1", "TRUE", "1e999", "-", "T#1s", "nan", "'a'")),
              "paths": st.lists(st.sampled_from(("n", "a", "row[9]")), max_size=3),
              "trigger": st.sampled_from(("n > 3", "a rises", "x falls", "n >", "rises", "x = nan")),
              "owner": st.sampled_from(("me", "you"))}
    body = {"do": kind.__struct_config__.tag, "version": 1}
    for name in names:
        body[name] = data.draw(st.one_of(likely.get(name, st.integers(-2, 1 << 40)), SCALARS))
    answer = shared.raw(msgspec.msgpack.encode(body))
    assert all(f.code in ("LD0827", "LD0855", "LD0857", "LD0858", "LD0859") for f in answer.findings)
    assert not shared.failed


@pytest.fixture(scope="module")
def shared(tmp_path_factory) -> Iterator[Runtime]:
    with runtime_at(tmp_path_factory.mktemp("shared")) as made:
        yield made


def traced(runtime: Runtime, owner: str = "me") -> tuple[str, wire.Trace]:
    parts: list[str] = []
    first, end = 0, time.monotonic() + 20
    while time.monotonic() < end:
        trace = runtime.ask(Collect(owner=owner, first=first)).trace
        parts.append(trace.text)
        first = trace.next
        if trace.state == "done" and first == trace.rows:
            return "".join(parts), trace
    raise AssertionError("the trace was not complete")


def test_a_trace_has_every_scan_around_the_event(runtime: Runtime, monkeypatch) -> None:
    monkeypatch.setattr("runtime.online.values._CHUNK_CELLS", 16)
    wait_until(lambda: int(values(runtime, "n")[0]) > 40)
    assert not runtime.codes(Arm(paths=["n", "a"], trigger="a rises", before=20, after=30, owner="me"))
    assert runtime.ask(Collect(owner="me")).trace.state == "waiting"
    assert runtime.codes(Arm(paths=["n"], trigger="n > 1", before=1, after=1, owner="you")) == ["LD0859"]
    at = int(values(runtime, "n")[0])
    wait_until(lambda: int(values(runtime, "n")[0]) > at + 25)
    runtime.ask(Set(path="a", value="1", owner="me"))
    text, trace = traced(runtime)
    rows = [[int(cell) for cell in line.split(",")] for line in text.splitlines()[1:]]
    assert text.startswith("scan,t_ms,n,a\n") and len(rows) == 51
    assert [row[0] for row in rows] == list(range(trace.event - 20, trace.event + 31))
    assert [row[3] for row in rows] == [0] * 20 + [1] * 31
    assert all(row[2] == row[0] + 1 for row in rows)
    assert runtime.codes(Collect(owner="me")) == ["LD0859"], "once"


def test_a_trace_that_nobody_asks_for_makes_room(tmp_path: Path, monkeypatch) -> None:
    with runtime_at(tmp_path) as runtime:
        runtime.ask(Arm(paths=["n"], trigger="a rises", before=1, after=1, owner="gone"))
        monkeypatch.setattr("runtime.online.values._ABANDONED", 0.0)
        assert not runtime.codes(Arm(paths=["n"], trigger="n > 1", before=1, after=1, owner="me"))
        assert len(traced(runtime)[0].splitlines()) in (3, 4)
        assert runtime.codes(Collect(owner="gone")) == ["LD0859"]


def test_a_change_that_cannot_hold_what_is_forced_is_refused(tmp_path: Path) -> None:
    with runtime_at(tmp_path) as runtime:
        controller = runtime.controller
        new = loaded(TEXT.replace("x : REAL", "y : REAL"), "vm", runtime.first)
        staged = prepare(runtime.first, new, runtime.first.digest, "me", Limits())
        runtime.ask(Force(path="x", value="1.5", owner="me"))
        codes = _tried(runtime, lambda: controller.stage(staged))
        assert codes == ["LD0856"] and controller.state == "running"
        runtime.ask(Unforce(owner="me"))
        assert not _tried(runtime, lambda: controller.stage(staged))
        runtime.ask(Force(path="x", value="1.5", owner="me"))
        assert _tried(runtime, lambda: controller.test("me")) == ["LD0856"] and controller.state == "staged"
        runtime.ask(Unforce(owner="me"))
        assert not _tried(runtime, lambda: controller.test("me"))
        runtime.ask(Force(path="y", value="1.5", owner="me"))
        assert not _tried(runtime, lambda: controller.untest("me"))
        assert runtime.ask(Forced()).values == []
        last = [line for line in runtime.lines() if line["action"] == "unforced"][-1]
        assert last["detail"].startswith("main.y ")


def _tried(runtime: Runtime, job) -> list[str]:
    def work() -> list[str]:
        try:
            job()
        except Invalid as error:
            return [d.code for d in error.diagnostics]
        return []

    return runtime.server._between(work)


# ---- commands ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ENGINES)
def test_what_users_type_from_another_terminal(engine: str, tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.ld").write_text(TEXT, encoding="utf-8")
    with running(["run", "main.ld", "--online", "--period", "1ms", "--engine", engine, "--retain", "kept",
                  "--retain-every", "5ms"], monkeypatch) as process:
        assert main(["online", "force", "a", "TRUE"]) == 0
        assert main(["online", "set", "row[1]", "7"]) == 0
        capsys.readouterr()
        assert main(["online", "forces"]) == 0
        assert main(["online", "get", "row[1]", "rest"]) == 0
        assert capsys.readouterr().out == "main.a  1\nrow[1]  7\nrest    1000 ms\n"
        assert main(["online", "watch", "row[1],q", "--every", "10ms", "--for", "60ms"]) == 0
        header, *rows = capsys.readouterr().out.splitlines()
        assert header == "scan,t_ms,row[1],q" and len(rows) > 2
        assert all(row.endswith(",7,1") for row in rows)
        scans = [int(row.split(",")[0]) for row in rows]
        assert scans == sorted(set(scans))
        assert main(["online", "trace", "--watch", "n,q", "--trigger", "n > 5", "--before", "3", "--after",
                     "4", "-o", "out.csv"]) == 0
        assert len(Path("out.csv").read_text(encoding="utf-8").splitlines()) in range(6, 10)
        capsys.readouterr()
        assert main(["online", "trace", "--watch", "n", "--trigger", "n > 5", "-o", "gone/out.csv"]) == 1
        assert "waiting" not in capsys.readouterr().err, "the event would be lost"
        assert main(["online", "unforce"]) == 2 and main(["online", "unforce", "a", "--all"]) == 2
        assert main(["online", "unforce", "--all"]) == 0
        capsys.readouterr()
        assert main(["online", "forces"]) == 0 and capsys.readouterr().out == ""
        assert main(["online", "force", "q", "1"]) == 0
        process.send_signal(signal.SIGTERM)
        errors = process.stderr.read()
    assert "still forced: main.q = 1" in errors
    saved = Store(Path("kept")).load(Diagnostics())
    assert f"{saved.scan:,} scans" in errors, "the last save is that of the end"


def test_a_real_run_goes_on_after_kill_9(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.ld").write_text(TEXT, encoding="utf-8")
    command = [sys.executable, "-m", "ldc.cli", "run", "main.ld", "--online", "--no-wait", "--retain", "kept",
               "--retain-every", "50ms", "--socket", "s", "--audit", "log"]
    reached = 0
    for _ in range(2):
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
            wait_until(lambda: Path("kept").exists() and _saved() > reached, 20.0)
            reached = _saved()
            process.kill()
        kept = _ends_changing()
        assert kept >= reached
    assert reached > 0


def _ends_changing() -> int:
    """What was saved last: the process that executes the scans ends with the one that watches it."""
    last = -1
    for _ in range(50):
        now = _saved()
        if now == last:
            return now
        last = now
        time.sleep(0.2)
    raise AssertionError("scans go on after the run was ended")


def _saved() -> int:
    kept = Store(Path("kept")).load(Diagnostics())
    entry = next(e for e in kept.entries if e.path == "MAIN.N")
    return int.from_bytes(entry.data, "little")


def run(*arguments: str) -> int:
    return main(["run", "main.ld", "--scans", "3", "--watch", "n", "--trace", "-", *arguments])


def test_warm_cold_and_origin(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.ld").write_text(TEXT, encoding="utf-8")

    def last(*arguments: str) -> str:
        assert run("--retain", "kept", *arguments) == 0
        return capsys.readouterr().out.splitlines()[-1].split(",")[-1]

    assert [last(), last(), last("--start", "warm")] == ["3", "6", "9"]
    assert last("--start", "cold", "--force", "n=8") == "8"
    before = Store(Path("kept.before")).load(Diagnostics())
    assert before.entries[0].data[0] == 9, "the save before a cold start is there"
    assert last() == "11"
    assert last("--start", "origin") == "3" and not Path("kept.before").exists()


def test_a_cold_start_leaves_the_whole_one_of_two_files(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.ld").write_text(TEXT, encoding="utf-8")
    assert run("--retain", "kept") == 0 == run("--retain", "kept")
    whole = Path("kept.before").read_bytes()
    Path("kept").write_bytes(b"cut")
    assert run("--retain", "kept", "--start", "cold") == 0
    assert Path("kept.before").read_bytes() == whole


@pytest.mark.parametrize("start", ["warm", "cold", "origin"])
@pytest.mark.parametrize("name", ["kept", "kept.before"])
def test_what_is_no_retain_file_is_left_as_it_is(tmp_path: Path, monkeypatch, capsys, start, name) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.ld").write_text(TEXT, encoding="utf-8")
    Path(name).write_bytes(b"class Plant: ...")
    assert run("--retain", "kept", "--start", start) == 1
    assert "error[LD0860]: `kept`" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir() if path.name != "main.ld"] == [name]
    assert Path(name).read_bytes() == b"class Plant: ..."
    Path(name).write_bytes(b"")
    assert run("--retain", "kept", "--start", "cold") == 0, "an empty file has nothing to lose"


def test_the_project_names_the_file(tmp_path: Path, monkeypatch, capsys) -> None:
    folder = tmp_path / "line"
    folder.mkdir()
    (folder / "main.ld").write_text(TEXT, encoding="utf-8")
    (folder / "ldc.toml").write_text('[run]\nretain = "kept"\nretain_every = "20ms"\n', encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    assert main(["run", "line", "--scans", "5"]) == 0 == main(["run", "line", "--scans", "5"])
    assert Store(folder / "kept").load(Diagnostics()).entries[0].data[0] == 10
    assert Store(folder / "kept.before").load(Diagnostics()).scan == 4
    (folder / "ldc.toml").write_text('[run]\nretain_every = "soon"\n', encoding="utf-8")
    assert main(["run", "line"]) == 1 and "soon" in capsys.readouterr().err


def test_a_file_of_another_version_is_left_alone(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.ld").write_text(TEXT, encoding="utf-8")
    assert run("--retain", "kept") == 0 == run("--retain", "kept")
    newer = bytearray(Path("kept").read_bytes())
    newer[7] = 9
    Path("kept").write_bytes(newer)
    assert run("--retain", "kept") == 1
    assert "LD0851" in capsys.readouterr().err and Path("kept").read_bytes() == newer


def test_a_disk_that_fails_is_told_and_the_program_runs_on(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.ld").write_text(TEXT, encoding="utf-8")
    assert run("--retain", "kept") == 0
    before = Path("kept").read_bytes()
    capsys.readouterr()

    def full(self, kept) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Store, "save", full)
    assert run("--retain", "kept", "--retain-every", "10ms") == 1
    shown = capsys.readouterr()
    assert shown.out.splitlines()[-1] == "2,50,6" and Path("kept").read_bytes() == before
    assert shown.err.count("LD0854") == 2, "once while it ran, once at the end"


@pytest.mark.parametrize("arguments", [
    ["--start", "cold"], ["--retain-every", "1s"], ["--ring", "o.csv"], ["--trigger", "a rises"],
    ["--before", "3"], ["--retain", "kept", "--target", "cortex-m3"],
    ["--force", "a=1", "--target", "cortex-m3"]])
def test_options_that_mean_nothing_together(arguments: list[str], tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.ld").write_text(TEXT, encoding="utf-8")
    assert run(*arguments) == 2
