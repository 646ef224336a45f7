"""From a command to the runtime: where its socket is, who the client is, one request and its answer."""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import secrets
import socket
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from ldc import unfinished
from ldc.cli.console import Failure, reason
from ldc.diagnostics import Diagnostics, Invalid
from ldc.manifest import Sources
from runtime.online import wire
from runtime.online.wire import Answer, Request

_MOST = 100
"""Bytes of the path of a socket; the system takes 107."""


def name_of(sources: Sources) -> str:
    """What a runtime is called: by its project, else by its first file."""
    if sources.manifest:
        return sources.manifest.name
    return Path(sources.files[0].name).stem if sources.files else "program"


def socket_path(asked: str | None, name: str) -> Path:
    """The socket that is asked for, that of LDC_SOCKET, or the one of a name in a private folder of the user.
    Raises Failure for a path that is too long for a socket."""
    chosen = asked or os.environ.get("LDC_SOCKET")
    path = Path(chosen) if chosen else _folder() / f"{re.sub(r'[^A-Za-z0-9_.-]', '_', name)[:40]}.sock"
    if len(os.fsencode(path.absolute())) > _MOST:
        raise Failure(f"the path of the socket is longer than {_MOST} bytes: {path}")
    return path


def _folder() -> Path:
    """``$XDG_RUNTIME_DIR/ldc``, else one among temporary files; only this user may enter it."""
    base = os.environ.get("XDG_RUNTIME_DIR")
    path = Path(base) / "ldc" if base else Path("/tmp") / f"ldc-{os.getuid()}"
    try:
        path.mkdir(mode=0o700, exist_ok=True)
        found = path.lstat()
    except OSError as error:
        raise Failure(f"cannot make the folder of the socket: {reason(error)}") from error
    if found.st_uid != os.getuid() or found.st_mode & 0o077 or path.is_symlink():
        raise Failure(f"`{path}` must be a folder that only you may enter: `chmod 700` it, or set LDC_SOCKET")
    return path


def state_folder() -> Path:
    """Where audit logs and the secret of this user's clients lie: ``$XDG_STATE_HOME/ldc``."""
    base = os.environ.get("XDG_STATE_HOME")
    return (Path(base) if base else Path.home() / ".local" / "state") / "ldc"


def owner_of(sources: Sequence[str]) -> str:
    """By what the runtime knows a client again: one for each working copy of this user, that others cannot
    guess. Raises Failure when the secret cannot be kept."""
    path = state_folder() / "client"
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        if path.exists() and not path.stat().st_size:
            path.unlink()  # of an ldc that had no room to fill it
        if not path.exists():
            _keep_secret(path)
        secret = path.read_text(encoding="ascii")
    except (OSError, UnicodeDecodeError) as error:
        raise Failure(f"cannot keep the secret of this client: {error}") from error
    place = Path(sources[0]).resolve()
    folder = place if place.is_dir() else place.parent
    return hashlib.sha256(secret.encode() + b"\0" + os.fsencode(folder)).hexdigest()


def _keep_secret(path: Path) -> None:
    """Makes the file, whole or not at all; of several clients that do it at once the first one's counts.
    Raises OSError."""
    with unfinished.file_in(path.parent, 0o600) as file:
        file.write(secrets.token_hex(32).encode("ascii"))
        file.flush()
        with suppress(FileExistsError):
            os.link(file.name, path)


def ask(path: Path, request: Request) -> Answer:
    """The answer of the runtime. Raises Invalid: what it refuses, or LD0828 when none answers."""
    try:
        with socket.socket(socket.AF_UNIX) as connection:
            connection.settimeout(wire.PATIENCE)
            connection.connect(str(path))
            wire.send(connection, request)
            if not connection.recv(1, socket.MSG_PEEK):
                raise ConnectionAbortedError("it ended before it answered")
            answer = wire.receive(connection, Answer)
    except OSError as error:
        found = Diagnostics()
        found.error("LD0828", f"no runtime answers at `{path}`: {error.strerror or error}",
                    help="start one with `ldc run SRC --online`; `--socket` or LDC_SOCKET name another place")
        raise Invalid(found) from error
    if answer.findings:
        raise Invalid([wire.diagnostic(found) for found in answer.findings])
    return answer


def runtime_of(options: argparse.Namespace, sources: Sources) -> Path:
    """The socket of the runtime that a command means."""
    return socket_path(options.socket, name_of(sources))
