"""Everything that firmware is made of, before any tool runs: files with digests, linker script, flags."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from struct import unpack

import jinja2

from ldc.backends.c import emit
from ldc.backends.c.emit import BuildPlan, File
from ldc.backends.firmware.board import Board
from ldc.il import block
from ldc.il.block import Block, Spot
from ldc.il.external import Binding
from ldc.types import Value

FLAGS = ("-std=c11", "-Os", "-g", "-ffreestanding", "-fwrapv", "-ffp-contract=off", "-fno-strict-aliasing",
         "-ffunction-sections", "-fdata-sections", "-fno-asynchronous-unwind-tables")
BITS = 0x8000_0000
TASKS_MOST = 64
_LONGEST = 128
_SYSTICK = 1 << 24
_ROOM = files("ldc.backends.firmware")
_RUNTIME = ("scan.c", "live.c")


@dataclass(frozen=True, slots=True)
class TaskPlan:
    """A task as firmware runs it, in order of priority. ``interval`` in nanoseconds, 0: every scan; ``single``:
    the variable of SINGLE; ``safe``: what outputs become when it is stopped."""

    name: str
    interval: int
    watchdog: int
    runs: tuple[int, ...]
    single: Spot | None
    safe: tuple[tuple[Spot, Value], ...]


@dataclass(frozen=True, slots=True)
class FirmwarePlan:
    """``files`` are compiled with ``flags``, ``headers`` are what they include by name, ``script`` is the
    linker script. ``code``: the plan of the program that is in it. ``digest`` covers all."""

    board: Board
    code: BuildPlan
    files: tuple[File, ...]
    headers: dict[str, str]
    flags: tuple[str, ...]
    script: str
    digest: str


def plan(memory: Block, board: Board, period: int, tasks: Iterable[TaskPlan],
         bindings: Iterable[Binding] = (), further: Iterable[tuple[str, str]] = ()) -> FirmwarePlan:
    """Firmware for a program in a block. ``period``: nanoseconds from scan to scan; ``further``: name and text of
    more C files."""
    flags = (*FLAGS, *board.cpu)
    code = emit.plan(memory, flags, bindings)
    headers = {emit.HEADER: code.header, "firmware.h": _read("firmware.h"),
               "board.h": _render("board.h.j2", board=board)}
    reload, ticks = systick(board.clock_hz, period)
    title = memory.program.name or "program"
    rows = [{"name": t.name, "interval": t.interval, "watchdog": t.watchdog, "runs": t.runs,
             "safe": tuple(changes(t.safe)), "single": _single(t.single)} for t in tasks]
    own = [(name, _read(name)) for name in (*_RUNTIME, f"uart_{board.uart.kind}.c")]
    if board.qemu is not None:
        own.append(("job.c", _read("job.c")))
    own += [
        ("startup.c", _render("startup.c.j2", board=board)),
        ("plant.c", _render("plant.c.j2", title=title, size=memory.size, period=period, reload=reload,
                            ticks=ticks, tasks=rows, initial=tuple(initial(memory)))),
        *further,
    ]
    common = "\0".join((*headers.values(), *flags))
    made = (*code.files, *(File(name, text, _digest(name, text, common)) for name, text in own))
    script = _render("linker.ld.j2", board=board)
    digest = _digest(script, *(f"{file.name} {file.digest}" for file in made))
    return FirmwarePlan(board, code, made, headers, flags, script, digest)


def systick(clock_hz: int, period: int) -> tuple[int, int]:
    """The reload value of SysTick and how many of its ticks make ``period`` nanoseconds: as few as fit its 24
    bits."""
    cycles = max(clock_hz * period // 10**9, 1)
    ticks = -(-cycles // _SYSTICK)
    return max(cycles // ticks - 1, 1), ticks


def changes(values: Iterable[tuple[Spot, Value]]) -> Iterator[int]:
    """Values for places as the words that ``ldc_change`` takes (runtime/firmware.h)."""
    for spot, value in values:
        if spot.bit is not None:
            yield from (spot.offset, BITS | 1 << spot.bit | bool(value) << spot.bit + 8)
            continue
        yield from piece(spot.offset, encoded(spot, value))


def encoded(spot: Spot, value: Value) -> bytes:
    """The bytes of a value at a place that is no single bit; of a string, those that hold it."""
    data = bytearray(_room(spot, value))
    block.write(data, Spot(0, spot.type), value)
    return bytes(data)


def piece(offset: int, data: bytes) -> Iterator[int]:
    """The words that write ``data``; long data in several pieces."""
    for at in range(0, len(data), _LONGEST):
        part = data[at:at + _LONGEST]
        yield from (offset + at, len(part))
        yield from unpack(f"<{-(-len(part) // 4)}I", part + bytes(-len(part) % 4))


def initial(memory: Block) -> Iterator[int]:
    """The words that make the block before the first scan of one that is all zero."""
    data = bytes(memory.initial())
    at = 0
    while at < len(data):
        if not data[at]:
            at += 1
            continue
        end = at + 1
        # A pair of words costs as much as eight bytes: shorter gaps are written.
        while end < len(data) and any(data[end:end + 8]):
            end += 1
        yield from piece(at, data[at:end])
        at = end


def _room(spot: Spot, value: Value) -> int:
    if isinstance(value, bytes | str):
        return 2 + 2 * len(value) * (1 if isinstance(value, bytes) else 2)
    return 8


def _single(spot: Spot | None) -> tuple[int, int]:
    if spot is None:
        return 0, 0
    return spot.offset, 0xFF if spot.bit is None else 1 << spot.bit


def _digest(*texts: str) -> str:
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()


@cache
def _read(name: str) -> str:
    return (_ROOM / "runtime" / name).read_text(encoding="utf-8")


@cache
def _environment() -> jinja2.Environment:
    return jinja2.Environment(loader=jinja2.FunctionLoader(lambda name: (_ROOM / "templates" / name).read_text()),
                              trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True,
                              undefined=jinja2.StrictUndefined, autoescape=False)


def _render(template: str, **values: object) -> str:
    return _environment().get_template(template).render(**values)
