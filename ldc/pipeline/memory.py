"""What earlier compiles made of rungs, kept in a file of the user's cache (docs/incremental.md).

An entry is found by all that it depends on, so it is never stale; the file is named after the compiler's own
code, so that another compiler begins anew. What the last compile did not use is not kept: a file is as large
as its program. A file that is damaged, or of something else, counts as none.
"""

from __future__ import annotations

import hashlib
import os
import sys
from functools import cache
from pathlib import Path

import msgspec

import ldc
from ldc import unfinished
from ldc.il.image import Reader, Writer
from ldc.parser.unread import Head

_FILES = 32
_MOST = 256 << 20
_MOST_TYPES = 20_000
_encode, _decode = msgspec.msgpack.Encoder().encode, msgspec.msgpack.Decoder().decode
_whole = msgspec.msgpack.Decoder(tuple[list, dict[str, bytes], dict[bytes, bytes]])


class Memory:
    """Texts of rungs with their heads, rows of code by name. Names are digests of what code depends on."""

    def __init__(self, path: Path) -> None:
        """Reads the file, if it is there. Entries stay bytes until they are asked for."""
        self.path = path
        types, self._heads, self._rows = _read(path) or ([], {}, {})
        self._used_heads: dict[str, bytes] = {}
        self._used_rows: dict[bytes, bytes] = {}
        self._new = False
        self.reader = Reader([types], [[], [], ""])
        self.writer = Writer(types, {type_: number for number, type_ in enumerate(self.reader.types)})

    def head(self, text: str) -> Head | None:
        """What is known of the text of a rung."""
        data = self._heads.get(text)
        if data is None:
            return None
        self._used_heads[text] = data
        name, title, at, jumps, calls, stem = _decode(data)
        return Head(name, title, at, tuple(jumps), frozenset(calls), stem)

    def rows(self, name: bytes) -> list | None:
        """The rows that were kept under a name."""
        data = self._rows.get(name)
        if data is None:
            return None
        self._used_rows[name] = data
        return _decode(data)

    def keep(self, text: str, head: Head, name: bytes, rows: list) -> None:
        """Keeps what was made of a rung that nothing was told about."""
        row = [head.name, head.title, head.name_at, head.jumps, sorted(head.calls), head.stem]
        self._used_heads[text] = _encode(row)
        self._used_rows[name] = _encode(rows)
        self._new = True

    def save(self) -> None:
        """Writes what was used and kept since the file was read, whole or not at all. A cache that cannot be
        written is none."""
        gone = len(self._used_rows) < len(self._rows) or len(self._used_heads) < len(self._heads)
        if not (self._new or gone) or len(self.writer.types) > _MOST_TYPES:
            return
        data = _encode([self.writer.types, self._used_heads, self._used_rows])
        if len(data) > _MOST:
            return
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            with unfinished.file_in(self.path.parent) as file:
                file.write(hashlib.sha256(data).digest() + data)
                unfinished.named(file, self.path)
            _prune(self.path.parent)
        except OSError:
            return


def memory_of(project: str) -> Memory:
    """The memory of a project, by the path of its folder or file."""
    path = os.fsencode(os.path.abspath(project))
    name = hashlib.sha256(_compiler().encode() + b"\0" + path).hexdigest()[:32]
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Memory(Path(base) / "ldc" / "rungs" / f"{name}.rungs")


def _read(path: Path) -> tuple[list, dict[str, bytes], dict[bytes, bytes]] | None:
    try:
        if path.stat().st_uid != os.getuid():
            return None
        data = path.read_bytes()
        if hashlib.sha256(data[32:]).digest() != data[:32]:
            return None
        found = _whole.decode(data[32:])
        os.utime(path)
    except (OSError, msgspec.DecodeError, ValueError):
        return None
    return found


def _prune(folder: Path) -> None:
    """The files of the projects that were compiled last stay."""
    files = sorted(((path.stat().st_mtime, path) for path in folder.glob("*.rungs")), reverse=True)
    for _, path in files[_FILES:]:
        path.unlink(missing_ok=True)


@cache
def _compiler() -> str:
    """SHA-256 of all that this compiler consists of."""
    digest = hashlib.sha256(sys.version.encode())
    root = Path(ldc.__file__).parent
    for path in sorted(p for p in root.rglob("*") if p.suffix in (".py", ".il", ".st", ".lark", ".toml")):
        digest.update(f"\0{path.relative_to(root)}\0".encode() + path.read_bytes())
    return digest.hexdigest()
