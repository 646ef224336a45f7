"""Components in C and C++ inside of an image: rewritten with the addresses that its variables have (SPEC
9.4)."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from ldc.backends.c import gcc
from ldc.components import host, toolchain
from ldc.components.address_map import AddressMap, global_symbol, nameable, of_symbols
from ldc.components.find import own_files
from ldc.components.header import file_name
from ldc.components.project import Native
from ldc.diagnostics import Diagnostics
from ldc.il.block import Block
from ldc.il.external import Binding
from ldc.records import record
from ldc.symbols import Variable
from ldc.types import Array

_TOOLS = toolchain.ARM_GCC, toolchain.ARM_GXX
_FLAGS = ("-Os", "-g", "-ffreestanding", "-fwrapv", "-ffp-contract=off", "-fno-strict-aliasing",
          "-ffunction-sections", "-fdata-sections", "-fno-asynchronous-unwind-tables")
_CXX = ("-fno-exceptions", "-fno-rtti", "-fno-threadsafe-statics")


@record
class Part:
    """The object of one component, which shows nothing but its entry; ``text``: its rewritten sources."""

    native: Native
    path: Path
    text: str

    @property
    def file(self) -> str:
        """What its rewritten sources are called together."""
        component = self.native.component
        return f"body_{component.entry}{'.cpp' if component.language == 'c++' else '.c'}"


def binding(native: Native) -> Binding:
    """How generated code calls a component of the same image: without a window, for it sees the memory
    itself."""
    return Binding(native.unit.name, Path(), native.component.entry)


def memory_of_slave(processor: str) -> AddressMap:
    """What a component sees on a slave: nothing of the master's globals."""
    return of_symbols(processor, (), base="ldc_block")


def memory_of(block: Block, globals_: Iterable[Variable], processor: str = "master") -> AddressMap:
    """The globals that C can name, each at its place in the block of the image."""
    symbols = []
    for v, element in nameable(globals_):
        spot = block.variable(v.name, v)
        if spot.bit is not None and isinstance(v.type, Array):
            continue  # C has no pointers to bits
        symbols.append(global_symbol(v, element, spot.offset, spot.bit))
    return of_symbols(processor, symbols, base="ldc_block")


def symbol(number: int) -> str:
    """The entry of a component in an image; ``number`` is its place among the components of the program."""
    return f"ldc_entry_{number}"


def build(natives: Iterable[tuple[int, Native]], memory: AddressMap, cpu: Sequence[str],
          diagnostics: Diagnostics) -> list[Part]:
    """The objects of some components, each with its number, from the cache or made now; those that cannot be
    made are left out, with findings. Raises OSError when the cache cannot be written."""
    made = (_part(number, native, memory, cpu, diagnostics) for number, native in natives)
    return [part for part in made if part is not None]


def _part(number: int, native: Native, memory: AddressMap, cpu: Sequence[str],
          diagnostics: Diagnostics) -> Part | None:
    component = native.component
    cxx = component.language == "c++"
    entry = symbol(number)
    with tempfile.TemporaryDirectory(prefix="ldc-") as name:
        folder = Path(name)
        found = host.rewritten(native, memory, folder, diagnostics, _TOOLS)
        compiler = toolchain.find(_TOOLS[cxx], diagnostics) if found else None
        if found is None or compiler is None:
            return None
        texts = ["extern unsigned char ldc_block[];\n" * (not cxx) + text for text in found[0]]
        flags = [*cpu, *_FLAGS, *(_CXX if cxx else ()), *component.cflags,
                 f"-std={component.standard or ('c++17' if cxx else 'c11')}"]
        header = (folder / file_name(component)).read_text(encoding="utf-8")
        key = hashlib.sha256("\0".join((*texts, header, *flags, compiler, entry)).encode()).hexdigest()
        target = gcc.cache_folder() / f"component-{key}.o"
        if not target.exists() and not _compiled(native, texts, [compiler, *flags], entry, target, folder,
                                                 diagnostics):
            return None
    return Part(native, target, "\n".join(texts))


def _compiled(native: Native, texts: Sequence[str], command: Sequence[str], entry: str, target: Path,
              folder: Path, diagnostics: Diagnostics) -> bool:
    """Several sources become one object, in which only the entry has a name that others see."""
    component = native.component
    own = ["-I", str(component.folder.resolve()), "-I", str(folder)]
    sources = own_files(component, diagnostics)
    files = []
    for number, text in enumerate(texts):
        path = folder / f"part{number}{'.cpp' if component.language == 'c++' else '.c'}"
        path.write_text(text, encoding="utf-8")
        files.append(str(path))
    whole, alone = folder / "whole.o", folder / "alone.o"
    status, _, said = toolchain.run([*command, *own, "-nostdlib", "-r", "-o", str(whole), *files])
    toolchain.report(said, sources, component.span("function", "sources"), diagnostics)
    if status:
        return False
    objcopy = gcc.beside(command[0], "objcopy")
    gcc.run([objcopy, "--redefine-sym", f"{component.entry}={entry}", f"--keep-global-symbol={entry}",
             str(whole), str(alone)])
    target.parent.mkdir(parents=True, exist_ok=True)
    gcc.placed(alone.read_bytes(), target)
    return True


def bind(count: int) -> str:
    """The C file that tells generated code where its components are: numbers 0 to ``count`` - 1."""
    lines = ['#include "firmware.h"', "", "unsigned char *ldc_memory = ldc_block;",
             "int32_t ldc_bind(uint32_t component, void (*entry)(const void *, void *, void *, uint32_t),",
             "                 uint8_t **memory);"]
    lines += [f"void {symbol(n)}(const void *in, void *out, void *state, uint32_t microseconds);"
              for n in range(count)]
    lines += ["", "void ldc_components(void) {"]
    lines += [f"    ldc_bind({n}, {symbol(n)}, 0);" for n in range(count)]
    return "\n".join([*lines, "}", ""])
