"""C of a component for one processor: preprocessed, parsed, its symbols resolved, rewritten (SPEC 9.4).

The rewriting is done on pycparser's tree. Every statement is printed behind a ``#line``, so that the
messages of gcc and the steps of gdb are at the author's lines.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pycparser import c_ast, c_generator, c_parser

from ldc.components import findings, lookup, toolchain
from ldc.components.address_map import MACROS, AddressMap, Symbol
from ldc.components.descriptor import Component
from ldc.diagnostics import Diagnostics
from ldc.il import c_types
from ldc.source import SourceFile, Span
from ldc.types import BOOL, Array, storage

INCLUDE = Path(__file__).with_name("include")
_WHERE = re.compile(r"^(.*?):(\d+):(\d+): (.*)$", re.DOTALL)
_TARGET = {
    "=": None,
    "+=": "+",
    "-=": "-",
    "*=": "*",
    "/=": "/",
    "%=": "%",
    "<<=": "<<",
    ">>=": ">>",
    "&=": "&",
    "^=": "^",
    "|=": "|",
}
_BIG = 1 << 64
_ARITHMETIC = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "&": operator.and_,
    "|": operator.or_,
    "^": operator.xor,
    "<<": lambda left, right: left << min(max(right, 0), 64),
    ">>": lambda left, right: left >> min(max(right, 0), 64),
}


@dataclass(frozen=True, slots=True)
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
    text = preprocess(component, source, header, gcc, diagnostics)
    if text is None:
        return None
    places = _Places(source, component)
    try:
        tree = c_parser.CParser().parse(text, source.path)
    except c_parser.ParseError as error:
        # gcc tells mistakes better; what it takes is an extension that only gcc knows.
        command = [*_command(component, source, header, gcc), "-fsyntax-only"]
        status, _, said = toolchain.run(command)
        if status:
            toolchain.report(
                [s for s in said if s.level == "error"], {source.path: source}, places.fallback, diagnostics
            )
        else:
            findings.c_syntax(diagnostics, *places.of_error(str(error)))
        return None
    except RecursionError:
        findings.c_syntax(diagnostics, component.span("function", "sources"), "it nests too deeply")
        return None
    work = _Remap(places, memory, diagnostics)
    before = len(diagnostics)
    work.visit(tree)
    if len(diagnostics) > before:
        return None
    defines = frozenset(node.decl.name for node in tree.ext if isinstance(node, c_ast.FuncDef))
    return Rewritten(
        _PREAMBLE + _Printer(places).visit(tree), frozenset(work.reads), frozenset(work.writes), defines
    )


def preprocess(
    component: Component, source: SourceFile, header: Path, gcc: str, diagnostics: Diagnostics
) -> str | None:
    """The source after the preprocessor, with its headers and line markers; None with findings."""
    status, text, said = toolchain.run([*_command(component, source, header, gcc), "-DLDC_REMAPPED", "-E"])
    if status:
        toolchain.report(
            [s for s in said if s.level == "error"],
            {source.path: source},
            component.span("function", "sources"),
            diagnostics,
        )
        return None
    return text


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


_PREAMBLE = """\
#ifdef __cplusplus
extern "C"
#endif
extern unsigned char *ldc_memory;
static inline void ldc_put_bit(volatile unsigned char *at, unsigned bit, int on)
{
  *at = (unsigned char)((*at & ~(1u << bit)) | ((unsigned)(on != 0) << bit));
}
"""


class _Places:
    """Spans of what pycparser tells by file, line and column."""

    def __init__(self, source: SourceFile, component: Component) -> None:
        self.source, self.fallback = source, component.span("function", "sources")
        self.path = Path(source.path)

    def span(self, node: c_ast.Node) -> Span:
        at = node.coord
        return self.fallback if at is None else self.at(at.file, at.line, at.column or 1)

    def at(self, file: str, line: int, column: int) -> Span:
        if Path(file) != self.path or not 1 <= line <= len(self.source.line_starts):
            return self.fallback
        start = min(self.source.line_starts[line - 1] + column - 1, len(self.source.text))
        word = re.compile(r"\w+|.?").match(self.source.text, start)
        return Span(self.source, start, max(word.end(), start + 1))

    def of_error(self, error: str) -> tuple[Span, str]:
        match = _WHERE.match(error)
        if match is None:
            return self.fallback, error
        return self.at(match[1], int(match[2]), int(match[3])), match[4]

    def own(self, node: c_ast.Node) -> bool:
        """Whether a node stands in the author's source, not in a header of ours."""
        return node.coord is not None and Path(node.coord.file) == self.path


class _Remap(c_ast.NodeVisitor):
    """Resolves the symbols of a tree in place and tells what a component may not do."""

    def __init__(self, places: _Places, memory: AddressMap, diagnostics: Diagnostics) -> None:
        self.places, self.memory, self.diagnostics = places, memory, diagnostics
        self.reads: set[tuple[str, str]] = set()
        self.writes: set[tuple[str, str]] = set()
        self.depth = 0

    # ---- what is not allowed

    def visit_FuncDef(self, node: c_ast.FuncDef) -> None:
        self.depth += 1
        self.generic_visit(node)
        self.depth -= 1

    def visit_Struct(self, node: c_ast.Struct | c_ast.Union) -> None:
        """Members are no data of their own."""
        self.depth += 1
        self._children(node)
        self.depth -= 1

    visit_Union = visit_Struct

    def visit_Decl(self, node: c_ast.Decl) -> None:
        data = not isinstance(node.type, c_ast.FuncDecl) and node.name is not None
        lasting = "static" in node.storage or self.depth == 0 and "extern" not in node.storage
        if data and lasting and not _constant(node.type) and self.places.own(node):
            findings.static_data(self.diagnostics, self.places.span(node), node.name)
        if isinstance(node.type, c_ast.PtrDecl) and node.init is not None:
            self._address(node.init)
        self._children(node)

    def visit_Cast(self, node: c_ast.Cast) -> None:
        if isinstance(node.to_type.type, c_ast.PtrDecl):
            self._address(node.expr)
        self._children(node)

    def _address(self, node: c_ast.Node) -> None:
        """A constant other than 0 that becomes a pointer."""
        if self.places.own(node) and _number(node):
            text = c_generator.CGenerator().visit(node)
            findings.raw_address(self.diagnostics, self.places.span(node), text)

    # ---- symbols

    def generic_visit(self, node: c_ast.Node) -> None:
        self._children(node)

    def _children(self, node: c_ast.Node) -> None:
        if isinstance(node, c_ast.Assignment):
            self._element(node.lvalue, read=node.op != "=")
        elif isinstance(node, c_ast.UnaryOp) and node.op in ("++", "--", "p++", "p--", "&"):
            self._element(node.expr, read=True)
        for name, child in node.children():
            symbol = self._symbol(child)
            if symbol is None:
                self.visit(child)
                continue
            key = (symbol.macro, symbol.name.upper())
            if isinstance(node, c_ast.UnaryOp) and node.op == "&":
                self._take_address(node, symbol)
            elif isinstance(node, c_ast.UnaryOp) and node.op in ("++", "--", "p++", "p--"):
                self._written(child, symbol, read=True)
            elif isinstance(node, c_ast.Assignment) and name == "lvalue":
                self._written(child, symbol, read=node.op != "=")
                if symbol.bit is not None:
                    continue  # the assignment itself becomes a call
            else:
                self.reads.add(key)
            _replace(node, name, self._access(symbol, child))
        for name, child in node.children():
            if isinstance(child, c_ast.Assignment) and self._symbol(child.lvalue, tell=False) is not None:
                _replace(node, name, self._put_bit(child))

    def _symbol(self, node: c_ast.Node, tell: bool = True) -> Symbol | None:
        """The symbol that ``PLC_D(name)`` is, or None."""
        if (
            not isinstance(node, c_ast.FuncCall)
            or not isinstance(node.name, c_ast.ID)
            or node.name.name not in MACROS
        ):
            return None
        macro, args = node.name.name, node.args.exprs if node.args is not None else []
        if len(args) != 1 or not isinstance(args[0], c_ast.ID):
            if tell:
                findings.wrong_macro(self.diagnostics, self.places.span(node), macro)
            return None
        if tell:
            return lookup.symbol(
                self.memory, macro, args[0].name, self.places.span(args[0]), self.diagnostics
            )
        found = self.memory.find(macro, args[0].name)
        return found if found is not None and self.memory.processor in found.readers else None

    def _element(self, node: c_ast.Node, read: bool) -> None:
        """An element of an array symbol that is written."""
        if isinstance(node, c_ast.ArrayRef):
            symbol = self._symbol(node.name, tell=False)
            if symbol is not None:
                self._written(node.name, symbol, read)

    def _written(self, node: c_ast.Node, symbol: Symbol, read: bool) -> None:
        key = (symbol.macro, symbol.name.upper())
        self.writes.add(key)
        if read:
            self.reads.add(key)
        lookup.writable(self.memory, symbol, self.places.span(node), self.diagnostics)

    def _take_address(self, node: c_ast.UnaryOp, symbol: Symbol) -> None:
        """A pointer may be used to write, unless the memory is read-only: then gcc watches its const."""
        self.reads.add((symbol.macro, symbol.name.upper()))
        if symbol.bit is not None:
            findings.address_of(self.diagnostics, self.places.span(node), symbol.name)
        elif self.memory.processor in symbol.writers:
            self.writes.add((symbol.macro, symbol.name.upper()))

    def _access(self, symbol: Symbol, at: c_ast.Node) -> c_ast.Node:
        return _expression(self._text(symbol), at.coord)

    def _text(self, symbol: Symbol) -> str:
        const = "" if self.memory.processor in symbol.writers else "const "
        address = self._address_text(symbol)
        if symbol.bit is not None:
            return f"((*({const}volatile unsigned char *)({address}) >> {symbol.bit}) & 1)"
        plain = "unsigned char" if storage(symbol.type) == BOOL else _element(symbol)
        access = f"({const}volatile {plain} *)({address})"
        return access if isinstance(symbol.type, Array) else f"(*{access})"

    def _address_text(self, symbol: Symbol) -> str:
        number = f"{symbol.address:#x}u"
        return f"{self.memory.base} + {number}" if self.memory.base else number

    def _put_bit(self, node: c_ast.Assignment) -> c_ast.Node:
        """``PLC_M(x) = e`` on a packed bit: a call, for C has no references to bits."""
        symbol = self._symbol(node.lvalue, tell=False)
        op = _TARGET[node.op]
        value = c_generator.CGenerator().visit(node.rvalue)
        if op is not None:
            value = f"{self._text(symbol)} {op} ({value})"
        at = f"(volatile unsigned char *)({self._address_text(symbol)})"
        return _expression(f"ldc_put_bit({at}, {symbol.bit}, ({value}) != 0)", node.coord)


def _element(symbol: Symbol) -> str:
    type_ = symbol.type
    while isinstance(type_, Array):
        type_ = type_.element
    return c_types.scalar(type_) or "unsigned char"


def _expression(text: str, coord) -> c_ast.Node:
    """A piece of C as a tree that stands at ``coord``."""
    names = (
        "typedef int int8_t; typedef int int16_t; typedef int int32_t; typedef int int64_t; "
        "typedef int uint8_t; typedef int uint16_t; typedef int uint32_t; typedef int uint64_t; "
    )
    tree = c_parser.CParser().parse(f"{names}void f(void) {{ {text}; }}")
    node = tree.ext[-1].body.block_items[0]
    for part in _walk(node):
        part.coord = coord
    return node


def _walk(node: c_ast.Node) -> Iterator[c_ast.Node]:
    todo = [node]
    while todo:
        node = todo.pop()
        yield node
        todo += [child for _, child in node.children()]


def _replace(parent: c_ast.Node, name: str, child: c_ast.Node) -> None:
    """Puts a child in the place that ``children()`` calls ``name`` (``lvalue``, ``exprs[2]``)."""
    field, _, index = name.partition("[")
    if index:
        getattr(parent, field)[int(index[:-1])] = child
    else:
        setattr(parent, field, child)


def _constant(type_: c_ast.Node) -> bool:
    """Whether nothing of a declared object can change."""
    while isinstance(type_, c_ast.ArrayDecl):
        type_ = type_.type
    return "const" in (getattr(type_, "quals", None) or [])


def _number(node: c_ast.Node) -> int | None:
    """The value of an expression that is made of whole numbers alone."""
    match node:
        case c_ast.Constant() if "int" in node.type or node.type == "char":
            digits = node.value.rstrip("uUlL")
            octal = len(digits) > 1 and digits[0] == "0" and digits.isdigit()
            return (
                int(digits, 8 if octal else 0)
                if digits[:1].isdigit()
                else ord(digits.strip("'")[-1:] or "\0")
            )
        case c_ast.Cast():
            return _number(node.expr)
        case c_ast.UnaryOp(op="-" | "+" | "~"):
            value = _number(node.expr)
            return None if value is None else {"-": -value, "+": value, "~": ~value}[node.op]
        case c_ast.BinaryOp():
            left, right = _number(node.left), _number(node.right)
            if (
                left is None
                or right is None
                or node.op not in _ARITHMETIC
                or abs(left) > _BIG
                or abs(right) > _BIG
            ):
                return None
            return _ARITHMETIC[node.op](left, right)
    return None


class _Printer(c_generator.CGenerator):
    """Prints a tree with a ``#line`` before every statement and definition of the author."""

    def __init__(self, places: _Places) -> None:
        super().__init__()
        self.places = places

    def _line(self, node: c_ast.Node) -> str:
        if node.coord is None or not self.places.own(node):
            return ""
        file = str(self.places.path).replace("\\", "\\\\").replace('"', '\\"')
        return f'#line {node.coord.line} "{file}"\n'

    def visit_FuncDef(self, n: c_ast.FuncDef) -> str:
        return self._line(n.decl) + super().visit_FuncDef(n)

    def _generate_stmt(self, n: c_ast.Node, add_indent: bool = False) -> str:
        return self._line(n) + super()._generate_stmt(n, add_indent)
