"""From the AST of a project to its model: one pass over declarations, bodies stay as drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ldc.diagnostics import Diagnostics, Severity
from ldc.free_names import claimed
from ldc.library import blocks
from ldc.model import action_calls, chart_names
from ldc.model import declaration_findings as findings
from ldc.model.chart_names import ACTION, STEP
from ldc.model.configuration import Configurator
from ldc.model.edges import edges_of
from ldc.model.frame import CALLED, Frame
from ldc.model.instance_config import configured, with_places
from ldc.model.names import IL_WORDS, PREFIX, standard
from ldc.model.order import call_order
from ldc.model.outputs import check_overlaps
from ldc.model.paths import with_paths
from ldc.model.project import Model, Pou
from ldc.model.settings import Settings
from ldc.model.sizes import check_sizes
from ldc.model.type_table import TypeTable
from ldc.parser import ast, sfc
from ldc.parser.findings import BEYOND
from ldc.records import replace
from ldc.source import Span
from ldc.symbols import Parameter, Signature, Variable
from ldc.types import BOOL, ELEMENTARY, INT, Type, blocks_in

_PINS = ("input", "output", "in_out")


def resolve(project: ast.Project, diagnostics: Diagnostics, settings: Settings | None = None) -> Model:
    """The model of a project. What is wrong is reported and left out of it.

    ``settings``: what ``ldc.toml`` says (``ldc.model.settings.Settings``, or any object with some of
    its attributes). The order of files and declarations does not matter, except that a PROGRAM
    without a CONFIGURATION runs in the order of the text.
    """
    return _Resolver(project, diagnostics, _settings(settings)).model()


def declared(project: ast.Project, settings: Settings | None = None) -> Callable[[str], Frame | None]:
    """What the POUs of a project declare, by their names in capitals; nothing is reported."""
    resolver = _Resolver(project, Diagnostics(), _settings(settings))

    return resolver.frame


def _settings(given: object | None) -> Settings:
    usual = Settings()
    names = ("image_bytes", "tasks", "modules", "safe", "library")
    return Settings(**{name: getattr(given, name, getattr(usual, name)) for name in names})


class _Resolver:
    def __init__(self, project: ast.Project, diagnostics: Diagnostics, settings: Settings) -> None:
        self.diagnostics, self.settings = diagnostics, settings
        project = configured(project, diagnostics)
        self.library, self.image_bytes = settings.library, settings.image_bytes
        self._first: dict[str, Span] = {}
        self._pous: dict[str, ast.Pou] = {}
        declared: dict[str, ast.TypeDecl] = {}
        for file in project.files:
            for type_ in file.types:
                if self._claim(type_.name, type_.span, "type"):
                    declared[type_.name.upper()] = type_
            for pou in file.pous:
                if self._claim(pou.name, pou.name_span, "POU", pou.kind):
                    self._pous[pou.name.upper()] = pou
        self._own = {} if self.library else self._in_place_of_standard()
        self._safe = dict(value for file in project.files for value in file.safe) | dict(settings.safe)
        self.incomplete, self._torn, self._damaged = _what_is_missing(self._pous, diagnostics)
        self.incomplete |= any(file.incomplete and not file.pous for file in project.files)
        kinds = {key: (pou.kind, pou.name) for key, pou in self._pous.items()}
        kinds |= {written: kinds[key] for written, key in self._own.items()}
        self.types = TypeTable(declared, kinds, diagnostics)
        self.configurations = [c for file in project.files for c in file.configurations]
        self.globals = Frame(self, "", "", _global_blocks(project, self.configurations), None)
        for key, node in self.globals.declarations().items():
            if key in self._first:
                findings.duplicate(diagnostics, node.span, node.name, "global variable", self._first[key])
        self.frames: dict[str, Frame] = {}
        self._built: dict[str, Pou] = {}
        self._signatures: dict[str, Signature] = {}
        self._declared_types = declared

    def _in_place_of_standard(self) -> dict[str, str]:
        """The POUs with the name of a standard one, in capitals: it and the name that they get. The library's
        blocks go on to call the standard one, so the two need different names."""
        taken = set(self._first)
        made: dict[str, str] = {}
        for key, pou in tuple(self._pous.items()):
            if _replaces_standard(pou.kind, key):
                name = claimed(pou.name, taken)
                findings.own_standard(self.diagnostics, pou.name_span, pou.name, standard(key), name)
                del self._pous[key]
                made[key] = name.upper()
                self._pous[name.upper()] = replace(pou, name=name, written=pou.written or pou.name)
        return made

    def _claim(self, name: str, span: Span, what: str, kind: str = "") -> bool:
        """Types and POUs share one space of names."""
        key = name.upper()
        if key in self._first:
            findings.duplicate(self.diagnostics, span, name, what, self._first[key])
            return False
        self._first[key] = span
        if not self.library:
            if key.startswith(PREFIX):
                # IL text may be what the compiler printed: the types of steps and actions come back.
                if what != "type" or not span.source.path.lower().endswith(".il"):
                    findings.reserved_prefix(self.diagnostics, span, name)
            elif (why := standard(key)) and not _replaces_standard(kind, key):
                findings.reserved_name(self.diagnostics, span, name, why)
        return True

    def model(self) -> Model:
        for key in self._declared_types:
            self.types.named(self.globals, key)
        global_variables = self.globals.build()
        for key in self._pous:
            self.signature(key)
        used = dict(self._signatures)
        used |= {written: used[key] for written, key in self._own.items() if key in used}
        for variable in (v for scope in (global_variables, *(p.variables for p in self._built.values()))
                         for v in scope.values()):
            for pou in blocks_in(variable.type):
                if pou not in used:
                    used[pou] = blocks.signature(pou)
        order = call_order(self._built, self.diagnostics)
        check_sizes(self._built, order, global_variables, self.diagnostics)
        model = Model(
            pous=self._built, types=self.types.types(), globals=global_variables, signatures=used,
            resources=(), order=order, safe=self._safe, image_bytes=self.image_bytes,
            enum_values={key: tuple(choices) for key, choices in self.types.enum_values.items()},
            broken=self._broken(), incomplete=self.incomplete, damaged=self._damaged,
        )
        check_overlaps(model, self.diagnostics)
        configurator = Configurator(model, self.globals, self.settings, self.diagnostics)
        return with_paths(with_places(configurator.configured(self.configurations), self._pous))

    def _broken(self) -> dict[str, frozenset[str]]:
        frames = {"": self.globals, **self.frames}
        broken = {key: frozenset(frame.broken) for key, frame in frames.items() if frame.broken}
        if told := self.types.broken | self.types.unknown:
            broken[""] = broken.get("", frozenset()) | told
        return broken

    # ---- what frames ask ----------------------------------------------------------------------------

    def signature(self, key: str) -> Signature | None:
        """The signature of a POU of the project; its variables are built when it is first asked for."""
        key = self._own.get(key, key)
        if key in self._signatures:
            return self._signatures[key]
        node = self._pous.get(key)
        if node is None or key in self.frames:
            return None
        frame = self.frames[key] = Frame(self, node.name, node.kind, node.var_blocks, self.globals,
                                         node.written)
        if key in self._torn:
            frame.broken.add("*")
        variables = frame.build()
        actions = self._actions(node, variables, frame)
        pins = {kind: tuple(v for v in variables.values() if v.kind == kind) for kind in _PINS}
        if isinstance(node.body, sfc.SfcBody):
            self._add_chart(node, variables, frame)
        result = self._result(node, frame)
        signature = Signature(node.kind, node.name, *(tuple(map(_parameter, pins[k])) for k in _PINS),
                              result=result, standard=self.library, actions=actions,
                              written=node.written, order=_order(node))
        ordered = {v.name.upper(): v for kind in _PINS for v in pins[kind]}
        ordered.update((key, v) for key, v in variables.items() if v.kind not in _PINS)
        if result is not None:
            ordered[key] = Variable(node.name, result, "local", span=node.name_span)
        edges = edges_of(node, ordered)
        ordered.update((v.name.upper(), v) for edge in edges for v in (edge.pulse, edge.memory))
        self._signatures[key] = signature
        self._built[key] = Pou(signature, node.title, ordered, node.body, node.span, edges, node.actions)
        return signature

    def _actions(self, node: ast.Pou, variables: dict[str, Variable], frame: Frame) -> tuple[str, ...]:
        """The names of actions that may be called. A function block gets the input that chooses one."""
        first: dict[str, Span] = {key: declared.span for key, declared in frame.declarations().items()}
        for action in node.actions:
            key = action.name.upper()
            taken = first.setdefault(key, action.name_span)
            if taken is not action.name_span:
                findings.duplicate(self.diagnostics, action.name_span, action.name, "action", taken)
        if node.actions and node.kind == "FUNCTION_BLOCK":
            name = action_calls.selector_name(frozenset(first))
            variables[name.upper()] = Variable(name, INT, "input", span=node.name_span)
        return tuple(action.name for action in node.actions)

    def _add_chart(self, node: ast.Pou, variables: dict[str, Variable], frame: Frame) -> None:
        """Add the variables of steps, actions and their control."""
        transitions: dict[str, Span] = {}
        for named in (t for t in node.body.transitions if t.name is not None):
            key = named.name.upper()
            first = transitions.setdefault(key, named.name_span)
            taken = None if isinstance(named.condition, sfc.Body) else variables.get(key)
            if first is not named.name_span or taken is not None:
                findings.duplicate(self.diagnostics, named.name_span, named.name, "transition",
                                   first if taken is None else taken.span)
        for variable in chart_names.variables(node.body):
            key = variable.name.upper()
            first = variables.get(key) or frame.declarations().get(key)
            if first is None and key != node.name.upper():
                variables[key] = variable
            elif variable.span is not None:
                what = {STEP: "step", ACTION: "action"}.get(variable.type, "transition")
                findings.duplicate(self.diagnostics, variable.span, variable.name, what,
                                   node.name_span if first is None else first.span)

    def _result(self, node: ast.Pou, frame: Frame) -> Type | None:
        if node.kind != "FUNCTION":
            return None
        if node.result is None:
            return BOOL  # one without a result is FALSE
        known = frame.type_of(node.result)
        if known is not None and (held := next(blocks_in(known.type), None)):
            findings.not_allowed_here(self.diagnostics, node.result.span,
                                      f"FUNCTION `{node.name}` returns a function block",
                                      f"an instance of {held}",
                                      "return a value, or make it a FUNCTION_BLOCK")
            known = None
        if known is None:
            frame.broken.add(node.name.upper())
            return None
        return known.type

    def frame(self, key: str) -> Frame | None:
        """What a POU declares."""
        self.signature(key)
        return self.frames.get(self._own.get(key, key))

    def callables(self) -> Iterable[str]:
        return [pou.name for pou in self._pous.values()]


def _replaces_standard(kind: str, key: str) -> bool:
    """Whether a POU takes the place of a standard one; what is an instruction of IL stays one."""
    return kind in CALLED and standard(key) is not None and key not in ELEMENTARY and key not in IL_WORDS


def _order(node: ast.Pou) -> tuple[str, ...]:
    """The names of inputs and VAR_IN_OUT as they are declared, where that is not the inputs first."""
    blocks = [block for block in node.var_blocks if block.kind in ("VAR_INPUT", "VAR_IN_OUT")]
    if blocks == sorted(blocks, key=lambda block: block.kind != "VAR_INPUT"):
        return ()
    return tuple(v.name.upper() for block in blocks for v in block.variables)


def _parameter(variable: Variable) -> Parameter:
    return Parameter(variable.name, variable.type, variable.initial)


def _global_blocks(project: ast.Project, configurations: list[ast.Configuration]) -> list[ast.VarBlock]:
    found = [block for file in project.files for block in file.globals]
    for configuration in configurations[:1]:
        found += configuration.var_blocks
        for resource in configuration.resources:
            found += resource.var_blocks
    return found


def _what_is_missing(
    pous: dict[str, ast.Pou], diagnostics: Diagnostics
) -> tuple[bool, frozenset[str], frozenset[str]]:
    """What syntax errors took away: whether anything outside of POUs, the POUs that lost declarations,
    and those that lost rungs."""
    incomplete, torn, damaged = False, set(), set()
    for diagnostic in diagnostics:
        beyond = diagnostic.code == BEYOND
        if not (beyond or diagnostic.code.startswith("LD01")) or diagnostic.severity is not Severity.ERROR:
            continue
        at = diagnostic.primary.span if diagnostic.primary is not None else None
        around = next((key for key, pou in pous.items() if at is not None and _within(pou.span, at)), None)
        if around is None:
            incomplete = True
        elif _in_body(pous[around], at) and not beyond:
            damaged.add(around)
        else:
            torn.add(around)
    return incomplete, frozenset(torn), frozenset(damaged)


def _within(outer: Span, at: Span) -> bool:
    # Readers of XML make twins of a text that are as long as it: the path says whether it is the same.
    return at.source.path == outer.source.path and outer.start <= at.start < outer.end


def _in_body(pou: ast.Pou, at: Span) -> bool:
    """A body may begin with rungs that were not understood, so the declarations decide."""
    declared = max((block.span.end for block in pou.var_blocks), default=pou.name_span.end)
    return at.start >= max(declared, pou.body.span.start)
