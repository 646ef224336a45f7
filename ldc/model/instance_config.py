"""VAR_CONFIG: addresses and initial values of single instances (IEC 61131-3, 2nd edition, 2.7.1; 3rd, 6.8.2).

A program or function block leaves an address open, ``x AT %I* : BOOL;``, and VAR_CONFIG completes it for an
instance by its path. What such an instance declares is its own: its POU is declared once more with these
addresses and values, the bodies are the same. All other instances share the POU itself; where there are none,
the first one that is configured keeps it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping

from ldc.diagnostics import Diagnostics
from ldc.free_names import claimed
from ldc.model import declaration_findings as findings
from ldc.model.frame import HANDED
from ldc.model.project import Model
from ldc.parser import ast
from ldc.parser.unparse import type_text
from ldc.records import entity, field, replace

MOST = 10_000
"""Instances with something of their own."""
_DEEPEST = 100
_OPEN = "*"
_PLACED = ("VAR", "VAR_GLOBAL")


@entity
class _Entry:
    """What VAR_CONFIG says about a path, and about what is inside of it (by names in capitals)."""

    declared: ast.VarDecl | None = None
    inner: dict[str, _Entry] = field(default_factory=dict)
    used: bool = False


def configured(project: ast.Project, diagnostics: Diagnostics) -> ast.Project:
    """The project in which instances have their addresses and values; itself when nothing is to be done."""
    shared = [block for file in project.files for block in file.shared()]
    written = [v for block in shared if block.kind == "VAR_CONFIG" for v in block.variables]
    own = (block for file in project.files for pou in file.pous for block in pou.var_blocks)
    if not written and not any(_is_open(v) for block in (*shared, *own) for v in block.variables):
        return project
    found = _Configuring(project, Diagnostics(), written, None)
    found.project()
    return _Configuring(project, diagnostics, written, found.plain).project()


def with_places(model: Model, nodes: dict[str, ast.Pou]) -> Model:
    """The model in which variables of function blocks that have an address are global variables, which are
    called by their paths. ``nodes``: what the POUs were made of, by names in capitals."""
    shared, made = dict(model.globals), {}
    for key, pou in model.pous.items():
        declared = (v for block in nodes[key].var_blocks for v in block.variables if v.path)
        paths = {v.name.upper(): v.path for v in declared if v.name.upper() in pou.variables}
        if not paths:
            continue
        variables = dict(pou.variables)
        for name, path in paths.items():
            variable = variables[name]
            shared[path.upper()] = replace(variable, name=path, kind="global")
            variables[name] = replace(variable, name=path, kind="external", initial=None, retain=False)
        made[key] = replace(pou, variables=variables)
    return replace(model, pous=model.pous | made, globals=shared) if made else model


def _is_open(declared: ast.VarDecl) -> bool:
    return declared.location is not None and declared.location.endswith(_OPEN)


def block_of(type_: ast.TypeExpr) -> str:
    """The name of the type of an instance, or of the elements of an array, in capitals."""
    while isinstance(type_, ast.ArrayType):
        type_ = type_.element
    return type_.name.upper() if isinstance(type_, ast.NamedType) else ""


class _Configuring:
    """``shared``: POUs (capitals) of which there are instances with nothing of their own, each with the path
    of one; None while these are looked for. ``plain`` are those that are found."""

    def __init__(self, project: ast.Project, diagnostics: Diagnostics, written: Iterable[ast.VarDecl],
                 shared: Mapping[str, str] | None) -> None:
        self.given, self.diagnostics = project, diagnostics
        self.pous = {pou.name.upper(): pou for file in project.files for pou in file.pous}
        self.configuration = next((c for file in project.files for c in file.configurations), None)
        self.shared, self.plain = shared, dict[str, str]()
        self.root = _Entry()
        self.own: dict[str, ast.Pou] = {}
        self.further: dict[str, list[ast.Pou]] = defaultdict(list)
        self.chain: list[str] = []
        self.versions = 0
        self.taken = {type_.name.upper() for file in project.files for type_ in file.types} | set(self.pous)
        self.open = self._open()
        self.plain |= {block_of(v.type): t.name for file in project.files for t in file.types
                       if isinstance(t.type, ast.StructType) for v in t.type.fields}
        self.found = list(self.plain)
        for declared in written:
            self._enter(declared)

    def _open(self) -> set[str]:
        """POUs with an open address in them or in one of their instances."""
        users: dict[str, list[str]] = defaultdict(list)
        found: set[str] = set()
        for key, pou in self.pous.items():
            for block in pou.var_blocks:
                for declared in block.variables:
                    users[block_of(declared.type)].append(key)
                    if _is_open(declared) and block.kind in _PLACED:
                        found.add(key)
        todo = list(found)
        while todo:
            new = set(users[todo.pop()]) - found
            found |= new
            todo += new
        return found

    def _enter(self, declared: ast.VarDecl) -> None:
        parts = declared.name.split(".")
        resources = self.configuration.resources if self.configuration is not None else ()
        if len(parts) > 2 and parts[0].upper() in (resource.name.upper() for resource in resources):
            del parts[0]
        entry = self.root
        for part in parts:
            entry = entry.inner.setdefault(part.upper(), _Entry())
        if entry.declared is not None:
            findings.bad_configured(self.diagnostics, declared.span, f"`{declared.name}` is configured twice",
                                    "again here", "leave one of the two out")
            return
        entry.declared = declared

    # ---- the project

    def project(self) -> ast.Project:
        chosen = {run.name.upper(): self._program(run) for run in self._runs()}
        retyped: dict[str, ast.TypeExpr] = {}
        files = [
            replace(file, globals=self._globals(file.globals, retyped),
                    configurations=tuple(self._configured(c, chosen, retyped) for c in file.configurations))
            for file in self.given.files]
        self._without_places()
        self._unused(self.root)
        return ast.Project(tuple(
            replace(file, pous=tuple(
                _externals(made, retyped) for pou in file.pous for made in self._made(pou)))
            for file in files))

    def _without_places(self) -> None:
        """POUs with open addresses as those instances have them with nothing of their own, or as nobody
        does."""
        for key in self.found:  # grows
            if key in self.open and key not in self.own:
                self.own[key] = self._version(self.pous[key], self.pous[key].name, None, self.plain[key])
        for key in sorted(self.open - set(self.own) - set(self.further)):
            self.own[key] = self._version(self.pous[key], self.pous[key].name, None, "")

    def _made(self, pou: ast.Pou) -> Iterator[ast.Pou]:
        key = pou.name.upper()
        if self.pous[key] is not pou:
            yield pou  # declared twice, which is told elsewhere
            return
        yield self.own.get(key, pou)
        yield from self.further[key]

    def _runs(self) -> tuple[ast.ProgramInstance, ...]:
        if self.configuration is not None:
            return tuple(run for resource in self.configuration.resources for run in resource.programs)
        return tuple(ast.ProgramInstance(pou.name, None, pou.name, pou.name_span)
                     for pou in self.pous.values() if pou.kind == "PROGRAM")

    def _program(self, run: ast.ProgramInstance) -> str:
        key = run.pou.upper()
        if key not in self.pous or self.pous[key].kind != "PROGRAM":
            return run.pou
        alone = sum(other.pou.upper() == key for other in self._runs()) == 1
        return self._instance(key, self.root.inner.get(run.name.upper()), run.name, alone)

    def _configured(self, node: ast.Configuration, chosen: dict[str, str], retyped: dict[str, ast.TypeExpr]
                    ) -> ast.Configuration:
        if node is not self.configuration:
            return node
        resources = tuple(
            replace(resource, var_blocks=self._globals(resource.var_blocks, retyped),
                    programs=tuple(replace(run, pou=chosen[run.name.upper()]) for run in resource.programs))
            for resource in node.resources)
        return replace(node, var_blocks=self._globals(node.var_blocks, retyped), resources=resources)

    def _globals(
        self, blocks: Iterable[ast.VarBlock], retyped: dict[str, ast.TypeExpr]
    ) -> tuple[ast.VarBlock, ...]:
        """The global variables, without VAR_CONFIG. ``retyped``: those that are of another type now, with
        it."""
        made = []
        for block in blocks:
            if block.kind == "VAR_CONFIG":
                continue
            made.append(self._section(block, self.root, "", False))
            retyped.update((new.name.upper(), new.type)
                           for old, new in zip(block.variables, made[-1].variables)
                           if old.type is not new.type)
        return tuple(made)

    # ---- instances

    def _instance(self, key: str, entry: _Entry | None, path: str, alone: bool = False) -> str:
        """The name of the POU that an instance is made of."""
        pou = self.pous[key]
        if entry is None or not entry.inner:
            if key not in self.plain:
                self.plain[key] = path
                self.found.append(key)
            return pou.name
        if key in self.chain or len(self.chain) >= _DEEPEST:
            return pou.name  # in a circle or too deep, which is told elsewhere
        self.versions += 1
        if self.versions > MOST:
            findings.bad_configured(self.diagnostics, pou.name_span,
                                    f"more than {MOST:,} instances have addresses of their own",
                                    "one of them",
                                    "declare fewer instances of it, or give the addresses in VAR_GLOBAL")
            return pou.name
        keeps = self.shared is not None and key not in self.own and key not in self.shared and (
            alone or key in self.open)
        name = pou.name if keeps else self._free(f"{pou.name}_{_identifier(path)}")
        self.chain.append(key)
        made = replace(self._version(pou, name, entry, path), written=pou.name)
        self.chain.pop()
        if keeps:
            self.own[key] = made
        else:
            self.further[key].append(made)
        return name

    def _version(self, pou: ast.Pou, name: str, entry: _Entry | None, path: str) -> ast.Pou:
        inside = pou.kind == "FUNCTION_BLOCK"
        return replace(pou, name=name, var_blocks=tuple(
            self._section(block, entry, f"{path}.", inside) for block in pou.var_blocks))

    def _free(self, wanted: str) -> str:
        return claimed(wanted, self.taken)

    def _section(self, block: ast.VarBlock, entry: _Entry | None, prefix: str, inside: bool) -> ast.VarBlock:
        """A section with what its variables are given. ``inside``: of a function block."""
        if block.kind == "VAR_EXTERNAL":
            return block
        made = []
        for declared in block.variables:
            given = entry.inner.get(declared.name.upper()) if entry is not None else None
            path = f"{prefix}{declared.name}"
            if block.kind in HANDED and block_of(declared.type) in self.open:
                findings.cannot_be_lent(self.diagnostics, declared.span, declared.name,
                                        f"{type_text(declared.type)} has an address that VAR_CONFIG gives")
                made.append(declared)
                continue
            if _is_open(declared) and block.kind in _PLACED:
                made.append(self._placed(declared, given, path, inside))
            else:
                made.append(self._valued(declared, given, path))
        return replace(block, variables=tuple(made))

    def _placed(self, declared: ast.VarDecl, entry: _Entry | None, path: str, inside: bool) -> ast.VarDecl:
        """A variable with an open address."""
        given = self._taken(declared, entry)
        if given is None or given.location is None:
            wrong = given is None and entry is not None and entry.declared is not None  # and told
            if path[0] != "." and not wrong:  # "." : of a POU without instances
                findings.no_place(self.diagnostics, declared.span, path, declared.location,
                                  type_text(declared.type))
            return replace(declared, location=None, initial=_either(given, declared))
        if not given.location.startswith(declared.location.removesuffix(_OPEN)) or _is_open(given):
            begins = declared.location.removesuffix(_OPEN)
            findings.bad_configured(self.diagnostics, given.span,
                                    f"`{given.name}` is declared `AT {declared.location}`",
                                    f"{given.location} here", f"write an address that begins with `{begins}`")
            return replace(declared, location=None)
        return replace(declared, location=given.location, initial=_either(given, declared),
                       path=path if inside else None)

    def _valued(self, declared: ast.VarDecl, entry: _Entry | None, path: str) -> ast.VarDecl:
        """A variable that may have another initial value, or an instance with something in it."""
        key = block_of(declared.type)
        block = key in self.pous and self.pous[key].kind == "FUNCTION_BLOCK"
        if entry is None and not block:
            return declared
        given = self._taken(declared, entry)
        if given is not None and given.location is not None:
            findings.bad_configured(self.diagnostics, given.span,
                                    f"the address of `{given.name}` is not open", given.location,
                                    f"declare it `{declared.name} AT %{given.location[1]}* : "
                                    f"{type_text(declared.type)};` in its POU")
        type_ = declared.type
        if block:
            type_ = self._retyped(type_, entry, path)
        return replace(declared, type=type_, initial=_either(given, declared))

    def _retyped(self, type_: ast.TypeExpr, entry: _Entry | None, path: str) -> ast.TypeExpr:
        """The elements of an array are of one type: they have no addresses of their own."""
        if isinstance(type_, ast.ArrayType):
            element = self._retyped(type_.element, None, f"{path}[]")
            return type_ if element is type_.element else replace(type_, element=element)
        name = self._instance(type_.name.upper(), entry, path)
        return type_ if name.upper() == type_.name.upper() else replace(type_, name=name)

    def _taken(self, declared: ast.VarDecl, entry: _Entry | None) -> ast.VarDecl | None:
        """What VAR_CONFIG says about a variable, if it means its type."""
        if entry is None or entry.declared is None:
            return None
        entry.used = True
        written, wanted = type_text(entry.declared.type), type_text(declared.type)
        if written.upper() == wanted.upper():
            return entry.declared
        findings.bad_configured(self.diagnostics, entry.declared.span,
                                f"`{entry.declared.name}` is {wanted}, not {written}",
                                f"declared as {written} here", f"write `{wanted}`")
        return None

    def _unused(self, root: _Entry) -> None:
        todo = [] if any(file.incomplete for file in self.given.files) else [root]
        while todo:
            entry = todo.pop()
            todo += entry.inner.values()
            node = entry.declared
            if node is None or entry.used:
                continue
            help = "a path leads from an instance of a program through function blocks to a variable: " \
                   "`main.valve.open`"
            if "[" in node.name:
                help = "elements of an array are alike: declare instances with names of their own"
            findings.bad_configured(self.diagnostics, node.span, f"there is no variable `{node.name}`",
                                    "configured here", help)


def _either(given: ast.VarDecl | None, declared: ast.VarDecl) -> ast.Initial | None:
    """The initial value; of an instance, what its declaration says about other members stays."""
    if given is None or given.initial is None:
        return declared.initial
    new, old = given.initial, declared.initial
    if not (isinstance(new, ast.Aggregate) and isinstance(old, ast.Aggregate) and new.fields and old.fields):
        return new
    names = {name.upper() for name, _ in new.fields}
    kept = tuple(part for part in old.fields if part[0].upper() not in names)
    return replace(new, fields=kept + new.fields)


def _externals(pou: ast.Pou, retyped: dict[str, ast.TypeExpr]) -> ast.Pou:
    """A POU that names the types that global instances have now."""
    if not retyped:
        return pou
    sections = []
    for block in pou.var_blocks:
        if block.kind == "VAR_EXTERNAL":
            typed = (replace(v, type=retyped.get(v.name.upper(), v.type)) for v in block.variables)
            block = replace(block, variables=tuple(typed))
        sections.append(block)
    return replace(pou, var_blocks=tuple(sections))


def _identifier(path: str) -> str:
    return "_".join(part for part in path.replace("[]", "").split(".") if part).strip("_")
