"""Programs that are called, and connections of programs, in terms of function blocks (docs/st.md).

Some editors let a POU call a PROGRAM, which has one memory for all callers; the standard connects pins of a
program where it is put into a task, ``PROGRAM p WITH t : main(x := g, y => h);`` (2nd edition, 2.7.1). Both
make a function block of the program, with a global instance of the name of the program or of what the task
runs; the task runs a program that calls it. Addresses in such a program are completed by VAR_CONFIG.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

from ldc.free_names import claimed
from ldc.library import blocks
from ldc.model.instance_config import block_of
from ldc.model.paths import paths_in
from ldc.model.rewrite import mapped, nodes
from ldc.parser import ast, statements
from ldc.parser.unparse import argument_text
from ldc.patterns import Pattern
from ldc.records import replace
from ldc.source import SourceFile, Span


def with_blocks(project: ast.Project) -> ast.Project:
    """The project with a function block for each program that is called or connected; itself when there is
    none."""
    programs = {p.name.upper(): p for file in project.files for p in file.pous if p.kind == "PROGRAM"}
    runs = [run for configuration in _configurations(project) for resource in configuration.resources
            for run in resource.programs]
    called = set(_called(project, programs))
    chosen = called | {run.pou.upper() for run in runs if run.connections and run.pou.upper() in programs}
    if not chosen:
        return project
    return _Blocks(project, {key: programs[key] for key in programs if key in chosen}, called, runs).project()


def _configurations(project: ast.Project) -> list[ast.Configuration]:
    return [configuration for file in project.files for configuration in file.configurations]


class _Blocks:
    """``blocks``: the name of the function block that each program becomes; ``instances``: the names of its
    instances; ``runners``: for each thing that a task runs, the program that it is now; ``reached``: what
    other POUs name of each instance, in capitals."""

    def __init__(self, project: ast.Project, chosen: Mapping[str, ast.Pou], called: set[str],
                 runs: list[ast.ProgramInstance]) -> None:
        self.given, self.chosen = project, chosen
        self.pous = {p.name.upper() for file in project.files for p in file.pous}
        taken = {p.name.upper() for file in project.files for p in (*file.pous, *file.types)}
        taken |= {v.name.upper() for file in project.files for block in file.globals for v in block.variables}
        taken |= {run.name.upper() for run in runs}
        self.blocks: dict[str, str] = {}
        self.instances: dict[str, list[str]] = {}
        self.runners: dict[int, ast.Pou] = {}
        for key, pou in chosen.items():
            self.blocks[key] = claimed(f"{pou.name}_block", taken)
            self.instances[key] = [pou.name] if key in called else []
        for run in runs:
            key = run.pou.upper()
            if key not in chosen:
                continue
            if key not in called:
                self.instances[key].append(run.name)
            instance = self.instances[key][0] if key in called else run.name
            self.runners[id(run)] = _runner(run, instance, claimed(f"{run.name}_run", taken))

        self.reached: dict[str, set[str]] = {name.upper(): set() for names in self.instances.values()
                                             for name in names}
        for pou in (pou for file in project.files for pou in file.pous):
            for first, second in paths_in(pou):
                if first in self.reached and pou.name.upper() != first:
                    self.reached[first].add(second)

    def project(self) -> ast.Project:
        return ast.Project(tuple(self._file(file) for file in self.given.files))

    def _file(self, file: ast.File) -> ast.File:
        pous, shared = [], list(file.globals)
        for pou in file.pous:
            pou = self._calling(pou)
            key = pou.name.upper()
            if self.chosen.get(key) is None or self.chosen[key].span is not pou.span:
                pous.append(pou)
                continue
            block, located = _without_addresses(self._shown(pou, key))
            pous.append(replace(block, kind="FUNCTION_BLOCK", name=self.blocks[key], written=pou.name))
            type_ = ast.NamedType(self.blocks[key], None, pou.name_span)
            for name in self.instances[key]:
                declared = ast.VarDecl(name, None, type_, None, pou.name_span, pou.name_span)
                shared.append(ast.VarBlock("VAR_GLOBAL", (), (declared,), pou.name_span))
                placed = tuple(replace(v, name=f"{name}.{v.name}", initial=None) for v in located)
                shared += [ast.VarBlock("VAR_CONFIG", (), placed, pou.name_span)] if placed else []
        configurations = tuple(map(self._configuration, file.configurations))
        for resource in (r for c in file.configurations for r in c.resources):
            pous += [self.runners[id(run)] for run in resource.programs if id(run) in self.runners]
        return replace(file, pous=tuple(pous), globals=tuple(shared), configurations=configurations)

    def _shown(self, pou: ast.Pou, key: str) -> ast.Pou:
        """The POU in which variables that others read by its name are outputs."""
        wanted = set().union(*(self.reached.get(name.upper(), ()) for name in self.instances[key]))
        made = []
        for block in pou.var_blocks:
            shown = tuple(v for v in block.variables if v.name.upper() in wanted and v.location is None
                          and not self._is_block(v.type))
            if block.kind != "VAR" or "CONSTANT" in block.qualifiers or not shown:
                made.append(block)
                continue
            made.append(replace(block, variables=tuple(v for v in block.variables if v not in shown)))
            made.append(replace(block, kind="VAR_OUTPUT", variables=shown))
        return replace(pou, var_blocks=tuple(made))

    def _is_block(self, type_: ast.TypeExpr) -> bool:
        """Whether the type is a function block, which is no output."""
        name = block_of(type_)
        return name in self.pous or blocks.signature(name) is not None

    def _configuration(self, node: ast.Configuration) -> ast.Configuration:
        return replace(node, resources=tuple(
            replace(resource, programs=tuple(map(self._run, resource.programs)))
            for resource in node.resources))

    def _run(self, run: ast.ProgramInstance) -> ast.ProgramInstance:
        runner = self.runners.get(id(run))
        return run if runner is None else replace(run, name=runner.name, pou=runner.name, connections=())

    def _calling(self, pou: ast.Pou) -> ast.Pou:
        """The POU, in whose ladders a called program is drawn as an instance."""
        if not any(isinstance(part, ast.Block) for part in _calls(pou, self.chosen)):
            return pou
        return replace(pou, body=mapped(pou.body, self._drawn), actions=mapped(pou.actions, self._drawn))

    def _drawn(self, old: object, node: object) -> object:
        if not isinstance(node, ast.Block) or node.instance is not None:
            return node
        key = node.type.upper()
        if key not in self.chosen:
            return node
        return replace(node, instance=ast.Name(self.chosen[key].name, node.span), type=self.blocks[key])


def _runner(run: ast.ProgramInstance, instance: str, name: str) -> ast.Pou:
    """The program that calls an instance as its task did. Its body has a text, which exports take."""
    call = statements.Invoke(ast.Name(instance, run.span), run.connections, run.span)
    text = f"\n    {instance}({', '.join(map(argument_text, run.connections))});\n"
    body = statements.StatementBody((call,), Span(SourceFile(run.span.source.path, text), 0, len(text)))
    return ast.Pou("PROGRAM", name, None, None, (), body, run.span, run.span)


def _without_addresses(pou: ast.Pou) -> tuple[ast.Pou, list[ast.VarDecl]]:
    """A POU whose addresses are left open, and the variables with what they had."""
    made, located = [], []
    for block in pou.var_blocks:
        fixed = [v for v in block.variables if v.location is not None and not v.location.endswith("*")]
        located += fixed
        made.append(replace(block, variables=tuple(
            replace(v, location=f"{v.location[:2]}*") if v in fixed else v for v in block.variables))
            if fixed else block)
    return replace(pou, var_blocks=tuple(made)), located


# ---- who calls


def _called(project: ast.Project, programs: Mapping[str, ast.Pou]) -> Iterator[str]:
    """The programs that POUs call, in capitals."""
    if not programs:
        return
    hinted: dict[SourceFile, bool] = {}
    for pou in (pou for file in project.files for pou in file.pous):
        source = pou.span.source
        if source not in hinted:
            hinted[source] = _hints(source.text.upper(), programs)
        if hinted[source]:
            for call in _calls(pou, programs):
                yield call.upper() if isinstance(call, str) else _name(call)


def _hints(text: str, programs: Iterable[str]) -> bool:
    """Whether a text, in capitals, may call one of the programs: to look is cheaper than to walk."""
    for name in programs:
        at = text.find(name)
        while at >= 0:
            end = at + len(name)
            before, behind = text[max(at - 12, 0) : at].rstrip(), text[end : end + 40].lstrip()
            if behind[:1] == "(" or before.endswith(("CAL", "CALC", "CALCN")):
                return True
            tag = text.rfind("<", 0, at) + 1
            if before.endswith(('TYPENAME="', "TYPENAME='")) and text.startswith("BLOCK", tag):
                return True
            at = text.find(name, at + 1)
    return False


def _calls(pou: ast.Pou, programs: Mapping[str, object]) -> Iterator[statements.Invoke | ast.Block | str]:
    """The calls of programs in the bodies of a POU; of Instruction List their names."""
    own = {v.name.upper() for block in pou.var_blocks
           for v in block.variables if block.kind != "VAR_EXTERNAL"}
    for node in nodes((pou.body, pou.actions)):
        if isinstance(node, ast.TextBody):
            yield from (name for name in _CALLED.findall(node.span.text) if name.upper() in programs)
        elif isinstance(node, statements.Invoke | ast.Block):
            name = _name(node)
            if name in programs and name not in own:
                yield node


_CALLED = Pattern(r"\bCAL(?:C|CN)?\s+(\w+)", re.IGNORECASE)


def _name(node: statements.Invoke | ast.Block) -> str:
    """What is called, in capitals, where it is no instance."""
    if isinstance(node, ast.Block):
        return node.type.upper() if node.instance is None else ""
    return node.callee.name.upper() if isinstance(node.callee, ast.Name) else ""
