"""What a receiver asks of an envelope before it takes it: nine codes, the first that fails is told (SPEC
2.4)."""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum

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


TRANSIENT = frozenset((Code.CRC, Code.SEQ, Code.SILENT))
"""Codes after which the same envelope is sent again."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """``type``: f32, i32, u32 or bool32. ``rate``: the most that it may differ from its last value."""

    pid: int
    type: str = "f32"
    min: float = -math.inf
    max: float = math.inf
    rate: float = math.inf


@dataclass(frozen=True, slots=True)
class Algorithm:
    """What one algorithm takes. ``stamp``: the pid of the parameter that holds the time of the data, in ms of
    the common clock modulo 2^32; data older than ``max_age_ms`` are stale."""

    aid: int
    parameters: tuple[Parameter, ...] = ()
    stamp: int | None = None
    max_age_ms: int = 0

    def __post_init__(self) -> None:
        types = {p.pid: p.type for p in self.parameters}
        if len(types) < len(self.parameters):
            raise ValueError(f"algorithm {self.aid:#x}: two parameters have one pid")
        if self.stamp is not None and types.get(self.stamp) != "u32":
            raise ValueError(f"algorithm {self.aid:#x}: its stamp is no parameter of type u32")


@dataclass(frozen=True, slots=True)
class Situation:
    """What a receiver knows when it checks: its algorithms, those that run, the values they have, (aid, pid)
    the key, and the time in ms."""

    algorithms: Mapping[int, Algorithm] = field(default_factory=dict)
    running: frozenset[int] = frozenset()
    values: Mapping[tuple[int, int], float] = field(default_factory=dict)
    now_ms: int = 0


@dataclass(frozen=True, slots=True)
class Verdict:
    """``token``: as the answer calls it; ``envelope``: None when its bytes cannot be trusted (LEN, CRC);
    ``again``: it was taken before."""

    code: Code
    token: int
    envelope: Envelope | None = None
    again: bool = False


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
    if previous is not None and envelope.content() == previous.content():
        return Verdict(Code.OK, name, envelope, again=True)
    due = successor(previous.seq if previous is not None else 0) if h.cmd != Command.RESET else 0
    if h.seq != due:
        return Verdict(Code.SEQ, name, envelope)
    if h.cmd == Command.RESET:
        return Verdict(Code.OK, name, envelope)
    code = Code.AID if algorithm is None else _of_data(envelope, algorithm, situation)
    return Verdict(code, name, envelope)


def _due(h: Head, algorithm: Algorithm | None) -> int:
    """The length that the command has; that of an unknown algorithm is its own."""
    if h.cmd in (Command.STOP, Command.RESET):
        return 0
    return h.len if algorithm is None else 8 * len(algorithm.parameters)


def _of_data(envelope: Envelope, algorithm: Algorithm, situation: Situation) -> Code:
    raw = dict(struct.iter_unpack("<I4s", envelope.adata))
    if envelope.cmd != Command.STOP and raw.keys() != {p.pid for p in algorithm.parameters}:
        return Code.PID
    values = {p.pid: value_of(raw[p.pid], p.type) for p in algorithm.parameters if p.pid in raw}
    if None in values.values():
        return Code.TYPE
    for p in algorithm.parameters:
        if p.pid in values and not _in_range(p, values[p.pid], situation.values.get((algorithm.aid, p.pid))):
            return Code.RANGE
    runs = algorithm.aid in situation.running
    if envelope.cmd not in (Command.START, Command.UPDATE, Command.STOP):
        return Code.STATE
    if envelope.cmd == Command.START and runs or envelope.cmd == Command.UPDATE and not runs:
        return Code.STATE
    age = situation.now_ms - values.get(algorithm.stamp, situation.now_ms) & 0xFFFFFFFF
    return Code.STALE if algorithm.stamp in values and age > algorithm.max_age_ms else Code.OK


def _in_range(p: Parameter, value: float, last: float | None) -> bool:
    return p.min <= value <= p.max and (last is None or abs(value - last) <= p.rate)


_FORMATS = {"f32": "<f", "i32": "<i", "u32": "<I", "bool32": "<I"}


def value_of(raw: bytes, type_: str) -> float | int | None:
    """The value of four bytes; None when they are none of the type: NaN, infinite, a BOOL other than 0 and
    1."""
    (value,) = struct.unpack(_FORMATS[type_], raw)
    if type_ == "f32" and not math.isfinite(value) or type_ == "bool32" and value > 1:
        return None
    return value


def values_of(envelope: Envelope, algorithm: Algorithm) -> dict[int, float]:
    """The parameters of an envelope that was checked, by pid."""
    types = {p.pid: p.type for p in algorithm.parameters}
    return {pid: value_of(raw, types[pid]) for pid, raw in struct.iter_unpack("<I4s", envelope.adata)}


def adata_of(values: Mapping[int, float], algorithm: Algorithm) -> bytes:
    """The data of an envelope, in the order of the algorithm's parameters. Raises KeyError, struct.error."""
    return b"".join(struct.pack("<I", p.pid) + struct.pack(_FORMATS[p.type], values[p.pid])
                    for p in algorithm.parameters)
