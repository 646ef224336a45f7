"""A BuildPlan into a shared object: gcc for the files that no cache holds, then one link.

Objects are kept by the digest of their file, the compiler and its flags, in ``$XDG_CACHE_HOME/ldc``; an
edited rung recompiles the chunk that it lies in. ``LDC_CC`` names another compiler.
"""

from __future__ import annotations

import hashlib
import os
import secrets
import shlex
import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from ldc.backends.c.emit import HEADER, BuildPlan, File

FLAGS = ("-std=c11", "-O1", "-fPIC", "-fwrapv", "-ffp-contract=off", "-fno-strict-aliasing",
         "-fvisibility=hidden", "-fno-gnu-unique", "-fno-asynchronous-unwind-tables")
VARIABLE = "LDC_CC"
_MOST_KEPT = 4000


class NoCompiler(Exception):
    """There is no C compiler of the name ``command``."""

    def __init__(self, command: str) -> None:
        self.command = command
        super().__init__(f"no C compiler: there is no program `{command}`")


class CompilerFailed(Exception):
    """gcc refused a file; ``output`` is what it said."""

    def __init__(self, command: list[str], output: str) -> None:
        self.command, self.output = command, output
        super().__init__(f"`{shlex.join(command[:1])}` failed: {output.strip() or 'no message'}")


@dataclass(frozen=True, slots=True)
class Artifact:
    """``path``: the shared object, of its own name for every build; ``compiled``: files that gcc ran for."""

    path: Path
    plan: BuildPlan
    compiled: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Compiler:
    """A command that takes the options of gcc, and what identifies it."""

    command: tuple[str, ...]
    identity: str


def find_compiler() -> Compiler:
    """The compiler that LDC_CC names, else gcc. Raises NoCompiler."""
    command = tuple(shlex.split(os.environ.get(VARIABLE, ""))) or ("gcc",)
    path = shutil.which(command[0])
    if path is None:
        raise NoCompiler(command[0])
    try:
        found = subprocess.run([path, *command[1:], "-dumpfullversion", "-dumpmachine"], capture_output=True,
                               text=True, check=False, stdin=subprocess.DEVNULL)
    except OSError as error:
        raise NoCompiler(command[0]) from error
    return Compiler((path, *command[1:]), f"{' '.join(command)} {found.stdout}")


def cache_folder() -> Path:
    """Where objects are kept."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "ldc" / "native"


def build(plan: BuildPlan, folder: Path | None = None, cache: Path | None = None) -> Artifact:
    """The shared object of a plan, in ``folder`` (None: in the cache). Raises NoCompiler, CompilerFailed,
    OSError when a folder cannot be written."""
    compiler = find_compiler()
    cache = cache_folder() if cache is None else cache
    cache.mkdir(parents=True, exist_ok=True)
    objects = {file: cache / f"{_name(file.digest, compiler)}.o" for file in plan.files}
    missing = [file for file, path in objects.items() if not _touched(path)]
    target = (cache if folder is None else folder) / f"program-{_name(plan.digest, compiler)[:16]}.so"
    if not missing and target.exists():
        return Artifact(target, plan, ())
    if missing:
        header = cache / f"include-{hashlib.sha256(plan.header.encode()).hexdigest()[:16]}"
        _write(header / HEADER, plan.header.encode())
        # The longest first, so that no processor waits for the last one alone.
        missing.sort(key=lambda file: -len(file.text))
        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            list(pool.map(lambda file: _compile(compiler, plan, file, header, objects[file]), missing))
    target.parent.mkdir(parents=True, exist_ok=True)
    partial = _partial(target)
    try:
        _run([*compiler.command, "-shared", "-o", str(partial), *map(str, objects.values()), "-lm"])
        os.replace(partial, target)
    finally:
        partial.unlink(missing_ok=True)
    _prune(cache)
    return Artifact(target, plan, tuple(file.name for file in missing))


def _name(digest: str, compiler: Compiler) -> str:
    return hashlib.sha256(f"{digest}\0{compiler.identity}".encode()).hexdigest()


def _touched(path: Path) -> bool:
    """Whether the object is there; it then counts as used now."""
    try:
        os.utime(path)
    except OSError:
        return False
    return True


def _compile(compiler: Compiler, plan: BuildPlan, file: File, header: Path, target: Path) -> None:
    partial = _partial(target)
    try:
        _run([*compiler.command, *plan.flags, "-I", str(header), "-x", "c", "-c", "-o", str(partial), "-"],
             file.text)
        os.replace(partial, target)
    finally:
        partial.unlink(missing_ok=True)


def _run(command: list[str], text: str = "") -> None:
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=False, errors="replace")
    if done.returncode:
        raise CompilerFailed(command, done.stderr)


def _partial(path: Path) -> Path:
    return path.with_name(f".{path.name}.{secrets.token_hex(6)}")


def _write(path: Path, data: bytes) -> None:
    if path.exists():
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = _partial(path)
    partial.write_bytes(data)
    os.replace(partial, path)


def _prune(cache: Path) -> None:
    """Keeps the cache bounded: the objects that were not used for longest go."""
    kept = sorted(cache.glob("*.[os]*"), key=lambda path: path.stat().st_mtime, reverse=True)
    for path in kept[_MOST_KEPT:]:
        path.unlink(missing_ok=True)
