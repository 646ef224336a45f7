"""Everything that firmware is made of, before any tool runs: files with digests, linker script, flags."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files

import jinja2

from ldc.backends.c import emit
from ldc.backends.c.emit import BuildPlan, File
from ldc.backends.firmware import components
from ldc.backends.firmware.board import Board
from ldc.backends.firmware.components import Part
from ldc.components.project import Native
from ldc.il import changes
from ldc.il.block import Block, Spot
from ldc.types import Value

FLAGS = ("-std=c11", "-Os", "-g", "-ffreestanding", "-fwrapv", "-ffp-contract=off", "-fno-strict-aliasing",
         "-ffunction-sections", "-fdata-sections", "-fno-asynchronous-unwind-tables")
TASKS_MOST = 64
_SYSTICK = 1 << 24
_ROOM = files("ldc.backends.firmware")
_RUNTIME = ("scan.c", "live.c", "system.c")


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
    linker script; ``parts``: objects of components. ``code``: the plan of the program that is in it. ``digest`` covers all."""

    board: Board
    code: BuildPlan
    files: tuple[File, ...]
    parts: tuple[Part, ...]
    headers: dict[str, str]
    flags: tuple[str, ...]
    script: str
    digest: str


def plan(memory: Block, board: Board, period: int, tasks: Iterable[TaskPlan],
         natives: Sequence[Native] = (), parts: Sequence[Part] = (),
         further: Iterable[tuple[str, str]] = ()) -> FirmwarePlan:
    """Firmware for a program in a block. ``period``: nanoseconds from scan to scan; ``natives``: its components
    in C and C++, ``parts`` their objects; ``further``: name and text of more C files."""
    flags = (*FLAGS, *board.cpu)
    code = emit.plan(memory, flags, map(components.binding, natives))
    headers = {emit.HEADER: code.header, "firmware.h": _read("firmware.h"),
               "board.h": _render("board.h.j2", board=board)}
    reload, ticks = systick(board.clock_hz, period)
    title = memory.program.name or "program"
    rows = [{"name": t.name, "interval": t.interval, "watchdog": t.watchdog, "runs": t.runs,
             "safe": tuple(changes.words(t.safe)), "single": _single(t.single)} for t in tasks]
    own = [(name, _read(name)) for name in (*_RUNTIME, f"uart_{board.uart.kind}.c")]
    if board.qemu is not None:
        own.append(("job.c", _read("job.c")))
    if parts:
        own.append(("bind.c", components.bind(parts)))
    own += [
        ("startup.c", _render("startup.c.j2", board=board, components=bool(parts))),
        ("plant.c", _render("plant.c.j2", title=title, size=memory.size, period=period, reload=reload,
                            ticks=ticks, tasks=rows, initial=tuple(changes.from_zero(bytes(memory.initial()))))),
        *further,
    ]
    common = "\0".join((*headers.values(), *flags))
    made = (*code.files, *(File(name, text, _digest(name, text, common)) for name, text in own))
    script = _render("linker.ld.j2", board=board)
    digest = _digest(script, *(f"{file.name} {file.digest}" for file in made))
    return FirmwarePlan(board, code, made, tuple(parts), headers, flags, script, digest)


def systick(clock_hz: int, period: int) -> tuple[int, int]:
    """The reload value of SysTick and how many of its ticks make ``period`` nanoseconds: as few as fit its 24
    bits."""
    cycles = max(clock_hz * period // 10**9, 1)
    ticks = -(-cycles // _SYSTICK)
    return max(cycles // ticks - 1, 1), ticks


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
