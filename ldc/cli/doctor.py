"""`ldc doctor`: what this machine has, what it lacks, and what each thing would enable."""

from __future__ import annotations

import argparse
import importlib.metadata
import platform
import re
import shutil
import subprocess

from ldc import __version__
from ldc.cli.console import OK, WRONG
from ldc.records import record


@record
class Tool:
    """A program outside Python. `install` is a Debian package."""

    command: str
    enables: str
    install: str


_TOOLS = (
    Tool("gcc", "native code (`ldc build`, `--engine native`) and components in C", "gcc"),
    Tool("arm-none-eabi-gcc", "firmware for Cortex-M (`ldc build --target cortex-m3`)",
         "gcc-arm-none-eabi libnewlib-arm-none-eabi"),
    Tool("qemu-system-arm", "running firmware (`ldc run --target cortex-m3`)", "qemu-system-arm"),
    Tool("dot", "pictures of `ldc compile --emit graph -o x.dot`", "graphviz"),
)


def run(options: argparse.Namespace) -> int:
    print(f"ldc {__version__}, Python {platform.python_version()}, {platform.system()} {platform.machine()}")
    print("\nPython packages")
    sound = True
    for name in _packages():
        version = _version(name)
        sound &= version is not None
        print(_row(version is not None, name, version or "missing: run script/bootstrap"))
    print("\ntools (none is needed to check, compile, draw or run)")
    for tool in _TOOLS:
        path = shutil.which(tool.command)
        if path:
            print(_row(True, tool.command, f"{_tool_version(path)}: {tool.enables}"))
        else:
            print(_row(False, tool.command, f"not found; for {tool.enables}: apt-get install {tool.install}"))
    return OK if sound else WRONG


def _row(there: bool, name: str, text: str) -> str:
    return f"  {'ok' if there else '--'}  {name:<18} {text}"


def _packages() -> list[str]:
    """What ldc itself needs, as its own package says."""
    try:
        needs = importlib.metadata.requires("ldc") or []
    except importlib.metadata.PackageNotFoundError:
        return []
    return [re.match(r"[\w.-]+", need)[0] for need in needs if "extra ==" not in need]


def _version(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _tool_version(path: str) -> str:
    """The first number with a dot that the tool's `--version` or `-V` prints."""
    for option in ("--version", "-V"):
        try:
            result = subprocess.run([path, option], capture_output=True, text=True, timeout=10, check=False)
        except (OSError, subprocess.TimeoutExpired):
            return "does not start"
        if match := re.search(r"\d+\.\d[\w.]*", result.stdout + result.stderr):
            return match[0]
    return "unknown version"
