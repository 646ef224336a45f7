"""Python text compiled in a process of its own: a compile lasts long for large programs and lets no other
thread of its process run, nor those that scan."""

from __future__ import annotations

import marshal
import subprocess
import sys
from collections.abc import Mapping
from types import CodeType

_WORK = """import marshal, sys
texts = marshal.load(sys.stdin.buffer)
made = [compile(text, name, 'exec', dont_inherit=True, optimize=0) for name, text in texts]
marshal.dump(made, sys.stdout.buffer)
"""
_LEAST = 50_000


def compiled(texts: Mapping[str, str]) -> dict[str, CodeType]:
    """The code of each text by the name of its file. Raises OSError and CalledProcessError when there can be
    no such process."""
    if sum(map(len, texts.values())) < _LEAST:
        return here(texts)
    command = [sys.executable, "-I", "-S", "-c", _WORK]
    done = subprocess.run(command, input=marshal.dumps(list(texts.items())), capture_output=True, check=True)
    return dict(zip(texts, marshal.loads(done.stdout), strict=True))


def here(texts: Mapping[str, str]) -> dict[str, CodeType]:
    """The same in this process."""
    return {name: compile(text, name, "exec", dont_inherit=True, optimize=0) for name, text in texts.items()}
