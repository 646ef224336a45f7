"""A FirmwarePlan into an image: the ARM compiler for what no cache holds, a link, the bytes for the flash."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from ldc.backends.firmware import findings
from ldc.backends.c import gcc
from ldc.backends.firmware.plan import FirmwarePlan
from ldc.components import toolchain
from ldc.diagnostics import Diagnostics

_OVERFLOW = re.compile(r"region `(FLASH|RAM)\w*' overflowed by (\d+) bytes")


@dataclass(frozen=True, slots=True)
class Firmware:
    """What a build gave: ``elf``, ``bin`` and the linker's ``map``; ``objects`` by the names of their files;
    ``compiled``: files that gcc ran for."""

    plan: FirmwarePlan
    elf: Path
    bin: Path
    map: Path
    objects: dict[str, str]
    compiled: tuple[str, ...]


def build(plan: FirmwarePlan, folder: Path, name: str, diagnostics: Diagnostics) -> Firmware | None:
    """The image in ``folder``, as ``name`` with the endings .elf, .bin and .map; None with findings. Raises
    OSError when a folder cannot be written."""
    try:
        compiler = gcc.find_compiler(diagnostics, toolchain.ARM_GCC)
        if compiler is None:
            return None
        return _built(plan, folder, name, compiler)
    except gcc.CompilerFailed as error:
        sizes = {"FLASH": plan.board.flash.size, "RAM": plan.board.ram.size}
        found = _OVERFLOW.search(error.output)
        if found is None:
            findings.arm_compiler_failed(diagnostics, error)
        else:
            findings.does_not_fit(diagnostics, plan.board.name, found[1], sizes[found[1]], int(found[2]))
    return None


def _built(plan: FirmwarePlan, folder: Path, name: str, compiler: gcc.Compiler) -> Firmware:
    objects, compiled = gcc.compiled(plan.files, plan.headers, plan.flags, compiler, gcc.cache_folder())
    parts = [part.path for part in plan.parts]
    folder.mkdir(parents=True, exist_ok=True)
    elf, binary, map_, script = (folder / f"{name}{end}" for end in (".elf", ".bin", ".map", ".ld"))
    script.write_text(plan.script, encoding="utf-8")
    gcc.run([compiler.path, *plan.board.cpu, "-nostartfiles", "-Wl,--gc-sections,--no-warn-rwx-segments", "-T",
             str(script), f"-Wl,-Map={map_}", "-o", str(elf), *map(str, (*objects, *parts)), "-lm", "-lc", "-lgcc"])
    gcc.run([gcc.beside(compiler.path, "objcopy"), "-O", "binary", str(elf), str(binary)])
    names = {path.name: file.name for path, file in zip(objects, plan.files, strict=True)}
    names |= {part.path.name: f"component {part.native.unit.name}" for part in plan.parts}
    return Firmware(plan, elf, binary, map_, names, compiled)


def address_of(elf: Path, symbol: str) -> int:
    """The address of a symbol of an image. Raises CompilerFailed when the tools are gone, KeyError for the symbol."""
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
    return text if text and "?" not in text else None
