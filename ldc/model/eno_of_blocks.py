"""``timer.ENO`` in Structured Text: whether the last call of an instance was made (docs/st.md).

Generators of texts from drawings read EN of one block from ENO of another. A variable of its own takes ENO of all
calls of such an instance, and is read for it.
"""

from __future__ import annotations

from ldc.free_names import claimed
from ldc.library import blocks
from ldc.model.rewrite import mapped, nodes
from ldc.parser import ast, statements
from ldc.records import replace
from ldc.source import SourceFile

_SPELLINGS = (".ENO", ".eno", ".Eno")


def with_enables(project: ast.Project) -> ast.Project:
    """The project in which a variable is read for each ENO of an instance; itself when there is none."""
    hinted: dict[SourceFile, bool] = {}
    made: dict[int, ast.Pou] = {}
    own: dict[str, bool] | None = None
    for pou in (pou for file in project.files for pou in file.pous):
        text = pou.span.source
        if text not in hinted:
            hinted[text] = any(word in text.text for word in _SPELLINGS)
        if not hinted[text]:
            continue
        if own is None:
            own = {p.name.upper(): _declares(p) for file in project.files for p in file.pous
                   if p.kind == "FUNCTION_BLOCK"}
        changed = _told(pou, own)
        if changed is not pou:
            made[id(pou)] = changed
    if not made:
        return project
    return ast.Project(tuple(
        replace(file, pous=tuple(made.get(id(pou), pou) for pou in file.pous)) for file in project.files))


def _declares(pou: ast.Pou) -> bool:
    """Whether a function block has a pin ENO of its own."""
    return any(v.name.upper() == "ENO" for block in pou.var_blocks for v in block.variables)


def _told(pou: ast.Pou, own: dict[str, bool]) -> ast.Pou:
    """The POU with a variable for ENO of each instance that is asked for it. ``own``: for each function block of
    the project whether it has a pin ENO itself."""
    instances = {v.name.upper(): v.name for block in pou.var_blocks if block.kind == "VAR" for v in block.variables
                 if isinstance(v.type, ast.NamedType) and _tells(v.type.name.upper(), own)}
    if not instances:
        return pou
    bodies = (pou.body, pou.actions)
    asked, enabled = set(), set()
    for node in nodes(bodies):
        if isinstance(node, ast.LadderBody | ast.TextBody):
            return pou
        if (key := _asked(node)) in instances:
            asked.add(key)
        if isinstance(node, statements.Invoke) and _enabled(node):
            enabled.add(_called(node))
    asked -= enabled
    if not asked:
        return pou
    taken = {v.name.upper() for block in pou.var_blocks for v in block.variables}
    taken |= {node.name.upper() for node in nodes(bodies) if isinstance(node, ast.Name)}
    names = {key: claimed(f"{instances[key]}_ENO", taken) for key in sorted(asked)}

    def change(old: object, node: object) -> object:
        if isinstance(node, ast.Member) and _asked(node) in names:
            return ast.Name(names[_asked(node)], node.span)
        if isinstance(node, statements.Invoke) and _called(node) in names:
            target = ast.Name(names[_called(node)], node.callee.span)
            return replace(node, arguments=(*node.arguments, ast.Argument("ENO", target, True, target.span)))
        return node

    at, type_ = pou.name_span, ast.NamedType("BOOL", None, pou.name_span)
    hidden = tuple(ast.VarDecl(name, None, type_, None, at, at) for name in names.values())
    return replace(pou, var_blocks=(*pou.var_blocks, ast.VarBlock("VAR", (), hidden, at)),
                   body=mapped(pou.body, change), actions=mapped(pou.actions, change))


def _tells(type_: str, own: dict[str, bool]) -> bool:
    """Whether ENO of a type is that of its calls."""
    return not own[type_] if type_ in own else blocks.signature(type_) is not None


def _asked(node: object) -> str:
    """The instance (capitals) whose ENO a node reads."""
    reads = isinstance(node, ast.Member) and node.name.upper() == "ENO" and isinstance(node.base, ast.Name)
    return node.base.name.upper() if reads else ""


def _called(node: statements.Invoke) -> str:
    return node.callee.name.upper() if isinstance(node.callee, ast.Name) else ""


def _enabled(node: statements.Invoke) -> bool:
    """Whether a call gives its ENO somewhere itself."""
    return any(a.name is not None and a.name.upper() == "ENO" for a in node.arguments)
