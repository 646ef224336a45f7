"""C++ of a component for one processor: it is not rewritten, a generated header carries the addresses.

`PLC_D(position)` is a ``constexpr`` object of a type that knows the address, reads and, where the processor
may write, assigns. So the compiler itself tells an unknown symbol and a write that is not allowed, and the
findings here put that into the words of the project.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable
from pathlib import Path

from ldc.components import findings, lookup, toolchain
from ldc.components.address_map import MACROS, AddressMap, Symbol
from ldc.components.c_source import Rewritten
from ldc.components.descriptor import Component
from ldc.components.find import own_files
from ldc.diagnostics import Diagnostics
from ldc.il import c_types
from ldc.patterns import Pattern
from ldc.source import SourceFile, Span
from ldc.types import Array

_USE = Pattern(r"\b(PLC_M|PLC_D|LCD)\s*\(\s*(\w*)\s*\)")
_RAW = Pattern(
    r"(?:reinterpret_cast\s*<[^<>;]*\*\s*>\s*\(\s*"
    r"|\(\s*(?:const\s+|volatile\s+)*\w+(?:\s+\w+)*\s*\*+\s*\)\s*\(?\s*)"
    r"((?:0[xX][0-9a-fA-F]+|[1-9]\d*)[uUlL]*)"
)
_CHANGES = Pattern(r"\.t?(data|bss)(?!\.rel\.ro)\b")
_SKIP = Pattern(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'', re.DOTALL)


def rewrite(
    component: Component,
    source: SourceFile,
    header: Path,
    memory: AddressMap,
    gcc: str,
    diagnostics: Diagnostics,
) -> Rewritten | None:
    """One C++ source for the processor of the map, or None with findings. The text includes the author's
    file, so that its lines stay where they are."""
    code = _code(source)
    before = len(diagnostics)
    reads = _uses(code, source, memory, diagnostics)
    for match in _RAW.finditer(code):
        findings.raw_address(diagnostics, Span(source, match.start(1), match.end(1)), match[1])
    if len(diagnostics) > before:
        return None
    writes = {key for key in reads if memory.processor in memory.symbols[key].writers}
    path = Path(source.path).resolve()
    text = "\n".join(
        [
            "#define LDC_REMAPPED",
            _references(memory),
            *_symbols(memory),
            header.read_text(encoding="utf-8"),
            *(f"#define {macro}(name) ldc_{macro.lower()}::name" for macro in MACROS),
            f'#include "{path}"',
            "",
        ]
    )
    unit = header.with_name("check.cpp")
    unit.write_text(text, encoding="utf-8")
    status, assembly, said = toolchain.run(
        [
            gcc,
            "-S",
            "-o",
            "-",
            "-O0",
            "-I",
            str(component.folder.resolve()),
            "-I",
            str(header.parent),
            f"-std={component.standard or 'c++17'}",
            *component.cflags,
            str(unit),
        ]
    )
    sources = own_files(component, diagnostics)
    toolchain.report(
        [s for s in said if s.level == "error"],
        sources,
        component.span("function", "sources"),
        diagnostics,
    )
    if status:
        return None
    for name in _static_data(assembly):
        findings.static_data(diagnostics, _where(name, (source, *sources.values()), component), name)
    defines = frozenset(re.findall(r"^(\w+):", assembly, re.MULTILINE))
    if len(diagnostics) > before:
        return None
    # The text includes files; what it is known by has to change with them.
    made_of = "\0".join((assembly, *(sources[path].text for path in sorted(sources))))
    text += f"// {hashlib.sha256(made_of.encode()).hexdigest()}\n"
    return Rewritten(text, frozenset(reads), frozenset(writes), defines)


def _where(name: str, sources: Iterable[SourceFile], component: Component) -> Span:
    """Where a name first stands in a source or in a header of its own."""
    for source in sources:
        at = re.search(rf"\b{re.escape(name)}\b", _code(source))
        if at is not None:
            return Span(source, at.start(), at.end())
    return component.span("function", "sources")


def _code(source: SourceFile) -> str:
    """The text with blanks for comments and literals."""
    return _SKIP.sub(lambda m: re.sub(r"[^\n]", " ", m[0]), source.text)


def _references(memory: AddressMap) -> str:
    """The types that know an address: behind the memory's begin, or absolute when it has none."""
    return _REFERENCES if memory.base else _REFERENCES.replace("ldc_memory + Address", "Address")


def _uses(
    code: str, source: SourceFile, memory: AddressMap, diagnostics: Diagnostics
) -> set[tuple[str, str]]:
    used = set()
    for match in _USE.finditer(code):
        macro, name = match[1], match[2]
        found = lookup.symbol(memory, macro, name, Span(source, match.start(2), match.end(2)), diagnostics)
        if found is None:
            continue
        if not _assigned(code, match.end()) or lookup.writable(
            memory, found, Span(source, match.start(), match.end()), diagnostics
        ):
            used.add((macro, name.upper()))
    return used


def _assigned(code: str, end: int) -> bool:
    return re.match(r"\s*(?:[-+*/%&|^]|<<|>>)?=(?!=)|\s*(?:\+\+|--)", code[end : end + 40]) is not None


def _static_data(assembly: str) -> list[str]:
    """Variables with a place of their own in the compiled text: in .data or .bss (or .tbss of a thread, or
    .bss.NAME of a template), not constants."""
    found, section = [], ""
    for line in assembly.splitlines():
        word = line.split()
        if not word:
            continue
        if word[0] in (".data", ".bss", ".text") or word[0] == ".section":
            section = word[0] if word[0] != ".section" else word[1].split(",")[0]
        elif word[0] in (".local", ".comm"):
            found.append(word[1].split(",")[0])
        elif line[:1] not in (" ", "\t", ".", "#") and line.endswith(":") and _CHANGES.match(section):
            found.append(line[:-1])
    names = (_plain(name) for name in found)
    return [name for name in dict.fromkeys(names) if name and name != "ldc_memory"]


def _plain(name: str) -> str:
    """The last part of a mangled name: ``_ZZ4stepvE5count`` is ``count``."""
    if not name.startswith("_Z"):
        return name
    at, last = 0, name
    for match in re.finditer(r"\d+", name):
        if match.start() >= at:
            length = int(match[0])
            last = name[match.end() : match.end() + length]
            at = match.end() + length
    return "" if name.startswith("_ZGV") else last


def _symbols(memory: AddressMap) -> list[str]:
    lines = []
    for macro in MACROS:
        rows = [_object(s, memory) for s in memory.symbols.values() if s.macro == macro]
        lines += [f"namespace ldc_{macro.lower()} {{", *(r for r in rows if r), "}"]
    return lines


def _object(symbol: Symbol, memory: AddressMap) -> str | None:
    element = symbol.type
    while isinstance(element, Array):
        element = element.element
    plain = c_types.scalar(element)
    if plain is None:
        return None
    plain += "".join(f"[{count}]" for count in c_types.dimensions(symbol.type)[1:])
    write = "true" if memory.processor in symbol.writers else "false"
    kind = "Elements" if isinstance(symbol.type, Array) else "Value"
    if symbol.bit is not None:
        return f"constexpr ldc::Bit<{symbol.address:#x}u, {symbol.bit}, {write}> {symbol.name}{{}};"
    return f"constexpr ldc::{kind}<{plain}, {symbol.address:#x}u, {write}> {symbol.name}{{}};"


_REFERENCES = """\
#include <stdint.h>
extern "C" { extern unsigned char *ldc_memory; }
namespace ldc {
template <typename T, unsigned long Address, bool Writable> struct Value {
  operator T() const { return *(volatile T *)(ldc_memory + Address); }
  template <typename V> const Value &operator=(V value) const {
    static_assert(Writable, "this processor may not write this symbol");
    *(volatile T *)(ldc_memory + Address) = (T)value;
    return *this;
  }
  template <typename V> const Value &operator+=(V value) const { return *this = (T)*this + value; }
  template <typename V> const Value &operator-=(V value) const { return *this = (T)*this - value; }
  template <typename V> const Value &operator*=(V value) const { return *this = (T)*this * value; }
  template <typename V> const Value &operator/=(V value) const { return *this = (T)*this / value; }
  template <typename V> const Value &operator|=(V value) const { return *this = (T)*this | value; }
  template <typename V> const Value &operator&=(V value) const { return *this = (T)*this & value; }
  template <typename V> const Value &operator^=(V value) const { return *this = (T)*this ^ value; }
  template <typename V> const Value &operator%=(V value) const { return *this = (T)*this % value; }
  template <typename V> const Value &operator<<=(V value) const { return *this = (T)*this << value; }
  template <typename V> const Value &operator>>=(V value) const { return *this = (T)*this >> value; }
  const Value &operator++() const { return *this += 1; }
  const Value &operator--() const { return *this -= 1; }
  T operator++(int) const { T before = *this; *this += 1; return before; }
  T operator--(int) const { T before = *this; *this -= 1; return before; }
};
template <typename T, unsigned long Address, bool Writable> struct Elements {
  volatile T &operator[](unsigned long index) const {
    static_assert(Writable, "this processor may not write this symbol");
    return ((volatile T *)(ldc_memory + Address))[index];
  }
};
template <typename T, unsigned long Address> struct Elements<T, Address, false> {
  const volatile T &operator[](unsigned long index) const {
    return ((const volatile T *)(ldc_memory + Address))[index];
  }
};
template <unsigned long Address, unsigned Index, bool Writable> struct Bit {
  operator bool() const { return (*(volatile unsigned char *)(ldc_memory + Address) >> Index) & 1; }
  template <typename V> const Bit &operator=(V value) const {
    static_assert(Writable, "this processor may not write this symbol");
    volatile unsigned char *at = ldc_memory + Address;
    *at = (unsigned char)((*at & ~(1u << Index)) | ((unsigned)(value != 0) << Index));
    return *this;
  }
};
}
"""
