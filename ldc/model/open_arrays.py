"""Parameters `ARRAY [*] OF type` (IEC 61131-3, 3rd edition, 6.5.3): a POU that has them is declared once for
each shape of arrays that calls give it, so that all that follows knows arrays with bounds only.

The first shape keeps the name of the POU, others get their bounds behind it: ``mean``, ``mean_0_9``. An
instance of a function block has one shape. A POU that nobody calls is compiled for a shape of its own, so
that it is checked.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence

from ldc.diagnostics import Diagnostics
from ldc.expr import IndexStep, Place
from ldc.free_names import free_name
from ldc.model import declaration_findings as findings
from ldc.model import places
from ldc.model.frame import Frame
from ldc.model.rewrite import mapped, nodes
from ldc.parser import ast, statements
from ldc.patterns import Pattern
from ldc.records import record, replace
from ldc.source import SourceFile, Span
from ldc.types import Array, Instance, Type

_PARAMETERS = {"FUNCTION": ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT"),
               "FUNCTION_BLOCK": ("VAR_INPUT", "VAR_IN_OUT")}

Bounds = tuple[tuple[int, int], ...]
Shape = tuple[Bounds, ...]
"""The bounds of each parameter without bounds, in declared order."""
Declared = Callable[[str], Frame | None]
"""The declarations of a POU, by its name in capitals."""


def with_bounds(
    project: ast.Project, diagnostics: Diagnostics, declared: Callable[[ast.Project], Declared]
) -> ast.Project:
    """The project in which every parameter has bounds; itself when all have. ``declared``: of a project."""
    pous = [pou for file in project.files for pou in file.pous]
    opened = {pou.name.upper(): pou for pou in pous if any(True for _ in _open_in(pou))}
    return _Shaping(project, opened, diagnostics, declared).project() if opened else project


def _open_in(pou: ast.Pou) -> Iterator[ast.VarDecl]:
    """The parameters without bounds."""
    kinds = _PARAMETERS.get(pou.kind, ())
    return (v for block in pou.var_blocks if block.kind in kinds for v in block.variables if _is_open(v.type))


def _is_open(type_: ast.TypeExpr) -> bool:
    return isinstance(type_, ast.ArrayType) and None in type_.bounds


@record
class _Given:
    """The shape that an instance is first called with, by which arrays, where, and the function block that it
    is of."""

    shape: Shape
    arrays: tuple[ast.Expr, ...]
    span: Span
    block: str


class _Shaping:
    """``made``: by POU (capitals) the names and trees of its versions, by shape; ``shared``: how global
    instances are called."""

    def __init__(self, project: ast.Project, opened: dict[str, ast.Pou], diagnostics: Diagnostics,
                 declared: Callable[[ast.Project], Declared]) -> None:
        self.given, self.opened, self.diagnostics, self.declared = project, opened, diagnostics, declared
        self.taken = {one.name.upper() for file in project.files for one in (*file.pous, *file.types)}
        self.made: dict[str, dict[Shape, ast.Pou]] = {key: {} for key in opened}
        self.shared: dict[str, _Given] = {}
        self.new: list[ast.Pou] = []

    def project(self) -> ast.Project:
        done: dict[int, ast.Pou] = {}
        todo = [p for file in self.given.files for p in file.pous if self.opened.get(p.name.upper()) is not p]
        while todo or self._uncalled():
            todo += self.new
            self.new = []
            declared = self.declared(self._with(lambda pou: pou, self.given.files))
            for pou in todo:
                done[id(pou)] = self._calling(pou, declared(pou.name.upper()))
            todo = self.new
            self.new = []
        types = {name: given.block for name, given in self.shared.items()}
        files = [replace(file, globals=_retyped(file.globals, types, ("VAR_GLOBAL",)),
                         configurations=tuple(_configuration(c, types) for c in file.configurations))
                 for file in self.given.files]
        return self._with(lambda pou: replace(done[id(pou)], var_blocks=_retyped(
            done[id(pou)].var_blocks, types, ("VAR_EXTERNAL",))), files)

    def _with(self, change: Callable[[ast.Pou], ast.Pou], files: Sequence[ast.File]) -> ast.Project:
        """The files with the versions that are made by now."""
        return ast.Project(tuple(
            replace(file, pous=tuple(change(made) for pou in file.pous for made in self._of(pou)))
            for file in files))

    def _of(self, pou: ast.Pou) -> Sequence[ast.Pou]:
        key = pou.name.upper()
        if self.opened.get(key) is not pou:
            return (pou,)
        return tuple(self.made[key].values()) or (_bounded(pou, pou.name, _usual(pou)),)

    def _uncalled(self) -> bool:
        """Make a version of a POU that nobody calls; whether there was one."""
        pou = next((pou for key, pou in self.opened.items() if not self.made[key]), None)
        if pou is not None:
            self._version(pou, _usual(pou))
        return pou is not None

    def _version(self, pou: ast.Pou, shape: Shape) -> str:
        """The name of the POU for a shape."""
        made = self.made[pou.name.upper()]
        if shape not in made:
            name = free_name(f"{pou.name}_{_named(shape)}", self.taken) if made else pou.name
            self.taken.add(name.upper())
            made[shape] = _bounded(pou, name, shape)
            self.new.append(made[shape])
        return made[shape].name

    # ---- calls

    def _calling(self, pou: ast.Pou, frame: Frame | None) -> ast.Pou:
        """The POU whose calls name versions, and whose instances are of them."""
        if frame is None:
            return pou
        names: dict[int, str | ast.Expr] = {}
        own: dict[str, _Given] = {}
        result = pou.written.upper() if pou.kind == "FUNCTION" and pou.name != pou.written else ""
        for node in nodes((pou.body, pou.actions)):
            if isinstance(node, ast.Name) and node.name.upper() == result:
                names[id(node)] = pou.name  # the variable of the result is called like the FUNCTION
            called = self._called(node, frame)
            arrays = () if called is None else _arrays(self.opened[called[0]], node)
            shape = None if called is None else _shape(self.opened[called[0]], arrays, frame)
            if shape is None:
                continue
            key, instance = called
            if instance is None:
                callee = node.callee if isinstance(node, statements.Invoke) else node
                names[id(callee)] = self._version(self.opened[key], shape)
                continue
            held = self.shared if instance.is_global else own
            first = held.get(instance.root.upper())
            if first is None:
                first = _Given(shape, arrays, node.span, self._version(self.opened[key], shape))
                held[instance.root.upper()] = first
            elif first.shape != shape:
                findings.other_bounds(self.diagnostics, node.span, instance.root, first.span)
                names |= {id(array): told for array, told in zip(arrays, first.arrays, strict=True)}
            if isinstance(node, ast.Block):
                names[id(node)] = first.block
        types = {name: given.block for name, given in own.items()}
        return replace(pou, body=_renamed(pou.body, names), actions=_renamed(pou.actions, names),
                       var_blocks=_retyped(pou.var_blocks, types, ("VAR",)))

    def _called(self, node: object, frame: Frame) -> tuple[str, Place | None] | None:
        """Which POU is called (capitals), and the instance of a function block."""
        match node:
            case ast.Call(name=name) | ast.Block(instance=None, type=name):
                instance = None
            case statements.Invoke(callee=ast.Name(name=name)) if name.upper() in self.opened:
                instance = None
            case ast.Block(instance=instance) | statements.Invoke(callee=instance):
                name = ""
            case _:
                return None
        if instance is None:
            known = self.opened.get(name.upper())
            return None if known is None or known.kind != "FUNCTION" else (name.upper(), None)
        place = places.place(frame, instance, Diagnostics())
        if place is None or not isinstance(place.type, Instance) or place.type.pou not in self.opened:
            return None
        return (place.type.pou, place) if all(isinstance(step, IndexStep) for step in place.steps) else None


def _usual(pou: ast.Pou) -> Shape:
    """What a POU is compiled for that nobody calls."""
    return tuple((((-100, 100) if len(v.type.bounds) == 1 else (-5, 5)),) * len(v.type.bounds)
                 for v in _open_in(pou))


def _named(shape: Shape) -> str:
    bounds = (f"{low}_{high}" for bounds in shape for low, high in bounds)
    return "_".join(bounds).replace("-", "m")


def _bounded(pou: ast.Pou, name: str, shape: Shape) -> ast.Pou:
    """The POU for a shape; what its body names is not looked at yet."""
    bounds = iter(shape)
    kinds = _PARAMETERS[pou.kind]
    blocks = tuple(replace(block, variables=tuple(
        replace(v, type=_closed(v.type, next(bounds))) if block.kind in kinds and _is_open(v.type) else v
        for v in block.variables)) for block in pou.var_blocks)
    return replace(pou, name=name, var_blocks=blocks, written=pou.name)


def _closed(type_: ast.ArrayType, bounds: Bounds) -> ast.ArrayType:
    made = tuple(tuple(ast.Literal(n, None, str(n), type_.span) for n in given) if written is None
                 else written
                 for written, given in zip(type_.bounds, bounds, strict=True))
    return replace(type_, bounds=made)


def _arrays(pou: ast.Pou, node: ast.Call | statements.Invoke | ast.Block) -> tuple[ast.Expr | None, ...]:
    """What a call gives to the parameters without bounds."""
    drawn = isinstance(node, ast.Block)
    kinds = ("VAR_INPUT",) if drawn else ("VAR_INPUT", "VAR_IN_OUT")
    inputs = [v for block in pou.var_blocks if block.kind in kinds for v in block.variables]
    if drawn and pou.kind == "FUNCTION_BLOCK" and node.power_in != "_":
        bools = (v for v in inputs if isinstance(v.type, ast.NamedType) and v.type.name.upper() == "BOOL")
        wanted = node.power_in and node.power_in.upper()
        power = next((v for v in bools if wanted is None or v.name.upper() == wanted), None)
        inputs = [v for v in inputs if v is not power]
    names = iter(v.name for v in inputs)
    given = {(pin.name or next(names, "")).upper(): pin.value
             for pin in (node.pins if drawn else node.arguments)}
    return tuple(given.get(parameter.name.upper()) for parameter in _open_in(pou))


def _shape(pou: ast.Pou, arrays: Sequence[ast.Expr | None], frame: Frame) -> Shape | None:
    """The bounds of the arrays; None when one is no array of as many dimensions."""
    found = []
    for parameter, array in zip(_open_in(pou), arrays, strict=True):
        type_ = _type(array, frame)
        if not isinstance(type_, Array) or len(type_.bounds) != len(parameter.type.bounds):
            return None
        found.append(type_.bounds)
    return tuple(found)


def _type(node: object, frame: Frame) -> Type | None:
    """The type of a variable, or of what a FUNCTION returns."""
    if isinstance(node, ast.Call):
        signature = frame.signature(node.name.upper())
        return None if signature is None else signature.result
    if not isinstance(node, ast.Name | ast.Member | ast.Index):
        return None
    place = places.place(frame, node, Diagnostics())
    return None if place is None else place.type


# ---- trees with other names


def _renamed(tree, names: dict[int, str | ast.Expr]):
    """Bodies in which the nodes (by identity) name another POU, or are others. Such a body has a text of its
    own, which is read for the order of calls and for exports."""
    if not names:
        return tree
    spans: list[tuple[Span, str]] = []

    def change(old: object, new: object) -> object:
        name = names.get(id(old))
        if name is not None and not isinstance(name, str):
            return name
        if name is not None:
            spans.append((old.span, name))
            return replace(new, type=name) if isinstance(new, ast.Block) else replace(new, name=name)
        if new is not old and isinstance(new, statements.StatementBody | ast.LadderBody):
            return replace(new, span=_text(old.span, spans))
        return new

    return mapped(tree, change)


def _text(body: Span, changed: list[tuple[Span, str]]) -> Span:
    """The text of a body with other words where names are changed; each span begins with the old one."""
    text, pieces, done = body.text, [], 0
    for at, name in sorted((span.start - body.start, name)
                           for span, name in changed if span.source is body.source):
        word = _WORD.match(text, at) if 0 <= at < len(text) else None
        if word is not None:
            pieces += text[done:at], name
            done = word.end()
    made = "".join((*pieces, text[done:]))
    return Span(SourceFile(body.source.path, made), 0, len(made))


_WORD = Pattern(r"[A-Za-z_]\w*", re.ASCII)


def _retyped(blocks: Sequence[ast.VarBlock], types: dict[str, str], kinds: Sequence[str]
             ) -> tuple[ast.VarBlock, ...]:
    """Declarations in which variables (capitals) are instances of other function blocks."""
    return tuple(replace(block, variables=tuple(
        replace(v, type=_instance(v.type, types[v.name.upper()])) if v.name.upper() in types else v
        for v in block.variables)) if types and block.kind in kinds else block for block in blocks)


def _instance(type_: ast.TypeExpr, name: str) -> ast.TypeExpr:
    if isinstance(type_, ast.ArrayType):
        return replace(type_, element=_instance(type_.element, name))
    return replace(type_, name=name)


def _configuration(node: ast.Configuration, types: dict[str, str]) -> ast.Configuration:
    kinds = ("VAR_GLOBAL",)
    return replace(node, var_blocks=_retyped(node.var_blocks, types, kinds), resources=tuple(
        replace(r, var_blocks=_retyped(r.var_blocks, types, kinds)) for r in node.resources))
