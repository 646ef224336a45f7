"""The image: a compiled project as canonical bytes with a digest (DESIGN section 4).

msgpack of two parts. ``core`` is what runs: types, globals, units with their code, tasks, safe values,
symbols with their places and the layout hash; its SHA-256 is the digest. ``notes`` is what people want to
know about it: the project's name, sources, titles, verdicts of the self-check, and which element each
instruction comes from.
"""

from __future__ import annotations

import gc
import hashlib
from collections.abc import Iterator
from contextlib import contextmanager

import msgspec

from ldc.expr import BitStep, Const, FieldStep, IndexStep, Load, Place, Step
from ldc.il.layout import Layout, Symbol, lay_out
from ldc.il.program import (
    NUMBER, OPCODES, External, Instr, Operand, Pace, Program, Resource, Run, RungCode, Task, Unit)
from ldc.records import record
from ldc.source import SourceFile, Span
from ldc.symbols import Location, Variable
from ldc.types import ELEMENTARY, Array, Elementary, Enum, Field, Instance, String, Struct, Subrange, Type

MAGIC = b"LDCI"
FORMAT = 2


class BadImage(ValueError):
    """The bytes are no image of this format."""


@record
class Image:
    """``program`` with ``layout``; ``digest``: 64 hex digits of what runs."""

    program: Program
    layout: Layout
    digest: str
    data: bytes


def build(program: Program, previous: Layout | None = None) -> Image:
    """The image of a program; the same program gives the same bytes."""
    layout = lay_out(program, previous)
    writer = Writer()
    core = msgspec.msgpack.encode(writer.core(program, layout))
    notes = msgspec.msgpack.encode(writer.notes(program))
    data = MAGIC + msgspec.msgpack.encode([FORMAT, core, notes])
    return Image(program, layout, hashlib.sha256(core).hexdigest(), data)


def load(data: bytes) -> Image:
    """Reads what ``build`` wrote. Raises BadImage when the bytes are something else."""
    with _parts(data) as (core, notes):
        reader = Reader(_opened(core, 3, 6, 9), _opened(notes, 0, 3))
        return Image(reader.program(), reader.layout(), hashlib.sha256(core).hexdigest(), data)


def layout_of(data: bytes) -> Layout:
    """Where the symbols of an image lie, without reading its code. Raises BadImage."""
    with _parts(data) as (core, _):
        return Reader(_opened(core, 3, 6, 9), [[], [], ""]).layout()


def _values(thing: Pace | External) -> list[object]:
    """The fields of a record in their order."""
    return [getattr(thing, name) for name in thing.__match_args__]


def _opened(data: bytes | msgspec.Raw, *large: int) -> list:
    """The items of a list; those of the given numbers, which are lists themselves, are not read yet."""
    items = msgspec.msgpack.decode(data, type=list[msgspec.Raw])
    return [item if number in large else msgspec.msgpack.decode(item) for number, item in enumerate(items)]


def _each(rows: list | msgspec.Raw, *large: int) -> Iterator[list]:
    """The rows of a list, read one by one when it was not read: other threads may run in between, those that
    scan. ``large``: what of a row is not read yet."""
    if not isinstance(rows, msgspec.Raw):
        yield from rows
        return
    for row in msgspec.msgpack.decode(rows, type=list[msgspec.Raw]):
        yield _opened(row, *large) if large else msgspec.msgpack.decode(row)


@contextmanager
def _parts(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """``core`` and ``notes``; what goes wrong with them inside becomes BadImage. The collector rests: what is
    read is acyclic, and walking it again and again takes longer than reading it."""
    if data[:4] != MAGIC:
        raise BadImage("this is no ldc image: it does not begin with LDCI")
    collects = gc.isenabled()
    gc.disable()
    try:
        version, core, notes = msgspec.msgpack.decode(data[4:])
        if version != FORMAT:
            raise BadImage(f"this image has format {version}; this ldc reads format {FORMAT}")
        yield core, notes
    except (msgspec.DecodeError, TypeError, ValueError, IndexError, KeyError, AttributeError) as error:
        raise error if isinstance(error, BadImage) else BadImage(f"the image is damaged: {error}") from None
    finally:
        if collects:
            gc.enable()


class Writer:
    """Makes rows of what a program consists of. ``types``: rows that are there already, ``numbers`` of theirs."""

    def __init__(self, types: list[list] | None = None, numbers: dict[Type, int] | None = None) -> None:
        self.types: list[list] = [] if types is None else types
        self.numbers: dict[Type, int] = {} if numbers is None else numbers
        self._seen: dict[int, tuple[Type, int]] = {}  # by identity: nearly all types are one of a few objects

    def core(self, program: Program, layout: Layout) -> list:
        units = [self.unit(u) for u in program.units]
        globals_ = [self.variable(v) for v in program.globals]
        types = [self.type(t) for t in program.types]
        resources = [
            [r.name, r.processor,
             [[t.name, t.interval, t.priority, None if t.single is None else self.place(t.single), t.watchdog]
              for t in r.tasks],
             [[run.name, run.pou, run.task] for run in r.runs]] for r in program.resources]
        symbols = [[s.path, self.type(s.type), s.area, s.offset, s.size, s.type_hash, s.retain, s.bit]
                   for s in layout.symbols]
        return [self.types, types, globals_, units, resources,
                [list(item) for item in program.safe], symbols, layout.size, layout.digest,
                *([] if not program.algorithms else [[self.unit(u) for u in program.algorithms]])]

    def type(self, type_: Type) -> int:
        seen = self._seen.get(id(type_))
        if seen is None:
            seen = self._seen[id(type_)] = type_, self._number(type_)
        return seen[1]

    def _number(self, type_: Type) -> int:
        number = self.numbers.get(type_)
        if number is None:
            row = self._type(type_)
            number = self.numbers[type_] = len(self.types)
            self.types.append(row)
        return number

    def _type(self, type_: Type) -> list:
        match type_:
            case Elementary(name):
                return ["E", name]
            case String(name, length):
                return ["S", name, length]
            case Array(bounds, element):
                return ["A", bounds, self.type(element)]
            case Struct(name, fields):
                return ["T", name, [[f.name, self.type(f.type), f.initial] for f in fields]]
            case Enum(name, values, initial):
                return ["N", name, values, initial]
            case Subrange(name, base, low, high):
                return ["R", name, self.type(base), low, high]
            case Instance(pou):
                return ["I", pou]

    def variable(self, v: Variable) -> list:
        return [v.name, self.type(v.type), v.kind, v.initial, v.retain, v.constant,
                None if v.location is None else str(v.location)]

    def unit(self, u: Unit) -> list:
        return [u.kind, u.name, None if u.result is None else self.type(u.result), u.standard,
                [self.variable(v) for v in u.variables],
                [[r.key, r.label, r.name, [self.instr(i) for i in r.code]] for r in u.rungs],
                *self.more(u)]

    def more(self, u: Unit) -> list:
        """What only units of components have."""
        if u.pace is not None:
            return [None, _values(u.pace)]
        return [] if u.external is None else [_values(u.external)]

    def instr(self, i: Instr) -> list:
        row: list = [NUMBER[i.op], self.type(i.type), None if i.operand is None else self.operand(i.operand)]
        if i.name or i.args or i.outputs:
            row += [i.name, [self.operand(a) for a in i.args], [[n, self.place(p)] for n, p in i.outputs]]
        return row

    def operand(self, operand: Operand) -> list:
        if isinstance(operand, Const):
            return [self.type(operand.type), operand.value]
        return self.place(operand)

    def place(self, p: Place) -> list:
        row: list = [self.type(p.type), p.root, p.is_global]
        if p.steps:
            row.append([self.step(s) for s in p.steps])
        return row

    def step(self, step: Step) -> object:
        match step:
            case FieldStep(name):
                return name
            case BitStep(bit, sign):
                return ~bit if sign else bit
            case IndexStep(indexes, bounds):
                return [[self.operand(i.place if isinstance(i, Load) else i) for i in indexes], bounds]

    def notes(self, program: Program) -> list:
        files: dict[SourceFile, int] = {}

        def span(s: Span | None) -> list | None:
            return None if s is None else [files.setdefault(s.source, len(files)), s.start, s.end]

        units, algorithms = (
            [[u.title, [[r.title, r.proof, span(r.span), [[i.element, span(i.span)] for i in r.code]]
                        for r in u.rungs]] for u in group] for group in (program.units, program.algorithms))
        return [units, [[f.name, f.text] for f in files], program.name, *([algorithms] if algorithms else [])]


class Reader:
    """Makes what rows say. ``core[0]``: the types; ``notes[1]``: path and text of files."""

    def __init__(self, core: list, notes: list) -> None:
        self.core, self.notes = core, notes
        self.files = [SourceFile(path, text) for path, text in notes[1]]
        self.types: list[Type] = []
        self.places: dict[tuple, Place] = {}
        for row in core[0]:
            self.types.append(self._type(row))

    def program(self) -> Program:
        _, types, globals_, units, resources, safe, *_ = self.core
        return Program(
            self.units(units, self.notes[0]),
            tuple(self.types[t] for t in types), tuple(self.variable(v) for v in globals_),
            tuple(Resource(
                rname, processor,
                tuple(Task(t[0], t[1], t[2], None if t[3] is None else self.place(t[3]), t[4]) for t in tasks),
                tuple(Run(*run) for run in runs)) for rname, processor, tasks, runs in resources),
            tuple((path, value) for path, value in safe), self.notes[2],
            tuple(unit for rows, notes in zip(self.core[9:], self.notes[3:], strict=True)
                  for unit in self.units(rows, notes)))

    def units(self, rows: list | msgspec.Raw, notes: list | msgspec.Raw) -> tuple[Unit, ...]:
        return tuple(self.unit(u, n) for u, n in zip(_each(rows, 4, 5), _each(notes, 1), strict=True))

    def layout(self) -> Layout:
        symbols, size, layout_hash = self.core[6:9]
        rows = tuple(Symbol(s[0], self.types[s[1]], *s[2:]) for s in _each(symbols))
        layout = Layout(rows, size)
        if layout.digest != layout_hash:
            raise BadImage("the image is damaged: its symbols do not match their hash")
        return layout

    def _type(self, row: list) -> Type:
        match row:
            case ["E", name]:
                return ELEMENTARY[name]
            case ["S", name, length]:
                return String(name, length)
            case ["A", bounds, element]:
                return Array(tuple(tuple(b) for b in bounds), self.types[element])
            case ["T", name, fields]:
                return Struct(name, tuple(Field(n, self.types[t], _tuples(v)) for n, t, v in fields))
            case ["N", name, values, initial]:
                return Enum(name, tuple(tuple(v) for v in values), initial)
            case ["R", name, base, low, high]:
                return Subrange(name, self.types[base], low, high)
            case ["I", pou]:
                return Instance(pou)
        raise BadImage(f"unknown type {row[:1]}")

    def variable(self, row: list) -> Variable:
        name, type_, kind, initial, retain, constant, location = row
        return Variable(name, self.types[type_], kind, _tuples(initial), retain, constant,
                        None if location is None else Location.parse(location))

    def unit(self, row: list, notes: list) -> Unit:
        kind, name, result, standard, variables, rungs, *more = row
        external, pace = *more, *(None, None)[len(more):]
        title, rung_notes = notes
        return Unit(kind, name, tuple(self.variable(v) for v in _each(variables)),
                    tuple(self.rung(r, n) for r, n in zip(_each(rungs), _each(rung_notes), strict=True)),
                    None if result is None else self.types[result], title, standard,
                    External(*external) if external else None,
                    Pace(*pace[:2], tuple(tuple(r) for r in pace[2])) if pace else None)

    def rung(self, row: list, notes: list) -> RungCode:
        key, label, name, code = row
        title, proof, span, places = notes
        return RungCode(key, tuple([self.instr(i, element, self.span(at))
                                    for i, (element, at) in zip(code, places, strict=True)]),
                        label, title, name, proof, self.span(span))

    def span(self, row: list | None) -> Span | None:
        return None if row is None else Span(self.files[row[0]], row[1], row[2])

    def instr(self, row: list, element: int, span: Span | None) -> Instr:
        op, type_, operand, *more = row
        operand = None if operand is None else self.operand(operand)
        if not more:
            return Instr(OPCODES[op], operand, self.types[type_], element=element, span=span)
        name, args, outputs = more
        return Instr(OPCODES[op], operand, self.types[type_], name, tuple(self.operand(a) for a in args),
                     tuple((n, self.place(p)) for n, p in outputs), element, span)

    def operand(self, row: list) -> Operand:
        return Const(row[1], self.types[row[0]]) if len(row) == 2 else self.place(row)

    def place(self, row: list) -> Place:
        if len(row) > 3:
            return Place(row[1], self.types[row[0]], tuple(self.step(s) for s in row[3]), row[2])
        # Most instructions name one of a few variables: one object for each is enough.
        key = tuple(row)
        found = self.places.get(key)
        if found is None:
            type_, root, is_global = row
            found = self.places[key] = Place(root, self.types[type_], (), is_global)
        return found

    def step(self, row: object) -> Step:
        if isinstance(row, str):
            return FieldStep(row)
        if isinstance(row, int):
            return BitStep(row) if row >= 0 else BitStep(~row, True)
        operands = [self.operand(i) for i in row[0]]
        return IndexStep(tuple(Load(o) if isinstance(o, Place) else o for o in operands),
                         tuple(tuple(b) for b in row[1]))


def _tuples(value: object) -> object:
    return tuple(_tuples(v) for v in value) if isinstance(value, list) else value
