"""The components that a project uses, as sources among its others."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Set

from ldc.components import find, interface, pace
from ldc.components.descriptor import Component
from ldc.diagnostics import Diagnostics
from ldc.il.program import Unit
from ldc.library import blocks
from ldc.parser import ast
from ldc.parser.plcopen import additional
from ldc.patterns import Pattern
from ldc.records import record, replace
from ldc.source import SourceFile
from ldc.types import ELEMENTARY

_WORD = Pattern(r"[A-Za-z_]\w*")


@record
class Native:
    """A component in C or C++ of a program, with its unit."""

    component: Component
    unit: Unit


def own_sources(known: find.Known) -> frozenset[str]:
    """Paths of the files that are bodies of components: no sources of the project beside that."""
    return frozenset((c.folder / name).as_posix() for c in known.components.values() for name in c.sources)


def used(
    files: tuple[ast.File, ...],
    known: find.Known,
    diagnostics: Diagnostics,
    wanted: Iterable[str] = (),
    slaves: Set[int] = frozenset(),
) -> tuple[dict[str, Component], tuple[ast.File, ...]]:
    """Components that declarations name or that are wanted, by name in capitals, and a file with the function
    block of each. ``slaves``: those that execute algorithms. Those of the project come first; installed
    packages are asked for what is still unknown. Blocks that editors bring along are added too, also instead
    of a component of the same name when the text names their pins."""
    declared = {name.upper() for file in files for name in _declared(file)}
    asked = False
    chosen: dict[str, Component] = {}
    made: list[ast.File] = [_nothing(source) for source in known.broken]
    brought: set[str] = set()  # blocks that editors bring along, which texts use without declaring them
    words: set[str] = set()
    todo = [*wanted, *(name for file in files for name in _named(file))]
    while todo:
        name = todo.pop()
        if name in chosen or name in brought:
            continue
        unknown = name not in known.components and name not in declared and name not in ELEMENTARY
        if unknown and not asked and blocks.signature(name) is None:
            asked = True
            installed = find.components(find.installed(diagnostics), diagnostics)
            made += [_nothing(source) for source in installed.broken]
            known = replace(known, components=installed.components | known.components)
        component = known.components.get(name)
        file = None if component is None else _file(component, slaves, diagnostics)
        if name not in declared and name in additional.NAMES:
            words = words or {word.upper() for one in files for word in _WORD.findall(one.source.text)}
            pou = additional.fitting(name, words, file.pous[0] if file is not None and file.pous else None)
            if pou is not None:
                brought.add(name)
                component, file = None, ast.File(pou.span.source, (pou,), (), (), (), ())
        if file is None:
            continue
        if component is not None:
            chosen[name] = component
        made.append(file)
        todo += _named(file)
    # What the project declares too is told as declared twice, and is no component then.
    return {name: component for name, component in chosen.items() if name not in declared}, tuple(made)


def _nothing(source: SourceFile) -> ast.File:
    """What a descriptor gives that could not be read."""
    return ast.File(source, (), (), (), (), (), incomplete=True)


def _file(component: Component, slaves: Set[int], diagnostics: Diagnostics) -> ast.File:
    sources = find.body_sources(component, diagnostics)
    on_slave = pace.slave_of(component, slaves) is not None
    pou = None if sources is None else interface.pou(component, sources, diagnostics, on_slave)
    return _nothing(component.source) if pou is None else ast.File(component.source, (pou,), (), (), (), ())


def _declared(file: ast.File) -> Iterator[str]:
    yield from (p.name for p in file.pous)
    yield from (t.name for t in file.types)


def _named(file: ast.File) -> Iterator[str]:
    """Names of types, in capitals, that variables are declared with."""
    sections = [*file.globals, *(s for p in file.pous for s in p.var_blocks)]
    for configuration in file.configurations:
        sections += [*configuration.var_blocks, *(s for r in configuration.resources for s in r.var_blocks)]
    for section in sections:
        for variable in section.variables:
            kind = variable.type
            while isinstance(kind, ast.ArrayType):
                kind = kind.element
            if isinstance(kind, ast.NamedType):
                yield kind.name.upper()
