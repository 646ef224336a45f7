"""Boards: processor, memory, serial port, and the QEMU machine that behaves like one (docs/firmware.md)."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Literal

from msgspec import Meta, Struct, convert, structs

from ldc.backends.firmware import findings
from ldc.diagnostics import Diagnostics
from ldc.reading import read_source
from ldc.source import SourceFile
from ldc.toml_tables import Tables, parse_toml

TARGETS = ("cortex-m3", "cortex-m4", "cortex-m33")
_ROOM = files("ldc.backends.firmware") / "boards"

Address = Annotated[int, Meta(ge=0, le=0xFFFF_FFFF)]
Size = Annotated[int, Meta(ge=1024, le=1 << 30)]


class Region(Struct, frozen=True):
    """Memory: first address and bytes."""

    base: Address = 0
    size: Size = 1024


class Uart(Struct, frozen=True):
    """The serial port that messages go to: its kind and first address."""

    kind: Literal["cmsdk", "pl011"] = "cmsdk"
    base: Address = 0


class Qemu(Struct, frozen=True):
    """``machine``: what ``qemu-system-arm -M`` calls the board; ``options``: what else it needs."""

    machine: Annotated[str, Meta(pattern=r"^[A-Za-z0-9._-]+\Z")] = "none"
    options: tuple[str, ...] = ()


class Second(Struct, frozen=True):
    """A second processor, slave1: its memory, what both share, and the registers that let it run (``table``:
    where its vectors are; ``wait``: 0 releases it)."""

    flash: Region = Region()
    ram: Region = Region()
    shared: Region = Region()
    table: Address = 0
    wait: Address = 0


class Board(Struct, frozen=True):
    """A board file. ``cpu``: options of the compiler; ``clock_hz``: of SysTick; ``stack``: bytes; ``retain``:
    memory that keeps its content without power (without it, RETAIN lasts over a reset only); ``sources``: C
    files beside the board file that are compiled in; ``default``: the board of its target when none is
    named."""

    target: Literal["cortex-m3", "cortex-m4", "cortex-m33"] = "cortex-m3"
    name: str = ""
    default: bool = False
    cpu: tuple[Annotated[str, Meta(pattern=r"^-m[a-z0-9=+.-]+\Z")], ...] = ()
    fpu: bool = False
    clock_hz: Annotated[int, Meta(ge=1000, le=10**10)] = 10**6
    stack: Annotated[int, Meta(ge=512, le=1 << 24)] = 8192
    flash: Region | None = None
    ram: Region | None = None
    retain: Region | None = None
    uart: Uart | None = None
    qemu: Qemu | None = None
    second: Second | None = None
    sources: tuple[str, ...] = ()


@cache
def known() -> dict[str, Board]:
    """The boards that come with ldc, by name."""
    found = {}
    for entry in sorted(_ROOM.iterdir(), key=lambda e: e.name):
        if entry.name.endswith(".toml"):
            board = convert(tomllib.loads(entry.read_text(encoding="utf-8")), Board)
            name = entry.name.removesuffix(".toml")
            found[name] = structs.replace(board, name=name)
    return found


def find(target: str, wanted: str | None, diagnostics: Diagnostics) -> tuple[Board, Path | None] | None:
    """The board that is ``wanted``, a name or a board file, or the usual one of the target; and the folder of
    its file when it is no board of ldc's own. None with findings."""
    if wanted is None:
        return next(b for b in known().values() if b.target == target and b.default), None
    if wanted in known():
        board, folder = known()[wanted], None
    elif wanted.endswith(".toml"):
        source = read_source(Path(wanted), wanted, diagnostics)
        made = None if source is None else read(source, diagnostics)
        if made is None:
            return None
        board, folder = made, Path(wanted).parent
    else:
        findings.no_board(diagnostics, wanted, list(known()))
        return None
    if board.target != target:
        findings.other_target(diagnostics, board.name, board.target, target)
        return None
    return board, folder


def read(source: SourceFile, diagnostics: Diagnostics) -> Board | None:
    """A board file of a user, or None with findings."""

    data = parse_toml(source, diagnostics)
    if data is None:
        return None
    before = len(diagnostics)
    tables = Tables(source, data, diagnostics, "the board file")
    board = tables.table((), Board)
    for key in ("flash", "ram", "uart"):
        if len(diagnostics) == before and getattr(board, key) is None:
            findings.board_lacks(diagnostics, source, key)
    return structs.replace(board, name=Path(source.path).stem) if len(diagnostics) == before else None
