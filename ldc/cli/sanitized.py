"""`ldc run --sanitize`: the run again, in a Python that has the address sanitizer loaded, and what that says
as a finding at the line in C."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from ldc import pipeline
from ldc.cli.console import Failure, report
from ldc.components import toolchain
from ldc.components.find import own_files
from ldc.diagnostics import Diagnostics, Invalid
from ldc.patterns import Pattern

VARIABLE = "LDC_SANITIZED"
"""Set in the inner run: components are compiled with the sanitizers."""

_ASAN = Pattern(r"ERROR: AddressSanitizer: (.+?)(?: on (?:unknown )?address.*)?$", re.MULTILINE)
_UBSAN = Pattern(r"^(.+?):(\d+):(\d+): runtime error: (.+)$", re.MULTILINE)
_ACCESS = Pattern(r"^(READ|WRITE) of size (\d+)", re.MULTILINE)
_FRAME = Pattern(r"^\s*#\d+ \S+ in (\S+) (\S+?):(\d+)(?::\d+)?$", re.MULTILINE)


def inside() -> bool:
    """Whether this is the inner run."""
    return bool(os.environ.get(VARIABLE))


def run(arguments: Sequence[str], result: pipeline.Compiled) -> int:
    """The status of the inner run; what a sanitizer found is reported."""
    diagnostics = Diagnostics()
    gcc = toolchain.find(toolchain.GCC, diagnostics)
    if gcc is None:
        raise Invalid(diagnostics)
    library = subprocess.run(
        [gcc, "-print-file-name=libasan.so"], capture_output=True, text=True, check=False
    )
    path = Path(library.stdout.strip())
    if not path.is_absolute() or not path.exists():
        raise Failure(f"`{gcc}` has no address sanitizer: install libasan")
    environment = {
        **os.environ,
        VARIABLE: "1",
        "LD_PRELOAD": str(path),
        "PYTHONMALLOC": "malloc",
        "ASAN_OPTIONS": "detect_leaks=0:handle_sigfpe=1:handle_abort=1",
        "UBSAN_OPTIONS": "halt_on_error=1:print_stacktrace=1",
    }
    done = subprocess.run(
        [sys.executable, "-m", "ldc.cli", *arguments], env=environment, stderr=subprocess.PIPE, check=False
    )
    said = done.stderr.decode("utf-8", "replace")
    if not _ASAN.search(said) and not _UBSAN.search(said):
        sys.stderr.write(said)
        return done.returncode
    _tell(said, result, diagnostics)
    return report(diagnostics)


def _tell(said: str, result: pipeline.Compiled, diagnostics: Diagnostics) -> None:
    sources = {
        Path(source.path).resolve(): (native.component.name, source)
        for native in result.natives
        for source in own_files(native.component, diagnostics).values()
    }
    undefined, broken = _UBSAN.search(said), _ASAN.search(said)
    if undefined is not None:
        what, places = undefined[4], [(undefined[1], int(undefined[2]))]
    else:
        access = _ACCESS.search(said)
        what = broken[1] + (f", {access[1].lower()}s {access[2]} bytes" if access else "")
        places = [(match[2], int(match[3])) for match in _FRAME.finditer(said)]
    for file, line in places:
        found = sources.get(Path(file).resolve())
        if found is not None:
            name, source = found
            break
    else:
        name, source, line = "of this program", None, 0
    span = source.line_span(line) if source is not None else None
    diagnostics.error(
        "LD0806",
        f"component {name}: {what}",
        span,
        "here",
        help="found by the sanitizers of gcc; the inputs of this scan lead there",
    )
