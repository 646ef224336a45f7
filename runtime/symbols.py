"""Symbol paths of a running machine: ``conveyor.warm.Q``, ``a[3]``, ``%QX0.0``, ``word.15``, ``count.%B1``,
in any case. Bits and parts are those of ``ldc.model.parts``.

The name of the program instance may be left out when there is a single one (DESIGN section 8).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ldc.expr import strides
from ldc.patterns import Pattern
from ldc.records import record
from ldc.similar import similar
from ldc.symbols import Location, Variable
from ldc.types import (
    BOOL, BYTE, DWORD, LWORD, WORD, Array, Elementary, Instance, Struct, Type, is_scalar, numbered)
from runtime.layout import Cell, Home, Layout, Root, slot

_TOKEN = Pattern(r"\.?([^\W\d]\w*)|\.(\d+|%[XBWDLxbwdl]\d+)|\[([-\d,\s]+)\]")
_PARTS = {"X": BOOL, "B": BYTE, "W": WORD, "D": DWORD, "L": LWORD}
_LETTERS = {type_: letter for letter, type_ in _PARTS.items()}
_LONGEST = 1000
Key = str | int


class UnknownSymbol(LookupError):
    """No variable of that path; the message names near ones."""


@record
class Symbol:
    """One scalar of the machine. ``keys``: attribute names and flat indexes from the root to it; ``bit``: the
    first one of a part of a number, which is a value of ``whole``; ``area``: I Q M when located."""

    path: str
    type: Type
    home: Home
    keys: tuple[Key, ...] = ()
    bit: int | None = None
    area: str = ""
    whole: Elementary | None = None

    @property
    def place(self) -> tuple:
        """The same for whatever path or address the variable is found by."""
        return self.home, self.keys, self.part

    @property
    def part(self) -> str:
        """What follows the path of the whole: ``.15``, ``.%B1``; nothing for what is no part."""
        if self.bit is None:
            return ""
        return f".{self.bit}" if self.type == BOOL else f".%{_LETTERS[self.type]}{self.bit // self.type.bits}"


class Symbols:
    """Finds symbols by path, and lists them."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._found: dict[str, Symbol] = {}
        self._addresses: dict[str, Root] = {}
        for root in layout.roots():
            if root.variable.location is not None:
                self._addresses.setdefault(str(root.variable.location), root)
        self._addresses |= layout.direct

    @property
    def programs(self) -> list[str]:
        """The names of the program instances."""
        return [run.name for run, _ in self._layout.programs]

    def find(self, path: str) -> Symbol:
        """The scalar of that path. Raises UnknownSymbol, also for arrays, structures and instances."""
        key = path.strip().upper()
        if key not in self._found:
            self._found[key] = self._find(path.strip())
        return self._found[key]

    def _find(self, path: str) -> Symbol:
        if path.startswith("%"):
            at = Location.parse(path)
            root = self._addresses.get(str(at)) if at else None
            if root is None:
                raise UnknownSymbol(f"the program has nothing at {path}")
            return self._walk(path, root, [])
        tokens = _tokens(path)
        if not tokens or not isinstance(tokens[0], str):
            raise UnknownSymbol(f"`{path[:_LONGEST]}` is no name of a variable")
        failed = None
        for root, rest in self._starts(tokens):
            try:
                return self._walk(path, root, rest)
            except UnknownSymbol as error:
                failed = failed or error
        if failed:
            raise failed
        raise UnknownSymbol(f"no variable `{path}`{_hint(path, self._names())}")

    def _starts(self, tokens: list) -> Iterator[tuple[Root, list]]:
        first = tokens[0].upper()
        for run, table in self._layout.programs:
            if run.name.upper() == first and len(tokens) > 1 and isinstance(tokens[1], str):
                root = table.get(tokens[1].upper())
                if root:
                    yield root, tokens[2:]
        if len(self._layout.programs) == 1 and first in self._layout.programs[0][1]:
            yield self._layout.programs[0][1][first], tokens[1:]
        # A variable of a program that others reach is a global with the path as its name.
        shared, second = self._layout.globals, tokens[1] if len(tokens) > 1 else None
        if isinstance(second, str) and f"{first}.{second.upper()}" in shared:
            yield shared[f"{first}.{second.upper()}"], tokens[2:]
        if len(self._layout.programs) == 1:
            path = f"{self._layout.programs[0][0].name.upper()}.{first}"
            if path in shared:
                yield shared[path], tokens[1:]
        if first in shared:
            yield shared[first], tokens[1:]

    def _names(self) -> Iterator[str]:
        single = len(self._layout.programs) == 1
        for table in (self._layout.globals, *(table for _, table in self._layout.programs)):
            for root in table.values():
                if root.variable.kind != "hidden":
                    yield root.variable.name if single else root.path

    def _walk(self, path: str, root: Root, rest: list) -> Symbol:
        type_, keys, bit, whole = root.variable.type, [], None, None
        for token in rest:
            if isinstance(token, list) and isinstance(type_, Array):
                keys.append(_offset(path, type_, token))
                type_ = type_.element
            elif isinstance(token, str):
                type_ = self._member(path, type_, token)
                keys.append(slot(token))
            elif isinstance(token, tuple) and (at := _part(type_, token)) is not None:
                whole = whole or numbered(type_)
                bit, type_ = (bit or 0) + at, token[0]
            else:
                raise UnknownSymbol(f"`{path}`: a value of {type_} has no such part")
        if not is_scalar(type_):
            raise UnknownSymbol(f"`{path}` is a whole {type_}: name one value in it")
        location = root.variable.location
        return Symbol(path, type_, root.home, tuple(keys), bit, location.area if location else "", whole)

    def _member(self, path: str, type_: Type, name: str) -> Type:
        names = []
        for member, of in self._members(type_):
            if member.upper() == name.upper():
                return of
            names.append(member)
        raise UnknownSymbol(f"`{path}`: {type_} has no `{name}`{_hint(name, names)}")

    def _members(self, type_: Type) -> list[tuple[str, Type]]:
        match type_:
            case Struct(fields=fields):
                return [(f.name, f.type) for f in fields]
            case Instance(pou=pou):
                return [(v.name, v.type) for v in self._layout.units[pou.upper()].variables if has_state(v)]
        return []

    def full(self, symbol: Symbol) -> str:
        """The path of a symbol with the name of its program, which means the same in every program."""
        if symbol.path.startswith("%"):
            return symbol.path
        roots = (root for root in self._layout.roots() if root.home == symbol.home)
        leaves = (leaf for root in roots for leaf in self.of(root, hidden=True))
        return next(leaf.path + symbol.part for leaf in leaves if leaf.keys == symbol.keys)

    def all(self, hidden: bool = False) -> Iterator[Symbol]:
        """Every scalar with state, in declared order; ``hidden``: the compiler's memories too."""
        for root in self._layout.roots():
            if hidden or root.variable.kind != "hidden":
                yield from self.of(root, hidden)

    def located(self, area: str) -> Iterator[Symbol]:
        """Every scalar that is declared in the area I, Q or M, in declared order."""
        for root in self._layout.roots():
            if root.variable.location is not None and root.variable.location.area == area:
                yield from self.of(root)

    def of(self, root: Root, hidden: bool = False) -> Iterator[Symbol]:
        """The scalars of one root variable."""
        location = root.variable.location
        area = location.area if location else ""
        yield from self._leaves(root.path, root.variable.type, root.home, (), area, hidden)

    def _leaves(self, path: str, type_: Type, home: Home, keys: tuple[Key, ...], area: str,
                hidden: bool) -> Iterator[Symbol]:
        if is_scalar(type_):
            yield Symbol(path, type_, home, keys, None, area)
        elif isinstance(type_, Array):
            for offset, index in enumerate(indexes(type_)):
                inside = (*keys, offset)
                yield from self._leaves(f"{path}[{index}]", type_.element, home, inside, area, hidden)
        elif isinstance(type_, Struct):
            for f in type_.fields:
                yield from self._leaves(f"{path}.{f.name}", f.type, home, (*keys, slot(f.name)), area, hidden)
        else:
            for v in self._layout.units[type_.pou.upper()].variables:
                if has_state(v) and (hidden or v.kind != "hidden"):
                    inside = (*keys, slot(v.name))
                    yield from self._leaves(f"{path}.{v.name}", v.type, home, inside, area, hidden)


def _tokens(path: str) -> list:
    """Names, parts (type and number) and lists of indexes; nothing when the path is none."""
    tokens, end = [], 0
    for match in _TOKEN.finditer(path if len(path) <= _LONGEST else ""):
        if match.start() != end:
            return []
        try:
            tokens.append(match[1] or _numbered(match[2]) or [int(i) for i in match[3].split(",")])
        except ValueError:  # as in `a[1,]` or `a[-]`
            return []
        end = match.end()
    return tokens if end == len(path) else []


def _numbered(text: str | None) -> tuple[Elementary, int] | None:
    """``15`` and ``%X15`` are the same bit."""
    if text is None:
        return None
    return (_PARTS[text[1].upper()], int(text[2:])) if text[0] == "%" else (BOOL, int(text))


def _part(type_: Type, token: tuple[Elementary, int]) -> int | None:
    """The first bit of a part of a value of the type; None when it has none such."""
    whole, (size, number) = numbered(type_), token
    known = whole is not None and (number + 1) * size.bits <= whole.bits
    return number * size.bits if known else None


def _hint(name: str, known: Iterable[str]) -> str:
    """The nearest known name, in its declared spelling, as the end of a sentence."""
    spelled = {one.upper(): one for one in known}
    near = similar(name.upper(), spelled, 1)
    return f", did you mean `{spelled[near[0]]}`?" if near else ""


def has_state(variable: Variable) -> bool:
    """Whether the variable is kept between two executions."""
    return variable.kind not in ("temp", "external")


def is_cell(symbol: Symbol) -> bool:
    """Whether the symbol is one entry of the namespace, which bulk reads and writes take directly."""
    return isinstance(symbol.home, Cell) and not symbol.keys and symbol.bit is None


def indexes(type_: Array) -> Iterator[str]:
    """The index of every element as it is written, in the order in which they lie: ``0,1``."""
    counts = [low for low, _ in type_.bounds]
    for _ in range(type_.count):
        yield ",".join(map(str, counts))
        for i in range(len(counts) - 1, -1, -1):
            counts[i] += 1
            if counts[i] <= type_.bounds[i][1]:
                break
            counts[i] = type_.bounds[i][0]


def _offset(path: str, type_: Array, indexes: list[int]) -> int:
    if len(indexes) != len(type_.bounds):
        raise UnknownSymbol(f"`{path}`: {type_} takes {len(type_.bounds)} indexes")
    total = 0
    for index, (low, high), stride in zip(indexes, type_.bounds, strides(type_.bounds), strict=True):
        if not low <= index <= high:
            raise UnknownSymbol(f"`{path}`: {index} is outside {low}..{high}")
        total += (index - low) * stride
    return total
