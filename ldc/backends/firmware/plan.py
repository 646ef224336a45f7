"""Everything that firmware is made of, before any tool runs: files with digests, linker scripts, flags."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from ldc.backends.c import emit
from ldc.backends.c.emit import BuildPlan, File
from ldc.backends.firmware import components, remote
from ldc.backends.firmware.board import Board, Region
from ldc.backends.firmware.components import Part
from ldc.backends.room import Room, digest
from ldc.components.project import Native
from ldc.il import changes
from ldc.il.block import Block, Spot
from ldc.il.c_types import c_type
from ldc.il.layout import state, type_hash
from ldc.records import record
from ldc.types import String, Value, is_scalar

FLAGS = ("-std=c11", "-Os", "-g", "-ffreestanding", "-fwrapv", "-ffp-contract=off", "-fno-strict-aliasing",
         "-ffunction-sections", "-fdata-sections", "-fno-asynchronous-unwind-tables")
TASKS_MOST = 64
_SYSTICK = 1 << 24
_ROOM = Room("ldc.backends.firmware")
_RUNTIME = ("scan.c", "live.c", "system.c")
_RETAIN = ("retain.c", "p_handshake.c")
_LINK = ("link.c", "p_handshake.c")
_HEADERS = ("firmware.h", "link.h", "p_handshake.h")


@record
class TaskPlan:
    """A task as firmware runs it, in order of priority. ``interval`` in nanoseconds, 0: every scan;
    ``single``: the variable of SINGLE; ``safe``: what outputs become when it is stopped."""

    name: str
    interval: int
    watchdog: int
    runs: tuple[int, ...]
    single: Spot | None
    safe: tuple[tuple[Spot, Value], ...]


@record
class Image:
    """What one processor runs. ``files`` are compiled with ``flags``, ``headers`` are what they include by
    name, ``parts``: objects of components, ``script``: the linker script."""

    processor: str
    files: tuple[File, ...]
    parts: tuple[Part, ...]
    headers: dict[str, str]
    flags: tuple[str, ...]
    script: str
    flash: Region
    ram: Region


@record
class FirmwarePlan:
    """``images``: that of the master, then that of a slave if one has something to do. ``code``: the plan of
    the program that is in the first. ``digest`` covers all."""

    board: Board
    code: BuildPlan
    images: tuple[Image, ...]
    digest: str


def plan(memory: Block, board: Board, period: int, tasks: Iterable[TaskPlan], natives: Sequence[Native] = (),
         parts: Sequence[Part] = (), remotes: Sequence[tuple[int, Native]] = (),
         remote_parts: Sequence[Part] = (), further: Iterable[tuple[str, str]] = (),
         steps: Mapping[int, int] = {}) -> FirmwarePlan:
    """Firmware for a program in a block. ``period``: nanoseconds from scan to scan; ``natives``: its
    components in C and C++, ``parts`` the objects of those on the master; ``remotes``: those of the slave,
    each with its number, ``remote_parts`` their objects; ``further``: name and text of more C files of the
    board; ``steps``: by the number of a component its period in microseconds, when it has one of its own."""
    flags = (*FLAGS, *board.cpu)
    code = emit.plan(memory, flags, map(components.binding, natives))
    own = list(_plant(memory, board, period, tasks))
    if natives:
        own.append(("bind.c", components.bind(len(natives))))
    shared = remote.windows(board, remotes) if remotes else {}
    if remotes:
        own += [*((name, _ROOM.read(name)) for name in _LINK if name not in dict(own)),
                ("remotes.c", remote.tables(remotes, False, steps))]
    own += _board(board, shared, slave=False, components=bool(natives))
    own += further
    more = {"places.h": _ROOM.render("places.h.j2", places=list(_places(memory)))} if board.sources else {}
    master = _image("master", board, board.flash, board.ram, (code.header, code.files), own, parts, flags,
                    shared, more)
    images = (master,)
    if remotes:
        own = [*((name, _ROOM.read(name)) for name in _LINK),
               ("remotes.c", remote.tables(remotes, True, steps)),
               *_board(board, shared, slave=True, components=False)]
        images += (_image("slave1", board, board.second.flash, board.second.ram, (code.header, ()), own,
                          remote_parts, (*flags, "-DLDC_SLAVE"), shared),)
    whole = digest(*(image.script for image in images),
                     *(f"{file.name} {file.digest}" for image in images for file in image.files))
    return FirmwarePlan(board, code, images, whole)


def _plant(memory: Block, board: Board, period: int, tasks: Iterable[TaskPlan]) -> Iterable[tuple[str, str]]:
    """The files that know the program and how it is run."""
    reload, ticks = systick(board.clock_hz, period)
    rows = [{"name": t.name, "interval": t.interval, "watchdog": t.watchdog, "runs": t.runs,
             "safe": tuple(changes.words(t.safe)), "single": _single(t.single)} for t in tasks]
    kept = [(offset, size) for _, offset, size, _ in retained(memory)]
    named = (f"{path} {size} {type_}" for path, _, size, type_ in retained(memory))
    key = int(digest("with the time", *named)[:8], 16)
    yield "plant.c", _ROOM.render("plant.c.j2", title=memory.program.name or "program", size=memory.size,
                             period=period, reload=reload, ticks=ticks, tasks=rows,
                             initial=tuple(changes.from_zero(bytes(memory.initial()))), ranges=kept,
                             key=key, words=5 + -(-sum(size for _, size in kept) // 4))
    for name in (*_RUNTIME, *(_RETAIN if kept else ()), *(("job.c",) if board.qemu is not None else ())):
        yield name, _ROOM.read(name)


def _places(memory: Block) -> Iterator[tuple[str, str, int, int | None]]:
    """Address as a part of a C name, C type, offset and bit of every input and output."""
    found = {}
    for at, type_ in memory.homes:
        if at.area in "IQ" and is_scalar(type_) and not isinstance(type_, String):
            spot = memory.located(at, type_)
            found.setdefault(str(at)[1:].replace(".", "_"), (c_type(type_), spot.offset, spot.bit))
    for name, (kind, offset, bit) in sorted(found.items()):
        yield name, kind, offset, bit


def retained(memory: Block) -> list[tuple[str, int, int, str]]:
    """Path, offset, size and hash of the type of the variables that are RETAIN, in the order of their
    paths."""
    part = memory.program.resources[memory.resource]
    wanted = [(v.name, v) for v in memory.program.globals]
    for run in part.runs:
        wanted += [(f"{run.name}.{v.name}", v) for v in state(memory.units[run.pou.upper()])]
    found = []
    for path, variable in sorted(wanted, key=lambda pair: pair[0].upper()):
        spot = memory.variable(path, variable)
        if variable.retain and spot.bit is None:
            found.append((path.upper(), spot.offset, memory.measure(variable.type),
                          type_hash(variable.type, memory.units)))
    return found


def _board(board: Board, shared: Mapping[str, int], slave: bool, components: bool) -> list[tuple[str, str]]:
    name = f"uart_{board.uart.kind}.c"
    startup = _ROOM.render("startup.c.j2", board=board, slave=slave, second=bool(shared),
                           components=components)
    return [("startup.c", startup), (name, _ROOM.read(name))]


def _image(processor: str, board: Board, flash: Region, ram: Region, code: tuple[str, tuple[File, ...]],
           own: Iterable[tuple[str, str]], parts: Sequence[Part], flags: tuple[str, ...],
           shared: Mapping[str, int], more: Mapping[str, str] = {}) -> Image:
    headers = {emit.HEADER: code[0],
               "board.h": _ROOM.render("board.h.j2", board=board, ram=ram, shared=shared)}
    headers |= {name: _ROOM.read(name) for name in _HEADERS} | more
    common = "\0".join((*headers.values(), *flags))
    made = [File(name, text, digest(name, text, common)) for name, text in own]
    return Image(processor, (*code[1], *made), tuple(parts), headers, flags,
                 _ROOM.render("linker.ld.j2", board=board, flash=flash, ram=ram), flash, ram)


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
