"""Runtimes for tests: an ldc that runs a program meanwhile, and a socket that says what it was told to."""

from __future__ import annotations

import shlex
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import pytest


def runtime_of(folder: Path, monkeypatch: pytest.MonkeyPatch):
    """What the files `runtime` or `answer` of an example ask for; nothing without them."""
    if (folder / "runtime").exists():
        return running(shlex.split((folder / "runtime").read_text(encoding="utf-8")), monkeypatch)
    if (folder / "answer").exists():
        return answering((folder / "answer").read_bytes(), monkeypatch)
    return nullcontext()


@contextmanager
def private(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder for the socket and the state of clients. Its path is short: those of sockets are."""
    with tempfile.TemporaryDirectory(prefix="ldc") as folder:
        monkeypatch.setenv("LDC_SOCKET", str(Path(folder, "s")))
        monkeypatch.setenv("XDG_STATE_HOME", folder)
        yield Path(folder)


@contextmanager
def running(arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> Iterator[subprocess.Popen]:
    """`ldc ARGUMENTS` in the folder where we are, until the block ends."""
    with private(monkeypatch) as folder:
        command = [sys.executable, "-m", "ldc.cli", *arguments]
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
            for line in process.stderr:
                if line.startswith("online: "):
                    break
            else:
                raise AssertionError(f"ldc {shlex.join(arguments)} ended with {process.wait()}")
            try:
                yield process
            finally:
                process.terminate()
                process.communicate()
                assert not Path(folder, "s").exists(), "the socket is there after its runtime"


@contextmanager
def answering(answer: bytes, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """A socket that gives one client these bytes."""
    with private(monkeypatch) as folder, socket.socket(socket.AF_UNIX) as served:
        served.bind(str(folder / "s"))
        served.listen()

        def serve() -> None:
            with served.accept()[0] as client:
                client.recv(1 << 16)
                client.sendall(answer)

        thread = threading.Thread(target=serve, daemon=True)
        thread.start()
        yield
        thread.join(timeout=10)


def wait_until(true, seconds: float = 10.0) -> None:
    """Until the function says so. Raises AssertionError when it never does."""
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.01)
