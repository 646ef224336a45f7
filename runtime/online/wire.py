"""Messages of online change: msgpack behind a length, on a local socket (docs/online.md, "Protocol").

A message is four bytes of length (big-endian, at most ``LIMIT``) and a map. One request, one answer, and the
connection ends. What has another shape, version or size is refused (LD0827), never guessed at.
"""

from __future__ import annotations

import socket
import struct
import time
from typing import TypeVar

import msgspec

from ldc.diagnostics import Diagnostic, Severity
from runtime.online import findings

VERSION = 1
LIMIT = 64 << 20
PATIENCE = 30.0
"""Seconds that one message may take."""

Message = TypeVar("Message")


class _Request(msgspec.Struct, tag_field="do", forbid_unknown_fields=True, kw_only=True):
    version: int = VERSION


class Status(_Request, tag="status"):
    """What runs, what is staged."""


class Pull(_Request, tag="pull"):
    """The image that runs, and its sources."""


class Report(_Request, tag="report"):
    """What the staged program would do to each symbol."""


class Part(msgspec.Struct, forbid_unknown_fields=True):
    """The compiled code of a component: ``library`` is a shared object that exports ``entry`` and takes
    ``size`` bytes with the globals ``shared``: name, offset, whether it is written (``Binding``)."""

    unit: str
    entry: str
    library: bytes
    size: int = 0
    shared: list[tuple[str, int, bool]] = []


class Stage(_Request, tag="stage"):
    """A program, compiled for the running one with the digest ``base``. ``library`` and ``parts``: native
    code and the places of its faults, None and empty for the virtual machine; ``areas``: bytes of I, Q and M
    in its memory. ``components``: the code of those in C and C++; ``together``: how its modules work together
    (``ldc.il.coordination_image``). ``watch``: paths that are shown when it runs, None: those that were
    before. ``owner``: a secret of the client, by which it is known again."""

    image: bytes
    sources: list[tuple[str, str]]
    base: str
    owner: str
    library: bytes | None = None
    parts: list[tuple[str, list[int]]] = []
    areas: dict[str, int] = {}
    components: list[Part] = []
    together: bytes | None = None
    watch: list[str] | None = None


class Act(_Request, tag="act"):
    """``action``: test, untest, commit or cancel. ``limit_ns``: of a test; ``force``: of cancel."""

    action: str
    owner: str
    limit_ns: int | None = None
    force: bool = False


class Get(_Request, tag="get"):
    """Values of some variables, all of one moment between two scans."""

    paths: list[str]


class Set(_Request, tag="set"):
    """One variable gets a value, once. Values are texts, as people write them."""

    path: str
    value: str
    owner: str


class Force(_Request, tag="force"):
    """One variable holds a value until it is let go."""

    path: str
    value: str
    owner: str


class Unforce(_Request, tag="unforce"):
    """Lets a variable go, without ``path`` all of them."""

    owner: str
    path: str | None = None


class Forced(_Request, tag="forced"):
    """All forces."""


class Arm(_Request, tag="arm"):
    """Begins a trace around an event; the answer comes at once."""

    paths: list[str]
    trigger: str
    before: int
    after: int
    owner: str


class Collect(_Request, tag="collect"):
    """Rows of the trace that this client began, from the row ``first`` on, when all are there."""

    owner: str
    first: int = 0


Request = Status | Pull | Report | Stage | Act | Get | Set | Force | Unforce | Forced | Arm | Collect


class Finding(msgspec.Struct, forbid_unknown_fields=True):
    """A diagnostic without a place; ``about``: the path or name of what it is about."""

    code: str
    message: str
    help: str
    severity: str = "error"
    about: str = ""


class State(msgspec.Struct, forbid_unknown_fields=True):
    """``state``: running, staged or testing; ``left_ns``: of a test. ``last``: how the last change ended.
    ``client``: who staged a program, by the name that the audit log has too. ``waits``: what the
    sequence waits for, in words. ``settings``: digest of all that ldc.toml and the command line say of what
    runs."""

    name: str
    engine: str
    state: str
    digest: str
    staged: str
    scans: int
    now_ns: int
    left_ns: int
    faults: list[Finding]
    resource: int
    areas: dict[str, int]
    client: str = ""
    last: str = ""
    pause_ns: int = 0
    waits: str = ""
    settings: str = ""


class Changes(msgspec.Struct, forbid_unknown_fields=True):
    """Paths by what becomes of them."""

    kept: list[str]
    initialised: list[str]
    dropped: list[str]


class Value(msgspec.Struct, forbid_unknown_fields=True):
    """``value`` as traces print it."""

    path: str
    type: str
    value: str

    @property
    def shown(self) -> str:
        """For people: a time has its unit."""
        return f"{self.value} ms" if self.type == "TIME" else self.value


class Trace(msgspec.Struct, forbid_unknown_fields=True):
    """``state``: waiting (for the event), filling, done, lost (its variable is not in the program any more);
    ``text``: rows up to ``next`` of ``rows``, in the form of a trace; ``event``: the scan of the event."""

    state: str
    text: str = ""
    next: int = 0
    rows: int = 0
    event: int = -1


class Answer(msgspec.Struct, forbid_unknown_fields=True, kw_only=True):
    """``findings``: why a request was refused; what was asked for otherwise. ``settings``: what the runtime
    was started with and keeps, by names that clients know (``ldc.cli.settled``)."""

    version: int = VERSION
    findings: list[Finding] = []
    state: State | None = None
    changes: Changes | None = None
    image: bytes | None = None
    together: bytes | None = None
    sources: list[tuple[str, str]] | None = None
    settings: dict[str, str] = {}
    values: list[Value] | None = None
    scan: int = 0
    now_ns: int = 0
    trace: Trace | None = None


def finding(diagnostic: Diagnostic) -> Finding:
    return Finding(diagnostic.code, diagnostic.message, diagnostic.help, str(diagnostic.severity),
                   diagnostic.about)


def diagnostic(found: Finding) -> Diagnostic:
    """Raises Invalid (LD0827) when the severity is none."""
    try:
        severity = Severity(found.severity)
    except ValueError:
        raise refuse(f"`{found.severity[:20]}` is no severity") from None
    return Diagnostic(found.code, found.message, None, (), found.help, severity, found.about)


def refuse(what: str) -> Exception:
    return findings.refused(findings.bad_message(what))


def send(connection: socket.socket, message: msgspec.Struct) -> None:
    """Raises OSError when the other end is gone, Invalid (LD0827) for a message that is too long."""
    data = msgspec.msgpack.encode(message)
    if len(data) > LIMIT:
        raise refuse(f"{len(data):,} bytes are more than the {LIMIT:,} of a message")
    connection.settimeout(PATIENCE)
    connection.sendall(struct.pack(">I", len(data)) + data)


def receive(connection: socket.socket, type_: type[Message]) -> Message:
    """What the other end says. Raises Invalid (LD0827) when it is no message, OSError when it is slow."""
    end = time.monotonic() + PATIENCE
    length, = struct.unpack(">I", _exactly(connection, 4, end))
    if length > LIMIT:
        raise refuse(f"it says that it has {length:,} bytes, {LIMIT:,} are possible")
    data = _exactly(connection, length, end)
    try:
        message = msgspec.msgpack.decode(data, type=type_)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as error:
        raise refuse(str(error)) from None
    if message.version != VERSION:
        raise refuse(f"it has version {message.version}, this ldc speaks version {VERSION}")
    return message


def leave(connection: socket.socket) -> None:
    """Ends a connection so that the other end can read the answer: what it still says is taken and forgotten,
    for a second at most."""
    connection.shutdown(socket.SHUT_WR)
    end = time.monotonic() + 1.0
    while (left := end - time.monotonic()) > 0:
        connection.settimeout(left)
        if not connection.recv(1 << 20):
            return


def _exactly(connection: socket.socket, count: int, end: float) -> bytes:
    parts, left = [], count
    while left:
        connection.settimeout(max(end - time.monotonic(), 0.001))
        part = connection.recv(min(left, 1 << 20))
        if not part:
            raise refuse("it ends too early" if parts or count > 4 else "there is none")
        parts.append(part)
        left -= len(part)
    return b"".join(parts)
