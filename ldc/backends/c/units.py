"""POUs as C: their parts in chunks, and the function that runs them in order."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ldc.backends.c.ctypes import by_address, is_string, width
from ldc.backends.c.frames import frame
from ldc.backends.c.parts import Cut, cut
from ldc.backends.c.places import Names, c_name
from ldc.backends.c.statements import Part, alone
from ldc.backends.c.values import Callee, Shared
from ldc.expr import Apply, Load
from ldc.il.block import Block
from ldc.il.c_types import c_type
from ldc.il.pieces import Passes
from ldc.il.program import Instr, Unit
from ldc.il.statements import Goto
from ldc.il.structure import Structured, structure
from ldc.records import record
from ldc.symbols import Variable
from ldc.types import Array


@record
class Function:
    """One part as text: ``head`` is its prototype without the semicolon."""

    head: str
    name: str
    declared: tuple[str, ...]
    entries: tuple[tuple[int, str], ...]
    lines: tuple[str, ...]


@record
class Chunk:
    """One C file: the parts of some rungs of one POU and what they need."""

    name: str
    title: str
    shared: Shared
    functions: tuple[Function, ...]


@record
class Driver:
    """The function that runs a POU: ``parts`` in order with their arguments; ``far``: number of a label that
    another part jumps to -> the part that it is in (their count: the end); ``enter`` and ``leave`` move the
    arguments of a FUNCTION; ``frame``: the bytes of its frame; ``paced``: each call executes one part."""

    head: str
    number: int
    parts: tuple[tuple[str, str, bool], ...]
    far: tuple[tuple[int, int], ...]
    frame: bytes
    enter: tuple[str, ...] = ()
    leave: tuple[str, ...] = ()
    paced: bool = False


@record
class UnitCode:
    """A POU (of a PROGRAM: one instance) as C. ``firsts``: the first rung of every part."""

    unit: Unit
    chunks: tuple[Chunk, ...]
    driver: Driver
    callee: Callee
    firsts: tuple[int, ...]


def translate(block: Block, unit: Unit, number: int, callees: Mapping[str, Callee],
              run: str | None = None, cost: Callable[[Instr], int] | None = None) -> UnitCode:
    """The C of a unit; ``run`` names the instance of a PROGRAM. ``number``: how its driver calls itself in
    the trace of a fault; ``callees``: all POUs that it may call, by name in capitals; ``cost``: what an
    instruction costs in ns, for code that is executed piece by piece."""
    code = _structured(block, unit, run)
    offsets, data = frame(block, code)
    names = Names(block, unit, run, code.temporaries, offsets)
    paced = run is not None and cost is not None
    passes = None if cost is None else Passes(unit, code.flat, cost)
    cuts = cut(code, paced)
    label = f"{'run' if run else 'pou'}_{c_name(run or unit.name).upper()}"
    parts = [part for chunk in cuts for part in chunk]
    far = _far(code, parts)
    parameters = ["uint8_t *m"] + ["uint8_t *s"] * (unit.kind == "FUNCTION_BLOCK")
    parameters += ["uint8_t *f"] * bool(data)
    chunks, called = [], []
    for chunk in cuts:
        shared, made = Shared(), []
        for part in chunk:
            work = Part(names, code, shared, part.first, callees=callees, passes=passes)
            function = _function(part, work, far, f"{label}_{part.name}", parameters)
            made.append(function)
            arguments = ", ".join(p[-1] for p in parameters)
            called.append((function.name, arguments, bool(function.entries)))
        title = f"{unit.kind} {unit.name}, rungs {_key(unit, chunk[0])} to {_last(unit, chunk[-1])}"
        chunks.append(Chunk(f"{label}_{chunk[0].name}", title, shared, tuple(made)))
    faults = any("return ldc_" in line for chunk in chunks for f in chunk.functions for line in f.lines)
    head, enter, leave = _signature(block, unit, label, offsets)
    if paced:
        head = f"int32_t {label}(uint8_t *m, ldc_pace *p)"
    ends = {n: next((i for i, p in enumerate(parts) if p.first <= rung < p.end), len(parts))
            for n, rung in far.values()}
    driver = Driver(head, number, tuple(called), tuple(ends.items()), data, enter, leave, paced)
    if len(called) == 1 and not (faults or data or far or run):
        callee = Callee(called[0][0], f"{chunks[0].functions[0].head};", False)
    else:
        callee = Callee(label, f"{head};", faults)
    return UnitCode(unit, tuple(chunks), driver, callee, tuple(p.first for p in parts))


def inline(block: Block, unit: Unit) -> Callee:
    """A block of the library as a function that every file that calls it has for itself."""
    code = _structured(block, unit, None)
    names = Names(block, unit, None, code.temporaries, frame(block, code)[0])
    part = Part(names, code, Shared(named=False), 0)
    part.add(code.statements)
    body = "\n".join("    " + line for line in (*part.declared.values(), *_without_lines(part.lines)))
    name = f"ldc_{c_name(unit.name)}"
    head = f"static inline void {name}(uint8_t *m, uint8_t *s)"
    return Callee(name, f"{head} {{\n    (void)m;\n{body}\n}}", False)


def _without_lines(lines: list[str]) -> list[str]:
    return [line for line in lines if not line.startswith("#line")]


def _structured(block: Block, unit: Unit, run: str | None) -> Structured:
    outer = Names(block, unit, run)

    def by_itself(expr: Apply | Load) -> bool:
        if isinstance(expr, Load) and isinstance(expr.place.type, Array):
            # Arrays of image bits have no address that a value could be given by.
            return outer.reach(expr.place).address.bit is not None
        return alone(expr)

    functions = {u.name.upper(): u for u in block.program.units if u.kind == "FUNCTION"}
    return structure(unit, functions, block.program.globals, by_itself)


def _far(code: Structured, parts: list[Cut]) -> dict[int, tuple[int, int]]:
    """Positions that a part jumps to in another one: their number (from 1) and rung."""
    places, end = code.flat.places, len(code.flat.code)
    part_of = {rung: n for n, part in enumerate(parts) for rung in range(part.first, part.end)}
    found: dict[int, tuple[int, int]] = {}
    for part_number, part in enumerate(parts):
        for statement in part.statements:
            if isinstance(statement, Goto) and statement.target < end:
                rung = places[statement.target][0]
                if part_of[rung] != part_number and statement.target not in found:
                    found[statement.target] = len(found) + 1, rung
    return found


def _function(cut_: Cut, part: Part, far: dict[int, tuple[int, int]], name: str,
              parameters: list[str]) -> Function:
    flat = part.code.flat
    inside = sorted(at for at in flat.labels if at < len(flat.code)
                    and cut_.first <= flat.places[at][0] < cut_.end)
    part.labels = {at: f"L{n}" for n, at in enumerate(inside, 1)}
    part.far = {at: n for at, (n, _) in far.items()} | {len(flat.code): "LDC_RETURN"}
    entries = tuple((far[at][0], part.labels[at]) for at in inside if at in far)
    part.add(cut_.statements)
    parameters = parameters + ["uint32_t entry"] * bool(entries)
    head = f"int32_t {name}({', '.join(parameters)})"
    return Function(head, name, tuple(part.declared.values()), entries, tuple(part.lines))


def _signature(block: Block, unit: Unit, label: str, offsets: Mapping[str, int]
               ) -> tuple[str, tuple[str, ...], tuple[str, ...]]:
    """The prototype of a driver, and how a FUNCTION takes its arguments and gives its results."""
    if unit.kind != "FUNCTION":
        more = ", uint8_t *s" if unit.kind == "FUNCTION_BLOCK" else ""
        return f"int32_t {label}(uint8_t *m{more})", (), ()
    parameters, enter, leave = ["uint8_t *m"], [], []
    for number, variable in enumerate(unit.arguments, 1):
        pointer = by_address(variable.type)
        parameters.append(f"const uint8_t *a{number}" if pointer else f"{c_type(variable.type)} a{number}")
        enter.append(_taken(block, variable, offsets, f"a{number}"))
    outputs = [v for v in unit.variables if v.kind in ("output", "in_out")]
    if unit.result is not None:
        outputs.insert(0, Variable(unit.name, unit.result))
    for number, variable in enumerate(outputs):
        kind = "uint8_t" if by_address(variable.type) else c_type(variable.type)
        parameters.append(f"{kind} *o{number}")
        leave.append(_given(block, variable, offsets, f"o{number}"))
    return f"int32_t {label}({', '.join(parameters)})", tuple(enter), tuple(leave)


def _taken(block: Block, variable: Variable, offsets: Mapping[str, int], name: str) -> str:
    at = offsets[variable.name.upper()]
    if is_string(variable.type):
        return f"ldc_put(f + {at}, {variable.type.length}, {name}, {width(variable.type)});"
    if by_address(variable.type):
        return f"__builtin_memcpy(f + {at}, {name}, {block.measure(variable.type)});"
    return f"LDC_AT({c_type(variable.type)}, f, {at}) = {name};"


def _given(block: Block, variable: Variable, offsets: Mapping[str, int], name: str) -> str:
    at = offsets[variable.name.upper()]
    if by_address(variable.type):
        return f"if ({name}) __builtin_memcpy({name}, f + {at}, {block.measure(variable.type)});"
    return f"if ({name}) *{name} = LDC_AT({c_type(variable.type)}, f, {at});"


def _key(unit: Unit, part: Cut) -> str:
    return unit.rungs[part.first].key


def _last(unit: Unit, part: Cut) -> str:
    return unit.rungs[part.end - 1].key
