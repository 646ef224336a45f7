"""A program as a BuildPlan: every C file with its digest, before any tool runs (DESIGN 10, item 6)."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ldc.backends.c import components
from ldc.backends.c.units import UnitCode, inline, translate
from ldc.backends.c.values import Callee
from ldc.backends.room import Room, digest
from ldc.il.block import Block
from ldc.il.external import Binding
from ldc.il.program import Instr
from ldc.records import record

HEADER = "ldc_runtime.h"
_RUNTIME, _TEXT = "ldc_runtime.c", "ldc_text.c"
_ROOM = Room("ldc.backends.c")


@record
class File:
    """A file to compile; ``digest``: SHA-256 over all that its object depends on but the compiler. Lines of
    the sources count only when the object holds them (``debug``)."""

    name: str
    text: str
    digest: str

    @property
    def is_generated(self) -> bool:
        """Whether it is of the program, not of the library."""
        return self.name not in (_RUNTIME, _TEXT)


@record
class BuildPlan:
    """``files`` are compiled, ``header`` is what they include. ``map``: for every driver by number the name
    of its POU and the first rung of each part, for the places of faults; ``bindings``: the components in C
    and C++, in the order of their numbers for ``ldc_bind``. ``digest`` covers all but these."""

    block: Block
    files: tuple[File, ...]
    header: str
    flags: tuple[str, ...]
    map: tuple[tuple[str, tuple[int, ...]], ...]
    bindings: tuple[Binding, ...]
    digest: str


def plan(block: Block, flags: tuple[str, ...], bindings: Iterable[Binding] = (),
         cost: Callable[[Instr], int] | None = None) -> BuildPlan:
    """The files of one resource of a program; ``bindings``: its components in C and C++, which were built;
    ``cost``: what an instruction costs in ns: PROGRAMs are then executed piece by piece (``ldc_step``)."""
    known = {b.unit.upper(): b for b in bindings}
    natives = [unit for unit in block.program.units if unit.external is not None]
    debug = "-g" in flags
    codes = _translated(block, cost)
    header = _ROOM.read(HEADER)
    made = [_file(f"{chunk.name}.c", _ROOM.render("chunk.c.j2", chunk=chunk), header, flags, debug)
            for code in codes for chunk in code.chunks]
    main = _ROOM.render(
        "main.c.j2", title=f"{block.program.name or 'program'}: how POUs run their parts", zero=b"\0",
        heads=[f.head for code in codes for chunk in code.chunks for f in chunk.functions]
        + [code.driver.head for code in codes], drivers=[code.driver for code in codes], size=block.size,
        runs=[code.callee.name for code in codes if code.unit.kind == "PROGRAM"],
        components=[components.bound(unit) for unit in natives], paced=cost is not None,
        frame=max((len(code.driver.frame) for code in codes if code.driver.paced), default=0))
    for unit in natives:
        wrapper = components.wrapper(block, unit, known[unit.name.upper()])
        text = _ROOM.render("component.c.j2", wrapper=wrapper)
        made.append(_file(f"{components.callee(unit).name}.c", text, header, flags, debug))
    made.append(_file("main.c", main, header, flags, debug))
    library = [_RUNTIME]
    if any("ldc_print_" in file.text or "ldc_read_" in file.text for file in made):
        library.append(_TEXT)
    made += [_file(name, _ROOM.read(name), header, flags, debug) for name in library]
    map_ = tuple((code.unit.name, code.firsts) for code in codes)
    whole = digest(*(f"{file.name} {file.digest}" for file in made))
    return BuildPlan(block, tuple(made), header, flags, map_,
                     tuple(known[unit.name.upper()] for unit in natives), whole)


def _translated(block: Block, cost: Callable[[Instr], int] | None) -> list[UnitCode]:
    callees: dict[str, Callee] = {}
    codes: list[UnitCode] = []
    for unit in block.program.units:
        if unit.standard:
            callees[unit.name.upper()] = inline(block, unit)
        elif unit.kind != "PROGRAM":
            code = translate(block, unit, len(codes), callees, cost=cost)
            callees[unit.name.upper()] = code.callee
            codes.append(code)
    for run in block.program.resources[block.resource].runs:
        codes.append(translate(block, block.units[run.pou.upper()], len(codes), callees, run.name, cost))
    return codes


def _file(name: str, text: str, header: str, flags: tuple[str, ...], debug: bool) -> File:
    counted = text if debug else "\n".join(line for line in text.split("\n") if not line.startswith("#line"))
    return File(name, text, digest(counted, header, *flags))
