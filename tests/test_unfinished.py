"""What somebody leaves who is killed while he writes: the next takes it away, and nothing of the living."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import pytest
from online_runtime import private, wait_until

from ldc import unfinished
from ldc.cli.main import main

COUNT = "PROGRAM p\nVAR RETAIN\n  n : INT;\nEND_VAR\nRUNG r\n  <ADD(IN1 := n, IN2 := 1, OUT => n)>\nEND_PROGRAM\n"
HOLD = """
    import sys, time
    from pathlib import Path
    from ldc import unfinished
    with unfinished.file_in(Path(sys.argv[1])) as file, unfinished.folder_in(Path(sys.argv[1])) as folder:
        file.write(b"half")
        (folder / "part").write_text("half")
        print("there", flush=True)
        time.sleep(60)
"""


@pytest.fixture(autouse=True)
def fresh():
    """Every test begins like a process of its own."""
    unfinished._sweep.cache_clear()


def started(code: str, *arguments: str) -> subprocess.Popen:
    """A process that has said something."""
    process = subprocess.Popen([sys.executable, "-c", textwrap.dedent(code), *arguments],
                               stdout=subprocess.PIPE, text=True)
    process.stdout.readline()
    return process


def ended(process: subprocess.Popen) -> None:
    process.kill()
    process.communicate()


def test_what_the_dead_left_goes_and_what_the_living_have_stays(tmp_path: Path) -> None:
    dead, living = started(HOLD, str(tmp_path)), started(HOLD, str(tmp_path))
    try:
        assert len(list(tmp_path.iterdir())) == 4
        ended(dead)
        with unfinished.file_in(tmp_path) as own:
            kept = {path.name for path in tmp_path.iterdir()} - {Path(own.name).name}
        assert len(kept) == 2
        assert (next(path for path in tmp_path.iterdir() if path.is_dir()) / "part").read_text() == "half"
    finally:
        ended(living)
    unfinished._sweep.cache_clear()
    unfinished.sweep(tmp_path)
    assert not list(tmp_path.iterdir())


def test_files_of_others_are_no_business_of_ours(tmp_path: Path) -> None:
    for name in (".ldc-notes", "ldc-1.tmp", ".swap.tmp", ".main.ld.0123456789abcdef"):
        (tmp_path / name).touch()
    (tmp_path / ".ldc-0.tmp").symlink_to(tmp_path / "ldc-1.tmp")
    unfinished.sweep(tmp_path)
    assert len(list(tmp_path.iterdir())) == 5


def test_two_that_write_and_sweep_at_once_lose_nothing(tmp_path: Path) -> None:
    failed: list[BaseException] = []

    def write(number: int) -> None:
        try:
            for turn in range(100):
                unfinished._sweep.cache_clear()
                with unfinished.file_in(tmp_path) as file:
                    file.write(b"%d" % turn)
                    unfinished.named(file, tmp_path / f"{number}-{turn}")
        except BaseException as error:
            failed.append(error)

    threads = [threading.Thread(target=write, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not failed
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(f"{n}-{t}" for n in range(4) for t in range(100))


def test_only_one_is_alone(tmp_path: Path) -> None:
    lock = tmp_path / "lock"
    with unfinished.alone(lock) as first, unfinished.alone(lock, patience=0) as second:
        assert (first, second) == (True, False)
    assert not lock.exists()
    dead = started("import sys\nfrom pathlib import Path\nfrom ldc import unfinished\n"
                   "with unfinished.alone(Path(sys.argv[1])):\n print('there', flush=True)\n import time\n"
                   " time.sleep(60)", str(lock))
    ended(dead)
    assert lock.exists()
    with unfinished.alone(lock, patience=0) as again:
        assert again
    assert not lock.exists()


def test_a_run_that_is_killed_leaves_nothing_for_ever(tmp_path: Path) -> None:
    """Its trace is not finished, its retain file is locked: the next run takes both over."""
    (tmp_path / "main.ld").write_text(COUNT)
    arguments = ["main.ld", "--retain", "r", "--trace", "t.csv"]
    process = subprocess.Popen([sys.executable, "-m", "ldc.cli", "run", *arguments, "--scans", "100000000"],
                               cwd=tmp_path, stderr=subprocess.DEVNULL)
    wait_until(lambda: (tmp_path / "r.before").exists(), 30)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    names = {path.name for path in tmp_path.iterdir()}
    assert ".r.lock" in names and any(name.endswith(".tmp") for name in names)
    again = subprocess.run([sys.executable, "-m", "ldc.cli", "run", *arguments, "--scans", "2"], cwd=tmp_path,
                           capture_output=True, text=True, check=False)
    assert again.returncode == 0 and "retain: 1 value" in again.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"main.ld", "r", "r.before", "t.csv"}


def test_the_library_of_a_load_that_was_killed_goes_with_the_next_start(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "main.ld").write_text(COUNT)
    with private(monkeypatch) as folder:
        dead, living = started(HOLD, str(folder)), started(HOLD, str(folder))
        ended(dead)
        assert len(list(folder.glob(".ldc-*"))) == 4
        assert main(["run", str(tmp_path / "main.ld"), "--online", "--no-wait", "--scans", "2"]) == 0
        assert len(list(folder.glob(".ldc-*"))) == 2
        ended(living)


def test_a_socket_that_was_taken_away_is_that_of_the_next_runtime(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Somebody deletes the socket of a runtime and starts another one: when the first ends, the second has its own."""
    (tmp_path / "main.ld").write_text(COUNT)
    command = [sys.executable, "-m", "ldc.cli", "run", str(tmp_path / "main.ld"), "--online"]
    with private(monkeypatch) as folder:
        def runtime() -> subprocess.Popen:
            process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            wait_until((folder / "s").exists, 30)
            return process

        first = runtime()
        (folder / "s").unlink()
        second = runtime()
        for process, there in ((first, True), (second, False)):
            process.terminate()
            assert process.wait(timeout=30) in (0, 143, -signal.SIGTERM)
            assert (folder / "s").exists() == there


def test_of_runtimes_that_start_at_once_one_has_the_socket(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A dead runtime left one, which all of them find."""
    (tmp_path / "main.ld").write_text(COUNT)
    command = [sys.executable, "-m", "ldc.cli", "run", str(tmp_path / "main.ld"), "--online"]
    with private(monkeypatch) as folder:
        with socket.socket(socket.AF_UNIX) as dead:
            dead.bind(str(folder / "s"))
        running = [subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
                   for _ in range(3)]
        wait_until(lambda: sum(process.poll() is None for process in running) == 1, 30)
        one, = (process for process in running if process.poll() is None)
        assert main(["online", "get", "n", "--src", str(tmp_path / "main.ld")]) == 0
        one.terminate()
        told = [process.communicate(timeout=30)[1] for process in running]
        assert sum("a runtime has the socket" in text for text in told) == 2
