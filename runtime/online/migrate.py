"""What becomes of each symbol when another program takes over (DESIGN sections 3.4 and 7).

A variable is known by its path and its type. Of a function block, structure or array that changed, the
members and elements are, so that what is still there goes on. A located variable is known by its address:
the process images stay, whatever their parts are called. Memories of the compiler are kept by their names;
a new one of an edge is set so that its first execution shows no edge.
"""

from __future__ import annotations

from collections.abc import Iterator

from ldc.diagnostics import Diagnostic
from ldc.il.layout import type_hash
from ldc.records import record
from ldc.types import Array, Instance, Struct, Type, is_scalar, storage
from runtime.layout import Layout, Root
from runtime.online import findings
from runtime.symbols import Symbol, Symbols

_NO_EDGE = {"P": True, "PC": True, "N": False, "NC": False}
Bit = tuple[str, int, Type]


@record
class Plan:
    """``whole``: variables that are copied as they are, old and new; ``parts``: single scalars;
    ``quiet``: new edge memories with the value that shows no edge. ``kept``, ``initialised``, ``dropped``:
    paths in the order of the programs, as people read them; the compiler's memories are not among them.
    ``refusals``: why the change cannot be (LD0820); nothing may be copied then."""

    whole: tuple[tuple[Root, Root], ...]
    parts: tuple[tuple[Symbol, Symbol], ...]
    quiet: tuple[tuple[Symbol, bool], ...]
    kept: tuple[str, ...]
    initialised: tuple[str, ...]
    dropped: tuple[str, ...]
    refusals: tuple[Diagnostic, ...]


def plan(old: Layout, new: Layout) -> Plan:
    """How the state of a program becomes that of another one. Linear in the number of scalars."""
    return _Planner(old, new).plan()


def no_edge(path: str) -> bool | None:
    """The value of an edge memory that shows no edge, whatever its operand is; None for other variables."""
    parts = path.rsplit(".", 1)[-1].rsplit("_", 3)
    if len(parts) < 4 or not parts[0].lower().startswith("_ldc_") or not parts[3].isdigit():
        return None
    return _NO_EDGE.get(parts[1].upper())


class _Planner:
    def __init__(self, old: Layout, new: Layout) -> None:
        self.old, self.new = old, new
        self.symbols, self.symbols_before = Symbols(new), Symbols(old)
        self.before = {root.path.upper(): root for root in old.roots()}
        self.whole: list[tuple[Root, Root]] = []
        self.parts: list[tuple[Symbol, Symbol]] = []
        self.quiet: list[tuple[Symbol, bool]] = []
        self.kept: list[str] = []
        self.initialised: list[str] = []
        self.dropped: list[str] = []
        self.refusals: list[Diagnostic] = []
        self._hashes: dict[tuple[int, Type], str] = {}

    def plan(self) -> Plan:
        addresses, located = self._addresses(), self._located_roots()
        seen = set()
        for root in self.new.roots():
            key = root.path.upper()
            seen.add(key)
            before = self.before.get(key)
            if before is not None and not self._alike(before.variable.type, root.variable.type):
                self.refusals.append(
                    findings.type_changed(root.path, before.variable.type, root.variable.type))
            elif root.variable.location is not None:
                was = located.get((root.variable.location, storage(root.variable.type)))
                if was is not None:
                    self._pair(was, root)
                else:
                    self._located(root, before, addresses)
            elif before is not None:
                self._pair(before, root)
            else:
                self._begin(root)
        hidden = (r for r in self.old.roots() if r.path.upper() not in seen and r.variable.kind != "hidden")
        self.dropped += [root.path for root in hidden]
        return Plan(*map(tuple, (self.whole, self.parts, self.quiet, self.kept, self.initialised,
                                 self.dropped, self.refusals)))

    def _alike(self, old: Type, new: Type) -> bool:
        """Whether parts of one can be found in the other: both of one kind, or the same scalar."""
        if isinstance(old, Array) and isinstance(new, Array):
            return len(old.bounds) == len(new.bounds)
        if isinstance(old, Struct) and isinstance(new, Struct):
            return True
        if isinstance(old, Instance) and isinstance(new, Instance):
            return old.pou.upper() == new.pou.upper()
        return self._same(old, new)

    def _same(self, old: Type, new: Type) -> bool:
        return self._hash(self.old, old) == self._hash(self.new, new)

    def _hash(self, layout: Layout, type_: Type) -> str:
        key = id(layout), type_
        if key not in self._hashes:
            self._hashes[key] = type_hash(type_, layout.units)
        return self._hashes[key]

    # ---- variables by path ---------------------------------------------------------------------------

    def _pair(self, old: Root, new: Root) -> None:
        if self._same(old.variable.type, new.variable.type):
            self.whole.append((old, new))
        else:
            self._by_parts(old, new)
        if new.variable.kind != "hidden":
            self.kept.append(new.path)

    def _by_parts(self, old: Root, new: Root) -> None:
        """The scalars of a variable whose type gained or lost some."""
        before = {s.path.upper(): s for s in self.symbols_before.of(old, hidden=True)}
        for symbol in self.symbols.of(new, hidden=True):
            was = before.pop(symbol.path.upper(), None)
            if was is None:
                if not self._silent(symbol) and not _is_hidden(symbol):
                    self.initialised.append(symbol.path)
            elif self._same(was.type, symbol.type):
                self.parts.append((was, symbol))
            else:
                self.refusals.append(findings.type_changed(symbol.path, was.type, symbol.type))
        self.dropped += [s.path for s in before.values() if not _is_hidden(s)]

    def _begin(self, root: Root) -> None:
        """A variable that was not there."""
        if root.variable.kind != "hidden":
            self.initialised.append(root.path)
        if root.variable.kind == "hidden" or not is_scalar(root.variable.type):
            for symbol in self.symbols.of(root, hidden=True):
                self._silent(symbol)

    def _silent(self, symbol: Symbol) -> bool:
        value = no_edge(symbol.path)
        if value is not None:
            self.quiet.append((symbol, value))
        return value is not None

    # ---- variables by address ------------------------------------------------------------------------

    def _located_roots(self) -> dict[tuple, Root]:
        return {(root.variable.location, storage(root.variable.type)): root for root in self.old.roots()
                if root.variable.location is not None}

    def _addresses(self) -> dict[Bit, Symbol]:
        return {place: symbol for root in self.old.roots() if root.variable.location is not None
                for place, symbol in _bits(root, self.symbols_before)}

    def _located(self, root: Root, before: Root | None, addresses: dict[Bit, Symbol]) -> None:
        """What lies at the same address goes on; what moved takes its value along."""
        found = [(addresses.get(place), symbol) for place, symbol in _bits(root, self.symbols)]
        if all(was is not None for was, _ in found):
            self.parts += found
            self.kept.append(root.path)
        elif before is not None:
            self._pair(before, root)
        else:
            self.parts += [(was, symbol) for was, symbol in found if was is not None]
            self.initialised.append(root.path)


def _bits(root: Root, symbols: Symbols) -> Iterator[tuple[Bit, Symbol]]:
    """The first bit and the stored type of each scalar of a located variable."""
    at = root.variable.location
    start = at.byte * 8 + at.bit
    for number, symbol in enumerate(symbols.of(root)):
        yield (at.area, start + number * at.bits, storage(symbol.type)), symbol


def _is_hidden(symbol: Symbol) -> bool:
    return symbol.path.rsplit(".", 1)[-1].lower().startswith("_ldc_")
