"""Runs the stages in order: sources, AST, model, graphs, trees, IL, image (DESIGN section 1).

A rung is the unit of work: built, checked, reduced, lowered and proved on its own.
"""

from __future__ import annotations

import gc
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from ldc import types
from ldc.components import find
from ldc.components import project as components
from ldc.components.descriptor import Component
from ldc.diagnostics import Diagnostics
from ldc.graph.build import build as graph_build
from ldc.graph import rules
from ldc.graph.keys import rung_keys
from ldc.graph.memory import memories
from ldc.graph.order import Turn, schedule
from ldc.graph.reduce import reduce
from ldc.graph.rung import RungGraph
from ldc.graph.tree import SPTree
from ldc.il import image as il_image
from ldc.il import program as il
from ldc.il import shapes, standard, text
from ldc.il.layout import Layout
from ldc.il.lower import lower
from ldc.il.lower_charts import ChartCode
from ldc.il.lower_statements import lower_body
from ldc.il.verify import Verdict, verify
from ldc.library import blocks
from ldc.manifest import Sources, find_sources
from ldc.model import Scope, resolve, usage
from ldc.model.chart_control import Control
from ldc.model.elements import Coil
from ldc.model.project import Model, Pou
from ldc.parser import ast, parse_file
from ldc.parser.sfc import Body, SfcBody, rungs_of
from ldc.parser.sfc import bodies as sfc_bodies
from ldc.parser.statements import StatementBody
from ldc.symbols import Location, Variable

# Trees of nets that hang one below another can be thousands deep; Python-to-Python calls take no C
# stack since 3.11, so that only the limit is in the way.
_RECURSION = 200_000


@dataclass(frozen=True, slots=True)
class Options:
    """How to compile. ``every_component``: also those that no program uses. ``keep``: hold graph and tree of every rung (for the dumps; they are most of the
    memory). ``progress(done, total)`` is called after every rung. ``previous``: layout to keep."""

    max_paren_depth: int | None = None
    verify: bool = True
    keep: bool = True
    every_component: bool = False
    previous: Layout | None = None
    progress: Callable[[int, int], None] | None = None


@dataclass(frozen=True, slots=True)
class RungBuild:
    """Everything that was made of one rung; graph, turns and tree are None when not kept."""

    rung: ast.Rung
    code: il.RungCode
    verdict: Verdict | None = None
    graph: RungGraph | None = None
    turns: tuple[Turn, ...] = ()
    tree: SPTree | None = None


@dataclass(frozen=True, slots=True)
class _Body:
    """What was made of a body: its code, and the variables that this needs beside the declared ones."""

    codes: tuple[il.RungCode, ...]
    builds: tuple[RungBuild, ...]
    temps: tuple[Variable, ...]
    hidden: tuple[Variable, ...]


@dataclass(frozen=True, slots=True)
class Compiled:
    """``program`` and ``image`` are None when there were errors. ``units``: rungs by POU name;
    ``timings``: seconds by stage; ``components``: those of the program by name in capitals; ``natives``:
    the ones in C and C++, which engines build and call."""

    sources: Sources
    diagnostics: Diagnostics
    project: ast.Project
    model: Model
    units: dict[str, tuple[RungBuild, ...]]
    program: il.Program | None = None
    image: il_image.Image | None = None
    timings: dict[str, float] = field(default_factory=dict)
    natives: tuple[components.Native, ...] = ()
    components: dict[str, Component] = field(default_factory=dict)


def compile_paths(paths: Iterable[str], options: Options = Options()) -> Compiled:
    """Compiles what the user named: files, a manifest, a folder. Findings are in ``diagnostics``."""
    diagnostics = Diagnostics()
    sources = find_sources(list(paths), diagnostics)
    return compile_project(sources, options, diagnostics)


def compile_project(sources: Sources, options: Options = Options(),
                    diagnostics: Diagnostics | None = None) -> Compiled:
    """Compiles sources that were read. Never raises for wrong input."""
    with _deep_and_busy():
        return _Compile(sources, options, Diagnostics() if diagnostics is None else diagnostics).run()


@contextmanager
def _deep_and_busy() -> Iterator[None]:
    """Deep recursion allowed; the collector is kept from walking the growing, acyclic results."""
    limit, collects = sys.getrecursionlimit(), gc.isenabled()
    sys.setrecursionlimit(max(limit, _RECURSION))
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()
        sys.setrecursionlimit(limit)


class _Compile:
    def __init__(self, sources: Sources, options: Options, diagnostics: Diagnostics) -> None:
        self.sources = sources
        self.options = options
        self.diagnostics = diagnostics
        self.timings: dict[str, float] = {}
        self.natives: list[components.Native] = []
        self.done = self.total = 0
        self.shapes: dict[tuple, shapes.Known] = {}

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        start = time.perf_counter()
        try:
            yield
        finally:
            self.timings[stage] = self.timings.get(stage, 0.0) + time.perf_counter() - start

    def run(self) -> Compiled:
        with self.timed("parse"):
            known = find.components(self.sources.descriptors, self.diagnostics)
            bodies = components.own_sources(known)
            files = tuple(parse_file(f, self.diagnostics) for f in self.sources.files if f.path not in bodies)
            wanted = known.components if self.options.every_component else ()
            self.components, more = components.used(files, known, self.diagnostics, wanted)
            project = ast.Project((*files, *more))
        with self.timed("resolve"):
            self.model = resolve(project, self.diagnostics, self.sources.settings)
        self.total = sum(len(rungs_of(p.body)) for p in self.model.pous.values())
        self.nullary = frozenset(
            name for name, s in self.model.signatures.items() if s.kind == "FUNCTION" and not (s.inputs or s.in_outs))
        self.locations = {v.name.upper(): v.location for v in self.model.globals.values() if v.location}
        builds: dict[str, tuple[RungBuild, ...]] = {}
        units: list[il.Unit] = []
        for name in self.model.order:
            pou = self.model.pous[name]
            built = self.pou(pou)
            if built is not None:
                unit, builds[pou.name] = self.wrapped(pou, *built)
                units.append(unit)
        result = Compiled(self.sources, self.diagnostics, project, self.model, builds, timings=self.timings,
                          natives=tuple(self.natives), components=self.components)
        if self.diagnostics.has_errors:
            return result
        with self.timed("image"):
            program = self.program(units)
            image = il_image.build(program, self.options.previous)
        return replace(result, program=program, image=image)

    # -- one POU

    def pou(self, pou: Pou) -> tuple[il.Unit, tuple[RungBuild, ...]] | None:
        scope = Scope(self.model, pou.name)
        if isinstance(pou.body, ast.TextBody):
            return self.text_pou(pou, scope)
        if isinstance(pou.body, StatementBody):
            return self.statements(pou, scope)
        if isinstance(pou.body, ast.NativeBody):
            return self.native(pou)
        if isinstance(pou.body, SfcBody):
            return self.chart(pou, scope)
        rungs = pou.body.rungs
        keys = dict(zip(map(id, rungs), rung_keys(rungs, self.diagnostics), strict=True))
        made = self.ladder(pou, scope, rungs, keys)
        return self.unit(pou, [made], tuple(b.code for b in made.builds))

    def unit(self, pou: Pou, bodies: Sequence[_Body], codes: tuple[il.RungCode, ...]
             ) -> tuple[il.Unit, tuple[RungBuild, ...]]:
        hidden = (v for body in bodies for v in body.hidden)
        temps = {v.name: v for body in bodies for v in body.temps}
        variables = (*pou.variables.values(), *hidden, *temps.values())
        unit = il.Unit(pou.signature.kind, pou.name, variables, codes, pou.signature.result, pou.title)
        return unit, tuple(build for body in bodies for build in body.builds)

    def ladder(self, pou: Pou, scope: Scope, rungs: tuple[ast.Rung, ...], keys: dict[int, str]) -> _Body:
        """The rungs of a body; ``keys`` by identity."""
        locations = self.locations | {
            v.name.upper(): v.location for v in pou.variables.values() if v.location}
        builds, temps, hidden, coils = [], {}, [], []
        targets = {j.target.upper() for rung in rungs for j in _jumps(rung.paths)}
        for rung in rungs:
            label = rung.name if rung.name and rung.name.upper() in targets else None
            lowered = self.rung(rung, keys[id(rung)], label, scope, locations, coils)
            self.done += 1
            if self.options.progress:
                self.options.progress(self.done, self.total)
            if lowered is not None:
                build, rung_temps, rung_hidden = lowered
                builds.append(build)
                temps.update((t.name, t) for t in rung_temps)
                hidden += rung_hidden
        usage.duplicate_coils(pou, coils, self.diagnostics)
        codes = tuple(build.code for build in builds)
        return _Body(codes, tuple(builds), tuple(temps.values()), tuple(hidden))

    # -- charts

    def chart(self, pou: Pou, scope: Scope) -> tuple[il.Unit, tuple[RungBuild, ...]]:
        """A sequential function chart: its control as statements, the bodies of its actions each as it is."""
        rungs = rungs_of(pou.body)
        keys = dict(zip(map(id, rungs), rung_keys(rungs, self.diagnostics), strict=True))
        made = {id(body): self.part(pou, body, keys, f"a{number}_")
                for number, body in enumerate(sfc_bodies(pou.body), 1)}
        with self.timed("statements"):
            parts = scope.chart(self.diagnostics)
        with self.timed("lower"):
            taken = (code.key for body in made.values() for code in body.codes)
            code = ChartCode(taken, self.options.max_paren_depth)
            for part in parts:
                if isinstance(part, Control):
                    code.control(part)
                else:
                    code.guarded(part, made[id(part.body)].codes)
            codes = code.finish()
        control = _Body((), (), tuple(code.temps.values()), ())
        return self.unit(pou, (*made.values(), control), codes)

    def part(self, pou: Pou, body: Body, keys: dict[int, str], stem: str) -> _Body:
        """The body of an action or a transition."""
        scope = Scope(self.model, pou.name, body)
        if isinstance(body, ast.LadderBody):
            return self.ladder(pou, scope, body.rungs, keys)
        if isinstance(body, ast.TextBody):
            made = text.parse_unit(replace(pou, body=body), scope, self.diagnostics)
            return _Body((), (), (), ()) if made is None else _Body(
                tuple(replace(code, key=f"{stem}{n}") for n, code in enumerate(made.rungs, 1)), (),
                made.variables[len(pou.variables):], ())
        with self.timed("statements"):
            actions = scope.actions(self.diagnostics)
        with self.timed("lower"):
            codes, temps = lower_body(actions, self.options.max_paren_depth, stem)
        return _Body(codes, (), temps, ())

    def rung(self, rung: ast.Rung, key: str, label: str | None, scope: Scope,
             locations: dict[str, Location], coils: list) -> tuple[RungBuild, tuple, tuple] | None:
        with self.timed("graph"):
            graph = graph_build(rung, key, scope, self.diagnostics)
            if graph is None:
                return None
            coils += [(key, e) for e in graph.elements if isinstance(e, Coil)]
        with self.timed("shape"):
            shape = shapes.shape_of(graph, locations)
            known = self.shapes.get(shape.key) if shape is not None else None
            made = known.another(graph, shape, label) if known is not None else None
        if made is None:
            made = self.made(rung, graph, shape, label, locations)
        if made is None:
            return None
        code = made.lowered.code
        if self.options.keep:
            build = RungBuild(rung, code, made.verdict, graph, made.turns, made.tree)
        else:
            build = RungBuild(rung, code, made.verdict)
        return build, made.lowered.temps, made.lowered.hidden

    def made(self, rung: ast.Rung, graph: RungGraph, shape: shapes.Shape | None, label: str | None,
             locations: dict[str, Location]) -> shapes.Made | None:
        """Checks, reduces, lowers and proves a rung; what was told about it keeps it from being an example
        for others of its shape."""
        found = len(self.diagnostics)
        with self.timed("graph"):
            if not rules.check(graph, self.diagnostics):
                return None
        with self.timed("reduce"):
            turns = schedule(graph)
            hidden = memories(graph, turns)
            tree = reduce(graph, turns)
            rules.note_bridge(graph, tree, self.diagnostics)
        with self.timed("lower"):
            lowered = lower(graph, tree, hidden, label=label, max_paren_depth=self.options.max_paren_depth)
        verdict = None
        if self.options.verify:
            with self.timed("verify"):
                verdict = verify(graph, turns, hidden, tree, lowered.code.code, lowered.temps, locations,
                                 self.nullary)
            if verdict.kind == "wrong":
                self.wrong(rung, verdict)
            lowered = replace(lowered, code=replace(lowered.code, proof=verdict.kind))
        made = shapes.Made(turns, tree, lowered, verdict)
        if shape is not None and len(self.diagnostics) == found:
            with self.timed("shape"):
                known = shapes.known(graph, shape, hidden, made)
                if known is not None:
                    self.shapes[shape.key] = known
        return made

    def wrong(self, rung: ast.Rung, verdict: Verdict) -> None:
        values = ", ".join(f"{name} = {'TRUE' if on else 'FALSE'}" for name, on in verdict.example)
        self.diagnostics.error(
            "LD0901", f"the {'IL' if verdict.stage == 'il' else 'tree'} of this rung does not do what the "
            f"drawing says: {verdict.what} differs", rung.name_span or rung.span, "self-check failed here",
            help=f"this is a fault of ldc, not of the program; please report it with this rung. It shows with {values}")

    def text_pou(self, pou: Pou, scope: Scope) -> tuple[il.Unit, tuple[RungBuild, ...]] | None:
        with self.timed("read IL"):
            unit = text.parse_unit(pou, scope, self.diagnostics)
        return None if unit is None else (unit, ())

    def statements(self, pou: Pou, scope: Scope) -> tuple[il.Unit, tuple[RungBuild, ...]]:
        """A body in Structured Text. Its statements are no rungs: there is no drawing to compare with."""
        with self.timed("statements"):
            actions = scope.actions(self.diagnostics)
        with self.timed("lower"):
            code, temps = lower_body(actions, self.options.max_paren_depth)
        unit = il.Unit(pou.signature.kind, pou.name, (*pou.variables.values(), *temps), code,
                       pou.signature.result, pou.title)
        return unit, ()

    def wrapped(self, pou: Pou, unit: il.Unit, builds: tuple[RungBuild, ...]
                ) -> tuple[il.Unit, tuple[RungBuild, ...]]:
        """The body of a component in IL or ST gets what every component has around its body."""
        component = self.components.get(pou.name.upper())
        if component is None or component.native:
            return unit, builds
        from ldc.components import body

        return body.wrapped(component, pou, unit), builds

    def native(self, pou: Pou) -> tuple[il.Unit, tuple[RungBuild, ...]]:
        """A component in C or C++: its sources are read and checked here, and compiled when it is built."""
        from ldc.components import body, host  # slow to load, and most projects have no such component

        with self.timed("components"):
            component = self.components[pou.name.upper()]
            unit = body.native(component, pou, host.digest(component, self.diagnostics))
            native = components.Native(component, unit)
            host.check(native, tuple(self.model.globals.values()), self.diagnostics)
            self.natives.append(native)
        return unit, ()

    # -- the whole

    def program(self, units: list[il.Unit]) -> il.Program:
        model = self.model
        used = dict.fromkeys(name for pou in model.pous.values() for v in pou.variables.values()
                             for name in _blocks(v.type))
        used |= dict.fromkeys(name for v in model.globals.values() for name in _blocks(v.type))
        library = [standard.unit(name) for name in used if blocks.signature(name) is not None]
        resources = tuple(
            il.Resource(r.name, r.processor,
                        tuple(il.Task(t.name, t.interval, t.priority, self.single(t.single)) for t in r.tasks),
                        tuple(il.Run(run.name, run.pou, run.task) for run in r.runs))
            for r in model.resources)
        named = tuple(t for t in model.types.values() if isinstance(t, types.Struct | types.Enum))
        name = self.sources.manifest.name if self.sources.manifest else ""
        return il.Program((*library, *units), named, tuple(model.globals.values()), resources,
                          tuple(sorted(model.safe.items())), name)

    def single(self, expr: ast.Expr | None):
        if expr is None:
            return None
        scope = Scope(self.model, None)
        return scope.place(expr, self.diagnostics)


def _jumps(paths: tuple[ast.Path, ...]) -> Iterator[ast.Jump]:
    for path in paths:
        for item in path.items:
            if isinstance(item, ast.Jump):
                yield item
            elif isinstance(item, ast.Branches):
                yield from _jumps(item.paths)


def _blocks(type_: types.Type) -> Iterator[str]:
    """The function blocks that a variable of the type holds instances of."""
    match type_:
        case types.Instance(pou):
            yield pou
        case types.Array(element=element):
            yield from _blocks(element)
        case types.Struct(fields=fields):
            for member in fields:
                yield from _blocks(member.type)
