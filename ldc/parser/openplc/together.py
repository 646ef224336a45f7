"""What concerns all files of an OpenPLC project: addresses that overlap here, inputs that are written.

Its runtime keeps bits, bytes and words apart, as that of Beremiz does, so both are mended as in PLCopen XML
(``plcopen.addresses``, ``plcopen.inputs``); here variables lie in several files.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.foreign import Reading
from ldc.parser.openplc.known import FORMAT
from ldc.parser.plcopen import addresses, inputs
from ldc.records import replace


def settled(files: tuple[ast.File, ...], diagnostics: Diagnostics) -> tuple[ast.File, ...]:
    """The files of one project with addresses that mean here what they mean there (LD0149, LD0155)."""
    if not any(v.location for file in files for block in _sections(file) for v in block.variables):
        return files
    reading = Reading(files[0].source, FORMAT, diagnostics)
    pous, shared, _ = inputs.without_addresses(
        tuple(pou for file in files for pou in file.pous),
        tuple(block for file in files for block in file.globals), (), reading)
    blocks = (*shared, *(block for pou in pous for block in pou.var_blocks))
    places = {v.location for block in blocks for v in block.variables if v.location}
    placed = addresses.changed(addresses.moves(places, [file.source.text for file in files]), reading)
    own_pous, own_blocks = iter(pous), iter(shared)
    made = []
    for file in files:
        drawn = tuple(replace(pou, var_blocks=placed(pou.var_blocks))
                      for pou in islice(own_pous, len(file.pous)))
        made.append((file, drawn, placed(tuple(islice(own_blocks, len(file.globals))))))
    return tuple(
        replace(file, pous=drawn, globals=declared,
                remarks=(*file.remarks, *(r for r in reading.remarks if r.span.source is file.source)))
        for file, drawn, declared in made)


def _sections(file: ast.File) -> Iterator[ast.VarBlock]:
    yield from file.globals
    for pou in file.pous:
        yield from pou.var_blocks
