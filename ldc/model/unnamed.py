"""Variables that are declared by their address alone, ``AT %MW6 : INT;`` (IEC 61131-3, 2nd edition, 2.4.3.1,
tables 17 and 18; docs/ladder.md, declarations).

Such an address stands for a variable of the declared type wherever the declaration is seen: in the POU, or in
all of the project when it is global. The variable gets a name of its own, ``MW6``, and the bodies have that name
where they have the address. What a POU declares hides what is global at the same address.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping

from ldc.free_names import free_name
from ldc.model.rewrite import mapped
from ldc.parser import ast
from ldc.patterns import Pattern
from ldc.records import replace
from ldc.symbols import Location

_WORD = Pattern(r"(?<![\w%.])[^\W\d]\w*")
Names = Mapping[str, str]
"""The name of the variable at each address, by the address in its usual spelling."""


def with_names(project: ast.Project) -> ast.Project:
    """The project in which every variable has a name; itself when all have one."""
    blocks = [block for file in project.files for block in _blocks(file)]
    if not any(v.unnamed for block in blocks for v in block.variables):
        return project
    taken = {v.name.upper() for block in blocks for v in block.variables}
    for source in {file.source for file in project.files}:
        taken |= {word.upper() for word in _WORD.findall(source.text)}
    shared = _names((block for file in project.files for block in file.shared()), taken)
    return ast.Project(tuple(_file(file, shared, taken) for file in project.files))


def named(names: Names) -> Callable:
    """What ``mapped`` asks for: variables for the addresses that stand for some, also in Instruction List."""

    def change(_: object, node: object) -> object:
        if isinstance(node, ast.Direct):
            name = names.get(Location.usual(node.address))
            return node if name is None else ast.Name(name, node.span)
        if isinstance(node, ast.TextBody):
            return replace(node, names=tuple(names.items()))
        return node

    return change


def _blocks(file: ast.File) -> Iterator[ast.VarBlock]:
    yield from file.shared()
    for pou in file.pous:
        yield from pou.var_blocks


def _names(blocks: Iterable[ast.VarBlock], taken: set[str]) -> dict[str, str]:
    """Names for the variables of the sections that have none; an address that stands there twice has one name,
    so that it is told as declared twice."""
    found: dict[str, str] = {}
    for variable in (v for block in blocks for v in block.variables if v.unnamed):
        address = Location.usual(variable.location)
        found.setdefault(address, free_name(re.sub(r"\W", "_", address[1:]), taken))
    return found


def _file(file: ast.File, shared: Names, taken: set[str]) -> ast.File:
    change = named(shared)
    return replace(file, pous=tuple(_pou(pou, shared, taken) for pou in file.pous),
                   globals=_sections(file.globals, shared),
                   configurations=tuple(_configuration(c, shared, change) for c in file.configurations))


def _pou(pou: ast.Pou, shared: Names, taken: set[str]) -> ast.Pou:
    own = _names(pou.var_blocks, taken)
    names = {**shared, **own}
    if not names:
        return pou
    change = named(names)
    return replace(pou, var_blocks=_sections(pou.var_blocks, own), body=mapped(pou.body, change),
                   actions=mapped(pou.actions, change))


def _configuration(given: ast.Configuration, names: Names, change: Callable) -> ast.Configuration:
    resources = tuple(replace(mapped(resource, change), var_blocks=_sections(resource.var_blocks, names))
                      for resource in given.resources)
    return replace(given, var_blocks=_sections(given.var_blocks, names), resources=resources)


def _sections(blocks: tuple[ast.VarBlock, ...], names: Names) -> tuple[ast.VarBlock, ...]:
    return tuple(replace(block, variables=tuple(
        replace(v, name=names[Location.usual(v.location)]) if v.unnamed else v for v in block.variables))
        if any(v.unnamed for v in block.variables) else block for block in blocks)
