"""Inputs that the program itself writes: variables at %I, and VAR_INPUT of a PROGRAM.

Some editors let that pass, and the value stays until the input is read again. Here the first lose their
address, the second become VAR: they are ordinary variables, which keep what is written.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

from ldc.parser import ast
from ldc.parser import statements as st
from ldc.parser.foreign import Reading
from ldc.parser.plcopen import findings
from ldc.parser.plcopen.guarded import nodes
from ldc.records import replace

_Holder = ast.Configuration | ast.Resource


def without_addresses(
    pous: tuple[ast.Pou, ...], loose: tuple[ast.VarBlock, ...], configurations: tuple[ast.Configuration, ...],
    reading: Reading,
) -> tuple[tuple[ast.Pou, ...], tuple[ast.VarBlock, ...], tuple[ast.Configuration, ...]]:
    """The parts of a file; each variable that lost its address is told. One that shares its address with
    another variable keeps it: the two would no longer be the same."""
    shared = [*loose, *(block for c in configurations for h in (c, *c.resources) for block in h.var_blocks)]
    blocks = [*shared, *(block for pou in pous for block in pou.var_blocks)]
    inputs = any(block.kind == "VAR_INPUT" for pou in pous if pou.kind == "PROGRAM"
                 for block in pou.var_blocks)
    at = Counter(v.location for block in blocks for v in block.variables if v.location)
    if not inputs and not any(place.startswith("%I") for place in at):
        return pous, loose, configurations
    anywhere: set[str] = set()

    def changed(found: Iterable[ast.VarBlock], written: set[str]) -> tuple[ast.VarBlock, ...]:
        return tuple(replace(block, variables=tuple(one(v, written) for v in block.variables))
                     if any(v.location for v in block.variables) else block for block in found)

    def one(variable: ast.VarDecl, written: set[str]) -> ast.VarDecl:
        place = variable.location or ""
        if not place.startswith("%I") or at[place] > 1 or variable.name.upper() not in written:
            return variable
        findings.written_input(reading.diagnostics, variable.span, variable.name, place)
        reading.remark("left out", f"the address {place} of {variable.name}", "the program writes it",
                       variable.span)
        return replace(variable, location=None)

    made = []
    for pou in pous:
        names = set(_written(pou.body))
        own = {v.name.upper() for block in pou.var_blocks for v in block.variables
               if block.kind != "VAR_EXTERNAL"}
        anywhere |= names - own
        blocks = changed(pou.var_blocks, names)
        if pou.kind == "PROGRAM":
            blocks = tuple(part for block in blocks for part in _parted(block, names))
        made.append(replace(pou, var_blocks=blocks))

    def within(holder: _Holder) -> _Holder:
        found = replace(holder, var_blocks=changed(holder.var_blocks, anywhere))
        if isinstance(found, ast.Configuration):
            found = replace(found, resources=tuple(map(within, found.resources)))
        return found

    return tuple(made), changed(loose, anywhere), tuple(map(within, configurations))


def _parted(block: ast.VarBlock, written: set[str]) -> Iterator[ast.VarBlock]:
    """A section; of inputs, those that are written as a section of its own."""
    own = tuple(v for v in block.variables if v.name.upper() in written)
    if block.kind != "VAR_INPUT" or not own:
        yield block
        return
    others = tuple(v for v in block.variables if v not in own)
    if others:
        yield replace(block, variables=others)
    yield replace(block, kind="VAR", variables=own)


def _written(body: object) -> Iterator[str]:
    """The variables that a body writes, in capitals."""
    writers = (ast.Coil, ast.Pin, ast.Argument, st.Assign, st.ForHead)
    for node in _elements(body) if isinstance(body, ast.LadderBody) else nodes(body, writers):
        match node:
            case ast.Coil() | st.Assign():
                target = node.target
            case st.ForHead():
                target = node.variable
            case _ if node.output:
                target = node.value
            case _:
                continue
        while isinstance(target, ast.Member | ast.Index):
            target = target.base
        if isinstance(target, ast.Name):
            yield target.name.upper()


def _elements(body: ast.LadderBody) -> Iterator[ast.Coil | ast.Pin]:
    """The coils and pins of rungs: a short way through what is most of a file."""
    work: list = [path for rung in body.rungs for path in rung.paths]
    while work:
        for item in work.pop().items:
            kind = type(item)
            if kind is ast.Coil:
                yield item
            elif kind is ast.Block:
                yield from item.pins
                work += [path for pin in item.pins if isinstance(pin.value, ast.Branches)
                         for path in pin.value.paths]
            elif kind is ast.Branches:
                work += item.paths
