"""Data types of a Logix controller: atomic ones, strings, arrays, structures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from ldc.parser import ast
from ldc.parser.foreign import Names
from ldc.parser.plcopen.document import Node
from ldc.records import record
from ldc.source import Span

MAX_ELEMENTS, MAX_DEPTH = 1_000_000, 30


@record
class Atom:
    """``name``: BOOL SINT INT DINT LINT USINT UINT UDINT ULINT REAL LREAL TIME, as in IEC 61131-3."""

    name: str


@record
class Text:
    """A string of up to ``length`` bytes."""

    length: int


@record
class Array:
    """Indexes of every dimension begin at 0. ``element`` None: a type that the file does not tell."""

    sizes: tuple[int, ...]
    element: Type | None


@record
class Member:
    """``data`` holds the value that it has at the start; ``alias``: another name for this place in
    the same structure."""

    name: str
    type: Type | None
    span: Span
    note: str | None = None
    data: Node | None = None
    alias: str = ""


@dataclass(slots=True, eq=False)
class Structure:
    """``name``: what it is called in our text; ``foreign``: in the file. ``members`` by name in capitals;
    ``starts``: values at the start by way into the structure, for every variable of the type. ``size``:
    how many scalars it holds, ``depth``: how deep structures nest in it (both set by ``measure``)."""

    name: str
    foreign: str
    span: Span
    members: dict[str, Member] = field(default_factory=dict)
    starts: dict[tuple, object] = field(default_factory=dict)
    size: int = 0
    depth: int = 0


Type = Atom | Text | Array | Structure

BOOL, SINT, INT, DINT, LINT = map(Atom, ("BOOL", "SINT", "INT", "DINT", "LINT"))
REAL, LREAL, TIME = map(Atom, ("REAL", "LREAL", "TIME"))
ATOMS = {name: Atom(name) for name in
         "BOOL SINT INT DINT LINT USINT UINT UDINT ULINT REAL LREAL".split()} | {"BIT": BOOL}
WIDTHS = {"SINT": 8, "INT": 16, "DINT": 32, "LINT": 64, "USINT": 8, "UINT": 16, "UDINT": 32, "ULINT": 64}
STRING = Text(82)

_PREDEFINED = {
    "TIMER": {"DINT": "PRE ACC", "BOOL": "EN TT DN", "TIME": "since"},
    "COUNTER": {"DINT": "PRE ACC", "BOOL": "CU CD DN OV UN"},
    "FBD_TIMER": {"BOOL": "EnableIn TimerEnable Reset EnableOut EN TT DN InstructFault PresetInv",
                  "DINT": "PRE ACC Status", "TIME": "since"},
    "FBD_COUNTER": {"BOOL": "EnableIn CUEnable CDEnable Reset EnableOut CU CD DN OV UN",
                    "DINT": "PRE ACC"},
    "FBD_ONESHOT": {"BOOL": "EnableIn InputBit EnableOut OutputBit storage"},
    "CONTROL": {"DINT": "LEN POS", "BOOL": "EN EU DN EM ER UL IN FD"},
    "MESSAGE": {"BOOL": "EW ER DN ST EN TO", "DINT": "ERR EXERR REQ_LEN DN_LEN"},
    "PID": {
        "BOOL": "EN CT CL PVT DOE SWM CA MO PE NDF NOBC NOZC INI SPOR OLL OLH EWD DVNA DVPA PVLA PVHA begun",
        "DINT": "CTL",
        "REAL": "SP KP KI KD BIAS MAXS MINS DB SO MAXO MINO UPD PV ERR OUT PVH PVL DVP DVN PVDB DVDB MAXI "
                "MINI TIE MAXCV MINCV MINTIE MAXTIE before before2 sum",
    },
}
"""Members by type; those in small letters are ours and hold what the controller hides."""


def is_integer(type_: Type | None) -> bool:
    return isinstance(type_, Atom) and type_.name in WIDTHS


def is_real(type_: Type | None) -> bool:
    return type_ in (REAL, LREAL)


def is_structure(type_: Type | None, name: str) -> bool:
    """Whether it is the predefined structure of that name."""
    return isinstance(type_, Structure) and type_.foreign == name


def written(type_: Type | str, span: Span) -> ast.TypeExpr:
    """A type as it stands in a declaration; ``str``: a name that nobody declared."""
    match type_:
        case Atom(name):
            return ast.NamedType(name, None, span)
        case Text(length):
            return ast.NamedType("STRING", _number(length, span), span)
        case Array(sizes, element):
            bounds = tuple((_number(0, span), _number(size - 1, span)) for size in sizes)
            return ast.ArrayType(bounds, written(element or "UNKNOWN", span), span)
        case Structure():
            return ast.NamedType(type_.name, None, span)
    return ast.NamedType(type_, None, span)


def text(type_: Type) -> str:
    """A type as text of the ladder language."""
    match type_:
        case Text(length):
            return f"STRING[{length}]"
        case Array(sizes, element):
            return f"ARRAY [{', '.join(f'0..{size - 1}' for size in sizes)}] OF {text(element)}"
    return type_.name


def _number(value: int, span: Span) -> ast.Literal:
    return ast.Literal(value, None, str(value), span)


class Types:
    """The types of one file by name. ``used``: structures of variables, in the order of their use."""

    def __init__(self, names: Names) -> None:
        self.names = names
        self.known: dict[str, Structure | Text] = {}
        self.used: list[Structure] = []

    def named(self, name: str, span: Span) -> Type | None:
        """The type of that name, None when there is none."""
        key = name.upper()
        if key in ATOMS:
            return ATOMS[key]
        found = self.known.get(key)
        if found is None and key == "STRING":
            return STRING
        if found is None and key in _PREDEFINED:
            found = self.known[key] = self._predefined(key, span)
        if isinstance(found, Structure) and found not in self.used:
            self.used.append(found)
        return found

    def dimensioned(self, type_: Type | None, sizes: tuple[int, ...]) -> Type | None:
        return Array(sizes, type_) if sizes and type_ is not None else type_

    def _predefined(self, key: str, span: Span) -> Structure:
        members = {name.upper(): Member(name, Atom(type_), span)
                   for type_, listed in _PREDEFINED[key].items() for name in listed.split()}
        return Structure(self.names.name(key, span, f"type {key}"), key, span, members)


def is_predefined(name: str) -> bool:
    return name.upper() in _PREDEFINED or name.upper() == "STRING"


def sizes(text_: str) -> tuple[int, ...] | None:
    """``10`` and ``2 3`` and ``2,3`` as numbers; () for none and for ``0``; None when it is no such list."""
    parts = text_.replace(",", " ").split()
    if not all(part.isdecimal() and len(part) < 11 for part in parts):
        return None
    found = tuple(int(part) for part in parts)
    return found if all(found) else () if not any(found) else None


def total(sizes_: tuple[int, ...]) -> int:
    """How many elements an array has."""
    found = 1
    for size in sizes_:
        found *= size
    return found


def inner(type_: Type | None) -> Structure | None:
    """The structure that a type is, or is an array of."""
    type_ = type_.element if isinstance(type_, Array) else type_
    return type_ if isinstance(type_, Structure) else None


def measure(structures: Iterable[Structure]) -> Iterator[tuple[Structure, Member]]:
    """Sets the size and depth of all structures. A member by which one would hold itself is taken out
    and given."""
    done: set[int] = set()
    for first in structures:
        work, open_ = [(first, False)], set()
        while work:
            structure, counted = work.pop()
            if counted:
                open_.discard(id(structure))
                done.add(id(structure))
                _count(structure)
            elif id(structure) not in done and id(structure) not in open_:
                open_.add(id(structure))
                work.append((structure, True))
                for key, member in list(structure.members.items()):
                    held = inner(member.type)
                    if held is not None and id(held) in open_:
                        del structure.members[key]
                        yield structure, member
                    elif held is not None:
                        work.append((held, False))


def _count(structure: Structure) -> None:
    size, depth = 0, 0
    for member in structure.members.values():
        held = inner(member.type)
        count = total(member.type.sizes) if isinstance(member.type, Array) else 1
        size += count * (held.size if held is not None else 1)
        depth = max(depth, held.depth if held is not None else 0)
    structure.size, structure.depth = size, depth + 1


def is_large(type_: Type | None) -> bool:
    """Whether a variable of the type holds or nests more than the model takes."""
    held = inner(type_)
    count = total(type_.sizes) if isinstance(type_, Array) else 1
    return held is not None and (count * held.size > MAX_ELEMENTS or held.depth > MAX_DEPTH)


def declaration(structure: Structure) -> ast.TypeDecl:
    """The structure as a declaration of a type."""
    span = structure.span
    fields = tuple(ast.VarDecl(m.name, None, written(m.type or "UNKNOWN", m.span), None, m.span, m.span,
                               m.note)
                   for m in structure.members.values() if not m.alias)
    return ast.TypeDecl(structure.name, ast.StructType(fields, span), None, span)
