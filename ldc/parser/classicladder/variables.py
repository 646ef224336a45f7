"""What a type and a number name in ClassicLadder: bits, words, inputs, outputs, parts of blocks.

Bits are BOOL, numbers are 32 bits wide (DINT), floats REAL. A symbol gives the name, otherwise the letter of
the type and the number do. Words and bits that an index chooses become arrays.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ldc.parser import ast, fragments
from ldc.parser.classicladder.settings import CLASSIC, REGISTERS, Preset, Settings
from ldc.parser.foreign import Names, Reading, stored
from ldc.records import record
from ldc.source import Span

PACKAGE = "ldc.parser.classicladder"
MAX_OFFSET = 100_000
BIT, WORD, STEP, STEP_TIME, INPUT, OUTPUT, SYSTEM = 0, 200, 30, 220, 50, 60, 70
_PLAIN = {
    BIT: ("B", "BOOL"),
    STEP: ("X", "BOOL"),
    INPUT: ("I", "BOOL"),
    OUTPUT: ("Q", "BOOL"),
    SYSTEM: ("E", "BOOL"),
    75: ("E", "BOOL"),
    WORD: ("W", "DINT"),
    270: ("IW", "DINT"),
    280: ("QW", "DINT"),
    300: ("IF", "REAL"),
    310: ("QF", "REAL"),
    STEP_TIME: ("X", "DINT"),
}
_AREAS = {INPUT: ("%I", 0), 270: ("%I", 1), 300: ("%I", 2), OUTPUT: ("%Q", 0), 280: ("%Q", 1), 310: ("%Q", 2)}
_SIZES = {BIT: "SIZE_NBR_BITS", WORD: "SIZE_NBR_WORDS", INPUT: "SIZE_NBR_PHYS_INPUTS",
          OUTPUT: "SIZE_NBR_PHYS_OUTPUTS"}
_PARTS = {10: ("T", "DONE", "BOOL"), 11: ("T", "RUNNING", "BOOL"), 15: ("TM", "Q", "BOOL"),
          20: ("M", "RUNNING", "BOOL"), 25: ("C", "DONE", "BOOL"), 26: ("C", "EMPTY", "BOOL"),
          27: ("C", "FULL", "BOOL"), 231: ("T", "VALUE", "DINT"), 241: ("M", "VALUE", "DINT"),
          261: ("TM", "VALUE", "DINT")}
PRESETS = {230: "T", 240: "M", 250: "C", 260: "TM"}
_COUNT = 251
_SYSTEM_WORD = 290
_SYSTEM_BITS = {0: "FLASH", 1: "DARK", 4: "START", 5: "START"}
"""Outputs of the block that is called before all rungs; a cold start and a hot one are not told apart."""
_REGISTER_VALUES = range(300, 320)
"""Of registers, in newer tools; floats in LinuxCNC."""
BLOCKS = {"T": "timer", "M": "monostable", "C": "counter", "TM": "timer_iec"}


@record
class Place:
    """``text`` of an expression of a type; ``writable``: an expression may be stored there."""

    text: str
    type: str
    writable: bool = True


def base(text: str) -> str:
    """The variable in the text of a place: ``T0`` of ``T0.DONE``, ``W`` of ``W[3]``."""
    return text.split("[")[0].split(".")[0]


@dataclass(slots=True)
class Declared:
    name: str
    type: str
    span: Span
    initial: str | None = None
    note: str | None = None
    kind: int = -1
    offset: int = 0


@dataclass(slots=True)
class Variables:
    """All variables of a project. ``indexed``: types that an index chooses from; ``presets``: those that an
    expression or a contact names; ``used``: variables of the POU that is being read, by name;
    ``symbols``: the variables whose symbols gave a name."""

    reading: Reading
    settings: Settings
    names: Names
    indexed: set[int] = field(default_factory=set)
    presets: set[tuple[str, int]] = field(default_factory=set)
    found: dict[tuple, Declared] = field(default_factory=dict)
    used: dict[str, Declared] = field(default_factory=dict)
    blocks: dict[str, ast.Pou] = field(default_factory=dict)
    reach: dict[int, int] = field(default_factory=dict)
    symbols: set[str] = field(default_factory=set)

    def place(self, kind: int, offset: int, span: Span, index: str | None = None) -> Place:
        """The variable that a type and an offset name; ``index``: an expression added to the offset."""
        if not 0 <= offset < MAX_OFFSET:
            self.reading.malformed(span, f"there is no variable {kind}/{offset}")
            offset = 0
        if kind == SYSTEM and self.settings.age != CLASSIC and offset in _SYSTEM_BITS:
            return Place(f"{self.system(span)}.{_SYSTEM_BITS[offset]}", "BOOL", False)
        if what := self._newer(kind, offset):
            self.reading.unsupported(span, what, "see docs/import-classicladder.md")
            return Place("FALSE" if kind < 200 else "0", "BOOL" if kind < 200 else "DINT", False)
        if index is not None or kind in self.indexed:
            return self._element(kind, offset, span, index)
        if kind in _PLAIN:
            return Place(self._plain(kind, offset, span).name, _PLAIN[kind][1])
        if kind in _PARTS:
            letters, pin, type_ = _PARTS[kind]
            return Place(f"{self.instance(letters, offset, span)}.{pin}", type_, False)
        if kind in PRESETS:
            return Place(self.preset(PRESETS[kind], offset, span), "DINT")
        if kind == _COUNT:
            return Place(self.count(offset, span), "DINT")
        self.reading.unsupported(span, f"the variable type {kind}", "see docs/import-classicladder.md")
        return Place("FALSE" if kind < 200 else "0", "BOOL" if kind < 200 else "DINT", False)

    def _newer(self, kind: int, offset: int) -> str | None:
        """What a type means that meant something else in older tools."""
        if kind == SYSTEM and self.settings.age != CLASSIC:
            return f"the system bit %S{offset}"
        if kind in _REGISTER_VALUES and self.settings.age == REGISTERS:
            return f"the variable type {kind} of a register"
        if kind == _SYSTEM_WORD:
            return f"the system word %SW{offset}"
        return None

    def supporting(self, file: str) -> str:
        """The name of a block of ours, which is added to the file."""
        if file not in self.blocks:
            (self.blocks[file],) = stored(PACKAGE, file)
        return self.blocks[file].name

    def system(self, span: Span) -> str:
        """The block of the system bits."""
        key = ("system",)
        if key not in self.found:
            self.found[key] = Declared(self.names.fresh("SYS"), self.supporting("system"), span)
        return self._use(key)

    def instance(self, letters: str, number: int, span: Span) -> str:
        """The block of a timer (T), monostable (M), counter (C) or IEC timer (TM)."""
        self.table(letters, number, span)
        symbol, note, at = self._symbol(f"%{letters}{number}", f"{letters}{number}", span)
        key = (letters, number)
        if key not in self.found:
            type_ = self.supporting(BLOCKS[letters])
            self.found[key] = Declared(self.names.name(symbol, at, str(key)), type_, at, None, note)
        return self._use(key)

    def table(self, letters: str, number: int, span: Span) -> Preset:
        rows = getattr(self.settings, f"{BLOCKS[letters]}s" if letters != "TM" else "timers_iec")
        if number in rows:
            return rows[number]
        if self.settings.age != REGISTERS or number >= MAX_OFFSET:
            self.reading.malformed(span, f"%{letters}{number} has no row in the table of presets")
        return Preset(1_000, 0, 0, span)

    def preset(self, letters: str, number: int, span: Span) -> str:
        """The preset in units of the base: a number, or a variable when something names it."""
        row = self.table(letters, number, span)
        if (letters, number) not in self.presets:
            return str(row.preset)
        key = (letters, number, "preset")
        if key not in self.found:
            name = self.names.fresh(f"{letters}{number}_preset")
            self.found[key] = Declared(name, "DINT", span, str(row.preset))
        return self._use(key)

    def count(self, number: int, span: Span) -> str:
        key = ("C", number, "value")
        if key not in self.found:
            self.found[key] = Declared(self.names.fresh(f"C{number}_value"), "DINT", span)
        return self._use(key)

    def subroutine(self, instance: str, type_: str, span: Span) -> str:
        key = ("subroutine", type_)
        if key not in self.found:
            self.found[key] = Declared(self.names.fresh(instance), type_, span)
        return self._use(key)

    def added(self, wanted: str, type_: str, span: Span, why: str, initial: str | None = None) -> str:
        """A variable that the file has no name for."""
        name = self.names.fresh(wanted)
        self.found["added", name] = Declared(name, type_, span, initial, why)
        self.reading.remark("added", name, why, span)
        return self._use(("added", name))

    def _use(self, key: tuple) -> str:
        declared = self.found[key]
        self.used[declared.name] = declared
        return declared.name

    def _plain(self, kind: int, offset: int, span: Span) -> Declared:
        key = (kind, offset)
        if key not in self.found:
            letters, type_ = _PLAIN[kind]
            default = f"{letters}{offset}_time" if kind == STEP_TIME else f"{letters}{offset}"
            symbol, note, at = self._symbol(f"%{letters}{offset}" if kind != STEP_TIME else "", default, span)
            name = self.names.name(symbol, at, str(key))
            self.found[key] = Declared(name, type_, at, None, note, kind, offset)
            self.reach[kind] = max(self.reach.get(kind, 0), offset + 1)
        self._use(key)
        return self.found[key]

    def _symbol(self, variable: str, default: str, span: Span) -> tuple[str, str | None, Span]:
        symbol, comment, at = self.settings.symbols.get(variable, (default, "", span))
        self.symbols.add(variable)
        return symbol, comment or None, at

    def _element(self, kind: int, offset: int, span: Span, index: str | None) -> Place:
        if kind not in (BIT, WORD):
            self.reading.unsupported(span, f"an index on variables of type {kind}", "index %B or %W")
            return Place("0", "DINT", False)
        letters, type_ = _PLAIN[kind]
        size = min(max(self.settings.sizes.get(_SIZES[kind], 0), offset + 1), MAX_OFFSET)
        declared = self.found.setdefault(
            (letters,), Declared("", "", span, None, "all of them, since an index chooses one"))
        declared.name = declared.name or self.names.fresh(letters)
        self.reach[kind] = max(self.reach.get(kind, 0), size)
        declared.type = f"ARRAY [0..{self.reach[kind] - 1}] OF {type_}"
        symbol = self.settings.symbols.get(f"%{letters}{offset}")
        if symbol is not None and index is None:
            self.symbols.add(f"%{letters}{offset}")
            self.reading.remark("renamed", symbol[0], f"{declared.name}[{offset}]", symbol[2])
        where = str(offset) if index is None else f"{offset} + {index}" if offset else index
        return Place(f"{self._use((letters,))}[{where}]", type_)

    # ---- declarations

    def section(self, kind: str, chosen, span: Span) -> tuple[ast.VarBlock, ...]:
        """VAR or VAR_GLOBAL with addresses and values, or VAR_EXTERNAL."""
        whole = kind != "VAR_EXTERNAL"
        declared = tuple(
            fragments.variable(v.name, v.type, v.span, initial=v.initial if whole else None,
                               location=self._address(v) if whole else None, note=v.note if whole else None)
            for v in chosen)
        return (ast.VarBlock(kind, (), declared, span),) if declared else ()

    def _address(self, variable: Declared) -> str | None:
        """Bits lie at the beginning of the process image, words and floats behind them, four bytes each."""
        area = _AREAS.get(variable.kind)
        if area is None:
            return None
        letters, rank = area
        if not rank:
            return f"{letters}X{variable.offset // 8}.{variable.offset % 8}"
        bits, words = (kind for kind, (place, n) in _AREAS.items() if place == letters and n < 2)
        most = max(self.reach.get(bits, 0), min(self.settings.sizes.get(_SIZES[bits], 0), MAX_OFFSET))
        base = (most + 31) // 32 + (self.reach.get(words, 0) if rank == 2 else 0)
        return f"{letters}D{base + variable.offset}"
