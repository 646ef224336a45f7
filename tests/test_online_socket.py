"""The control socket: whatever comes over it, the program runs on; what users type from another terminal."""

from __future__ import annotations

import errno
import json
import os
import re
import socket
import stat
import struct
import threading
import time
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import native
from ldc.cli import link, modules
from ldc.cli.console import Failure
from ldc.cli.main import main
from ldc.diagnostics import Diagnostics, Invalid
from ldc.manifest import find_sources
from online_programs import compiled, loaded
from online_runtime import private, running, wait_until
from runtime.online import loading, server, wire
from runtime.online.audit import Audit
from runtime.online.controller import Controller
from runtime.online.server import Busy, Server
from runtime.online.wire import Act, Answer, Pull, Report, Stage, Status

TEXT = "PROGRAM main\nVAR n, z : INT; END_VAR\nRUNG count\n<ADD(IN1 := n, IN2 := 1, OUT => n)>\nEND_PROGRAM\n"
OTHER = TEXT.replace("IN2 := 1", "IN2 := 2")


class Runtime:
    """A program that runs in this process, one scan a millisecond, with its socket."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "online.sock"
        self.controller = Controller(loaded(TEXT))
        self.log = folder / "audit.jsonl"
        self.server = Server(self.controller, self.path, "main", Audit(self.log, pytest.fail))
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        while not self._end.wait(0.001):
            self.server.serve()
            self.controller.scan()

    def close(self) -> None:
        self._end.set()
        self._thread.join()
        self.server.close()

    def ask(self, request) -> Answer:
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(str(self.path))
            wire.send(connection, request)
            return wire.receive(connection, Answer)

    def say(self, data: bytes) -> bytes:
        """Raw bytes, and what comes back until the end."""
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(str(self.path))
            connection.settimeout(10)
            connection.sendall(data)
            connection.shutdown(socket.SHUT_WR)
            parts = []
            while part := connection.recv(1 << 16):
                parts.append(part)
            return b"".join(parts)

    def goes_on(self) -> None:
        """The program counts scans, none is missed."""
        before = self.ask(Status()).state.scans
        wait_until(lambda: self.ask(Status()).state.scans > before)
        assert self.controller.machine.faults == []


@pytest.fixture
def runtime(monkeypatch) -> Iterator[Runtime]:
    with private(monkeypatch) as folder:
        made = Runtime(folder)
        try:
            yield made
        finally:
            made.close()


def change(text: str, base: str, owner: str = "me", **more) -> Stage:
    return Stage(image=compiled(text).image.data, sources=[("main.ld", text)], base=base, owner=owner, **more)


def codes(answer: Answer) -> list[str]:
    return [found.code for found in answer.findings]


def framed(message: object) -> bytes:
    data = msgspec.msgpack.encode(message)
    return struct.pack(">I", len(data)) + data


# ---- the protocol ------------------------------------------------------------------------------------


def test_a_change_from_stage_to_commit(runtime) -> None:
    state = runtime.ask(Status()).state
    assert (state.state, state.engine, state.staged) == ("running", "vm", "")
    answer = runtime.ask(change(OTHER, state.digest))
    assert (answer.findings, answer.state.state, answer.changes.kept) == ([], "staged", ["main.n", "main.z"])
    assert runtime.ask(Report()).changes == answer.changes
    assert runtime.ask(Act(action="test", owner="me")).state.digest == answer.state.staged
    state = runtime.ask(Act(action="commit", owner="me")).state
    assert (state.state, state.last) == ("running", "committed")
    assert runtime.ask(Pull()).sources == [("main.ld", OTHER)]
    runtime.goes_on()
    lines = [json.loads(line) for line in runtime.log.read_text().splitlines()]
    assert [line["action"] for line in lines] == ["started", "staged", "testing", "committed"]
    assert "me" not in {line.get("client") for line in lines}
    assert lines[-1]["program"] == state.digest


@pytest.mark.parametrize("data", [
    b"", b"\0", b"\0\0\0\0", b"\0\0\0\5abc", b"\xff" * 100, b"\0\0\0\1\xc1", b"GET / HTTP/1.1\r\n\r\n",
    framed(None), framed([]), framed({}), framed({"do": "fly"}), framed({"do": "status", "version": 99}),
    framed({"do": "status", "more": 1}), framed({"do": "stage", "image": 7}), framed({"do": "act", "action": "commit"}),
    framed({"do": "act", "action": "explode", "owner": "me"}),
    framed({"do": "act", "action": "test", "owner": "me", "limit_ns": -5}),
    framed({"do": "act", "action": "test", "owner": "me", "limit_ns": 1 << 62}),
    struct.pack(">I", 3000) + b"\x91" * 3000], ids=range(19))
def test_messages_of_the_wrong_shape_are_refused(runtime, data: bytes) -> None:
    answer = msgspec.msgpack.decode(runtime.say(data)[4:], type=Answer)
    assert codes(answer) == ["LD0827"]
    runtime.goes_on()


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.one_of(
    st.binary(max_size=60),
    st.binary(max_size=60).map(lambda data: struct.pack(">I", len(data)) + data),
    st.dictionaries(st.sampled_from(["do", "version", "image", "base", "owner", "sources", "action", "areas"]),
                    st.one_of(st.none(), st.integers(-1, 99), st.sampled_from(["stage", "act", "status", "test"]),
                              st.binary(max_size=9), st.lists(st.integers(0, 3), max_size=2))).map(framed)))
def test_no_bytes_disturb_the_program(runtime, data: bytes) -> None:
    before = runtime.controller.running
    runtime.say(data)
    assert runtime.controller.running is before and runtime.controller.state == "running"
    assert runtime.ask(Status()).state.state == "running"


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.data())
def test_a_damaged_image_is_refused_or_is_a_program(runtime, data) -> None:
    digest = runtime.controller.running.digest
    image = bytearray(compiled(OTHER).image.data)
    for _ in range(data.draw(st.integers(1, 4))):
        image[data.draw(st.integers(0, len(image) - 1))] = data.draw(st.integers(0, 255))
    answer = runtime.ask(Stage(image=bytes(image), sources=[], base=digest, owner="me"))
    assert set(codes(answer)) <= {"LD0820", "LD0821", "LD0822", "LD0826"}
    if not answer.findings:
        assert runtime.ask(Act(action="cancel", owner="me")).findings == []
    runtime.goes_on()


def test_a_stale_change_and_a_second_client_are_refused(runtime) -> None:
    digest = runtime.ask(Status()).state.digest
    assert codes(runtime.ask(change(OTHER, "0" * 64))) == ["LD0823"]
    assert codes(runtime.ask(change(OTHER, digest))) == []
    assert codes(runtime.ask(change(OTHER, digest, "you"))) == ["LD0825"]
    assert codes(runtime.ask(Act(action="test", owner="you"))) == ["LD0825"]
    assert codes(runtime.ask(change(TEXT.replace("n, z", "n, z, y"), digest))) == []  # one's own is replaced
    runtime.goes_on()


def test_of_two_clients_that_stage_at_once_one_wins(runtime) -> None:
    digest = runtime.ask(Status()).state.digest
    messages = [change(OTHER, digest, owner) for owner in ("a", "b", "c", "d")]
    answers: list[list[str]] = []
    threads = [threading.Thread(target=lambda m=m: answers.append(codes(runtime.ask(m)))) for m in messages]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(answers) == [[], ["LD0825"], ["LD0825"], ["LD0825"]]
    runtime.goes_on()


def test_clients_that_vanish_or_say_nothing_hold_up_nobody(runtime) -> None:
    silent = [socket.socket(socket.AF_UNIX) for _ in range(6)]
    for connection in silent:
        connection.connect(str(runtime.path))
        connection.sendall(b"\0\0")
    data = framed(change(OTHER, runtime.controller.running.digest))
    for cut in (3, 10, len(data) // 2, len(data)):
        with socket.socket(socket.AF_UNIX) as connection:
            connection.connect(str(runtime.path))
            connection.sendall(data[:cut])
    runtime.goes_on()
    wait_until(lambda: runtime.ask(Status()).state.state == "staged")  # the last one said all before it went
    assert codes(runtime.ask(Act(action="cancel", owner="me"))) == []
    for connection in silent:
        connection.close()


def test_a_test_of_a_client_that_vanished_ends_by_itself(runtime) -> None:
    runtime.ask(change(OTHER, runtime.controller.running.digest))
    runtime.ask(Act(action="test", owner="me", limit_ns=20_000_000))
    wait_until(lambda: runtime.ask(Status()).state.state == "staged")
    assert runtime.ask(Status()).state.last.startswith("reverted")


def test_a_program_that_faults_in_its_first_scan_is_gone_at_once(runtime) -> None:
    digest = runtime.ask(Status()).state.digest
    bad = TEXT.replace("END_PROGRAM", "RUNG bad\n[n / z > 1] (q)\nEND_PROGRAM").replace("z : INT;", "z : INT; q : BOOL;")
    assert codes(runtime.ask(change(bad, digest))) == []
    runtime.ask(Act(action="test", owner="me"))
    wait_until(lambda: runtime.ask(Status()).state.state == "running")
    state = runtime.ask(Status()).state
    assert (state.digest, state.faults) == (digest, [])
    line = bad[: bad.index("[n / z")].count("\n") + 1
    assert re.fullmatch(rf"reverted: division by zero in rung bad of main \(\S*:{line}:2\)", state.last)
    runtime.goes_on()


def test_the_socket_is_of_one_user_and_one_runtime(runtime) -> None:
    mode = runtime.path.stat().st_mode
    assert stat.S_ISSOCK(mode) and stat.S_IMODE(mode) == 0o600
    with pytest.raises(Busy):
        Server(runtime.controller, runtime.path, "second", Audit(runtime.log, pytest.fail))
    left = runtime.path.with_name("left.sock")
    with socket.socket(socket.AF_UNIX) as dead:
        dead.bind(str(left))
    second = Server(Controller(loaded(TEXT)), left, "third", Audit(runtime.log, pytest.fail))
    second.close()
    assert not left.exists()


def test_a_message_that_is_too_long_is_not_read(runtime) -> None:
    start = time.monotonic()
    answer = msgspec.msgpack.decode(runtime.say(struct.pack(">I", wire.LIMIT + 1) + b"x" * 1000)[4:], type=Answer)
    assert codes(answer) == ["LD0827"] and time.monotonic() - start < 5
    with pytest.raises(Invalid), socket.socket(socket.AF_UNIX) as nobody:
        wire.send(nobody, Stage(image=bytes(wire.LIMIT), sources=[], base="", owner=""))


def test_a_runtime_that_ends_while_it_is_asked_is_told(tmp_path: Path) -> None:
    path = tmp_path / "ends.sock"
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(path))
        listening.listen(1)

        def ends() -> None:
            with listening.accept()[0] as connection:
                wire.receive(connection, Status)

        thread = threading.Thread(target=ends)
        thread.start()
        with pytest.raises(Invalid) as refused:
            link.ask(path, Status())
        thread.join()
    found, = refused.value.diagnostics
    assert found.code == "LD0828" and found.message.endswith("it ended before it answered")


def test_a_refused_program_leaves_nothing_in_memory(runtime, monkeypatch) -> None:
    """Staging is made undisturbed by the collector of garbage, which never finds what is left of it then."""
    made: list[weakref.ref] = []

    def load(*arguments):
        found = loading.load(*arguments)
        made.append(weakref.ref(found.machine.code.bodies[0]))
        return found

    monkeypatch.setattr(server, "load", load)
    base = runtime.controller.running.digest
    for text, code in ((TEXT.replace("n, z : INT", "n : INT; z : DINT"), "LD0820"), (OTHER, None), (OTHER, "LD0824")):
        assert codes(runtime.ask(change(text, base))) == ([code] if code else [])
        if code is None:
            runtime.ask(Act(action="test", owner="me"))
            base = runtime.controller.running.digest
        wait_until(lambda: [ref() is None for ref in made] == [True, False, True][: len(made)])


@native.needs_gcc
def test_a_program_without_room_for_its_code_is_refused_with_the_place(tmp_path: Path) -> None:
    running = loaded(TEXT, "native")
    message = change(OTHER, running.digest, library=b"code", areas=loading.areas_of(running.machine))
    with pytest.raises(Invalid) as refused:
        loading.load(message, running.machine, tmp_path / "gone")
    (found,) = refused.value.diagnostics
    assert (found.code, "No such file" in found.message, str(tmp_path / "gone") in found.help) == ("LD0826", True, True)


def test_what_a_swap_took_is_in_its_answer(runtime) -> None:
    runtime.ask(change(OTHER, runtime.controller.running.digest))
    assert runtime.ask(Act(action="test", owner="me")).state.pause_ns > 0


def test_the_secret_of_a_client_is_whole_or_not_there(tmp_path: Path, monkeypatch) -> None:
    """A full disk leaves no empty one, which everybody could guess; one that is there already is made anew."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    kept = tmp_path / "ldc" / "client"

    def full(*paths) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as now, pytest.raises(Failure, match="No space left"):
        now.setattr(os, "link", full)
        link.owner_of(["."])
    assert list(kept.parent.iterdir()) == []
    kept.write_text("")
    assert link.owner_of(["."]) == link.owner_of(["."]) and len(kept.read_text()) == 64
    kept.unlink()
    owners: list[str] = []
    threads = [threading.Thread(target=lambda: owners.append(link.owner_of(["."]))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert set(owners) == {link.owner_of(["."])} and stat.S_IMODE(kept.stat().st_mode) == 0o600


def test_an_audit_log_without_room_has_no_half_lines_and_tells_what_it_lacks(tmp_path: Path, monkeypatch) -> None:
    told: list[str] = []
    audit, write, room = Audit(tmp_path / "log", told.append), os.write, [10_000]

    def little(file: int, data: bytes) -> int:
        part = data[: room[0]]
        if not part:
            raise OSError(errno.ENOSPC, "No space left on device")
        room[0] -= len(part)
        return write(file, part)

    with monkeypatch.context() as disk:
        disk.setattr(os, "write", little)
        audit.line("first")
        room[0] = 20
        audit.line("second")
        room[0] = 0
        audit.line("third")
        room[0] = 10_000
        audit.line("fourth", path="x")
    audit.close()
    rows = [json.loads(line) for line in (tmp_path / "log").read_text().splitlines()]
    assert [(row["action"], row.get("lines")) for row in rows] == [("first", None), ("lost", 2), ("fourth", None)]
    assert len(told) == 1


# ---- the commands ------------------------------------------------------------------------------------


def project(folder: Path, modules: str) -> None:
    (folder / "ldc.toml").write_text(f'[project]\nname = "plant"\nmodules = [{modules}]  # in order\n')
    (folder / "main.ld").write_text("VAR_GLOBAL\n    trail : INT;\nEND_VAR\n" + "".join(
        f"PROGRAM {name}\nVAR k : INT; END_VAR\nRUNG\n<ADD(IN1 := k, IN2 := 1, OUT => k)>\n"
        f"RUNG\n<MOVE(IN := trail * 10 + {n}, OUT => trail)>\nEND_PROGRAM\n"
        for n, name in enumerate(("feed", "press", "pack"), 1)) +
        "PROGRAM wash\nRUNG\n<MOVE(IN := 0, OUT => trail)>\nEND_PROGRAM\n")


@contextmanager
def at(folder: Path, monkeypatch, *arguments: str) -> Iterator[Path]:
    monkeypatch.chdir(folder)
    trace = folder / "trace.csv"
    with running(["run", ".", "--online", "--trace", str(trace), *arguments], monkeypatch):
        yield trace


@pytest.mark.parametrize("engine", ["vm", pytest.param("native", marks=native.needs_gcc)])
def test_a_module_is_inserted_into_the_sequence_while_it_runs(tmp_path, monkeypatch, capsys, engine) -> None:
    project(tmp_path, '"wash", "feed", "pack"')
    with at(tmp_path, monkeypatch, "--engine", engine, "--watch", "trail,feed.k,pack.k") as trace:
        assert main(["pull", "--check"]) == 0
        assert main(["online", "insert", "press", "--after", "FEED"]) == 0
        assert 'modules = ["wash", "feed", "press", "pack"]  # in order' in (tmp_path / "ldc.toml").read_text()
        assert main(["online", "test"]) == 0
        assert main(["online", "commit"]) == 0
        assert main(["pull", "--check"]) == 0
        assert main(["pull", "-o", "running"]) == 0
        assert (tmp_path / "running" / "main.ld").read_text() == (tmp_path / "main.ld").read_text()
        (tmp_path / "main.ld").write_text("")
        assert main(["pull", "running", "--check"]) == 0
        assert main(["pull", "--check"]) == 1
        assert main(["pull", "-o", "running"]) == 1
    rows = [list(map(int, row.split(",")[2:])) for row in trace.read_text().splitlines()[1:]]
    assert [row[1] for row in rows] == [row[2] for row in rows] == list(range(1, len(rows) + 1))
    trails = [row[0] for row in rows]
    swapped = trails.index(123)
    assert trails == [13] * swapped + [123] * (len(rows) - swapped)


def test_what_cannot_be_staged_leaves_the_project_as_it_was(tmp_path, monkeypatch, capsys) -> None:
    project(tmp_path, '"feed", "pack"')
    before = (tmp_path / "ldc.toml").read_bytes()
    with at(tmp_path, monkeypatch, "--watch", "trail"):
        capsys.readouterr()
        for arguments, code in ((["insert", "nothing"], "LD0220"), (["insert", "press", "--after", "wash"], "LD0829"),
                                (["insert", "feed"], "LD0829"), (["insert", "press", "--expect", "abc"], "LD0823"),
                                (["report"], "LD0824"), (["untest"], "LD0824")):
            assert main(["online", *arguments]) == 1
            assert code in capsys.readouterr().err
            assert (tmp_path / "ldc.toml").read_bytes() == before
        (tmp_path / "main.ld").write_text("PROGRAM feed\nRUNG\n[nothing] (here)\nEND_PROGRAM\n")
        assert main(["online", "stage"]) == 1
        assert main(["online", "status"]) == 0
        assert "running" in capsys.readouterr().out


def test_which_step_waits_for_what_is_in_the_status(tmp_path, monkeypatch, capsys) -> None:
    (tmp_path / "main.ld").write_text("".join(
        f"PROGRAM {name}\nVAR_INPUT start : BOOL; END_VAR\nVAR_OUTPUT done : BOOL; END_VAR\n"
        f"VAR eye AT %IX0.{n} : BOOL; END_VAR\nRUNG [start] [eye] (done)\nEND_PROGRAM\n"
        for n, name in enumerate(("feed", "pack"))))
    (tmp_path / "ldc.toml").write_text('[project]\nname = "line"\nmodules = ["feed", "pack"]\n'
                                       '[sequence]\nsteps = ["feed", { module = "pack", when = "pack.eye" }]\n')

    def status() -> str:
        assert main(["online", "status"]) == 0
        return next((row for row in capsys.readouterr().out.splitlines() if row.startswith("sequence")), "")

    with at(tmp_path, monkeypatch, "--watch", "feed.done"):
        wait_until(lambda: "step 1 of 2 (`feed`) waits for module `feed` to end (" in status())
        assert main(["online", "set", "feed.eye", "TRUE"]) == 0
        wait_until(lambda: "step 2 of 2 (`pack`) waits for `pack.eye` (" in status())


def test_a_second_runtime_of_a_socket_and_paths_that_are_none(tmp_path, monkeypatch, capfd) -> None:
    project(tmp_path, '"feed"')
    with at(tmp_path, monkeypatch, "--watch", "trail", "--audit", "log"):
        assert main(["run", ".", "--online"]) == 1
        assert "has the socket" in capfd.readouterr().err
        assert [json.loads(line)["action"] for line in Path("log").read_text().splitlines()] == ["started"]
        assert main(["online", "status", "--socket", "x" * 200]) == 1
        assert main(["run", ".", "--online", "--scans", "3", "--no-wait", "--socket", "s", "--audit", "/dev/null/x"]) == 1
    assert main(["run", ".", "--online", "--scans", "3", "--no-wait", "--socket", "s"]) == 0
    assert not os.path.exists("s")
    for wrong in (["--socket", "s"], ["--no-wait"], ["--audit", "log"], ["--online", "--target", "cortex-m3"]):
        assert main(["run", ".", *wrong]) == 2


STEPS = {
    "a line for each": ('steps = [\n    { module = "feed" },\n    "pack",  # the last\n    { module = "feed", until = "x" },\n]\n',
                        '    { module = "feed", until = "x" },\n    { module = "press" },\n]\n'),
    "one line": ('steps = ["feed", "pack"]\n', 'steps = ["feed", "press", "pack"]\n'),
    "none of the module before": ('steps = ["pack"]\n', 'steps = ["pack", "press"]\n'),
    "written already": (*['steps = [\n    "press",\n    "feed",\n]\n'] * 2,),
    "no steps": ("repeat = false\n", "repeat = false\n"),
}


@pytest.mark.parametrize("name", STEPS)
def test_an_inserted_module_gets_a_step_where_steps_are_written(tmp_path: Path, name: str) -> None:
    before, after = STEPS[name]
    project(tmp_path, '"feed", "pack"')
    path = tmp_path / "ldc.toml"
    path.write_text(path.read_text() + "[sequence]\n" + before)
    (tmp_path / "main.ld").write_text("".join(
        f"PROGRAM {name}\nVAR_INPUT Start : BOOL; END_VAR\nRUNG [Start]\nEND_PROGRAM\n"
        for name in ("feed", "press", "pack")))
    sources = find_sources([tmp_path], Diagnostics())
    text = path.read_text()
    with modules.inserted(sources, "press", "feed"):
        assert path.read_text().endswith(after)
        assert [line for line in text.splitlines() if line not in path.read_text().splitlines()] == [
            line for line in text.splitlines() if "modules" in line or ("steps" in line and "]" in line)]
    with pytest.raises(ZeroDivisionError), modules.inserted(find_sources([tmp_path], Diagnostics()), "wash", None):
        1 / 0
    assert '"press"' in path.read_text() and "wash" not in path.read_text()


def test_a_module_that_nothing_starts_gets_no_step(tmp_path: Path) -> None:
    project(tmp_path, '"feed", "pack"')
    path = tmp_path / "ldc.toml"
    path.write_text(path.read_text() + '[sequence]\nsteps = ["feed"]\n')
    with modules.inserted(find_sources([tmp_path], Diagnostics()), "press", None):
        assert path.read_text().endswith('steps = ["feed"]\n')


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", [b"", b"\xef\xbb\xbf"])
def test_an_insert_changes_nothing_else_of_the_file(tmp_path: Path, ends: str, mark: bytes) -> None:
    project(tmp_path, '"feed", "pack"')
    path = tmp_path / "ldc.toml"
    before = mark + path.read_text().replace("\n", ends).encode()
    path.write_bytes(before)
    with modules.inserted(find_sources([tmp_path], Diagnostics()), "press", "feed"):
        assert path.read_bytes() == before.replace(b'"feed", ', b'"feed", "press", ')


def test_an_insert_that_fails_keeps_what_somebody_else_wrote(tmp_path: Path) -> None:
    project(tmp_path, '"feed", "pack"')
    path = tmp_path / "ldc.toml"
    with pytest.raises(ZeroDivisionError), modules.inserted(find_sources([tmp_path], Diagnostics()), "press", "feed"):
        path.write_text(path.read_text() + "# another one's\n")
        1 / 0
    assert path.read_text().endswith("# another one's\n")
