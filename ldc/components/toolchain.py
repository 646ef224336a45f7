"""The compilers that ldc calls: where they are, what to install when they are not, what they say."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from ldc.components import findings
from ldc.diagnostics import Diagnostics
from ldc.patterns import Pattern
from ldc.records import record
from ldc.source import SourceFile, Span

_UNDEFINED = Pattern(r"^(?:\S*ld\S*: )?(.+?):(\d+): (undefined reference to .*)$", re.MULTILINE)
_MESSAGE = Pattern(r"^(.+?):(\d+):(?:(\d+):)? (fatal error|error|warning): (.*)$", re.MULTILINE)


MOST_KEPT = 4000
"""Files that a folder of compiled code holds."""


@record
class Tool:
    """``command``: its name on the PATH. ``variable``: the environment variable that names another one.
    ``purpose``: what it does, after `it`."""

    command: str
    variable: str
    package: str
    purpose: str


GCC = Tool("gcc", "LDC_CC", "gcc", "compiles C for this computer")
GXX = Tool("g++", "LDC_CXX", "g++", "compiles C++ for this computer")
ARM_GCC = Tool(
    "arm-none-eabi-gcc", "LDC_ARM_CC", "gcc-arm-none-eabi libnewlib-arm-none-eabi", "compiles C for Cortex-M"
)
ARM_GXX = Tool(
    "arm-none-eabi-g++",
    "LDC_ARM_CXX",
    "gcc-arm-none-eabi libstdc++-arm-none-eabi-newlib",
    "compiles C++ for Cortex-M",
)
QEMU_ARM = Tool("qemu-system-arm", "LDC_QEMU_ARM", "qemu-system-arm", "runs firmware on emulated boards")


def find(tool: Tool, diagnostics: Diagnostics | None = None) -> str | None:
    """The path of a tool, or None with a finding that tells what to install."""
    wanted = os.environ.get(tool.variable) or tool.command
    found = shutil.which(wanted)
    if found is None and diagnostics is not None:
        findings.no_tool(diagnostics, wanted, tool.purpose, tool.package, tool.variable)
    return found


@record
class Said:
    """One line of a compiler: ``level`` is error or warning; ``line`` and ``column`` from 1."""

    file: str
    line: int
    column: int
    level: str
    text: str


def run(command: Sequence[str], timeout: float = 120.0) -> tuple[int, str, list[Said]]:
    """Exit status, standard output and what the compiler said. A tool that hangs is stopped (status -1)."""
    environment = {**os.environ, "LC_ALL": "C"}
    try:
        done = subprocess.run(command, capture_output=True, timeout=timeout, env=environment, check=False)
    except subprocess.TimeoutExpired:
        return -1, "", [Said("", 0, 0, "error", f"{command[0]} was stopped after {timeout:g} s")]
    text = done.stderr.decode("utf-8", "replace")
    said = [
        Said(m[1], int(m[2]), int(m[3] or 1), "warning" if m[4] == "warning" else "error", m[5])
        for m in _MESSAGE.finditer(text)
    ]
    said += [Said(m[1], int(m[2]), 1, "error", m[3]) for m in _UNDEFINED.finditer(text)]
    if done.returncode and not any(s.level == "error" for s in said):
        # What the driver says of its linker last tells nothing.
        lines = [line for line in text.splitlines() if line.strip() and not line.startswith("collect2:")]
        silent = f"{os.path.basename(command[0])} ended with status {done.returncode}"
        words = lines[-1].strip() if lines else silent
        said.append(Said("", 0, 0, "error", words))
    return done.returncode, done.stdout.decode("utf-8", "replace"), said


def report(
    said: Sequence[Said], sources: Mapping[str, SourceFile], where: Span, diagnostics: Diagnostics
) -> None:
    """Compiler messages as findings at the author's lines; those of other files at ``where``. ``sources``: by
    the name that the compiler was given, or by absolute path."""
    for message in said:
        source = sources.get(message.file) or sources.get(str(Path(message.file).resolve()))
        if source is not None and 1 <= message.line <= len(source.line_starts):
            span = _word(source, message.line, message.column)
        else:
            span = where
        findings.compiler(diagnostics, span, message.text, message.level == "warning")


def _word(source: SourceFile, line: int, column: int) -> Span:
    """The word at a column; the whole line when it does not reach that far, as after a macro."""
    start = source.line_starts[line - 1] + column - 1
    if column <= 1 or column > len(source.line(line)):
        return source.line_span(line)
    word = re.compile(r"\w+|.").match(source.text, start)
    return Span(source, word.start(), word.end())


def touched(path: Path) -> bool:
    """Whether a file of compiled code is there; it then counts as used now."""
    try:
        os.utime(path)
    except OSError:
        return False
    return True


def prune(cache: Path) -> None:
    """Keeps a folder of compiled code bounded: what was not used for longest goes."""
    used = []
    for path in cache.glob("*.[os]*"):
        try:
            used.append((path.stat().st_mtime, path))
        except FileNotFoundError:
            continue  # another build gave it its name, or took it away
    for _, path in sorted(used, reverse=True)[MOST_KEPT:]:
        path.unlink(missing_ok=True)
