"""C of a component for one processor: preprocessed, parsed, its symbols resolved and their places written in
(SPEC 9.4).

The tree of pycparser tells where symbols stand and what is done with them. What is written is the author's
text with the places in it, so nothing that a printer of trees does not know is lost, and the messages of gcc
and the steps of gdb are at the author's lines.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Mapping
from pathlib import Path

from pycparser import c_ast, c_parser

from ldc.components import c_rules, c_text, findings, lookup, toolchain
from ldc.components.address_map import MACROS, AddressMap, Symbol
from ldc.components.c_rules import Site
from ldc.components.c_text import CText
from ldc.components.descriptor import Component
from ldc.components.find import own_files
from ldc.diagnostics import Diagnostics
from ldc.il import c_types
from ldc.patterns import Pattern
from ldc.records import record
from ldc.source import SourceFile, Span
from ldc.types import Array

INCLUDE = Path(__file__).with_name("include")
_WHERE = Pattern(r"^[^:]*:(\d+):(\d+): (.*)$", re.DOTALL)
_USE = Pattern(r"\w+\s*\(([\s(]*)\w+")
_FRAMES = 50_000
"""Of pycparser, some thousand branches of `else if`: generated code has them. They are on no stack of C."""


@record
class Rewritten:
    """``text``: one translation unit for the processor's compiler. ``reads``, ``writes``: symbols used, by
    macro and name in capitals. ``defines``: names of its functions."""

    text: str
    reads: frozenset[tuple[str, str]]
    writes: frozenset[tuple[str, str]]
    defines: frozenset[str]


def rewrite(
    component: Component,
    source: SourceFile,
    header: Path,
    memory: AddressMap,
    gcc: str,
    diagnostics: Diagnostics,
) -> Rewritten | None:
    """One C source for the processor of the map, or None with findings. ``header`` is the generated one."""
    sources = own_files(component, diagnostics)
    where = component.span("function", "sources")
    command = _command(component, source, header, gcc)
    status, text, said = toolchain.run([*command, "-DLDC_REMAPPED", "-E"])
    if status:
        toolchain.report([s for s in said if s.level == "error"], sources, where, diagnostics)
        return None
    written = c_text.cut(text)
    places = _Places(written, sources, where, (INCLUDE, header))
    try:
        tree = _parsed(written.plain)
    except c_parser.ParseError as error:
        # gcc tells mistakes better; what it takes is an extension that only gcc knows.
        status, _, said = toolchain.run([*command, "-fsyntax-only"])
        errors = [s for s in said if s.level == "error"]
        if status and errors:
            toolchain.report(errors, sources, where, diagnostics)
        else:
            findings.c_syntax(diagnostics, *places.of_error(str(error)))
        return None
    except RecursionError:
        findings.c_syntax(diagnostics, where, "it nests too deeply")
        return None
    before = len(diagnostics)
    uses = _Uses(places, memory, diagnostics)
    named = c_rules.pointers(tree)
    for site in c_rules.sites(tree):
        if site.node.coord is None or not places.own(site.node):
            continue
        if c_rules.lasting(site):
            findings.static_data(diagnostics, places.span(site.node, site.node.name), site.node.name)
        address = c_rules.raw_address(site.node, named)
        if address is not None:
            span = places.span(address)
            findings.raw_address(diagnostics, span, span.text)
        uses.visit(site)
    if len(diagnostics) > before:
        return None
    defines = frozenset(node.decl.name for node in tree.ext if isinstance(node, c_ast.FuncDef))
    # The folder of the header is another one each time, and the digest of the text names the library.
    text = written.replaced(uses.edits).replace(f'"{header}"', f'"{header.name}"')
    text = _preamble(memory.word_bits) + text
    return Rewritten(text, frozenset(uses.reads), frozenset(uses.writes), defines)


def _command(component: Component, source: SourceFile, header: Path, gcc: str) -> list[str]:
    """How gcc reads a source: with our headers and the generated one, as the author's file."""
    return [
        gcc,
        "-nostdinc",
        f"-std={component.standard or 'c11'}",
        "-isystem",
        str(INCLUDE),
        "-I",
        str(component.folder),
        "-I",
        str(header.parent),
        "-include",
        str(header),
        *(f for f in component.cflags if f[:2] in ("-D", "-U", "-I")),
        source.path,
    ]


def _parsed(text: str) -> c_ast.FileAST:
    """Raises ParseError, and RecursionError when it nests too deeply."""
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, _FRAMES))
    try:
        return c_parser.CParser().parse(text)
    finally:
        sys.setrecursionlimit(limit)


def _preamble(word_bits: int) -> str:
    bits = " ".join(f"_Bool b{n} : 1;" for n in range(word_bits))
    return (
        '#ifdef __cplusplus\nextern "C"\n#endif\nextern unsigned char *ldc_memory;\n'
        f"typedef struct {{ {bits} }} ldc_bits;\n"
    )


class _Places:
    """Spans of what pycparser tells by lines and columns of the preprocessed text."""

    def __init__(
        self, written: CText, sources: Mapping[str, SourceFile], fallback: Span, foreign: tuple[Path, ...]
    ) -> None:
        self.written, self.sources, self.fallback = written, sources, fallback
        self.foreign = tuple(folder.resolve() for folder in foreign)
        self.known: dict[str, tuple[bool, SourceFile | None]] = {}

    def own(self, node: c_ast.Node) -> bool:
        """Whether a node stands in a file of the author, not in a header of ours."""
        return self._file(self.written.origin(self.offset(node))[0])[0]

    def offset(self, node: c_ast.Node) -> int:
        return self.written.offset(node.coord.line, node.coord.column or 1)

    def span(self, node: c_ast.Node, word: str | None = None) -> Span:
        """Where the author wrote a node; ``word``: what it says there, when a macro moved it."""
        return self._at(self.offset(node), word)

    def of_error(self, error: str) -> tuple[Span, str]:
        match = _WHERE.match(error)
        if match is None:
            return self.fallback, error.lstrip(": ")
        return self._at(self.written.offset(int(match[1]), int(match[2])), None), match[3]

    def _at(self, offset: int, word: str | None) -> Span:
        name, line, column = self.written.origin(offset)
        source = self._file(name)[1]
        if source is None or not 1 <= line <= len(source.line_starts):
            return self.fallback
        start = source.line_starts[line - 1]
        found = re.search(rf"\b{re.escape(word)}\b", source.line(line)[column - 1 :]) if word else None
        if found is None and word:
            found, column = re.search(rf"\b{re.escape(word)}\b", source.line(line)), 1
        start = min(start + column - 1 + (found.start() if found else 0), len(source.text))
        end = re.compile(r"\w+|.?").match(source.text, start).end()
        return Span(source, start, max(end, start + 1))

    def _file(self, name: str) -> tuple[bool, SourceFile | None]:
        if name not in self.known:
            path = Path(name).resolve()
            ours = name[:1] == "<" or any(path.is_relative_to(folder) for folder in self.foreign)
            self.known[name] = not ours, self.sources.get(str(path))
        return self.known[name]


class _Uses:
    """The symbols that a tree names: what becomes of their places in the text, what is read and written."""

    def __init__(self, places: _Places, memory: AddressMap, diagnostics: Diagnostics) -> None:
        self.places, self.memory, self.diagnostics = places, memory, diagnostics
        self.reads: set[tuple[str, str]] = set()
        self.writes: set[tuple[str, str]] = set()
        self.edits: dict[tuple[int, int], str] = {}

    def visit(self, site: Site) -> None:
        call = site.node
        if not isinstance(call, c_ast.FuncCall) or not isinstance(call.name, c_ast.ID):
            return
        macro, args = call.name.name, call.args.exprs if call.args is not None else []
        if macro not in MACROS:
            return
        if len(args) != 1 or not isinstance(args[0], c_ast.ID):
            findings.wrong_macro(self.diagnostics, self.places.span(call, macro), macro)
            return
        name = args[0].name
        symbol = lookup.symbol(
            self.memory, macro, name, self.places.span(args[0], name), self.diagnostics
        )
        if symbol is None:
            return
        self._used(site, symbol, self.places.span(call, macro))
        self.edits[self._extent(call)] = self._access(symbol)

    def _used(self, site: Site, symbol: Symbol, span: Span) -> None:
        """Notes what is done with a symbol. Where its address goes, its memory may be written, unless it is
        read-only: then gcc watches its const."""
        key = (symbol.macro, symbol.name.upper())
        dimensions = len(_bounds(symbol))
        while site.above is not None and dimensions and _element(site):
            site, dimensions = site.above, dimensions - 1
        parent = site.above.node if site.above is not None else None
        assigned = isinstance(parent, c_ast.Assignment) and site.role == "lvalue"
        operator = parent.op if assigned or isinstance(parent, c_ast.UnaryOp) else ""
        if not assigned or operator != "=":
            self.reads.add(key)
        if assigned or operator in ("++", "--", "p++", "p--"):
            self.writes.add(key)
            lookup.writable(self.memory, symbol, span, self.diagnostics)
        elif operator == "&" and symbol.bit is not None:
            findings.address_of(self.diagnostics, span, symbol.name)
        elif (dimensions or operator == "&") and self.memory.processor in symbol.writers:
            self.writes.add(key)

    def _extent(self, call: c_ast.FuncCall) -> tuple[int, int]:
        """From the name of the macro to its closing parenthesis."""
        text, start = self.places.written.plain, self.places.offset(call.name)
        match = _USE.match(text, start)
        end = match.end()
        for _ in range(match[1].count("(") + 1):
            end = text.index(")", end) + 1
        return start, end

    def _access(self, symbol: Symbol) -> str:
        const = "" if self.memory.processor in symbol.writers else "const "
        number = f"{symbol.address:#x}u"
        address = f"({self.memory.base} + {number})" if self.memory.base else number
        if symbol.bit is not None:
            return f"(((volatile {const}ldc_bits *) {address})->b{symbol.bit})"
        element = symbol.type
        while isinstance(element, Array):
            element = element.element
        plain = (c_types.scalar(element) or "unsigned char").replace("bool", "_Bool")
        sizes = "".join(f"[{count}]" for count in _bounds(symbol))
        return f"(*({const}volatile {plain} {f'(*){sizes}' if sizes else '*'}) {address})"


def _bounds(symbol: Symbol) -> list[int]:
    """How many elements each dimension of a symbol has."""
    return c_types.dimensions(symbol.type)


def _element(site: Site) -> bool:
    """Whether what stands above takes an element of the array."""
    above = site.above.node
    return (
        isinstance(above, c_ast.ArrayRef) and site.role == "name"
        or isinstance(above, c_ast.UnaryOp) and above.op == "*"
    )
