"""Runs the stages in order: sources, AST, model, graphs, trees, IL, image (DESIGN section 1).

A rung is the unit of work: built, checked, reduced, lowered and proved on its own.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

from ldc import types
from ldc.collector import resting
from ldc.components import find, pace
from ldc.components import project as components
from ldc.diagnostics import Diagnostics
from ldc.graph.keys import rung_keys
from ldc.il import image as il_image
from ldc.il import program as il
from ldc.il import standard, text
from ldc.il.lower_charts import ChartCode
from ldc.il.lower_edges import lower_edges
from ldc.il.lower_statements import lower_body
from ldc.il.performed import Action, performed
from ldc.library import blocks
from ldc.manifest import Sources, find_sources
from ldc.model import Scope, resolve
from ldc.model.chart_control import Control
from ldc.model.eno_of_blocks import with_enables
from ldc.model.open_arrays import with_bounds
from ldc.model.program_calls import with_blocks
from ldc.model.project import Pou
from ldc.model.resolver import declared
from ldc.model.unnamed import with_names
from ldc.parser import ast, format_of, parse_file, parse_files
from ldc.parser.sfc import Body, SfcBody
from ldc.parser.sfc import bodies as sfc_bodies
from ldc.parser.sfc import rungs_of
from ldc.parser.statements import StatementBody
from ldc.pipeline.global_calls import callees_first
from ldc.pipeline.results import BodyCode, Compiled, Options, RungBuild, Timings
from ldc.pipeline.rungs import Rungs
from ldc.records import replace
from ldc.source import SourceFile

# Trees of nets that hang one below another can be thousands deep; Python-to-Python calls take no C
# stack since 3.11, so that only the limit is in the way.
_RECURSION = 200_000


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
    limit = sys.getrecursionlimit()
    sys.setrecursionlimit(max(limit, _RECURSION))
    try:
        with resting():
            yield
    finally:
        sys.setrecursionlimit(limit)


class _Compile:
    def __init__(self, sources: Sources, options: Options, diagnostics: Diagnostics) -> None:
        self.sources = sources
        self.options = options
        self.diagnostics = diagnostics
        self.timings = Timings()
        self.natives: list[components.Native] = []
        self.memory = None if options.keep else options.memory
        self.remembered: set[SourceFile] = set()
        self.algorithms: list[il.Unit] = []
        processors = sources.manifest.processors if sources.manifest and options.algorithms else {}
        self.slaves = pace.slaves(processors)

    def run(self) -> Compiled:
        with self.timings.of("parse"):
            known = find.components(self.sources.descriptors, self.diagnostics)
            bodies = components.own_sources(known)
            files = parse_files((f for f in self.sources.files if f.path not in bodies),
                                self.diagnostics, self.parsed)
            wanted = known.components if self.options.every_component else ()
            self.components, more = components.used(files, known, self.diagnostics, wanted, self.slaves)
            pace.elsewhere(self.components.values(), self.slaves, self.diagnostics)
            project = with_names(ast.Project((*files, *more)))
        with self.timings.of("resolve"):
            settings = self.sources.settings
            meant = with_bounds(with_blocks(project), self.diagnostics, lambda made: declared(made, settings))
            self.model = resolve(with_enables(meant), self.diagnostics, settings)
        self.rungs = Rungs(self.model, self.options, self.diagnostics, self.timings, self.remembered)
        builds: dict[str, tuple[RungBuild, ...]] = {}
        units: list[il.Unit] = []
        for name in self.model.order:
            pou = self.model.pous[name]
            built = self.pou(pou)
            if built is not None:
                unit, builds[pou.name] = self.wrapped(pou, *built)
                units.append(self.proxied(pou, unit))
        self.remember()
        result = Compiled(self.sources, self.diagnostics, project, meant, self.model, builds, timings=self.timings,
                          natives=tuple(self.natives), components=self.components)
        if not self.diagnostics.has_errors:
            units = callees_first(units, self.model, self.diagnostics)
        if self.diagnostics.has_errors:
            return result
        with self.timings.of("image"):
            program = self.program(units)
            pace.lent(program, self.diagnostics)
            pace.room(program, self.components, self.diagnostics)
            if self.diagnostics.has_errors:
                return result
            image = il_image.build(program, self.options.previous)
        return replace(result, program=program, image=image)

    def parsed(self, source: SourceFile) -> ast.File:
        """A source; its rungs are remembered when nothing was told about it."""
        if self.memory is None or format_of(source) is not None:
            return parse_file(source, self.diagnostics)
        found = len(self.diagnostics)
        file = parse_file(source, self.diagnostics, self.memory.head)
        if len(self.diagnostics) == found:
            self.remembered.add(source)
        return file

    def remember(self) -> None:
        """What a wrong program did not get to is not forgotten: it will soon be right."""
        if self.memory is not None and not self.diagnostics.has_errors:
            with self.timings.of("recall"):
                self.memory.save()

    # -- one POU

    def pou(self, pou: Pou) -> tuple[il.Unit, tuple[RungBuild, ...]] | None:
        """The code of a POU, with that of the edges of its inputs before it."""
        made = self.of_body(pou)
        if made is None:
            return None
        unit, builds = made
        if pou.edges:
            unit = replace(unit, rungs=(lower_edges(pou.edges), *unit.rungs))
        return self.with_actions(pou, unit, builds) if pou.actions else (unit, builds)

    def of_body(self, pou: Pou) -> tuple[il.Unit, tuple[RungBuild, ...]] | None:
        scope = Scope(self.model, pou.name)
        if isinstance(pou.body, ast.TextBody):
            return self.text_pou(pou, scope)
        if isinstance(pou.body, StatementBody):
            return self.statements(pou, scope)
        if isinstance(pou.body, ast.NativeBody):
            return self.native(pou)
        if isinstance(pou.body, SfcBody):
            return self.chart(pou, scope)
        made = self.rungs.body(pou, scope, pou.body.rungs, self.keys(pou))
        return self.unit(pou, [made], tuple(b.code for b in made.builds))

    def keys(self, pou: Pou) -> dict[int, str]:
        """The keys of all rungs of a POU, by identity."""
        rungs = rungs_of(pou)
        return dict(zip(map(id, rungs), rung_keys(rungs, self.diagnostics), strict=True))

    def with_actions(self, pou: Pou, unit: il.Unit, builds: tuple[RungBuild, ...]
                     ) -> tuple[il.Unit, tuple[RungBuild, ...]]:
        """The actions of a POU put in where its body calls them."""
        keys = {} if isinstance(pou.body, ast.TextBody) else self.keys(pou)
        made = [self.part(pou, action.body, keys, f"a{number}_") for number, action in enumerate(pou.actions, 1)]
        bodies = [Action(action.name, body.codes, body.temps, action.name_span)
                  for action, body in zip(pou.actions, made, strict=True)]
        selector = pou.signature.inputs[-1].name if pou.signature.kind == "FUNCTION_BLOCK" else None
        unit = replace(unit, variables=(*unit.variables, *(v for body in made for v in body.hidden)))
        return performed(unit, bodies, selector, self.diagnostics), (
            *builds, *(build for body in made for build in body.builds))

    def unit(self, pou: Pou, bodies: Sequence[Body], codes: tuple[il.RungCode, ...]
             ) -> tuple[il.Unit, tuple[RungBuild, ...]]:
        hidden = (v for body in bodies for v in body.hidden)
        temps = {v.name: v for body in bodies for v in body.temps}
        variables = (*pou.variables.values(), *hidden, *temps.values())
        unit = il.Unit(pou.signature.kind, pou.name, variables, codes, pou.signature.result, pou.title)
        return unit, tuple(build for body in bodies for build in body.builds)

    # -- charts

    def chart(self, pou: Pou, scope: Scope) -> tuple[il.Unit, tuple[RungBuild, ...]]:
        """A sequential function chart: its control as statements, the bodies of its actions each as it is."""
        keys = self.keys(pou)
        made = {id(body): self.part(pou, body, keys, f"a{number}_")
                for number, body in enumerate(sfc_bodies(pou.body), 1)}
        with self.timings.of("statements"):
            parts = scope.chart(self.diagnostics)
        with self.timings.of("lower"):
            taken = (code.key for body in made.values() for code in body.codes)
            code = ChartCode(taken, self.options.max_paren_depth)
            for part in parts:
                if isinstance(part, Control):
                    code.control(part)
                else:
                    code.guarded(part, made[id(part.body)].codes)
            codes = code.finish()
        control = BodyCode((), (), tuple(code.temps.values()), ())
        return self.unit(pou, (*made.values(), control), codes)

    def part(self, pou: Pou, body: Body, keys: dict[int, str], stem: str) -> Body:
        """The body of an action or a transition."""
        scope = Scope(self.model, pou.name, body)
        if isinstance(body, ast.LadderBody):
            return self.rungs.body(pou, scope, body.rungs, keys)
        if isinstance(body, ast.TextBody):
            made = text.parse_unit(replace(pou, body=body), scope, self.diagnostics)
            return BodyCode() if made is None else BodyCode(
                tuple(replace(code, key=f"{stem}{n}") for n, code in enumerate(made.rungs, 1)), (),
                made.variables[len(pou.variables):], ())
        with self.timings.of("statements"):
            actions = scope.actions(self.diagnostics)
        with self.timings.of("lower"):
            codes, temps = lower_body(actions, self.options.max_paren_depth, stem)
        return BodyCode(codes, (), temps, ())

    def text_pou(self, pou: Pou, scope: Scope) -> tuple[il.Unit, tuple[RungBuild, ...]] | None:
        with self.timings.of("read IL"):
            unit = text.parse_unit(pou, scope, self.diagnostics)
        return None if unit is None else (unit, ())

    def statements(self, pou: Pou, scope: Scope) -> tuple[il.Unit, tuple[RungBuild, ...]]:
        """A body in Structured Text. Its statements are no rungs: there is no drawing to compare with."""
        with self.timings.of("statements"):
            actions = scope.actions(self.diagnostics)
        with self.timings.of("lower"):
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

    def proxied(self, pou: Pou, unit: il.Unit) -> il.Unit:
        """What a slave executes by itself is for the slave; the program gets its proxy."""
        component = self.components.get(pou.name.upper())
        slave = pace.slave_of(component, self.slaves) if component is not None else None
        if slave is None:
            return unit
        from ldc.components import body

        body.check_memory(component, unit, slave, self.diagnostics)
        self.algorithms.append(unit)
        return body.proxy(component, pou, slave, self.diagnostics) or unit

    def native(self, pou: Pou) -> tuple[il.Unit, tuple[RungBuild, ...]]:
        """A component in C or C++: its sources are read and checked here, and compiled when it is built."""
        from ldc.components import body, host  # slow to load, and most projects have no such component

        with self.timings.of("components"):
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
                             for name in types.blocks_in(v.type))
        used |= dict.fromkeys(name for v in model.globals.values() for name in types.blocks_in(v.type))
        library = [standard.unit(name) for name in used if blocks.signature(name) is not None]
        resources = tuple(
            il.Resource(r.name, r.processor,
                        tuple(il.Task(t.name, t.interval, t.priority, self.single(t.single)) for t in r.tasks),
                        tuple(il.Run(run.name, run.pou, run.task) for run in r.runs))
            for r in model.resources)
        named = tuple(t for t in model.types.values() if isinstance(t, types.Struct | types.Enum))
        name = self.sources.manifest.name if self.sources.manifest else ""
        return il.Program((*library, *units), named, tuple(model.globals.values()), resources,
                          tuple(sorted(model.safe.items())), name, tuple(self.algorithms))

    def single(self, expr: ast.Expr | None):
        if expr is None:
            return None
        scope = Scope(self.model, None)
        return scope.place(expr, self.diagnostics)
