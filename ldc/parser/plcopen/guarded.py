"""Blocks that are called only with power at EN: a function block around what is called.

A function block has no EN of its own. One that is drawn with EN becomes an instance of `TYPE_EN`, which
calls the block inside of it when EN is TRUE; statements that are drawn as a block become a function block
too, which gets the variables that they use, and so does a chart inside of an action.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from functools import cache

from ldc.library import blocks
from ldc.parser import ast, sfc
from ldc.parser import statements as st
from ldc.records import entity, field, replace
from ldc.source import Span
from ldc.types import Elementary

_PINS = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")
Pins = dict[str, tuple[ast.VarDecl, ...]]


@entity
class Additions:
    """What the rungs of a POU need beside what is declared. ``interfaces``: pins of the function blocks of
    the project, by name in capitals; ``functions``: those of the functions; ``local``: variables of the
    POU; ``retyped``: other types for these;
    ``numbers``: types of the variables that are integers or bit strings, when they may be mixed;
    ``prefix``: of the names of function blocks that are made; ``added``: names of instances, in capitals;
    ``actions``: names in capitals of the actions in the file that may be called; ``fixed``: those of the
    variables that the POU may not write."""

    interfaces: dict[str, Pins] = field(default_factory=dict)
    local: Mapping[str, ast.VarDecl] = field(default_factory=dict)
    variables: list[ast.VarDecl] = field(default_factory=list)
    retyped: dict[str, str] = field(default_factory=dict)
    pous: dict[str, ast.Pou] = field(default_factory=dict)
    prefix: str = ""
    functions: Mapping[str, Pins] = field(default_factory=dict)
    added: set[str] = field(default_factory=set)
    numbers: Mapping[str, Elementary] = field(default_factory=dict)
    actions: Set[str] = frozenset()
    fixed: Set[str] = frozenset()

    def inside(self) -> Additions:
        """For a body that becomes a function block of its own: what it needs is declared there."""
        return Additions(self.interfaces, self.local, [], self.retyped, self.pous, self.prefix,
                         self.functions, set(), self.numbers, self.actions, self.fixed)

    def has_pin(self, type_: str, pin: str) -> bool:
        """Whether a function block of the project declares a pin of this name."""
        pins = self.interfaces.get(type_.upper(), {})
        return any(v.name.upper() == pin for group in pins.values() for v in group)

    def fresh(self, wanted: str) -> str:
        """A name for an instance that is added: the bodies of one POU number their elements alike."""
        name, number = wanted, 1
        while name.upper() in self.local or name.upper() in self.added:
            number += 1
            name = f"{wanted}_{number}"
        self.added.add(name.upper())
        return name

    def guard(self, instance: str, type_: str, span: Span) -> str:
        """The type that an instance takes to be called under EN; its own when that is not possible."""
        pins = self.interfaces.get(type_.upper()) or _library_pins(type_, span)
        if pins is None or instance.upper() not in self.local:
            return type_
        name = f"{self.prefix}{type_}_EN"
        self.retyped[instance.upper()] = name
        self.pous.setdefault(name.upper(), _around(name, type_, pins, span))
        return name

    def execute(self, name: str, instance: str, body: st.StatementBody, span: Span) -> list[ast.Pin]:
        """A function block of statements and an instance of it; the pins that give it its variables."""
        written = {n.upper() for n in _written(body.statements)}
        used = {n.name.upper(): n for n in nodes(body.statements, ast.Name) if n.name.upper() in self.local}
        found = {key: replace(self.local[key], location=None, initial=None, edge=None) for key in used}
        pins: Pins = {"VAR_INPUT": tuple(v for key, v in found.items() if key not in written),
                      "VAR_IN_OUT": tuple(v for key, v in found.items() if key in written), "VAR_OUTPUT": ()}
        self.pous[name.upper()] = _function_block(name, pins, (), body.statements, span)
        self.variables.append(_declare(instance, name, span))
        return [ast.Pin(v.name, ast.Name(v.name, span), False, span) for v in found.values()]

    def chart(self, name: str, wanted: str, body: sfc.SfcBody, own: list[ast.VarDecl], others: Set[str],
              span: Span) -> st.StatementBody:
        """A function block that is a chart, and the call of an instance of it. It has the variables ``own``,
        and is given those of the POU that it uses; but instances that no ``others`` use are its own too."""
        used = {n.name.upper() for n in nodes(body, ast.Name)} - {v.name.upper() for v in own}
        found = {key: replace(declared, location=None, initial=None, edge=None)
                 for key, declared in self.local.items() if key in used}
        own = [*own, *(found.pop(key) for key in list(found) if key not in others and self._is_instance(key))]
        pins = {"VAR_INPUT": tuple(v for key, v in found.items() if key in self.fixed),
                "VAR_IN_OUT": tuple(v for key, v in found.items() if key not in self.fixed),
                "VAR": tuple(own)}
        sections = tuple(ast.VarBlock(kind, (), group, span) for kind, group in pins.items() if group)
        self.pous[name.upper()] = ast.Pou("FUNCTION_BLOCK", name, None, None, retype(sections, self.retyped),
                                          body, span, span)
        instance = self.fresh(wanted)
        self.variables.append(_declare(instance, name, span))
        given = tuple(ast.Argument(v.name, ast.Name(v.name, span), False, span) for v in found.values())
        return st.StatementBody((st.Invoke(ast.Name(instance, span), given, span),), span)

    def _is_instance(self, variable: str) -> bool:
        """Whether a variable of the POU is an instance of a function block."""
        type_ = self.local[variable].type
        name = type_.name.upper() if isinstance(type_, ast.NamedType) else ""
        return name in self.interfaces or blocks.signature(name) is not None

    def remarks(self, pou: str) -> Iterator[ast.Remark]:
        """What became of the variables of a POU, for the report of an import."""
        for made in self.variables:
            yield ast.Remark("added", f"{pou}.{made.name}", f"an instance of `{made.type.name}`", made.span)
        for key, type_ in self.retyped.items():
            declared = self.local[key]
            yield ast.Remark("mapped", f"{pou}.{declared.name}", f"an instance of `{type_}`", declared.span)


def added(pou: ast.Pou) -> ast.Remark:
    """That a function block was added, for the report of an import."""
    what = "the chart of an action" if isinstance(pou.body, sfc.SfcBody) else "called with EN"
    return ast.Remark("added", pou.name, f"a function block, {what}", pou.name_span)


def pins_of(sections: tuple[ast.VarBlock, ...]) -> Pins:
    """The pins in an interface."""
    return {kind: tuple(replace(v, location=None, edge=None) for block in sections if block.kind == kind
                        for v in block.variables) for kind in _PINS}


def retype(sections: tuple[ast.VarBlock, ...], types: Mapping[str, str]) -> tuple[ast.VarBlock, ...]:
    """The sections with other types for some variables."""
    def changed(variable: ast.VarDecl) -> ast.VarDecl:
        name = types.get(variable.name.upper())
        if name is None:
            return variable
        return replace(variable, type=ast.NamedType(name, None, variable.type.span))

    return tuple(replace(s, variables=tuple(map(changed, s.variables))) for s in sections)


def _library_pins(type_: str, span: Span) -> Pins | None:
    signature = blocks.signature(type_)
    if signature is None:
        return None
    groups = {"VAR_INPUT": signature.inputs, "VAR_OUTPUT": signature.outputs, "VAR_IN_OUT": signature.in_outs}
    return {kind: tuple(_declare(p.name, p.type.name, span) for p in group) for kind, group in groups.items()}


def _declare(name: str, type_: str, span: Span) -> ast.VarDecl:
    return ast.VarDecl(name, None, ast.NamedType(type_, None, span), None, span, span)


def _around(name: str, type_: str, pins: Pins, span: Span) -> ast.Pou:
    inner = f"{type_}_called"
    given = (*pins["VAR_INPUT"], *pins["VAR_IN_OUT"])
    arguments = tuple(ast.Argument(v.name, ast.Name(v.name, span), False, span) for v in given)
    called = ast.Name(inner, span)
    results = tuple(st.Assign(ast.Name(v.name, span), ast.Member(called, v.name, span), span)
                    for v in pins["VAR_OUTPUT"])
    return _function_block(name, pins, (_declare(inner, type_, span),),
                           (st.Invoke(called, arguments, span), *results), span)


def _function_block(
    name: str, pins: Pins, local: tuple[ast.VarDecl, ...], body: tuple[st.Statement, ...], span: Span
) -> ast.Pou:
    """ENO := EN; IF EN THEN body END_IF;"""
    enable, enabled = ast.Name("EN", span), ast.Name("ENO", span)
    sections = {"VAR_INPUT": (_declare("EN", "BOOL", span), *pins["VAR_INPUT"]),
                "VAR_OUTPUT": (_declare("ENO", "BOOL", span), *pins["VAR_OUTPUT"]),
                "VAR_IN_OUT": pins["VAR_IN_OUT"], "VAR": local}
    written = tuple(ast.VarBlock(kind, (), found, span) for kind, found in sections.items() if found)
    guarded = st.If((st.Arm(enable, body, span),), None, span)
    statements = st.StatementBody((st.Assign(enabled, enable, span), guarded), span)
    return ast.Pou("FUNCTION_BLOCK", name, None, None, written, statements, span, span)


def nodes(tree: object, kind: type | tuple[type, ...]) -> Iterator:
    """All nodes of a kind in a body or a part of it, in order."""
    work = [tree]
    while work:
        node = work.pop()
        if isinstance(node, kind):
            yield node
        if isinstance(node, tuple):
            work += reversed(node)
        else:
            work += [getattr(node, name) for name in _parts(type(node))]


@cache
def _parts(class_: type) -> tuple[str, ...]:
    """The fields in which nodes of a class hold other nodes, the last one first."""
    if class_ is Span or not hasattr(class_, "__match_args__"):
        return ()
    types = class_.__annotations__
    return tuple(name for name in reversed(class_.__match_args__) if types[name] not in ("Span", "str", "bool"))


def _written(tree: object) -> Iterator[str]:
    """The variables that statements may change: assigned, counted by FOR, fed by an output, or called."""
    targets = [n.target for n in nodes(tree, st.Assign)] + [n.variable for n in nodes(tree, st.ForHead)]
    targets += [n.callee for n in nodes(tree, st.Invoke)]
    targets += [n.value for n in nodes(tree, ast.Argument)]
    for target in targets:
        while isinstance(target, (ast.Member, ast.Index)):
            target = target.base
        if isinstance(target, ast.Name):
            yield target.name
