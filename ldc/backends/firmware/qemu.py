"""Runs an image in QEMU: the job goes in as a file, the trace comes out as one (docs/firmware.md)."""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from ldc.backends.firmware import findings
from ldc.backends.firmware import tools
from ldc.backends.firmware.board import Board
from ldc.components import toolchain
from ldc.diagnostics import Diagnostics

JOB, TRACE = "ldc.job", "ldc.trace"
_TRAP = re.compile(r"ldc: trap cfsr=([0-9a-f]{8}) pc=([0-9a-f]{8}) lr=([0-9a-f]{8})")
_NO_ROOM = 5


def command(path: str, board: Board) -> list[str]:
    """How QEMU is called: without a screen, the serial port on standard output, files of this computer."""
    return [os.path.abspath(path), "-M", board.qemu.machine, "-display", "none", "-monitor", "none", 
            "-serial", "stdio", "-semihosting-config", "enable=on,target=native"]


def run(board: Board, elves: Sequence[Path], job: bytes, timeout: float,
        diagnostics: Diagnostics) -> bytes | None:
    """The trace of a job; ``elves``: the image of the master, then that of a slave. None, with findings, when
    QEMU is not there, ends badly, or does not end within ``timeout`` seconds. Raises OSError when there is no
    room for files."""
    path = toolchain.find(toolchain.QEMU_ARM, diagnostics)
    if path is None:
        return None
    elves = [elf.resolve() for elf in elves]
    loaded = [word for elf in elves[1:] for word in ("-device", f"loader,file={elf}")]
    with tempfile.TemporaryDirectory(prefix="ldc-") as folder:
        (Path(folder) / JOB).write_bytes(job)
        called = [*command(path, board), *board.qemu.options, *loaded, "-kernel", str(elves[0])]
        try:
            done = subprocess.run(called, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True,
                                  timeout=timeout, check=False)
        except subprocess.TimeoutExpired:
            findings.no_end(diagnostics, board.name, timeout)
            return None
        said = (done.stdout + done.stderr).decode("utf-8", "replace")
        if done.returncode == 0:
            return (Path(folder) / TRACE).read_bytes()
        if trap := _TRAP.search(said):
            status, pc, lr = (int(digits, 16) for digits in trap.groups())
            places = (tools.line_of(elf, at) for at in (pc, lr & ~1) for elf in elves)
            where = next((place for place in places if place), None)
            findings.trap(diagnostics, board.name, status, pc, where)
        elif done.returncode == _NO_ROOM:
            findings.too_much_watched(diagnostics, board.name)
        else:
            findings.qemu_failed(diagnostics, board.qemu.machine, done.returncode, said)
    return None
