"""What a receiver asks of an envelope before it takes it: nine codes, the first that fails is told (SPEC
2.4)."""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from math import inf, isfinite

from ldc.records import record
from runtime.protocol.envelope import HEAD, Command, Envelope, Head, decode, head, intact, successor, token


class Code(IntEnum):
    """1 to 9: why an envelope is refused. SILENT, STUCK: what a sender finds by itself."""

    OK = 0
    LEN = 1
    CRC = 2
    SEQ = 3
    AID = 4
    PID = 5
    TYPE = 6
    RANGE = 7
    STATE = 8
    STALE = 9
    SILENT = 10
    STUCK = 11


CODES = tuple(Code(n) for n in range(Code.STALE + 1))
"""Those that an answer can have, by number."""

TRANSIENT = frozenset((Code.CRC, Code.SEQ, Code.SILENT))
"""Codes after which the same envelope is sent again."""


@record
class Parameter:
    """``type``: f32, i32, u32 or bool32. ``rate``: the most that it may differ from its last value."""

    pid: int
    type: str = "f32"
    min: float = -inf
    max: float = inf
    rate: float = inf


@dataclass(frozen=True, slots=True)
class Algorithm:
    """What one algorithm takes. ``stamp``: the pid of the parameter that holds the time of the data, in ms of
    the common clock modulo 2^32; data older than ``max_age_ms`` are stale."""

    aid: int
    parameters: tuple[Parameter, ...] = ()
    stamp: int | None = None
    max_age_ms: int = 0
    layout: Layout = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        types = {p.pid: p.type for p in self.parameters}
        if len(types) < len(self.parameters):
            raise ValueError(f"algorithm {self.aid:#x}: two parameters have one pid")
        if self.stamp is not None and types.get(self.stamp) != "u32":
            raise ValueError(f"algorithm {self.aid:#x}: its stamp is no parameter of type u32")
        object.__setattr__(self, "layout", _layout(self.parameters))

    def packed(self, values: Sequence[float]) -> bytes:
        """The data of an envelope with these values, in the order of the parameters. Raises struct.error."""
        words = [*self.layout.pids] * 2
        words[::2], words[1::2] = self.layout.pids, values
        return self.layout.words.pack(*words)


@record
class Layout:
    """What is known of the data before any come. ``words``: pid and value of each parameter in order;
    ``floats``, ``bools``: the places of such parameters; ``limited``: those that have limits, with these;
    ``rated``: those that may not differ too much from their last values."""

    pids: tuple[int, ...]
    words: struct.Struct
    floats: tuple[int, ...]
    bools: tuple[int, ...]
    limited: tuple[tuple[int, float, float], ...]
    rated: tuple[tuple[int, Parameter], ...]


def _layout(parameters: tuple[Parameter, ...]) -> Layout:
    return Layout(
        pids=tuple(p.pid for p in parameters),
        words=struct.Struct("<" + "".join("I" + _FORMATS[p.type] for p in parameters)),
        floats=tuple(n for n, p in enumerate(parameters) if p.type == "f32"),
        bools=tuple(n for n, p in enumerate(parameters) if p.type == "bool32"),
        limited=tuple((n, p.min, p.max) for n, p in enumerate(parameters) if (p.min, p.max) != (-inf, inf)),
        rated=tuple((n, p) for n, p in enumerate(parameters) if p.rate != inf),
    )


_FORMATS = {"f32": "f", "i32": "i", "u32": "I", "bool32": "I"}


@dataclass(frozen=True, slots=True)
class Situation:
    """What a receiver knows when it checks: its algorithms, those that run, the values they have, (aid, pid)
    the key, and the time in ms. ``ended``: those that have ended by themselves; an UPDATE of one is taken,
    for its sender may not know yet."""

    algorithms: Mapping[int, Algorithm] = field(default_factory=dict)
    running: frozenset[int] = frozenset()
    values: Mapping[tuple[int, int], float] = field(default_factory=dict)
    now_ms: int = 0
    ended: frozenset[int] = frozenset()


@record
class Verdict:
    """``token``: as the answer calls it; ``envelope``: None when its bytes cannot be trusted (LEN, CRC);
    ``again``: it was taken before; ``values``: of its parameters, in their order, when it is OK."""

    code: Code
    token: int
    envelope: Envelope | None = None
    again: bool = False
    values: tuple[float, ...] = ()


def check(slot: bytes, previous: Envelope | None, situation: Situation) -> Verdict:
    """Judges the bytes of a whole slot. ``previous``: the last envelope that was taken.

    A repetition of it is OK whatever has changed since: it is answered, not taken twice.
    """
    h = head(slot)
    name = token(h.seq, h.aid, h.cmd)
    algorithm = situation.algorithms.get(h.aid)
    if h.len > len(slot) - HEAD or h.len % 4 or h.len != _due(h, algorithm):
        return Verdict(Code.LEN, name)
    if not intact(h, slot):
        return Verdict(Code.CRC, name)
    envelope = decode(h, slot)
    if previous is not None and h.seq == previous.seq and envelope.content() == previous.content():
        return Verdict(_OK, name, envelope, again=True)
    resets = h.cmd == _RESET
    due = 0 if resets else successor(previous.seq if previous is not None else 0)
    if h.seq != due:
        return Verdict(Code.SEQ, name, envelope)
    if resets:
        return Verdict(_OK, name, envelope)
    if algorithm is None:
        return Verdict(Code.AID, name, envelope)
    code, values = _of_data(envelope, algorithm, situation)
    return Verdict(code, name, envelope, False, values)


_OK = Code.OK
_START, _UPDATE, _STOP, _RESET = (int(c) for c in Command)


def _due(h: Head, algorithm: Algorithm | None) -> int:
    """The length that the command has; that of an unknown algorithm is its own."""
    if h.cmd in (_STOP, _RESET):
        return 0
    return h.len if algorithm is None else algorithm.layout.words.size


def _of_data(envelope: Envelope, algorithm: Algorithm, situation: Situation) -> tuple[Code, tuple]:
    """The code, and the values in the order of the parameters."""
    cmd, runs, values = envelope.cmd, algorithm.aid in situation.running, ()
    if cmd != _STOP:
        values = _in_order(envelope.adata, algorithm)
        if values is None:
            return Code.PID, ()
        code = _of_values(values, algorithm, situation)
        if code is not _OK:
            return code, values
    updated = runs or algorithm.aid in situation.ended
    if cmd not in (_START, _UPDATE, _STOP) or cmd == _START and runs or cmd == _UPDATE and not updated:
        return Code.STATE, values
    if algorithm.stamp is None or not values:
        return _OK, values
    age = situation.now_ms - values[algorithm.layout.pids.index(algorithm.stamp)] & 0xFFFFFFFF
    return Code.STALE if age > algorithm.max_age_ms else _OK, values


def _in_order(adata: bytes, algorithm: Algorithm) -> tuple | None:
    """The values in the order of the parameters, in which they nearly always come; None when a pid is
    missing, there twice or none of the algorithm's."""
    pids, words = algorithm.layout.pids, algorithm.layout.words
    found = words.unpack(adata)
    if found[::2] == pids:
        return found[1::2]
    raw = dict(struct.iter_unpack("<I4s", adata))
    if raw.keys() != set(pids):
        return None
    return words.unpack(b"".join(struct.pack("<I4s", pid, raw[pid]) for pid in pids))[1::2]


def _of_values(values: tuple, algorithm: Algorithm, situation: Situation) -> Code:
    layout = algorithm.layout
    if layout.floats and not isfinite(sum(values)):  # 32 bits each: a sum of finite ones is finite
        return Code.TYPE
    for n in layout.bools:
        if values[n] > 1:
            return Code.TYPE
    for n, low, high in layout.limited:
        if not low <= values[n] <= high:
            return Code.RANGE
    for n, p in layout.rated:
        last = situation.values.get((algorithm.aid, p.pid))
        if last is not None and not abs(values[n] - last) <= p.rate:
            return Code.RANGE
    return _OK


def adata_of(values: Mapping[int, float], algorithm: Algorithm) -> bytes:
    """The data of an envelope, in the order of the algorithm's parameters. Raises KeyError, struct.error."""
    return algorithm.packed([values[pid] for pid in algorithm.layout.pids])
