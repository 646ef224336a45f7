"""The variables of one POU, or the globals, while they are being built (IEC 61131-3 2.4)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from ldc.diagnostics import Diagnostics
from ldc.library import blocks
from ldc.model import declaration_findings as findings
from ldc.model import places
from ldc.model.initial import initial_value
from ldc.model.names import IL_WORDS, PREFIX, standard
from ldc.model.type_table import DEEPEST, Known, TypeTable, complete
from ldc.parser import ast
from ldc.symbols import Location, Signature, Variable
from ldc.types import BOOL, ELEMENTARY, Array, Elementary, Enum, Type, blocks_in, storage

KINDS = {
    "VAR": "local", "VAR_INPUT": "input", "VAR_OUTPUT": "output", "VAR_IN_OUT": "in_out",
    "VAR_TEMP": "temp", "VAR_EXTERNAL": "external", "VAR_GLOBAL": "global",
}
_KEPT = frozenset(("RETAIN", "PERSISTENT"))
_PINS = frozenset(("input", "output", "in_out"))
CALLED = ("FUNCTION", "FUNCTION_BLOCK")
HANDED = ("VAR_INPUT", "VAR_IN_OUT")
"""Where a POU that is called takes instances of its callers."""
_FUNCTION_PINS = frozenset(("EN", "ENO", "OUT"))


class Owner(Protocol):
    """What a frame asks of the project around it."""

    diagnostics: Diagnostics
    types: TypeTable
    library: bool
    image_bytes: int
    incomplete: bool

    def signature(self, key: str) -> Signature | None: ...

    def callables(self) -> Iterable[str]: ...


class Frame:
    """An ``Environment`` of declarations: its variables are built when they are first needed, so that
    constants may be used before the place where they are declared."""

    def __init__(
        self, owner: Owner, pou: str, kind: str, var_blocks: Iterable[ast.VarBlock], parent: Frame | None,
        written: str = "",
    ) -> None:
        self.owner, self.pou, self.kind, self.parent = owner, pou, kind, parent
        self.library, self.image_bytes, self.statements = owner.library, owner.image_bytes, False
        self.flags: frozenset[str] = frozenset()
        self.broken: set[str] = set()
        self._written = written
        self._built: dict[str, Variable | None] = {}
        self._building: list[str] = []
        self._types: dict[int, Known | None] = {}
        self._declared: dict[str, tuple[ast.VarDecl, ast.VarBlock]] = {}
        for block in var_blocks:
            if self._block_allowed(block):
                for declaration in block.variables:
                    self._declare(declaration, block)

    # ---- declarations -----------------------------------------------------------------------------

    def declarations(self) -> dict[str, ast.VarDecl]:
        """What was declared, by name in capitals."""
        return {key: declaration for key, (declaration, _) in self._declared.items()}

    def build(self) -> dict[str, Variable]:
        """All variables that are right, in declared order."""
        found = {key: self._variable(key) for key in self._declared}
        return {key: variable for key, variable in found.items() if variable is not None}

    def _block_allowed(self, block: ast.VarBlock) -> bool:
        diagnostics = self.owner.diagnostics
        if self.kind and block.kind in ("VAR_GLOBAL", "VAR_CONFIG"):
            findings.not_allowed_here(diagnostics, block.span, f"{block.kind} inside of a {self.kind}",
                                      "globals belong to the project",
                                      "declare them outside of the POU and name them in VAR_EXTERNAL")
        elif not self.kind and block.kind != "VAR_GLOBAL":
            findings.not_allowed_here(diagnostics, block.span, f"{block.kind} outside of a POU",
                                      "belongs into a POU", "write VAR_GLOBAL")
        elif "CONSTANT" in block.qualifiers and KINDS[block.kind] in ("output", "in_out", "temp"):
            findings.not_allowed_here(diagnostics, block.span, f"{block.kind} CONSTANT", "cannot be constant",
                                      "put constants into a VAR CONSTANT block")
        else:
            return True
        self.broken.update(v.name.upper() for v in block.variables)
        return False

    def _declare(self, node: ast.VarDecl, block: ast.VarBlock) -> None:
        diagnostics = self.owner.diagnostics
        key = node.name.upper()
        first = self._declared.get(key)
        if first is not None:
            findings.duplicate(diagnostics, node.span, node.name, "variable", first[0].span)
            return
        if self.kind and key in (self.pou.upper(), self._written.upper()):
            findings.reserved_name(diagnostics, node.span, node.name,
                                   "the result of this FUNCTION" if self.kind == "FUNCTION"
                                   else f"the name of this {self.kind}")
            return
        self._declared[key] = node, block
        if not self.library:
            self._check_name(node, key, KINDS[block.kind])

    def _check_name(self, node: ast.VarDecl, key: str, kind: str) -> None:
        diagnostics = self.owner.diagnostics
        if key.startswith(PREFIX):
            # IL text may be what the compiler printed: its own memories and temporaries come back.
            if kind != "local" or not node.span.source.path.lower().endswith(".il"):
                findings.reserved_prefix(diagnostics, node.span, node.name)
        elif key in ELEMENTARY:
            findings.reserved_name(diagnostics, node.span, node.name, "a data type of the standard")
        elif self.kind == "FUNCTION" and kind in _PINS and key in _FUNCTION_PINS:
            findings.reserved_name(diagnostics, node.span, node.name, "a pin of every FUNCTION in a ladder")
        elif kind not in _PINS and kind != "external":
            why = standard(key) or ("an instruction of IL" if key in IL_WORDS else None)
            if why:
                findings.shadowing_name(diagnostics, node.span, node.name, why)

    def _variable(self, key: str) -> Variable | None:
        if key in self._built:
            return self._built[key]
        node, block = self._declared[key]
        if key in self._building:
            self.broken.add(key)
            findings.circular_constant(self.owner.diagnostics, node.span, node.name)
            return None
        if len(self._building) > DEEPEST:
            self.broken.add(key)
            findings.nested_too_deep(self.owner.diagnostics, node.span, f"constant `{node.name}`", DEEPEST)
            return None
        self._building.append(key)
        try:
            found = self._typed(node, block)
        finally:
            self._building.pop()
        if found is None:
            self.broken.add(key)
        self._built[key] = found
        return found

    def _typed(self, node: ast.VarDecl, block: ast.VarBlock) -> Variable | None:
        kind = KINDS[block.kind]
        known = self.type_of(node.type)
        if known is None or not self._type_allowed(node, block, known.type):
            return None
        if node.edge is not None and not self._edge_allowed(node, block, known.type):
            return None
        if kind == "external":
            return self._external(node, known.type)
        constant = "CONSTANT" in block.qualifiers and kind != "input"  # nobody writes an input inside
        initial = complete(known) if constant else known.initial
        if node.initial is not None:
            initial = initial_value(self, node.initial, known.type, self.owner.diagnostics)
            if initial is None:
                return None
        location = None
        if node.location is not None:
            location = self._location(node, block, known.type)
            if location is None:
                return None
        retain = None if "NON_RETAIN" in block.qualifiers else not _KEPT.isdisjoint(block.qualifiers)
        return Variable(node.name, known.type, kind, initial, retain, constant, location, node.span)

    def type_of(self, node: ast.TypeExpr) -> Known | None:
        """The type that is written in a declaration (``a, b : INT`` shares one)."""
        if id(node) not in self._types:
            self._types[id(node)] = self.owner.types.of(self, node)
        return self._types[id(node)]

    def _type_allowed(self, node: ast.VarDecl, block: ast.VarBlock, type_: Type) -> bool:
        """A function block needs a place that keeps its state, also within a structure."""
        if type(type_) is Elementary:
            return True
        held = next(blocks_in(type_), None)
        if held is None:
            return True
        if block.kind in HANDED and self.kind in CALLED:
            return True  # that of the caller, lent for a call
        if self.kind == "FUNCTION":
            where = "a FUNCTION"
            help = ("a FUNCTION has no memory: make it a FUNCTION_BLOCK, or let callers give an instance by "
                    "VAR_IN_OUT")
        elif block.kind not in ("VAR", "VAR_GLOBAL", "VAR_EXTERNAL"):
            where = block.kind
            help = "declare the instance in VAR, or in VAR_IN_OUT where the caller gives one of its own"
        elif "CONSTANT" in block.qualifiers:
            where, help = "VAR CONSTANT", "declare the instance in VAR"
        else:
            return True
        findings.not_allowed_here(self.owner.diagnostics, node.span,
                                  f"function block `{node.name}` in {where}", f"an instance of {held}", help)
        return False

    def _edge_allowed(self, node: ast.VarDecl, block: ast.VarBlock, type_: Type) -> bool:
        """IEC 61131-3, 2.5.2.2: a BOOL input of what has a memory for its previous value."""
        if block.kind != "VAR_INPUT" or self.kind not in ("FUNCTION_BLOCK", "PROGRAM"):
            where = f"in {block.kind} of a {self.kind}" if self.kind else f"in {block.kind}"
        elif type_ != BOOL:
            where = f"is {type_}, not BOOL"
        else:
            return True
        findings.bad_edge(self.owner.diagnostics, node.span, node.name, node.edge, where)
        return False

    def _external(self, node: ast.VarDecl, type_: Type) -> Variable | None:
        diagnostics = self.owner.diagnostics
        if node.initial is not None or node.location is not None:
            findings.not_allowed_here(diagnostics, node.span,
                                      f"VAR_EXTERNAL `{node.name}` with a value or address",
                                      "refers to a global variable",
                                      "give it at the VAR_GLOBAL")
            return None
        found = self.parent.variable(node.name.upper()) if self.parent is not None else None
        if found is None:
            if self.parent is None or not self.parent.silent(node.name.upper()):
                findings.bad_external(diagnostics, node.span, f"there is no global variable `{node.name}`",
                                      "declared as VAR_EXTERNAL", None, "declare it in VAR_GLOBAL")
            return None
        target = found[0]
        if target.type != type_:
            findings.bad_external(diagnostics, node.span, f"`{node.name}` is {target.type}, not {type_}",
                                  f"declared as {type_} here", target.span,
                                  f"write `{node.name} : {target.type};`")
            return None
        return Variable(target.name, type_, "external", target.initial if target.constant else None,
                        constant=target.constant, location=target.location, span=node.span)

    def _location(self, node: ast.VarDecl, block: ast.VarBlock, type_: Type) -> Location | None:
        diagnostics = self.owner.diagnostics
        placed = self.kind not in ("FUNCTION", "FUNCTION_BLOCK") or node.path is not None
        pins = ("VAR_INPUT", "VAR_OUTPUT") if self.kind == "PROGRAM" else ()
        if block.kind not in ("VAR", "VAR_GLOBAL", *pins) or not placed:
            where = f"a {self.kind}" if block.kind == "VAR" else block.kind
            findings.location_not_allowed(diagnostics, node.span, node.name, where)
            return None
        count = type_.count if isinstance(type_, Array) else 1
        location = places.checked_location(node.location, self.image_bytes, node.span, diagnostics, count)
        if location is None:
            return None
        base = storage(type_.element if isinstance(type_, Array) else type_)
        if not isinstance(base, Elementary):
            findings.wrong_width(diagnostics, node.span, str(location), location.bits, str(type_),
                                 "only variables of elementary types and arrays of them can have an address")
            return None
        if base.bits != location.bits:
            size = next(size for size, bits in (("X", 1), ("B", 8), ("W", 16), ("D", 32), ("L", 64))
                        if bits == base.bits)
            findings.wrong_width(diagnostics, node.span, str(location), location.bits, str(type_),
                                 f"{base} has {base.bits} bit{'s' if base.bits > 1 else ''}: "
                                 f"write `%{location.area}{size}...`")
            return None
        return location

    # ---- the environment --------------------------------------------------------------------------

    def variable(self, key: str) -> tuple[Variable, bool] | None:
        if key in self._declared:
            found = self._variable(key)
            return None if found is None else (found, found.kind in ("external", "global"))
        return self.parent.variable(key) if self.parent is not None else None

    def path(self, first: str, second: str) -> None:
        """Declarations reach no program."""

    def silent(self, key: str) -> bool:
        if self.owner.incomplete or key in self.owner.types.broken:
            return True
        if key in self.broken or "*" in self.broken:
            return True
        return self.parent is not None and self.parent.silent(key)

    def silent_pin(self, pou: str, key: str) -> bool:
        return True

    def type_named(self, key: str) -> Type | None:
        known = self.owner.types.named(self, key)
        return None if known is None else known.type

    def enum_values(self, key: str) -> tuple[tuple[Enum, int], ...]:
        return tuple(self.owner.types.enum_values.get(key, ()))

    def signature(self, key: str) -> Signature | None:
        return self.owner.signature(key) or blocks.signature(key)

    def names(self) -> Iterable[str]:
        yield from (declaration.name for declaration, _ in self._declared.values())
        if self.parent is not None:
            yield from self.parent.names()

    def callables(self) -> Iterable[str]:
        yield from self.owner.callables()
        yield from blocks.names()
