"""What is known of components that were rewritten before: the symbols that they name, and their library.

Reading C costs more than all else in the start of a program with components, so it is done once for a
component as it stands: its descriptor, sources, headers, generated header, flags and compiler, and this
package. A source that includes a file from outside of its folder, which may change without notice, is read
each time.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable
from functools import cache
from pathlib import Path

import msgspec

from ldc.components.find import own_files, quoted
from ldc.components.descriptor import Component
from ldc.diagnostics import Diagnostics
from ldc.parser.tables import cache_folder, store

Key = tuple[str, str]


class Kept(msgspec.Struct, frozen=True):
    """``reads`` and ``writes``: symbols by macro and name; ``library``: the name of its file."""

    reads: tuple[Key, ...]
    writes: tuple[Key, ...]
    library: str


def folder() -> Path:
    """Where libraries of components are."""
    return cache_folder() / "components"


def key(component: Component, header: tuple[str, str], compiler: str, flags: Iterable[str]) -> str | None:
    """The name of what a component is made from, None when a part of it is unknown. ``header``: name and text
    of the generated one."""
    diagnostics = Diagnostics()
    files = own_files(component, diagnostics)
    root, parts = component.folder.resolve(), [_package(), *header, compiler, *flags, component.source.text]
    for path in sorted(files):
        parts += (path, files[path].text)
        for name in quoted(files[path].text):
            if name != header[0] and not any(str((at / name).resolve()) in files
                                             for at in (Path(path).parent, root)):
                return None
    if diagnostics.has_errors or any(flag.startswith(("-I", "-include", "-isystem")) for flag in flags):
        return None
    at = os.stat(os.path.realpath(compiler))
    parts += (str(at.st_size), str(at.st_mtime_ns))
    return hashlib.sha256("\0".join(parts).encode("utf-8", "surrogateescape")).hexdigest()[:32]


def look(name: str | None) -> Kept | None:
    """What was kept under a name."""
    if name is None:
        return None
    path = folder() / f"{name}.seen"
    try:
        found = msgspec.json.decode(path.read_bytes(), type=Kept)
        os.utime(path)
    except (OSError, msgspec.DecodeError):
        return None
    return found


def keep(name: str | None, known: Kept) -> None:
    """Keeps it for the next time."""
    if name is not None:
        store(folder() / f"{name}.seen", msgspec.json.encode(known).decode())


@cache
def _package() -> str:
    """SHA-256 of what rewrites components."""
    digest, root = hashlib.sha256(), Path(__file__).parent
    for path in sorted(p for p in root.rglob("*") if p.suffix in (".py", ".h")):
        digest.update(f"\0{path.relative_to(root)}\0".encode() + path.read_bytes())
    return digest.hexdigest()
