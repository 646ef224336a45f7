"""A BuildPlan into a shared object: gcc for the files that no cache holds, then one link.

Objects are kept by the digest of their file, the compiler and its flags, in ``$XDG_CACHE_HOME/ldc``; an
edited rung recompiles the chunk that it lies in. ``LDC_CC`` names another compiler.
"""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from ldc import unfinished
from ldc.backends.c.emit import HEADER, BuildPlan, File
from ldc.components import toolchain
from ldc.components.toolchain import Tool
from ldc.diagnostics import Diagnostics
from ldc.records import record

FLAGS = ("-std=c11", "-O1", "-fPIC", "-fwrapv", "-ffp-contract=off", "-fno-strict-aliasing",
         "-fvisibility=hidden", "-fno-gnu-unique", "-fno-asynchronous-unwind-tables")
SANITIZE = ("-g", "-fsanitize=undefined", "-fno-sanitize-recover=undefined")


class CompilerFailed(Exception):
    """The compiler refused a file; ``output`` is what it said."""

    def __init__(self, command: str, output: str) -> None:
        self.output = output
        lines = output.strip().splitlines() or ["it says nothing"]
        super().__init__(f"the C compiler `{command}` failed: {' '.join(lines[:3])}")


@record
class Artifact:
    """``path``: the shared object, of its own name for every build; ``compiled``: files that gcc ran for."""

    path: Path
    plan: BuildPlan
    compiled: tuple[str, ...]


@record
class Compiler:
    """A command that takes the options of gcc, and what identifies it."""

    path: str
    identity: str


def find_compiler(diagnostics: Diagnostics, tool: Tool = toolchain.GCC) -> Compiler | None:
    """gcc, or what LDC_CC names; None, with a finding that tells what to install, when it is not there.
    ``tool``: another one."""
    path = toolchain.find(tool, diagnostics)
    if path is None:
        return None
    try:
        found = subprocess.run([path, "-dumpfullversion", "-dumpmachine"], capture_output=True, text=True,
                               check=False, stdin=subprocess.DEVNULL)
    except OSError as error:
        raise CompilerFailed(os.path.basename(path), str(error)) from error
    return Compiler(path, f"{path} {found.stdout}")


def cache_folder() -> Path:
    """Where objects are kept."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "ldc" / "native"


def build(plan: BuildPlan, compiler: Compiler, folder: Path | None = None, cache: Path | None = None
          ) -> Artifact:
    """The shared object of a plan, in ``folder`` (None: in the cache). Raises CompilerFailed, and OSError
    when a folder cannot be written."""
    cache = cache_folder() if cache is None else cache
    target = (cache if folder is None else folder) / f"program-{_name(plan.digest, compiler)[:16]}.so"
    objects, missing = compiled(plan.files, {HEADER: plan.header}, plan.flags, compiler, cache)
    if not missing and target.exists():
        return Artifact(target, plan, ())
    target.parent.mkdir(parents=True, exist_ok=True)
    with unfinished.folder_in(target.parent) as made:
        partial = made / target.name
        run([compiler.path, *_sanitizers(plan), "-shared", "-o", str(partial), *map(str, objects), "-lm"])
        os.replace(partial, target)
    toolchain.prune(cache)
    return Artifact(target, plan, missing)


def compiled(files: Sequence[File], headers: Mapping[str, str], flags: Sequence[str], compiler: Compiler,
             cache: Path) -> tuple[list[Path], tuple[str, ...]]:
    """The objects of files in their order, and the names of those that the compiler ran for. ``headers``:
    what they include, by name; the digests of files cover it. Raises CompilerFailed, and OSError when the
    cache cannot be written."""
    cache.mkdir(parents=True, exist_ok=True)
    objects = {file: cache / f"{_name(file.digest, compiler)}.o" for file in files}
    missing = [file for file, path in objects.items() if not toolchain.touched(path)]
    if missing:
        whole = "\0".join(text for pair in headers.items() for text in pair)
        folder = cache / f"include-{hashlib.sha256(whole.encode()).hexdigest()[:16]}"
        for name, text in headers.items():
            placed(text.encode(), folder / name)
        # The longest first, so that no processor waits for the last one alone.
        missing.sort(key=lambda file: -len(file.text))
        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            list(pool.map(lambda file: _compile(compiler, flags, file, folder, objects[file]), missing))
    return list(objects.values()), tuple(file.name for file in missing)


def _name(digest: str, compiler: Compiler) -> str:
    return hashlib.sha256(f"{digest}\0{compiler.identity}".encode()).hexdigest()


def _compile(compiler: Compiler, flags: Sequence[str], file: File, headers: Path, target: Path) -> None:
    with unfinished.folder_in(target.parent) as folder:
        partial = folder / target.name
        run([compiler.path, *flags, "-I", str(headers), "-x", "c", "-c", "-o", str(partial), "-"], file.text)
        os.replace(partial, target)


def run(command: Sequence[str], text: str = "") -> str:
    """What a compiler or a tool of it prints on ``text``. Raises CompilerFailed."""
    try:
        done = subprocess.run(command, input=text, capture_output=True, text=True, check=False,
                              errors="replace")
    except OSError as error:
        raise CompilerFailed(os.path.basename(command[0]), str(error)) from error
    if done.returncode:
        raise CompilerFailed(os.path.basename(command[0]), done.stderr)
    return done.stdout


def _sanitizers(plan: BuildPlan) -> list[str]:
    """What the link has to be told as well."""
    return [flag for flag in plan.flags if flag.startswith("-fsanitize")]


def beside(compiler: str, tool: str) -> str:
    """A tool that comes with a compiler: ``arm-none-eabi-gcc`` has an ``arm-none-eabi-objcopy``."""
    folder, name = os.path.split(compiler)
    return os.path.join(folder, re.sub(r"(gcc|g\+\+)(-[\d.]+)?$", tool, name))


def placed(data: bytes, path: Path) -> None:
    """Writes a file that is there whole or not at all, if it is not there."""
    if path.exists():
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with unfinished.file_in(path.parent) as file:
        file.write(data)
        unfinished.named(file, path)
