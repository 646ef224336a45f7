"""Retain files: what survives a restart, on the disk, whole or not at all (DESIGN section 4, docs/retain.md).

    LDCR, version (u32, big-endian), SHA-256 of the rest, then a map in msgpack (``Kept``)

A save writes a new file, brings it to the disk, gives the one before the name ``FILE.before`` and takes its
name. So at every moment one of the two names is a whole save. What is damaged is never replaced by age.
"""

from __future__ import annotations

import hashlib
import os
import struct
from dataclasses import dataclass
from pathlib import Path

import msgspec

from ldc import unfinished
from ldc.diagnostics import Diagnostic, Diagnostics, Invalid

MAGIC, VERSION = b"LDCR", 1
_HEAD = struct.Struct(">4sI32s")
_MOST = 256 << 20


class Entry(msgspec.Struct, array_like=True, frozen=True):
    """A scalar, or an array of scalars: ``path`` in capitals, ``type``: hash of its type (``ldc.il.layout``),
    ``data``: canonical bytes (``runtime.checksum``), of an array one behind the other."""

    path: str
    type: str
    data: bytes


class Kept(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """``name``: of the project; ``program``: SHA-256 of what ran; ``layout``: hash of its layout; ``scan``
    and ``now_ns``: after how many scans and at which time of the program it was saved."""

    name: str
    program: str
    layout: str
    scan: int
    now_ns: int
    entries: list[Entry]


class _Damaged(ValueError):
    """Not all that was saved."""


@dataclass(slots=True)
class Store:
    """The file and the one before it. ``spoiled``: what has the name is no whole save, or there is none: the
    next save replaces it and leaves the one before."""

    path: Path
    spoiled: bool = False

    @property
    def before(self) -> Path:
        return self.path.with_name(f"{self.path.name}.before")

    def load(self, found: Diagnostics) -> Kept | None:
        """The newest whole save, None without a file. Raises Invalid: LD0851 when there are files and none
        can be used, LD0854 for one that cannot be read; ``found`` gets LD0850 for a damaged newest one."""
        problems: list[str] = []
        for path in (self.path, self.before):
            try:
                kept = read(path)
            except FileNotFoundError:
                self.spoiled = self.spoiled or path == self.path
                continue
            except OSError as error:
                raise Invalid([unreachable("read", path, error)]) from error
            except _Damaged as error:
                self.spoiled = self.spoiled or path == self.path
                problems.append(str(error))
                continue
            if problems:
                found.warning("LD0850", f"the retain file `{self.path}` is damaged: {problems[0]}",
                              help=f"the save before it was used, of scan {kept.scan}; "
                              "what came after it is lost")
            return kept
        if problems:
            raise Invalid([_unusable(self.path, problems[0])])
        return None

    @property
    def foreign(self) -> bool:
        """There is something, and nothing of it was written by ``save``, whatever became of it since. Raises
        OSError."""
        begins = []
        for path in (self.path, self.before):
            try:
                with open(path, "rb") as file:
                    begins.append(file.read(len(MAGIC)))
            except FileNotFoundError:
                continue
        return any(begins) and MAGIC not in begins

    def save(self, kept: Kept) -> None:
        """On the disk when it returns. Raises OSError; the saves before are as they were then."""
        folder = self.path.parent
        with unfinished.file_in(folder, 0o600) as file:
            file.write(encode(kept))
            file.flush()
            os.fsync(file.fileno())
            if not self.spoiled:
                os.replace(self.path, self.before)
                self.spoiled = True  # there is none of that name until the next line
            unfinished.named(file, self.path)
            self.spoiled = False
        opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
        try:
            os.fsync(opened)
        finally:
            os.close(opened)

    def delete(self) -> None:
        """Both generations. Raises OSError."""
        self.path.unlink(missing_ok=True)
        self.before.unlink(missing_ok=True)
        self.spoiled = True


def encode(kept: Kept) -> bytes:
    """The bytes of a file; the same values give the same bytes on every engine."""
    body = msgspec.msgpack.encode(kept)
    return _HEAD.pack(MAGIC, VERSION, hashlib.sha256(body).digest()) + body


def read(path: Path) -> Kept:
    """Raises OSError; ``_Damaged`` when it is not what ``encode`` wrote; Invalid (LD0851) for another
    version, which may be whole."""
    with open(path, "rb") as file:
        data = file.read(_MOST)
    if len(data) < _HEAD.size:
        raise _Damaged(f"it has {len(data)} bytes, fewer than its head")
    magic, version, digest = _HEAD.unpack_from(data)
    if magic != MAGIC:
        raise _Damaged("it does not begin like a retain file")
    if version != VERSION:
        raise Invalid([_unusable(path, f"it has version {version}, this ldc reads version {VERSION}")])
    body = data[_HEAD.size:]
    if hashlib.sha256(body).digest() != digest:
        raise _Damaged("its checksum does not match")
    try:
        return msgspec.msgpack.decode(body, type=Kept)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise _Damaged(str(error)) from None


def _unusable(path: Path, why: str) -> Diagnostic:
    found = Diagnostics()
    found.error("LD0851", f"the retain file `{path}` cannot be used: {why}",
                help="put a copy of it back, or begin with initial values: `--start cold` replaces it at the "
                "first save, `--start origin` deletes it at once")
    return next(iter(found))


def unreachable(what: str, path: Path, error: OSError) -> Diagnostic:
    """LD0854: the disk does not let us."""
    found = Diagnostics()
    found.error("LD0854", f"cannot {what} the retain file `{path}`: {error.strerror or error}",
                help="name a file in a folder that you may write to, with --retain or `retain` under [run]")
    return next(iter(found))
