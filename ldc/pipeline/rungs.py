"""From rungs to their code: graph, rules, tree, IL, proof; what is known of a rung is not made again."""

from __future__ import annotations

from collections.abc import Set

from ldc.diagnostics import Diagnostics
from ldc.graph import rules
from ldc.graph.build import build as graph_build
from ldc.graph.memory import memories
from ldc.graph.order import Turn, schedule
from ldc.graph.reduce import reduce
from ldc.graph.rung import RungGraph
from ldc.graph.tree import SPTree
from ldc.il import shapes
from ldc.il.lower import lower
from ldc.il.verify import Verdict, verify
from ldc.model import Scope, usage
from ldc.model.elements import Coil
from ldc.model.project import Model, Pou
from ldc.parser import ast
from ldc.parser.sfc import rungs_of
from ldc.pipeline.recall import Recall, RungResult, jump_targets
from ldc.pipeline.results import BodyCode, Options, RungBuild, Timings
from ldc.records import replace
from ldc.source import SourceFile
from ldc.symbols import Location


class Rungs:
    """Compiles the rungs of a project, body by body. ``known``: the sources whose rungs may be remembered."""

    def __init__(self, model: Model, options: Options, diagnostics: Diagnostics, timings: Timings,
                 known: Set[SourceFile]) -> None:
        self.options, self.diagnostics, self.timings = options, diagnostics, timings
        self.known = known
        self.done, self.total = 0, sum(len(rungs_of(p)) for p in model.pous.values())
        self.shapes: dict[tuple, shapes.Known] = {}
        self.trees: dict[tuple, tuple[tuple[Turn, ...], SPTree]] = {}
        self.nullary = frozenset(name for name, s in model.signatures.items()
                                 if s.kind == "FUNCTION" and not (s.inputs or s.in_outs))
        self.unnamed = any(
            v.location is not None and v.span is not None and v.span.text.startswith("%")
            for variables in (model.globals, *(p.variables for p in model.pous.values()))
            for v in variables.values())
        self.locations = {v.name.upper(): v.location for v in model.globals.values() if v.location}

    def body(self, pou: Pou, scope: Scope, rungs: tuple[ast.Rung, ...], keys: dict[int, str]) -> BodyCode:
        """The rungs of a body; ``keys`` by identity."""
        locations = self.locations | {
            v.name.upper(): v.location for v in pou.variables.values() if v.location}
        recall = None
        if pou.body.span.source in self.known:
            recall = Recall(self.options.memory, scope, locations, self.options)
        made, temps, hidden, coils = [], {}, [], []
        targets = {target.upper() for rung in rungs for target in jump_targets(rung)}
        for rung in rungs:
            label = rung.name if rung.name and rung.name.upper() in targets else None
            done = self._rung(rung, keys[id(rung)], label, scope, locations, recall)
            self.done += 1
            if self.options.progress:
                self.options.progress(self.done, self.total)
            coils += [(keys[id(rung)], coil) for coil in done.coils]
            if done.build is not None:
                made.append(done.build)
                temps.update((t.name, t) for t in done.temps)
                hidden += done.hidden
        usage.duplicate_coils(pou, coils, self.diagnostics)
        codes = tuple(build.code for build in made)
        return BodyCode(codes, tuple(made), tuple(temps.values()), tuple(hidden))

    def _rung(self, rung: ast.Rung, key: str, label: str | None, scope: Scope,
              locations: dict[str, Location], recall: Recall | None) -> RungResult:
        # What an address stands for is not among what is remembered of names.
        if recall is None or self.unnamed and "%" in rung.span.text:
            return self._fresh(rung, key, label, scope, locations)
        with self.timings.of("recall"):
            name = recall.name(rung, key, label)
            known = recall.find(name, rung, key, label)
        if known is not None:
            return known
        found = len(self.diagnostics)
        made = self._fresh(rung, key, label, scope, locations)
        if len(self.diagnostics) == found:
            with self.timings.of("recall"):
                recall.keep(name, rung, made)
        return made

    def _fresh(self, rung: ast.Rung, key: str, label: str | None, scope: Scope,
               locations: dict[str, Location]) -> RungResult:
        with self.timings.of("graph"):
            graph = graph_build(rung, key, scope, self.diagnostics)
            if graph is None:
                return RungResult(None)
            coils = tuple([e for e in graph.elements if isinstance(e, Coil)])
        with self.timings.of("shape"):
            shape = shapes.shape_of(graph, locations)
            known = self.shapes.get(shape.key) if shape is not None else None
            made = known.another(graph, shape, label) if known is not None else None
        if made is None:
            made = self._made(rung, graph, shape, label, locations)
        if made is None:
            return RungResult(None, coils)
        code = made.lowered.code
        if self.options.keep:
            build = RungBuild(rung, code, made.verdict, graph, made.turns, made.tree)
        else:
            build = RungBuild(rung, code, made.verdict)
        return RungResult(build, coils, made.lowered.temps, made.lowered.hidden)

    def _made(self, rung: ast.Rung, graph: RungGraph, shape: shapes.Shape | None, label: str | None,
              locations: dict[str, Location]) -> shapes.Made | None:
        """Checks, reduces, lowers and proves a rung; what was told about it keeps it from being an example
        for others of its shape."""
        found = len(self.diagnostics)
        with self.timings.of("graph"):
            if not rules.check(graph, self.diagnostics):
                return None
        with self.timings.of("shape"):
            family = shape.family(graph) if shape is not None else None
            alike = self.trees.get(family)
        with self.timings.of("reduce"):
            turns = alike[0] if alike is not None else schedule(graph)
            hidden = memories(graph, turns)
            tree = alike[1] if alike is not None else reduce(graph, turns)
            rules.note_bridge(graph, tree, self.diagnostics)
        with self.timings.of("lower"):
            lowered = lower(graph, tree, hidden, label=label, max_paren_depth=self.options.max_paren_depth)
        verdict = None
        if self.options.verify:
            with self.timings.of("verify"):
                verdict = verify(graph, turns, hidden, tree if alike is None else None, lowered.code.code,
                                 lowered.temps, locations, self.nullary)
            if verdict.kind == "wrong":
                self._wrong(rung, verdict)
            lowered = replace(lowered, code=replace(lowered.code, proof=verdict.kind))
        made = shapes.Made(turns, tree, lowered, verdict)
        if shape is not None and len(self.diagnostics) == found:
            self.trees.setdefault(family, (turns, tree))
            with self.timings.of("shape"):
                known = shapes.known(graph, shape, hidden, made)
                if known is not None:
                    self.shapes[shape.key] = known
        return made

    def _wrong(self, rung: ast.Rung, verdict: Verdict) -> None:
        values = ", ".join(f"{name} = {'TRUE' if on else 'FALSE'}" for name, on in verdict.example)
        self.diagnostics.error(
            "LD0901", f"the {'IL' if verdict.stage == 'il' else 'tree'} of this rung does not do what the "
            f"drawing says: {verdict.what} differs", rung.name_span or rung.span, "self-check failed here",
            help="this is a fault of ldc, not of the program; please report it with this rung. "
            f"It shows with {values}")
