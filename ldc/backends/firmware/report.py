"""How much flash and RAM an image takes, and which POU takes how much, from the map of the linker."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from ldc.backends.c.places import c_name
from ldc.backends.firmware.tools import Built, Firmware
from ldc.il.block import SYSTEM, Block
from ldc.il.layout import state
from ldc.il.program import Unit

_OUTPUT = re.compile(r"^(\.[\w.]+)")
_INPUT = re.compile(r"^ (\.[\w.$-]+|COMMON)(?:\s+(0x[0-9a-f]+)\s+(0x[0-9a-f]+)\s+(\S.*))?$")
_REST = re.compile(r"^\s+(0x[0-9a-f]+)\s+(0x[0-9a-f]+)\s+(\S.*)$")
_FILL = re.compile(r"^ \*fill\*\s+0x[0-9a-f]+\s+(0x[0-9a-f]+)")
_FLASH, _RAM = (".vectors", ".text", ".ARM.exidx", ".data"), (".stack", ".data", ".bss", ".retain")
IMAGES, SYSTEM_PART, STARTUP, LIBRARY, STACK = (
    "process image", "time and faults", "startup and scan", "library", "stack")


@dataclass(slots=True)
class Row:
    """What something takes, in bytes."""

    flash: int = 0
    ram: int = 0


@dataclass(slots=True)
class Size:
    """``rows``: POUs first, in the order of the program, then the rest; they add up to ``flash`` and
    ``ram``."""

    rows: dict[str, Row] = field(default_factory=dict)
    flash: int = 0
    ram: int = 0

    def add(self, name: str, flash: int = 0, ram: int = 0) -> None:
        row = self.rows.setdefault(name, Row())
        row.flash += flash
        row.ram += ram
        self.flash += flash
        self.ram += ram


def sizes(firmware: Firmware, number: int = 0) -> Size:
    """Of everything in an image: 0 is that of the master. Reads its map; raises OSError."""
    built, block = firmware.images[number], firmware.plan.code.block
    if number:
        return _divided(built, {}, frozenset(), None)
    units = [unit for unit in block.program.units if not unit.standard]
    runs = block.program.resources[block.resource].runs
    prefixes = {f"{kind}_{c_name(u.name).upper()}": _title(u) for u in units for kind in ("pou", "component")}
    prefixes |= {f"run_{c_name(r.name).upper()}": _title(block.units[r.pou.upper()]) for r in runs}
    return _divided(built, prefixes, frozenset(file.name for file in firmware.plan.code.files), block)


def _divided(built: Built, prefixes: dict[str, str], own: frozenset[str], block: Block | None) -> Size:
    """``prefixes``: what names of the POUs begin with in the files of the program, ``own``."""
    found = Size({title: Row() for title in prefixes.values()})
    lengths = sorted(prefixes, key=len, reverse=True)
    for output, section, size, path in _sections(built.map.read_text(encoding="utf-8", errors="replace")):
        file = built.objects.get(path.rpartition("/")[2])
        flash, ram = size * (output in _FLASH), size * (output in _RAM)
        name = re.sub(r"^\.(text|rodata|data|bss)\.", "", section)
        named = (p for p in lengths if _belongs(file, p) or _belongs(name, p))
        pou = next(named, None) if file in own else None
        if file is not None and file.startswith("component "):
            found.add(f"FUNCTION_BLOCK {file.removeprefix('component ')}", flash, ram)
        elif pou is not None:
            found.add(prefixes[pou], flash, ram)
        elif name == "ldc_block" and block is not None:
            _block(found, block, ram)
        elif output == ".stack":
            found.add(STACK, ram=ram)
        elif path != "fill" and file is None or file in ("ldc_runtime.c", "ldc_text.c"):
            found.add(LIBRARY, flash, ram)
        else:
            found.add(STARTUP, flash, ram)
    return found


def of_files(built: Built) -> dict[str, int]:
    """Flash that each C file takes in an image, by its name; the libraries together under "". Raises
    OSError."""
    found: dict[str, int] = {}
    for output, _, size, path in _sections(built.map.read_text(encoding="utf-8", errors="replace")):
        if output in _FLASH and path != "fill":
            name = built.objects.get(path.rpartition("/")[2], "")
            found[name] = found.get(name, 0) + size
    return found


def _title(unit: Unit) -> str:
    return f"{unit.kind} {unit.name}"


def _belongs(name: str | None, prefix: str) -> bool:
    """Whether a file or symbol is of the POU: ``pou_A`` and ``pou_A_1c2f.c``, not ``pou_AB``."""
    return name is not None and name.startswith(prefix) and re.match(r"(_[0-9a-f]{8}(_\d+)?)?(\.c)?\Z",
                                                                     name[len(prefix):]) is not None


def _block(found: Size, block: Block, ram: int) -> None:
    """Divides the block of memory: instances count with the program that they are in."""
    images = sum(9 * size for _, size in block.areas)
    found.add(SYSTEM_PART, ram=SYSTEM)
    found.add(IMAGES, ram=images)
    rest = ram - SYSTEM - images
    for run in block.program.resources[block.resource].runs:
        unit = block.units[run.pou.upper()]
        size = sum(block.measure(v.type) for v in state(unit) if v.location is None)
        found.add(_title(unit), ram=size)
        rest -= size
    found.add("globals and gaps", ram=rest)


def _sections(text: str) -> Iterator[tuple[str, str, int, str]]:
    """Output section, input section, bytes and object of everything that was placed."""
    output, section = "", ""
    for line in text[max(text.find("Linker script and memory map"), 0):].splitlines():
        if match := _OUTPUT.match(line):
            output, section = match[1], ""
            if output == ".stack":
                size = re.search(r"\s0x[0-9a-f]+\s+(0x[0-9a-f]+)", line)
                yield output, output, int(size[1], 16) if size else 0, ""
        elif match := _INPUT.match(line):
            section = match[1]
            if match[3] and output in (*_FLASH, *_RAM):
                yield output, section, int(match[3], 16), match[4]
        elif match := _FILL.match(line):
            if output in (*_FLASH, *_RAM) and output != ".stack":
                yield output, "", int(match[1], 16), "fill"
        elif section and (match := _REST.match(line)):
            if output in (*_FLASH, *_RAM):
                yield output, section, int(match[2], 16), match[3]
            section = ""
