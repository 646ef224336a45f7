"""What a compile is told, and what it hands over."""

from __future__ import annotations

import time
from collections.abc import Callable

from ldc.components import project as components
from ldc.components.descriptor import Component
from ldc.diagnostics import Diagnostics
from ldc.graph.order import Turn
from ldc.graph.rung import RungGraph
from ldc.graph.tree import SPTree
from ldc.il import image as il_image
from ldc.il import program as il
from ldc.il.layout import Layout
from ldc.il.verify import Verdict
from ldc.manifest import Sources
from ldc.model.project import Model
from ldc.parser import ast
from ldc.pipeline.memory import Memory
from ldc.records import field, record
from ldc.symbols import Variable


@record
class Options:
    """How to compile. ``every_component``: also those that no program uses. ``keep``: hold graph and tree of
    every rung (for the dumps; they are most of the memory). ``progress(done, total)`` is called after every
    rung. ``previous``: layout to keep. ``algorithms``: components with a pace become proxies, which slaves
    execute by themselves; else they are called. ``memory``: of rungs that were compiled before; not used with
    ``keep``."""

    max_paren_depth: int | None = None
    verify: bool = True
    keep: bool = True
    every_component: bool = False
    algorithms: bool = True
    previous: Layout | None = None
    progress: Callable[[int, int], None] | None = None
    memory: Memory | None = None


@record
class RungBuild:
    """Everything that was made of one rung; graph, turns and tree are None when not kept."""

    rung: ast.Rung
    code: il.RungCode
    verdict: Verdict | None = None
    graph: RungGraph | None = None
    turns: tuple[Turn, ...] = ()
    tree: SPTree | None = None


@record
class BodyCode:
    """What was made of a body: its code, and the variables that this needs beside the declared ones."""

    codes: tuple[il.RungCode, ...] = ()
    builds: tuple[RungBuild, ...] = ()
    temps: tuple[Variable, ...] = ()
    hidden: tuple[Variable, ...] = ()


@record
class Compiled:
    """``program`` and ``image`` are None when there were errors. ``project``: what was written, with a
    name for each variable (``ldc.model.unnamed``); ``meant``: with function blocks for programs that are called
    (``ldc.model.program_calls``) and bounds for arrays without (``ldc.model.open_arrays``).
    ``units``: rungs by POU name; ``timings``: seconds by stage; ``components``: those of the program by name in
    capitals; ``natives``: the ones in C and C++, which engines build and call."""

    sources: Sources
    diagnostics: Diagnostics
    project: ast.Project
    meant: ast.Project
    model: Model
    units: dict[str, tuple[RungBuild, ...]]
    program: il.Program | None = None
    image: il_image.Image | None = None
    timings: dict[str, float] = field(default_factory=dict)
    natives: tuple[components.Native, ...] = ()
    components: dict[str, Component] = field(default_factory=dict)


class Timings(dict[str, float]):
    """Seconds by stage."""

    def of(self, stage: str) -> _Timing:
        return _Timing(self, stage)


class _Timing:
    """Adds what it encloses to a stage. A class, since a rung enters several: a generator takes twice as long."""

    __slots__ = ("timings", "stage", "start")

    def __init__(self, timings: Timings, stage: str) -> None:
        self.timings, self.stage = timings, stage

    def __enter__(self) -> None:
        self.start = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self.timings[self.stage] = self.timings.get(self.stage, 0.0) + time.perf_counter() - self.start
