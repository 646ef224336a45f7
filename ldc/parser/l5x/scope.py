"""Tags and where they are seen: those of the controller, of a program, of an Add-On Instruction."""

from __future__ import annotations

from dataclasses import dataclass, field

from ldc.parser import ast
from ldc.parser.foreign import Names, Reading
from ldc.parser.l5x.types import Type, written
from ldc.parser.plcopen.document import Node
from ldc.source import Span


@dataclass(slots=True, eq=False)
class Tag:
    """``name``: what our text calls it. ``of``: the VAR_IN_OUT structure that it is a member of (Add-On
    Instructions), "" for a variable. ``alias``: the operand that it is another name for. ``starts``: values
    at the start by way into it, which win over ``data``."""

    name: str
    foreign: str
    type: Type | None
    span: Span
    type_name: str = ""
    of: str = ""
    alias: Span | None = None
    constant: bool = False
    local: bool = False
    data: Node | None = None
    note: str | None = None
    used: bool = False
    starts: dict[tuple, object] = field(default_factory=dict)


@dataclass(slots=True, eq=False)
class Scope:
    """``tags`` by name in capitals; what is not there is looked for in ``outer``."""

    outer: Scope | None = None
    tags: dict[str, Tag] = field(default_factory=dict)

    def find(self, name: str) -> Tag | None:
        scope: Scope | None = self
        while scope is not None:
            found = scope.tags.get(name.upper())
            if found is not None:
                return found
            scope = scope.outer
        return None


class Globals:
    """The global variables of the file: the tags in their order, and what is added to them."""

    def __init__(self, names: Names, reading: Reading) -> None:
        self.names, self.reading = names, reading
        self.tags: list[Tag] = []
        self.programs: dict[str, Scope] = {}
        self._added: dict[str, Tag] = {}
        self._spelled: set[str] = set()

    def declare(self, tag: Tag) -> Tag:
        self.tags.append(tag)
        self._spelled.add(tag.name.upper())
        return tag

    def add(self, key: str, wanted: str, type_: Type, span: Span, remark: str = "") -> Tag:
        """A variable that the file does not declare; the same one for the same ``key``."""
        tag = self._added.get(key)
        if tag is None:
            tag = self._added[key] = self.declare(Tag(self.names.fresh(wanted), wanted, type_, span))
            if remark:
                self.reading.remark("added", remark, tag.name, span)
        return tag

    def hides(self, word: str) -> bool:
        """Whether some variable of our text has this name."""
        return word.upper() in self._spelled

    def added(self, key: str) -> Tag | None:
        return self._added.get(key)


class Externals:
    """The globals that one POU uses."""

    def __init__(self) -> None:
        self.tags: dict[str, Tag] = {}

    def sections(self, span: Span) -> tuple[ast.VarBlock, ...]:
        found = []
        for constant in (False, True):
            used = [t for t in self.tags.values() if t.constant is constant]
            declared = tuple(ast.VarDecl(t.name, None, written(t.type or t.type_name, span), None, span, span)
                             for t in used)
            if declared:
                found.append(ast.VarBlock("VAR_EXTERNAL", ("CONSTANT",) if constant else (), declared, span))
        return tuple(found)
