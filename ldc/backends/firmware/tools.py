"""A FirmwarePlan into an image: the ARM compiler for what no cache holds, a link, the bytes for the flash."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from ldc.backends.firmware import findings
from ldc.backends.c import gcc
from ldc.backends.firmware.plan import FirmwarePlan, Image
from ldc.components import toolchain
from ldc.diagnostics import Diagnostics
from ldc.records import record

_OVERFLOW = re.compile(r"region `(FLASH|RAM)\w*' overflowed by (\d+) bytes")


@record
class Built:
    """One image: ``elf``, ``bin`` and the linker's ``map``; ``objects``: the names of files by those of their
    objects."""

    image: Image
    elf: Path
    bin: Path
    map: Path
    objects: dict[str, str]


@record
class Firmware:
    """What a build gave: an image for each processor; ``compiled``: files that gcc ran for, of ``files``."""

    plan: FirmwarePlan
    images: tuple[Built, ...]
    compiled: int
    files: int


def build(plan: FirmwarePlan, folder: Path, name: str, diagnostics: Diagnostics) -> Firmware | None:
    """The images: that of the master in ``folder`` as ``name`` with the endings .elf, .bin and .map, that of
    a slave in a folder of its own in it. None with findings. Raises OSError when a folder cannot be
    written."""
    image = plan.images[0]
    try:
        compiler = gcc.find_compiler(diagnostics, toolchain.ARM_GCC)
        if compiler is None:
            return None
        made, ran = [], 0
        for image in plan.images:
            place = folder if image.processor == "master" else folder / image.processor
            one, count = _built(image, plan.board.cpu, place, name, compiler)
            made.append(one)
            ran += count
        return Firmware(plan, tuple(made), ran, sum(len(image.files) for image in plan.images))
    except gcc.CompilerFailed as error:
        found = _OVERFLOW.search(error.output)
        if found is None:
            findings.arm_compiler_failed(diagnostics, error)
        else:
            what, region = ("flash", image.flash) if found[1] == "FLASH" else ("RAM", image.ram)
            findings.does_not_fit(diagnostics, plan.board.name, what, region.size, int(found[2]))
    return None


def _built(image: Image, cpu: Sequence[str], folder: Path, name: str,
           compiler: gcc.Compiler) -> tuple[Built, int]:
    objects, compiled = gcc.compiled(image.files, image.headers, image.flags, compiler, gcc.cache_folder())
    parts = [part.path for part in image.parts]
    folder.mkdir(parents=True, exist_ok=True)
    elf, binary, map_, script = (folder / f"{name}{end}" for end in (".elf", ".bin", ".map", ".ld"))
    script.write_text(image.script, encoding="utf-8")
    gcc.run([compiler.path, *cpu, "-nostartfiles", "-Wl,--gc-sections,--no-warn-rwx-segments", "-T",
             str(script), f"-Wl,-Map={map_}", "-o", str(elf), *map(str, (*objects, *parts)),
             "-lm", "-lc", "-lgcc"])
    gcc.run([gcc.beside(compiler.path, "objcopy"), "-O", "binary", str(elf), str(binary)])
    names = {path.name: file.name for path, file in zip(objects, image.files, strict=True)}
    names |= {part.path.name: f"component {part.native.unit.name}" for part in image.parts}
    return Built(image, elf, binary, map_, names), len(compiled)


def address_of(elf: Path, symbol: str) -> int:
    """The address of a symbol of an image. Raises CompilerFailed when the tools are gone, KeyError for the
    symbol."""
    compiler = toolchain.find(toolchain.ARM_GCC) or toolchain.ARM_GCC.command
    for line in gcc.run([gcc.beside(compiler, "nm"), str(elf)]).splitlines():
        address, _, name = line.split(maxsplit=2) if line[:1] != " " else ("", "", "")
        if name == symbol:
            return int(address, 16)
    raise KeyError(symbol)


def line_of(firmware: Path, address: int) -> str | None:
    """``file:line`` of an address of the code, None when it is not known."""
    compiler = toolchain.find(toolchain.ARM_GCC)
    if compiler is None or not address:
        return None
    try:
        text = gcc.run([gcc.beside(compiler, "addr2line"), "-e", str(firmware), hex(address)]).strip()
    except gcc.CompilerFailed:
        return None
    return text.partition(" (discriminator")[0] if text and "?" not in text else None
