"""Components for this computer: each native component becomes a shared library of its own.

Libraries are kept in the user's cache folder under a digest of everything that they are made from, so a
component is compiled once. A library has no state: that is in the instances that the engine hands over.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from ldc import unfinished
from ldc.components import findings, header, kept, toolchain
from ldc.components.address_map import AddressMap, global_symbol, nameable, of_symbols
from ldc.components.descriptor import Component
from ldc.components.find import body_sources, own_files
from ldc.components.kept import Kept
from ldc.components.project import Native
from ldc.components.toolchain import Tool
from ldc.diagnostics import Diagnostics
from ldc.il.external import Binding, Shared
from ldc.il.layout import measure
from ldc.source import SourceFile, Span
from ldc.symbols import Variable

_FLAGS = (
    "-O2",
    "-gdwarf-4",
    "-fPIC",
    "-shared",
    "-fno-gnu-unique",
    "-ffp-contract=off",
    "-fwrapv",
    "-fno-strict-aliasing",
    "-fvisibility=hidden",
    "-Wall",
)
_C_ONLY = (
    "-Werror=implicit-function-declaration",
    "-Werror=int-conversion",
    "-Werror=incompatible-pointer-types",
    "-Werror=discarded-qualifiers",
)


def digest(component: Component, diagnostics: Diagnostics) -> str:
    """SHA-256 of all that a component's code is made from: its descriptor, its sources and their headers."""
    files = own_files(component, diagnostics)
    texts = [files[path].text for path in sorted(files)]
    return hashlib.sha256("\0".join((component.source.text, *texts)).encode()).hexdigest()


def memory_of(globals_: Iterable[Variable], processor: str = "master") -> AddressMap:
    """A map of all globals that C can name, one behind the other: for checks, and as the window that an
    engine copies to and from."""
    symbols, end = [], 0
    for v, element in nameable(globals_):
        size, align = measure(v.type, {})
        at = -(-end // align) * align
        end = at + size
        symbols.append(global_symbol(v, element, at))
    return of_symbols(processor, symbols)


def _processor(native: Native) -> str:
    """Where it will run: what its source may name there is the same on this computer."""
    return "slave1" if native.component.processor == "slave" else native.component.processor


def check(native: Native, globals_: Sequence[Variable], diagnostics: Diagnostics) -> bool:
    """Whether the sources of a component can be rewritten for its processor; findings when not."""
    memory = memory_of(globals_, _processor(native))
    compiler = toolchain.find(_tool(native.component))
    if compiler is not None and kept.look(_key(native, memory, compiler, _flags(native.component))):
        return True
    with tempfile.TemporaryDirectory(prefix="ldc-") as folder:
        return _known(native, memory, Path(folder), _flags(native.component), diagnostics) is not None


def build(
    native: Native, globals_: Sequence[Variable], diagnostics: Diagnostics, sanitize: bool = False
) -> Binding | None:
    """The library of a component, from the cache or made now; None with findings."""
    memory = memory_of(globals_, _processor(native))
    component, flags = native.component, _flags(native.component, sanitize)
    compiler = toolchain.find(_tool(component), diagnostics)
    if compiler is None:
        return None
    known = kept.look(_key(native, memory, compiler, flags))
    if known is None or not toolchain.touched(kept.folder() / known.library):
        with tempfile.TemporaryDirectory(prefix="ldc-") as folder:
            made = _known(native, memory, Path(folder), flags, diagnostics)
            if made is None:
                return None
            texts, known = made
            library = kept.folder() / known.library
            if not toolchain.touched(library) and not _compile(
                native, texts, compiler, flags, library, Path(folder), diagnostics
            ):
                return None
    used = [(key, memory.symbols[key]) for key in sorted({*known.reads, *known.writes})]
    shared = tuple(Shared(s.name, s.type, s.address, key in known.writes) for key, s in used)
    size = max((s.offset + measure(s.type, {})[0] for s in shared), default=0)
    return Binding(native.unit.name, kept.folder() / known.library, component.entry, size, shared)


def _tool(component: Component) -> Tool:
    return toolchain.GXX if component.language == "c++" else toolchain.GCC


def _flags(component: Component, sanitize: bool = False) -> list[str]:
    return [
        *_FLAGS,
        *(_C_ONLY if component.language == "c" else ()),
        # The runtime of the sanitizers is in the process that loads the library.
        *(("-fsanitize=address,undefined", "-fno-omit-frame-pointer") if sanitize else ("-Wl,-z,defs",)),
        *component.cflags,
        f"-std={component.standard or ('c11' if component.language == 'c' else 'c++17')}",
    ]


def _key(native: Native, memory: AddressMap, compiler: str, flags: Sequence[str]) -> str | None:
    """The name under which it is kept what a component is."""
    component, silent = native.component, Diagnostics()
    if not header.check_types(native.unit, silent):
        return None
    generated = header.file_name(component), header.text(component, native.unit, memory)
    return kept.key(component, generated, compiler, flags)


def _known(
    native: Native, memory: AddressMap, folder: Path, flags: Sequence[str], diagnostics: Diagnostics
) -> tuple[list[str], Kept] | None:
    """The rewritten sources, and what to know of them, which is kept for the next time; None with
    findings."""
    component, before = native.component, len(diagnostics)
    made = rewritten(native, memory, folder, diagnostics)
    compiler = toolchain.find(_tool(component), diagnostics)
    if made is None or compiler is None:
        return None
    texts, reads, writes = made
    # What a sanitizer finds is told with the path at which the library was compiled.
    at = (str(Path.cwd()),) if any(flag.startswith("-fsanitize") for flag in flags) else ()
    digest_ = hashlib.sha256("\0".join((*texts, *flags, compiler, *at)).encode()).hexdigest()[:24]
    known = Kept(tuple(sorted(reads)), tuple(sorted(writes)), f"{component.entry}-{digest_}.so")
    if len(diagnostics) == before:  # what was told is to be told again
        kept.keep(_key(native, memory, compiler, flags), known)
    return texts, known


def guard_library(diagnostics: Diagnostics) -> Path | None:
    """The library with the handler that notes where native code crashes; None with findings."""
    compiler = toolchain.find(toolchain.GCC, diagnostics)
    if compiler is None:
        return None
    source = Path(__file__).with_name("guard") / "guard.c"
    text = source.read_text(encoding="utf-8")
    key = hashlib.sha256(f"{text}\0{compiler}".encode()).hexdigest()[:24]
    library = kept.folder() / f"guard-{key}.so"
    if toolchain.touched(library):
        return library
    file = SourceFile(str(source), text)
    command = [compiler, "-O1", "-fPIC", "-shared", "-fvisibility=hidden"]
    made = _linked(command, [str(source)], library, {str(source): file}, Span(file, 0, 0), diagnostics)
    return library if made else None


def rewritten(
    native: Native,
    memory: AddressMap,
    folder: Path,
    diagnostics: Diagnostics,
    tools: tuple[Tool, Tool] = (toolchain.GCC, toolchain.GXX),
) -> tuple[list[str], set[tuple[str, str]], set[tuple[str, str]]] | None:
    """The sources of a component for the processor of ``memory``, the symbols that they read and those that
    they write; None with findings. ``folder`` takes the generated header; ``tools`` are the compilers of C
    and C++."""
    component = native.component
    sources = body_sources(component, diagnostics)
    if sources is None or not header.check_types(native.unit, diagnostics):
        return None
    compiler = toolchain.find(tools[component.language == "c++"], diagnostics)
    if compiler is None:
        return None
    generated = folder / header.file_name(component)
    generated.write_text(header.text(component, native.unit, memory), encoding="utf-8")
    from ldc.components import c_source, cpp_source  # slow to load, and most components are known

    module = cpp_source if component.language == "c++" else c_source
    texts, reads, writes, defines = [], set(), set(), set()
    for source in sources:
        made = module.rewrite(component, source, generated, memory, compiler, diagnostics)
        if made is None:
            return None
        texts.append(made.text)
        reads |= made.reads
        writes |= made.writes
        defines |= made.defines
    if component.entry not in defines:
        at = component.span("function", "entry" if ("function", "entry") in component.spans else "sources")
        findings.no_entry(diagnostics, at, component.entry, component.name)
        return None
    return texts, reads, writes


def _compile(
    native: Native,
    texts: list[str],
    compiler: str,
    flags: list[str],
    library: Path,
    folder: Path,
    diagnostics: Diagnostics,
) -> bool:
    component = native.component
    suffix = ".cpp" if component.language == "c++" else ".c"
    files = []
    for number, text in enumerate(texts):
        path = folder / f"part{number}{suffix}"
        path.write_text(text, encoding="utf-8")
        files.append(str(path))
    glue = folder / f"glue{suffix}"
    glue.write_text(_GLUE.replace("ENTRY", component.entry), encoding="utf-8")
    own = ["-I", str(component.folder.resolve()), "-I", str(folder)]
    return _linked(
        [compiler, *flags, *own],
        [*files, str(glue), "-lm"],
        library,
        own_files(component, diagnostics),
        component.span("function", "sources"),
        diagnostics,
    )


def _linked(
    command: list[str],
    files: list[str],
    library: Path,
    sources: dict[str, SourceFile],
    where: Span,
    diagnostics: Diagnostics,
) -> bool:
    """Runs a compiler; the library is there whole or not at all."""
    try:
        library.parent.mkdir(parents=True, exist_ok=True)
        with unfinished.folder_in(library.parent) as folder:
            made = folder / library.name
            status, _, said = toolchain.run([*command, "-o", str(made), *files])
            toolchain.report(said, sources, where, diagnostics)
            if status:
                return False
            os.replace(made, library)
    except OSError as error:
        findings.cannot_write(diagnostics, str(library.parent), error.strerror or str(error))
        return False
    toolchain.prune(library.parent)
    return True


_GLUE = """\
#ifdef __cplusplus
extern "C" {
#endif
__attribute__((visibility("default"))) unsigned char *ldc_memory;
void ENTRY(const void *in, void *out, void *state, unsigned dt_us);
__attribute__((visibility("default"))) void ldc_entry(const void *in, void *out, void *state, unsigned dt_us)
{
  ENTRY(in, out, state, dt_us);
}
#ifdef __cplusplus
}
#endif
"""
